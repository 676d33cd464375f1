//! Modes at which the fit leaves far more of given responses than noise around them: another mode
//! within their width, or a mode that each response has in another place, which no test of one peak
//! tells apart.

use super::estimate::lscf::StabilisationPoint;
use super::estimate::{Block, Estimate, Pole, PoleEstimate, estimate};
use super::prepare::{Prepared, RecordKind};
use super::starts::{Stretch, starts_within, support};
use crate::notes::{Code, Notes};
use crate::units::{hz_from_rad_per_s, percent_from_ratio};

/// A pole at which it is so.
struct Misfit {
    pole: Pole,
    /// What is left of the responses about it.
    share: f64,
}

fn misfits(prepared: &Prepared, found: &Estimate) -> Vec<Misfit> {
    /// Of the responses, what sensors may be off by several times over.
    const OF_RESPONSES: f64 = 0.1;
    /// Power over that of the noise around.
    const OF_NOISE: f64 = 4.0;
    /// Decay rates, or lines, to either side.
    const WIDTHS: f64 = 2.0;
    if prepared.kind != RecordKind::GivenResponses {
        return Vec::new();
    }
    let mut all = Vec::new();
    for pole in &found.poles {
        let omega = pole.pole.omega();
        let (mut left, mut noise, mut whole) = (0.0, 0.0, 0.0);
        for (at, block) in prepared.blocks.iter().enumerate() {
            let reach = WIDTHS * pole.pole.lambda.re.abs().max(line(block));
            let below = |limit: f64| block.omega.partition_point(|omega| *omega < limit);
            let lines = below(omega - reach)..below(omega + reach);
            for (response, measured) in block.spectra.iter().enumerate() {
                for k in lines.clone() {
                    left += (measured[k] - found.fitted[at][response][k]).norm_sqr();
                    noise += found.noise[at][response][k].powi(2);
                    whole += measured[k].norm_sqr();
                }
            }
        }
        if left > OF_NOISE * noise && left > OF_RESPONSES * OF_RESPONSES * whole {
            all.push(Misfit { pole: pole.pole, share: (left / whole).sqrt() });
        }
    }
    all
}

fn line(block: &Block) -> f64 {
    block.omega.windows(2).next().map_or(0.0, |pair| pair[1] - pair[0])
}

/// Fits once more, from the blocks as they were `before`, with starts that the least squares of the
/// lines about such poles alone give: over a whole band they may offer one pole for two modes, or
/// none for a loud one. What leaves less is kept, with the stretches and the points of the
/// stabilisation diagram that support it.
pub(super) fn looked_at_closely(
    (prepared, before): (&mut Prepared, Vec<Block>),
    (stretches, points, mut starts): (&mut Vec<Stretch>, &mut Vec<StabilisationPoint>, Vec<Pole>),
    highest: usize,
    found: &mut Estimate,
) {
    /// Decay rates, and lines, to either side.
    const WIDTHS: f64 = 20.0;
    const LINES: f64 = 50.0;
    let all = misfits(prepared, found);
    let unsupported = unsupported(prepared, found, stretches, points);
    if all.is_empty() && unsupported.is_empty() {
        return;
    }
    let lines = before.iter().map(line).fold(0.0, f64::max);
    let (mut closer, mut more) = (Vec::new(), Vec::new());
    for pole in all.iter().map(|own| own.pole).chain(unsupported) {
        let reach = (WIDTHS * pole.lambda.re.abs()).max(LINES * lines);
        let own = [pole.omega() - reach, pole.omega() + reach];
        let (stretch, new) = starts_within(prepared, own, highest, &mut more);
        // Those of the whole band would keep the place of those that are sought.
        starts.retain(|start| !new.iter().any(|new| is_about(start, new)));
        closer.push(stretch);
        starts.extend(new);
    }
    let size = |all: &[Misfit]| all.iter().map(|own| own.share).fold(0.0, f64::max);
    if !all.is_empty() {
        let fitted = std::mem::replace(&mut prepared.blocks, before);
        let other = estimate(&mut prepared.blocks, &starts, highest / 2);
        match other.filter(|other| size(&misfits(prepared, other)) < 0.5 * size(&all)) {
            Some(other) => *found = other,
            None => {
                prepared.blocks = fitted;
                return;
            }
        }
    }
    stretches.splice(0..0, closer);
    points.extend(more);
}

/// Loud poles that no order of the least squares of a whole band has.
fn unsupported(
    prepared: &Prepared,
    found: &Estimate,
    stretches: &[Stretch],
    points: &[StabilisationPoint],
) -> Vec<Pole> {
    /// Of the loudest line of a response.
    const LOUD: f64 = 0.1;
    let is_one = |own: &&PoleEstimate| {
        let hz = hz_from_rad_per_s(own.pole.omega());
        own.prominence >= LOUD
            && support((hz, own.pole.ratio(), own.ratio_std), points, stretches) == 0.0
    };
    let all = found.poles.iter().filter(|_| prepared.kind == RecordKind::GivenResponses);
    all.filter(is_one).map(|own| own.pole).collect()
}

/// Whether a start is another one, or lies within its width.
fn is_about(start: &Pole, new: &Pole) -> bool {
    (start.omega() - new.omega()).abs() < new.lambda.re.abs()
}

/// Warns of all of them.
pub(super) fn warn(prepared: &Prepared, found: &Estimate, notes: &mut Notes) {
    for Misfit { pole, share } in misfits(prepared, found) {
        let what = format!(
            "the fit leaves {:.0} % of the responses near {:.2} Hz: another mode lies beside this \
             one, or the responses were not measured at once; look at the plot (--format svg)",
            percent_from_ratio(share),
            hz_from_rad_per_s(pole.omega())
        );
        notes.warning(Code::Misfit, None, what);
    }
}
