//! How many modes there are: poles are added one at a time while each lowers the sum of squares by
//! more than noise could, all poles being refined together after each. Starts come from the
//! stabilisation diagram, from peaks of the residual, and from splitting a pole in two, which is
//! what shows a close pair.

use nalgebra::{Complex, DMatrix, DVector, DVectorView};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::bands::Band;
use super::block::{Block, Pole};
use super::drift;
use super::fit::{COARSE, Fit, NORMAL, first_noise, matrix, weights};
use super::impacts;
use super::merge::of_one_mode;
use super::noise;
use super::thinning::Thinned;
use super::unexplained::reaches;
use crate::statistics::chi_squared_bound;

/// The significant poles, `most` of them at most, and the fit at them.
pub(super) fn select(blocks: &mut [Block], starts: &[Pole], most: usize) -> Option<Fit> {
    let most = most.min(plausible(blocks, starts));
    let mut fit = supported(blocks, starts, most)
        .or_else(|| Fit::at(blocks, first_noise(blocks), Vec::new()))?;
    while fit.poles.len() < most {
        let noise = fit.noise_by(blocks, |powers, _, strongest| noise::floor(powers, strongest));
        // What was noise at first may be the skirt of a mode: the poles move with the weights.
        fit = Fit::near(blocks, noise, fit.poles.clone(), NORMAL)?;
        if let Some(corrected) = impacts::corrected(blocks, &fit) {
            let trial = Fit::near(&corrected, fit.noise.clone(), fit.poles.clone(), NORMAL)?;
            if trial.evaluation.sum_of_squares < fit.evaluation.sum_of_squares {
                blocks.clone_from_slice(&corrected);
                fit = trial;
            }
        }
        let larger = larger(blocks, &fit, starts);
        if let Some((bent, other)) = bent(blocks, &fit, larger.as_ref()) {
            blocks.clone_from_slice(&bent);
            fit = other;
            continue;
        }
        if let Some((drifting, other)) = with_drift(blocks, &fit, larger.as_ref()) {
            blocks.clone_from_slice(&drifting);
            fit = other;
            continue;
        }
        // Tones are looked for only where no mode explains the residual: the comb that several
        // impacts make of a mode would pass for tones otherwise.
        match larger.or_else(|| grown(blocks, &fit, tones(blocks, &fit))) {
            Some(larger) => fit = larger,
            None => break,
        }
    }
    pruned(blocks, fit)
}

/// How many poles a record may have. A structure that is not quite linear leaves more under a
/// measured force the better it was measured, one on another, which are no modes; a floor that
/// sways takes many, too.
fn plausible(blocks: &[Block], starts: &[Pole]) -> usize {
    /// Poles that what is left shows beside those in the diagram.
    const BESIDE_STARTS: usize = 4;
    const LINES_OF_POLE: usize = 40;
    if !blocks.iter().any(Block::is_forced) {
        return usize::MAX;
    }
    let lines = blocks.iter().map(|block| block.omega.len()).max().unwrap_or(0);
    (starts.len() + BESIDE_STARTS).max(lines / LINES_OF_POLE)
}

/// What an analyser made, with all modes at once that the starts support.
fn supported(blocks: &[Block], starts: &[Pole], most: usize) -> Option<Fit> {
    if !blocks.iter().all(Block::is_given) {
        return None;
    }
    let mut poles: Vec<Pole> = Vec::new();
    for start in starts.iter().filter(|start| in_band(blocks, start)) {
        if poles.len() < most && !poles.iter().any(|pole| is_on(pole, start)) {
            poles.push(*start);
        }
    }
    if !has_room(blocks, &poles) {
        return None;
    }
    let mut fit = Fit::near(blocks, first_noise(blocks), poles, COARSE)?;
    let stays = |pole: &&Pole| starts.iter().any(|start| is_from(pole, start));
    let kept: Vec<Pole> = fit.poles.iter().filter(stays).copied().collect();
    if kept.len() < fit.poles.len() {
        fit = Fit::near(blocks, fit.noise.clone(), kept, COARSE)?;
    }
    let required = required_gain(blocks);
    // A loss is less when the others have moved.
    loop {
        let losses = linear_losses(blocks, &fit);
        let least = (0..losses.len()).min_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        let Some(least) = least.filter(|&least| losses[least] < required) else { break };
        let mut poles = fit.poles.clone();
        poles.remove(least);
        fit = Fit::near(blocks, fit.noise.clone(), poles, COARSE)?;
    }
    Some(fit)
}

