//! What text and JSON say in common: why this speed, and why none.

use super::AdvisedJob;
use crate::advice::{Block, Closure, Constant, Infeasible, Objective, OperationAdvice, Remedy};
use crate::report::words::{line, percent, round_percent, trimmed};

/// `1312.4 rpm`, with one decimal at most.
pub(super) fn rpm(rpm: f64) -> String {
    format!("{} rpm", trimmed(rpm, 2))
}

/// `mode 2 with tooth passing × 1`.
pub(super) fn block(block: &Block) -> String {
    format!("mode {} with {}", block.mode, line(&block.line))
}

/// The closure around a speed, if it is not safe.
pub(super) fn closure_at(operation: &OperationAdvice, rpm: f64) -> Option<&Closure> {
    let contains = |closure: &&Closure| {
        closure.blocks.iter().any(|b| b.speeds.low_rpm < rpm && rpm < b.speeds.high_rpm)
    };
    operation.set.closed.iter().find(contains)
}

/// Those blocks of a closure in which a speed lies, named each once.
pub(super) fn closers(closure: &Closure, rpm: f64) -> String {
    let mut names: Vec<String> = closure
        .blocks
        .iter()
        .filter(|b| b.speeds.low_rpm < rpm && rpm < b.speeds.high_rpm)
        .map(block)
        .collect();
    names.dedup();
    names.join(", ")
}

/// Why this advice, in one sentence.
pub(super) fn reason(job: &AdvisedJob, operation: &OperationAdvice) -> String {
    match &operation.remedy {
        Remedy::Constant(constant) => constant_reason(job, operation, constant),
        Remedy::Infeasible(infeasible) => infeasible_reason(job, operation, infeasible),
    }
}

fn constant_reason(job: &AdvisedJob, operation: &OperationAdvice, constant: &Constant) -> String {
    if constant.is_programmed {
        return format!("the programmed {} is safe along the whole path", rpm(constant.rpm));
    }
    let best = match job.advice.options.objective {
        Objective::Nearest => {
            format!("the safe speed nearest to the programmed {}", rpm(operation.programmed_rpm))
        }
        Objective::Margin => "the speed with the largest margin".to_owned(),
        Objective::Highest => "the highest safe speed".to_owned(),
        Objective::Vibration => "the safe speed at which the tool tip vibrates least".to_owned(),
    };
    match closure_at(operation, operation.programmed_rpm) {
        Some(closure) => {
            format!("{best}, which is closed by {}", closers(closure, operation.programmed_rpm))
        }
        None => format!("{best}, which is safe, too"),
    }
}

fn infeasible_reason(
    job: &AdvisedJob,
    operation: &OperationAdvice,
    infeasible: &Infeasible,
) -> String {
    let advice = &job.advice;
    let head = format!(
        "operation '{}': no spindle speed in {}..{} rpm stays {} % (separation {} %, model uncertainty {} %) \
         away from every mode along the whole path",
        operation.name,
        trimmed(job.spindle.min_rpm, 2),
        trimmed(job.spindle.max_rpm, 2),
        round_percent(advice.separation + advice.model_uncertainty),
        round_percent(advice.separation),
        round_percent(advice.model_uncertainty),
    );
    let Some(bind) = &infeasible.bind else {
        return format!("{head}; the gaps that are left are too narrow to set a speed in them");
    };
    let below = bind.below.as_ref().map_or("the spindle's lowest speed".to_owned(), block);
    let above = bind.above.as_ref().map_or("the spindle's highest speed".to_owned(), block);
    let closest = if bind.separation > 0.0 {
        format!("closest: {}, {} %", rpm(bind.rpm), percent(bind.separation))
    } else {
        format!("no speed keeps any distance; {} comes nearest to it", rpm(bind.rpm))
    };
    format!("{head}: {below} closes in from below and {above} from above ({closest})")
}
