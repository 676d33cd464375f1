//! Whose spindle speed and feed hold: the program's where it states them, the job's where it does
//! not; where both do and differ, the user says.

use super::super::raw::job as raw;
use super::super::waypoints::ProgramSays;
use super::Reader;
use super::stretches::Stretch;
use crate::formats::yaml::{Node, Step};
use crate::job::{Spindle, SpindleSpeed};
use crate::motion::Move;
use crate::notes::{Code, Note, Place};
use crate::program::Dialect;
use crate::units::mm_per_min_from_m_per_s;
use crate::wording::plain;

/// Speeds beyond these are slips of the pen, rev/min.
const RPM: std::ops::RangeInclusive<f64> = 1e-3..=1e7;

/// Numbers in job and program that differ by less than this share are the same: one may be mm/min
/// and the other mm/s with few digits.
const SAME: f64 = 1e-5;

/// What a job says of an operation.
pub(super) struct Said<'a> {
    pub(super) called: &'a str,
    pub(super) node: &'a Node,
    pub(super) speed: Option<SpindleSpeed>,
    pub(super) feed_m_per_s: Option<f64>,
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

impl Reader<'_> {
    /// What a path that stands in the job needs beside it.
    pub(super) fn require_speed_and_feed(
        &mut self,
        raw: &raw::Operation,
        node: &Node,
        called: &str,
    ) {
        let given = |keys: &[&str]| keys.iter().any(|key| node.get(key).is_some_and(|v| v.faulty));
        let line = node.line as usize;
        if raw.spindle_rpm.is_none()
            && raw.spindle_schedule.is_none()
            && !given(&["spindle_rpm", "spindle_schedule"])
        {
            let what = "missing key 'spindle_rpm' (or 'spindle_schedule')";
            self.notes.error(Code::MissingKey, line, format!("{called}: {what}"));
        }
        if raw.feed_mm_per_min.is_none() && !given(&["feed_mm_per_min"]) {
            let what = "missing key 'feed_mm_per_min'";
            self.notes.error(Code::MissingKey, line, format!("{called}: {what}"));
        }
    }

    /// Whether each stretch has one speed and the path one kind of feed.
    pub(super) fn settle_speeds(
        &mut self,
        said: &Said<'_>,
        moves: &[Move],
        stretches: &[Stretch],
        program: Option<&ProgramSays>,
        spindle: Option<&Spindle>,
    ) -> bool {
        let Some(program) = program else { return said.speed.is_some() };
        let before = self.notes.errors() + self.programs.errors.len();
        self.check_speeds_of_program(said, moves, stretches, program, spindle);
        self.require_speed(said, moves, stretches, program);
        self.compare_speeds(said, moves, stretches, program);
        self.compare_feeds(said, moves, program);
        self.require_tools(said, moves, stretches, program);
        self.notes.errors() + self.programs.errors.len() == before
    }

    fn check_speeds_of_program(
        &mut self,
        said: &Said<'_>,
        moves: &[Move],
        stretches: &[Stretch],
        program: &ProgramSays,
        spindle: Option<&Spindle>,
    ) {
        for stretch in stretches {
            let Some(rpm) = stretch.rpm else { continue };
            let line = line_of(program, moves, stretch, rpm);
            let place = Place { line: Some(line), ..Place::file(&program.file) };
            let shown = plain(rpm);
            if !RPM.contains(&rpm) {
                let what = format!("the spindle's speed is {shown} rpm, which no spindle has");
                self.programs.errors.push(Note::error(Code::Value, place, what));
            } else if let Some(Spindle { min_rpm, max_rpm, .. }) = spindle
                && !(*min_rpm..=*max_rpm).contains(&rpm)
            {
                let what = format!(
                    "commands {shown} rpm, outside the spindle's range {min_rpm}..{max_rpm} ({})",
                    said.called
                );
                let warning = Note::warning(Code::SpindleCommand, place, what);
                self.programs.reading.warnings.push(warning);
            }
        }
    }

    /// The job must say what the program does not; that the spindle stands is a statement.
    fn require_speed(
        &mut self,
        said: &Said<'_>,
        moves: &[Move],
        stretches: &[Stretch],
        program: &ProgramSays,
    ) {
        let silent = stretches.iter().find(|stretch| stretch.rpm.is_none() && !stretch.stands);
        let Some(stretch) = silent.filter(|_| said.speed.is_none()) else { return };
        let line = moves.get(stretch.moves.start).map_or(1, |first| first.line);
        let by_output = match program.dialect {
            Dialect::Rapid | Dialect::Krl | Dialect::Fanuc => {
                "; where an output or a routine of the program sets it, path.program.spindle_from \
                 says which"
            }
            _ => "",
        };
        let what = format!(
            "{}: missing key 'spindle_rpm' (or 'spindle_schedule'): {}:{line} runs at a speed that \
             the program does not state{by_output}",
            said.called,
            program.file.display()
        );
        self.notes.error(Code::MissingKey, said.node.line as usize, what);
    }

    /// A speed of the job beside one of the program.
    fn compare_speeds(
        &mut self,
        said: &Said<'_>,
        moves: &[Move],
        stretches: &[Stretch],
        program: &ProgramSays,
    ) {
        let Some(speed) = &said.speed else { return };
        let key = match speed {
            SpindleSpeed::Constant(_) => "spindle_rpm",
            SpindleSpeed::Schedule(_) => "spindle_schedule",
        };
        let line = said.node.line_at(&[Step::Key(key)]);
        let own = stretches.iter().filter_map(|stretch| Some((stretch, stretch.rpm?)));
        let other = |&(_, rpm): &(&Stretch, f64)| match speed {
            SpindleSpeed::Constant(own) => !is_same(*own, rpm),
            SpindleSpeed::Schedule(_) => true,
        };
        let others: Vec<(&Stretch, f64)> = own.filter(other).collect();
        if let (Some(&(stretch, rpm)), None) = (others.first(), self.raw.speeds_from) {
            let shown = match speed {
                SpindleSpeed::Constant(own) => format!("spindle_rpm is {own}"),
                SpindleSpeed::Schedule(_) => "has a spindle_schedule".to_owned(),
            };
            let more = match others.len() - 1 {
                0 => String::new(),
                1 => ", and one more speed".to_owned(),
                more => format!(", and {more} more speeds"),
            };
            let what = format!(
                "{}: {shown}, {}:{} commands {rpm} rpm{more}; make them agree, or write \
                 speeds_from: program or speeds_from: job",
                said.called,
                program.file.display(),
                line_of(program, moves, stretch, rpm)
            );
            self.notes.error(Code::Conflict, line, what);
        } else if let (SpindleSpeed::Schedule(_), [_, second, ..]) = (speed, stretches)
            && self.raw.speeds_from != Some(raw::SpeedsFrom::Program)
        {
            let at = moves.get(second.moves.start).map_or(1, |first| first.line);
            let what = format!(
                "{}: a spindle_schedule holds for one tool, and {}:{at} runs with another: divide \
                 the program into several operations",
                said.called,
                program.file.display(),
            );
            self.notes.error(Code::Conflict, line, what);
        }
    }

    /// A feed of the job beside a program that states all of its own, none of which is the job's.
    fn compare_feeds(&mut self, said: &Said<'_>, moves: &[Move], program: &ProgramSays) {
        let feeds = program.feeds;
        let Some(own) = said.feed_m_per_s else { return };
        let states_all = feeds.per_time && !feeds.per_revolution && !feeds.incomplete;
        let agrees = moves.iter().any(|each| is_same(each.feed_m_per_s, own));
        if !states_all || agrees || self.raw.speeds_from.is_some() {
            return;
        }
        let Some(usual) = super::stretches::usual_feed_m_per_s(moves, 0..moves.len()) else {
            return;
        };
        let line = moves.iter().find(|each| each.feed_m_per_s == usual).map_or(1, |m| m.line);
        let rounded = |feed: f64| (mm_per_min_from_m_per_s(feed) * 1e3).round() / 1e3;
        let what = format!(
            "{}: feed_mm_per_min is {}, {}:{line} runs at {} mm/min, and no move at the job's \
             feed; make them agree, or write speeds_from: program or speeds_from: job",
            said.called,
            rounded(own),
            program.file.display(),
            rounded(usual)
        );
        self.notes.error(Code::Conflict, said.node.line_at(&[Step::Key("feed_mm_per_min")]), what);
    }

    /// One cutter cannot stand for several.
    fn require_tools(
        &mut self,
        said: &Said<'_>,
        moves: &[Move],
        stretches: &[Stretch],
        program: &ProgramSays,
    ) {
        if self.raw.tools.is_some() {
            return;
        }
        let mut found: Vec<(u32, usize)> = Vec::new();
        for stretch in stretches {
            if let Some(number) = stretch.tool
                && !found.iter().any(|&(other, _)| other == number)
            {
                let line = moves.get(stretch.moves.start).map_or(1, |first| first.line);
                found.push((number, line));
            }
        }
        if let [(first, _), (second, line), ..] = found.as_slice() {
            let what = format!(
                "{}: the program loads tool {first} and, from {}:{line} on, tool {second}: write \
                 tools: {{{first}: {{teeth: …}}, {second}: {{teeth: …}}}} instead of tool",
                said.called,
                program.file.display()
            );
            self.error(Code::Conflict, &[Step::Key("tool")], what);
        }
    }
}

/// The line of the command that gives a stretch its speed.
fn line_of(program: &ProgramSays, moves: &[Move], stretch: &Stretch, rpm: f64) -> usize {
    let commands = program.spindle.iter();
    let commanded = commands
        .filter(|command| command.spindle.rpm() == Some(rpm))
        .filter(|command| command.from_move < stretch.moves.end)
        .max_by_key(|command| command.from_move.min(stretch.moves.start + 1));
    let first = moves.get(stretch.moves.start).map_or(1, |first| first.line);
    commanded.map_or(first, |command| command.line)
}