/// With a further mode. What an analyser made has errors that many lines share, as it averages
/// under a window and its sensors are not all alike. They pass for modes on a mode that is there:
/// the least squares of rising order, or a peak, must support a mode near others; away from them, a
/// peak of what is left will do.
fn larger(blocks: &[Block], fit: &Fit, starts: &[Pole]) -> Option<Fit> {
    if !blocks.iter().any(Block::is_given) {
        return grown(blocks, fit, driven(fit, starts, blocks));
    }
    let supported = grown(blocks, fit, unused(starts, &fit.poles));
    supported.or_else(|| {
        let are_apart =
            |poles: &[Pole], peak: &Pole| poles.iter().all(|pole| is_apart(blocks, pole, peak));
        let of = |omega| [0.002, 0.006, 0.018].map(|ratio| Pole::from_modal(omega, ratio));
        let peaks = residual_peaks(blocks, fit).into_iter();
        let peaks: Vec<Pole> = peaks.flat_map(of).filter(|p| are_apart(&fit.poles, p)).collect();
        let larger = grown(blocks, fit, peaks)?;
        let (new, others) = larger.poles.split_last()?;
        are_apart(others, new).then_some(larger)
    })
}

/// The starts that no pole began as, nor lies on.
fn unused(starts: &[Pole], poles: &[Pole]) -> Vec<Pole> {
    let apart = |pole: &Pole, start: &Pole| (pole.omega() - start.omega()).abs();
    let mut left = starts.to_vec();
    for pole in poles {
        let nearest = (0..left.len())
            .filter(|&at| is_from(pole, &left[at]))
            .min_by(|&a, &b| apart(pole, &left[a]).total_cmp(&apart(pole, &left[b])));
        nearest.map(|at| left.remove(at));
    }
    left.retain(|start| !poles.iter().any(|pole| is_on(pole, start)));
    left
}

/// Whether a peak is no part of a pole, as leakage, ripple of sensors and a scatter of frequencies
/// make of it.
fn is_apart(blocks: &[Block], pole: &Pole, peak: &Pole) -> bool {
    const LINES: f64 = 3.0;
    /// Of the pole's decay rate.
    const WIDTHS: f64 = 2.0;
    let reach = LINES * blocks.iter().map(Block::spacing).fold(0.0, f64::max);
    (pole.omega() - peak.omega()).abs() > reach + WIDTHS * pole.lambda.re.abs()
}

/// With a background that bends more, where a band was cut out and that explains what is left as
/// well as a further pole would: skirts of modes outside of the band make no modes in it.
fn bent(blocks: &[Block], fit: &Fit, larger: Option<&Fit>) -> Option<(Vec<Block>, Fit)> {
    const MOST: usize = 3;
    /// −ln of the probability that noise alone bends the background, about one in a thousand.
    const FALSE_ALARM: f64 = 7.0;
    /// Of what a further pole explains beyond chance.
    const MIN_FRACTION: f64 = 0.8;
    // In a band as narrow as a mode, the mode itself would pass for background.
    if fit.poles.is_empty() && larger.is_some() {
        return None;
    }
    let mut bent = blocks.to_vec();
    let mut new = 0;
    for block in bent.iter_mut().filter(|block| block.is_cut_out && block.bend < MOST) {
        let before = block.background().len();
        block.bend += 1;
        new += (block.background().len() - before) * block.spectra.len();
    }
    if new == 0 || !has_room(&bent, &fit.poles) {
        return None;
    }
    let other = Fit::near(&bent, fit.noise.clone(), fit.poles.clone(), NORMAL)?;
    let gain = |of: &Fit, required: f64| {
        fit.evaluation.sum_of_squares - of.evaluation.sum_of_squares - required
    };
    let own = gain(&other, chi_squared_bound(new as f64, FALSE_ALARM));
    let rival = larger.map_or(0.0, |larger| gain(larger, required_gain(blocks)));
    (own > 0.0 && own > MIN_FRACTION * rival).then_some((bent, other))
}

