//! Poles that are one mode: what an analyser made has errors that many lines share, which split a
//! mode in two.

use super::block::{Block, C64, Origin};
use super::fit::{FULL, Fit, NORMAL};

/// With one pole for those that are one mode.
pub(super) fn merged(blocks: &[Block], mut fit: Fit) -> Fit {
    let mut is_rough = false;
    loop {
        let Some([_, smaller]) = of_one_mode(blocks, &fit) else {
            if !std::mem::take(&mut is_rough) {
                return fit;
            }
            fit = fit.refined(blocks, FULL);
            continue;
        };
        let mut poles = fit.poles.clone();
        poles.remove(smaller);
        let without = Fit::near(blocks, fit.noise.clone(), poles, NORMAL);
        let Some(without) = without else { return fit };
        fit = without;
        is_rough = true;
    }
}

/// Two poles, the larger first, of one shape that lie within two lines of responses that an
/// analyser made, as its leakage splits narrow peaks; or of any shapes much nearer to each other
/// than they are wide, as responses that were not taken at once have each mode in another place.
pub(super) fn of_one_mode(blocks: &[Block], fit: &Fit) -> Option<[usize; 2]> {
    const LINES: f64 = 2.0;
    /// Of both decay rates.
    const WIDTHS: f64 = 0.25;
    let [Block { origin: Origin::Responses { .. }, omega, .. }] = blocks else { return None };
    let [first, second, ..] = omega[..] else { return None };
    let reach = LINES * (second - first);
    let shape = |at: usize| shape_of(blocks, fit, at);
    let is_one = |&[a, b]: &[usize; 2]| {
        let [first, second] = [&fit.poles[a], &fit.poles[b]];
        let apart = (first.omega() - second.omega()).abs();
        apart < WIDTHS * (first.lambda.re + second.lambda.re).abs()
            || apart < reach && have_one_shape(&shape(a), &shape(b))
    };
    let mut pairs = (0..fit.poles.len()).flat_map(|a| (0..a).map(move |b| [a, b]));
    let [a, b] = pairs.find(is_one)?;
    let size = |at: usize| shape(at).iter().map(C64::norm_sqr).sum::<f64>();
    Some(if size(a) < size(b) { [b, a] } else { [a, b] })
}

/// By the modal assurance criterion.
pub(super) fn have_one_shape(a: &[C64], b: &[C64]) -> bool {
    const ONE_SHAPE: f64 = 0.98;
    let size = |shape: &[C64]| shape.iter().map(C64::norm_sqr).sum::<f64>();
    let product: C64 = a.iter().zip(b).map(|(a, b)| a.conj() * b).sum();
    product.norm_sqr() > ONE_SHAPE * size(a) * size(b)
}

/// Residues of a pole of the fit in the first block.
pub(super) fn shape_of(blocks: &[Block], fit: &Fit, at: usize) -> Vec<C64> {
    let (place, _) = blocks[0].columns_of(&fit.poles)[at];
    let parts = fit.evaluation.parts.iter().filter(|part| part.block == 0);
    parts.map(|part| C64::new(part.factors[place], part.factors[place + 1])).collect()
}