/// Whether the lines are so many more than what is fitted to them that noise can be seen.
fn has_room(blocks: &[Block], poles: &[Pole]) -> bool {
    const ROWS_PER_COLUMN: f64 = 2.5;
    let columns = |block: &Block| {
        let of_poles: usize = block
            .columns_of(poles)
            .iter()
            .map(|(_, is_double)| if *is_double { 4 } else { 2 })
            .sum();
        of_poles + block.background().len()
    };
    let rows: usize = blocks.iter().map(|block| 2 * block.omega.len()).sum();
    rows as f64 >= ROWS_PER_COLUMN * blocks.iter().map(columns).sum::<usize>() as f64
}

/// With poles that drift with amplitude, where that explains more than a further pole would.
fn with_drift(blocks: &[Block], fit: &Fit, larger: Option<&Fit>) -> Option<(Vec<Block>, Fit)> {
    /// Drift that explains this fraction of what a further pole in the same place explains is the
    /// cause of both.
    const MIN_FRACTION: f64 = 0.7;
    // The feet of modes outside of a band pass for drift in it.
    if blocks.iter().any(|block| block.is_cut_out) {
        return None;
    }
    if let Some(new) = larger.and_then(|larger| larger.poles.last())
        && !fit.poles.iter().any(|pole| is_near(pole, new))
    {
        return None;
    }
    let (blocks_of_other, other, rates) = drift::drifting(blocks, fit)?;
    let required = rates as f64 * drift::required_gain(fit.poles.len());
    // Within the width of a pole another one can imitate part of its drift, and noise may tip the
    // balance. Such a pole decays several times as fast; two modes side by side decay alike.
    let fraction = match larger.and_then(|larger| larger.poles.split_last()) {
        Some((new, others)) if fit.poles.iter().any(|pole| is_on(pole, new)) => {
            match others.iter().any(|pole| is_on(pole, new) && decay_alike(pole, new)) {
                true => 1.0,
                false => MIN_FRACTION,
            }
        }
        _ => 1.0,
    };
    let before = fit.evaluation.sum_of_squares;
    let gain = |of: &Fit, required: f64| before - (of.evaluation.sum_of_squares + required);
    larger
        .is_none_or(|larger| {
            gain(&other, required) > fraction * gain(larger, required_gain(blocks))
        })
        .then_some((blocks_of_other, other))
}

/// Whether two poles decay about as fast.
fn decay_alike(a: &Pole, b: &Pole) -> bool {
    const MOST: f64 = 1.6;
    let ratio = a.lambda.re / b.lambda.re;
    (1.0 / MOST..=MOST).contains(&ratio)
}

/// Whether a pole lies within the width of another.
pub(super) fn is_on(pole: &Pole, new: &Pole) -> bool {
    (pole.omega() - new.omega()).abs() < pole.lambda.re.abs().max(new.lambda.re.abs())
}

/// Whether a refined pole still is the one that it began as.
fn is_from(pole: &Pole, start: &Pole) -> bool {
    const SHARE: f64 = 0.01;
    /// Of both decay rates.
    const WIDTHS: f64 = 2.0;
    let apart = (pole.omega() - start.omega()).abs();
    let widths = WIDTHS * (pole.lambda.re.abs().min(start.lambda.re.abs()) + start.lambda.re.abs());
    apart < widths.max(SHARE * start.omega())
}

/// Whether a pole may be there for the residual of another one.
fn is_near(pole: &Pole, new: &Pole) -> bool {
    let apart = (pole.omega() - new.omega()).abs();
    // Relative to the frequency, and to the sum of their decay rates.
    apart < 0.1 * pole.omega() || apart < 5.0 * (pole.lambda.re.abs() + new.lambda.re.abs())
}

/// Where a further mode may be: columns of the stabilisation diagram, peaks of the residual, and
/// either side of each pole.
fn driven(fit: &Fit, starts: &[Pole], blocks: &[Block]) -> Vec<Pole> {
    let mut candidates = starts.to_vec();
    for omega in residual_peaks(blocks, fit) {
        candidates.extend([0.003, 0.015, 0.05].map(|ratio| Pole::from_modal(omega, ratio)));
    }
    for pole in fit.poles.iter().filter(|pole| pole.is_driven) {
        let apart = pole.ratio().abs().clamp(0.003, 0.1);
        for factor in [1.0 - apart, 1.0 + apart] {
            candidates.push(Pole::from_modal(pole.omega() * factor, apart));
        }
    }
    candidates
}

/// Where a steady tone may be that no force explains, such as a line of the mains.
fn tones(blocks: &[Block], fit: &Fit) -> Vec<Pole> {
    let found = fit.poles.iter().filter(|pole| !pole.is_driven).count();
    // More tones are another effect that the model does not explain.
    if !blocks.iter().any(Block::is_forced) || found >= 4 {
        return Vec::new();
    }
    let tone = |omega| Pole { is_driven: false, ..Pole::from_modal(omega, 1e-5) };
    residual_peaks(blocks, fit).into_iter().map(tone).collect()
}

/// With one more pole, if one of the candidates is significant.
fn grown(blocks: &[Block], fit: &Fit, mut candidates: Vec<Pole>) -> Option<Fit> {
    /// Largest damping ratio of a steady tone.
    const MAX_TONE_DAMPING: f64 = 1e-3;
    /// Trials.
    const MOST: usize = 4;
    let reaches = reaches(blocks, &fit.poles);
    let is_drift = |pole: &Pole| reaches.iter().any(|reach| reach.holds(pole));
    candidates.retain(|pole| in_band(blocks, pole) && !is_drift(pole));
    let gains = linear_gains(blocks, fit, &candidates);
    let mut ranked: Vec<(f64, Pole)> = gains.into_iter().zip(candidates).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best: Option<(f64, Vec<Pole>)> = None;
    let required = required_gain(blocks);
    // A pole beside another one that is the same mode would only be merged with it.
    let is_split =
        |trial: &Fit| of_one_mode(blocks, trial).is_some() && of_one_mode(blocks, fit).is_none();
    let mut candidates = distinct(blocks, ranked);
    candidates.truncate(MOST);
    if candidates.iter().any(|(_, pole)| !has_room(blocks, &[&fit.poles[..], &[*pole]].concat())) {
        return None;
    }
    let trial = |(_, pole): (f64, Pole)| Some((pole, tried(blocks, fit, pole, is_split)?));
    let trials: Vec<_> = candidates.into_par_iter().map(trial).collect();
    for (pole, (gain, poles)) in trials.into_iter().flatten() {
        // A tone that decays is a mode.
        let is_mistaken = poles.iter().any(|p| !p.is_driven && p.ratio().abs() > MAX_TONE_DAMPING);
        let is_better = best.as_ref().is_none_or(|(most, _)| gain > *most);
        let is_drift = poles.last().is_some_and(&is_drift);
        let is_lost = blocks.iter().any(Block::is_given)
            && !(poles.last().is_some_and(|last| is_from(last, &pole))
                && poles.iter().all(|pole| in_band(blocks, pole)));
        if is_better && !is_mistaken && !is_drift && !is_lost {
            best = Some((gain, poles));
        }
    }
    // Only what a coarse refinement brings near the gain is refined further.
    let (_, poles) = best.filter(|(gain, _)| *gain > 0.4 * required)?;
    let best = Fit::near(blocks, fit.noise.clone(), poles, NORMAL)?;
    let gain = fit.evaluation.sum_of_squares - best.evaluation.sum_of_squares;
    (gain > required && !is_split(&best)).then_some(best)
}

/// By how much a further pole lowers the sum of squares after a coarse refinement, with all poles
/// then; `None` where the trial is to be left. Of many lines those about the pole are enough to
/// tell.
fn tried(
    blocks: &[Block],
    fit: &Fit,
    pole: Pole,
    is_left: impl Fn(&Fit) -> bool,
) -> Option<(f64, Vec<Pole>)> {
    /// Of the gain that is required.
    const NEGLIGIBLE: f64 = 0.01;
    let effort = COARSE.for_gains_of(NEGLIGIBLE * required_gain(blocks));
    let gain = |without: &Fit, trial: &Fit| {
        without.evaluation.sum_of_squares - trial.evaluation.sum_of_squares
    };
    let mut poles = fit.poles.clone();
    poles.push(pole);
    if let Some(Thinned { blocks: few, noise }) = Thinned::of(blocks, &fit.noise, &poles) {
        let without = Fit::at(&few, noise.clone(), fit.poles.clone())?;
        let trial = Fit::at(&few, noise, poles)?.descended(&few, effort);
        return (!is_left(&trial)).then(|| (gain(&without, &trial), trial.poles));
    }
    let Some((band, cut)) = about(blocks, fit, &pole) else {
        let trial = Fit::near(blocks, fit.noise.clone(), poles, effort)?;
        return (!is_left(&trial)).then(|| (gain(fit, &trial), trial.poles));
    };
    let noise = band.cut_noise(blocks, &fit.noise);
    let own: Vec<usize> =
        (0..fit.poles.len()).filter(|&at| band.holds(fit.poles[at].omega())).collect();
    let mut near = band.own(&fit.poles);
    near.extend(band.held(&fit.poles));
    let without = Fit::at(&cut, noise.clone(), near.clone())?;
    near.push(pole);
    let trial = Fit::near(&cut, noise, near, effort)?;
    let moved = own
        .into_iter()
        .zip(&trial.poles)
        .chain([fit.poles.len()].into_iter().zip(trial.poles.last()));
    moved.for_each(|(at, pole)| poles[at] = *pole);
    Some((gain(&without, &trial), poles))
}

/// The lines about a pole; `None` where that is most of them, and where all count: what an analyser
/// made has errors that many share, and laws of drift hold for a whole record.
fn about(blocks: &[Block], fit: &Fit, pole: &Pole) -> Option<(Band, Vec<Block>)> {
    /// To either side.
    const LINES: f64 = 60.0;
    const WIDTHS: f64 = 12.0;
    const SHARE: f64 = 0.5;
    let drifts = |pole: &Pole| pole.parameters() > 1;
    if blocks.iter().any(Block::is_given) || fit.poles.iter().any(drifts) {
        return None;
    }
    let line = blocks.iter().map(Block::spacing).fold(0.0, f64::max);
    let band = Band::about(pole.omega(), (LINES * line).max(WIDTHS * pole.lambda.re.abs()));
    Some((band, band.cut(blocks)?)).filter(|_| band.sees_less(SHARE, blocks))
}

/// Those that are worth a trial each, of each peak of what an analyser made only the best.
fn distinct(blocks: &[Block], ranked: Vec<(f64, Pole)>) -> Vec<(f64, Pole)> {
    let line =
        blocks.iter().filter(|block| block.is_given()).map(Block::spacing).fold(0.0, f64::max);
    let mut kept: Vec<(f64, Pole)> = Vec::new();
    for (gain, pole) in ranked {
        let is_new = kept.iter().all(|(_, old)| {
            (old.lambda - pole.lambda).norm() > 0.3 * pole.lambda.re.abs().max(1e-3 * pole.omega())
                && (old.omega() - pole.omega()).abs() >= line
        });
        if is_new && gain.is_finite() {
            kept.push((gain, pole));
        }
    }
    kept
}

pub(super) fn in_band(blocks: &[Block], pole: &Pole) -> bool {
    blocks.iter().any(|block| {
        let low = block.omega.first().copied().unwrap_or(f64::INFINITY);
        pole.omega() >= low && pole.lambda.im <= block.highest() && pole.ratio() < 0.5
    })
}

/// What the sum of squares must fall by: noise alone gives a χ² gain of as many degrees of freedom
/// as the pole has parameters, at each place of the band.
fn required_gain(blocks: &[Block]) -> f64 {
    /// Probability that noise alone adds a pole to a record.
    const FALSE_ALARM: f64 = 1e-3;
    let responses: usize = blocks
        .iter()
        .map(|block| block.spectra.len() * if block.begins_moving { 2 } else { 1 })
        .sum();
    let lines = blocks.iter().map(|block| block.omega.len()).max().unwrap_or(1);
    chi_squared_bound((2 + 2 * responses) as f64, (lines as f64 / FALSE_ALARM).ln())
}

/// How far each of some poles lowers the sum of squares with all others held.
fn linear_gains(blocks: &[Block], fit: &Fit, poles: &[Pole]) -> Vec<f64> {
    let admits = |pole: &Pole| blocks.iter().all(|block| block.admits(pole));
    let mut gains: Vec<f64> =
        poles.iter().map(|pole| if admits(pole) { 0.0 } else { f64::NEG_INFINITY }).collect();
    let admitted: Vec<usize> = (0..poles.len()).filter(|&at| gains[at] == 0.0).collect();
    for (at, block) in blocks.iter().enumerate() {
        // Two columns of each pole, see `Pair` of the fit.
        let i = Complex::new(0.0, 1.0);
        let pairs = admitted.iter().flat_map(|&pole| {
            let [a, b] = block.contribution(&poles[pole], poles[pole].is_driven).value;
            let both = || a.iter().zip(&b);
            [both().map(|(a, b)| a + b).collect(), both().map(|(a, b)| i * (a - b)).collect()]
        });
        let pairs: Vec<Vec<_>> = pairs.collect();
        for part in fit.evaluation.parts.iter().filter(|part| part.block == at) {
            let weights = weights(&fit.noise[at][part.response]);
            let lines = part.residual.len();
            let mut columns = matrix(pairs.iter(), &weights);
            let before: Vec<f64> = columns.column_iter().map(|own| own.norm_squared()).collect();
            part.projection.remove_from_all(&mut columns);
            let along = columns.tr_mul(&DVectorView::from_slice(&part.residual, lines));
            for (k, &pole) in admitted.iter().enumerate() {
                gains[pole] += gain_of_two([2 * k, 2 * k + 1], &columns, &before, along.as_slice());
            }
        }
    }
    gains
}

/// How far the two columns of a pole, of which `before` says how long they were, lower the square
/// of a residual with these products.
fn gain_of_two([u, v]: [usize; 2], columns: &DMatrix<f64>, before: &[f64], along: &[f64]) -> f64 {
    /// A pole on top of another one adds nothing, nor does a column like the other.
    const LEAST: f64 = 1e-12;
    let [mut uu, mut vv] = [u, v].map(|own| columns.column(own).norm_squared());
    uu = if uu > LEAST * before[u] { uu } else { 0.0 };
    vv = if vv > LEAST * before[v] { vv } else { 0.0 };
    let share = if uu > 0.0 { columns.column(u).dot(&columns.column(v)) / uu } else { 0.0 };
    let left = vv - share * share * uu;
    let of = |along: f64, square: f64| if square > 0.0 { along * along / square } else { 0.0 };
    let second = if left > LEAST * vv { of(along[v] - share * along[u], left) } else { 0.0 };
    of(along[u], uu) + second
}

/// The highest peaks of the weighted residual, rad/s.
fn residual_peaks(blocks: &[Block], fit: &Fit) -> Vec<f64> {
    let mut found = Vec::new();
    let reaches = reaches(blocks, &fit.poles);
    for (at, block) in blocks.iter().enumerate() {
        let lines = block.omega.len();
        let mut power = vec![0.0; lines];
        for part in fit.evaluation.parts.iter().filter(|part| part.block == at) {
            for (k, sum) in power.iter_mut().enumerate() {
                *sum += part.residual[k].powi(2) + part.residual[lines + k].powi(2);
            }
        }
        let is_drift = |k: usize| {
            let line = Pole::new(Complex::new(0.0, block.omega[k]));
            reaches.iter().any(|reach| reach.holds(&line))
        };
        let mut peaks: Vec<usize> = (0..lines)
            .filter(|&k| {
                (k == 0 || power[k] >= power[k - 1])
                    && (k + 1 == lines || power[k] > power[k + 1])
                    && !is_drift(k)
            })
            .collect();
        peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
        found.extend(peaks.iter().take(4).map(|&k| block.omega[k]));
    }
    found
}

/// Without the poles and rates that others have made needless.
fn pruned(blocks: &[Block], mut fit: Fit) -> Option<Fit> {
    /// Only what may be needless is refined.
    const FAR: f64 = 20.0;
    loop {
        let mut least: Option<(f64, Fit)> = None;
        let losses = linear_losses(blocks, &fit);
        for Smaller { poles, required, removed } in smaller(blocks, &fit) {
            if removed.is_some_and(|at| losses[at] > FAR * required) {
                continue;
            }
            let without = Fit::at(blocks, fit.noise.clone(), poles)?;
            if without.evaluation.sum_of_squares - fit.evaluation.sum_of_squares > FAR * required {
                continue;
            }
            let without = without.refined(blocks, NORMAL);
            let loss = without.evaluation.sum_of_squares - fit.evaluation.sum_of_squares;
            let missed = loss - required;
            if missed < 0.0 && least.as_ref().is_none_or(|(smallest, _)| missed < *smallest) {
                least = Some((missed, without));
            }
        }
        match least {
            Some((_, without)) => fit = without,
            None => return Some(fit),
        }
    }
}

/// By pole, what the sum of squares rises by without it, the others as they are: x'C⁻¹x of its
/// factors x with covariance C.
fn linear_losses(blocks: &[Block], fit: &Fit) -> Vec<f64> {
    let mut losses = vec![0.0; fit.poles.len()];
    for part in &fit.evaluation.parts {
        let inverse = part.projection.inverse_triangle();
        let columns = blocks[part.block].columns_of(&fit.poles);
        for (loss, (first, is_double)) in losses.iter_mut().zip(columns) {
            let count = if is_double { 4 } else { 2 };
            let covariance = DMatrix::from_fn(count, count, |i, j| {
                inverse.iter().map(|column| column[first + i] * column[first + j]).sum::<f64>()
            });
            let own = DVector::from_column_slice(&part.factors[first..first + count]);
            // Columns that depend on others are needless.
            *loss += covariance.cholesky().map_or(0.0, |factor| own.dot(&factor.solve(&own)));
        }
    }
    losses
}

/// The pole without which the sum of squares rises least; `None` where all are held.
pub(super) fn weakest(blocks: &[Block], fit: &Fit) -> Option<usize> {
    let losses = linear_losses(blocks, fit);
    let own = (0..losses.len()).filter(|&at| !fit.poles[at].is_held);
    own.min_by(|&a, &b| losses[a].total_cmp(&losses[b]))
}

/// With one pole or one rate less.
struct Smaller {
    poles: Vec<Pole>,
    /// What it must have gained to stay.
    required: f64,
    /// Place of the pole, where it is one.
    removed: Option<usize>,
}

fn smaller(blocks: &[Block], fit: &Fit) -> Vec<Smaller> {
    let mut all = Vec::new();
    for at in (0..fit.poles.len()).filter(|&at| !fit.poles[at].is_held) {
        let mut poles = fit.poles.clone();
        let pole = poles.remove(at);
        all.push(Smaller { poles, required: required_gain(blocks), removed: Some(at) });
        for rate in (0..pole.rates.len()).filter(|&rate| pole.rates[rate].is_some()) {
            let mut poles = fit.poles.clone();
            poles[at].rates[rate] = None;
            let required = drift::required_gain(fit.poles.len());
            all.push(Smaller { poles, required, removed: None });
        }
    }
    all
}
