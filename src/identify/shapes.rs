//! Shapes of several records: those of one mode and pose put together by the responses that they
//! have in common, how alike two are, and which of a pose's modes another pose has.

use super::estimate::C64;
use super::mode::ShapePart;

/// The modal assurance criterion of two shapes over the responses that both have, |aᴴb|²/(aᴴa·bᴴb)
/// (Allemang, Sound and Vibration 37, 2003); `None` of fewer than two.
pub(super) fn mac(a: &[ShapePart], b: &[ShapePart]) -> Option<f64> {
    let pairs = common(a, b);
    if pairs.len() < 2 {
        return None;
    }
    let size = |of: fn(&(&ShapePart, &ShapePart)) -> f64| pairs.iter().map(of).sum::<f64>();
    let product: C64 = pairs.iter().map(|(a, b)| a.value.conj() * b.value).sum();
    let sizes = size(|(a, _)| a.value.norm_sqr()) * size(|(_, b)| b.value.norm_sqr());
    (sizes > 0.0).then(|| product.norm_sqr() / sizes)
}

fn common<'s>(a: &'s [ShapePart], b: &'s [ShapePart]) -> Vec<(&'s ShapePart, &'s ShapePart)> {
    let of = |own: &'s ShapePart| {
        b.iter().find(|other| other.response == own.response).map(|other| (own, other))
    };
    a.iter().filter_map(of).collect()
}

/// One shape of those that records of a pose give for a mode, as set-ups with sensors in other
/// places do: each is scaled, with its phase, to the first by the responses in common, by weighted
/// least squares. What has none in common with those before is left out.
pub(super) fn together(shapes: &[&[ShapePart]]) -> Vec<ShapePart> {
    if let [] | [_] = shapes {
        return shapes.first().map_or_else(Vec::new, |shape| shape.to_vec());
    }
    let mut rest: Vec<Vec<ShapePart>> = shapes.iter().map(|own| with_noise(own)).collect();
    let mut all = rest.remove(0);
    // A set-up may be joined to the first by another one.
    while let Some(at) = rest.iter().position(|own| scale(&all, own).is_some()) {
        let own = rest.remove(at);
        let Some((factor, variance)) = scale(&all, &own) else { break };
        for part in &own {
            let value = part.value * factor;
            let own_variance = part.std.powi(2) * factor.norm_sqr();
            let scaled = own_variance + part.value.norm_sqr() * variance;
            match all.iter_mut().find(|known| known.response == part.response) {
                Some(known) => {
                    let [a, b] = [known.std.powi(2), own_variance].map(least);
                    known.value = (known.value * b + value * a) / (a + b);
                    known.std = (a * b / (a + b)).sqrt();
                }
                None => all.push(ShapePart { value, std: scaled.sqrt(), ..part.clone() }),
            }
        }
    }
    normalised(all)
}

/// With the noise of the part to which the others are related: about that of the others.
fn with_noise(shape: &[ShapePart]) -> Vec<ShapePart> {
    let noise = shape.iter().map(|part| part.std).filter(|std| *std > 0.0);
    let noise = noise.min_by(f64::total_cmp).unwrap_or(0.0);
    shape.iter().map(|part| ShapePart { std: part.std.max(noise), ..part.clone() }).collect()
}

/// A variance by which one may divide.
fn least(variance: f64) -> f64 {
    variance.max(f64::MIN_POSITIVE.sqrt())
}

/// The factor by which a shape becomes another one over the responses in common, and the variance
/// of
/// its real and imaginary part.
fn scale(known: &[ShapePart], own: &[ShapePart]) -> Option<(C64, f64)> {
    let pairs = common(known, own);
    let sums = |factor: f64| {
        pairs.iter().fold((C64::default(), 0.0), |(product, size), (known, own)| {
            let weight = least(known.std.powi(2) + factor * own.std.powi(2)).recip();
            let size_of = weight * own.value.norm_sqr();
            (product + own.value.conj() * known.value * weight, size + size_of)
        })
    };
    // Weights need the factor.
    let (product, size) = sums(1.0);
    let (product, size) = sums((product / least(size)).norm_sqr());
    (!pairs.is_empty() && size > 0.0).then(|| (product / size, size.recip()))
}

/// With the largest part 1, to which the others are related.
fn normalised(mut shape: Vec<ShapePart>) -> Vec<ShapePart> {
    let size = |at: &usize| shape[*at].value.norm();
    let largest = (0..shape.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
    let Some(largest) = largest.filter(|at| size(at) > 0.0) else { return shape };
    let (unit, noise) = (shape[largest].value, shape[largest].std / size(&largest));
    for part in &mut shape {
        part.value /= unit;
        part.std = (part.std / unit.norm()).hypot(part.value.norm() * noise);
    }
    shape[largest].std = 0.0;
    shape
}

/// A mode for which a place among another pose's modes is sought.
pub(super) struct Placed<'s> {
    pub(super) hz: f64,
    pub(super) shape: &'s [ShapePart],
}

/// Which of a pose's modes another pose has, both by ascending frequency: by shape and frequency,
/// in
/// order, if one way is clearly better than all others.
pub(super) fn places(own: &[Placed], full: &[Placed]) -> Option<Vec<usize>> {
    /// More modes have too many ways.
    const MOST: usize = 14;
    /// A mode's shape is at least so much like that of its place.
    const LIKE: f64 = 0.6;
    /// By how much the best way is better than the next.
    const CLEARLY: f64 = 0.3;
    if full.len() > MOST || own.is_empty() || own.len() >= full.len() {
        return None;
    }
    let mut likeness = Vec::new();
    for own in own {
        let of = |full: &Placed| Some((mac(own.shape, full.shape)?, (own.hz / full.hz).ln().abs()));
        likeness.push(full.iter().map(of).collect::<Option<Vec<_>>>()?);
    }
    let mut ways: Vec<(f64, Vec<usize>)> = Vec::new();
    for chosen in 0..1_usize << full.len() {
        if chosen.count_ones() as usize == own.len() {
            let way: Vec<usize> = (0..full.len()).filter(|at| chosen >> at & 1 == 1).collect();
            let one = |(own, &at): (usize, &usize)| likeness[own][at].0 - likeness[own][at].1;
            ways.push((way.iter().enumerate().map(|(own, at)| one((own, at))).sum(), way));
        }
    }
    ways.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(best, way), (next, _), ..] = &ways[..] else { return None };
    let is_like = way.iter().enumerate().all(|(own, &at)| likeness[own][at].0 >= LIKE);
    (is_like && best - next >= CLEARLY).then(|| way.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(parts: &[(&str, f64)]) -> Vec<ShapePart> {
        let part = |&(response, value): &(&str, f64)| ShapePart {
            response: response.to_owned(),
            value: C64::new(value, 0.0),
            std: 0.01,
            modal_constant: None,
            mass_normalised: None,
        };
        parts.iter().map(part).collect()
    }

    /// By hand: (1·1 + 2·1)²/(5·2) = 0.9.
    #[test]
    fn shapes_are_compared_over_what_they_have_in_common() {
        let [a, b] = [[("x", 1.0), ("y", 2.0), ("z", 9.0)], [("y", 1.0), ("x", 1.0), ("w", 5.0)]];
        assert!((mac(&shape(&a), &shape(&b)).unwrap() - 0.9).abs() < 1e-12);
        assert_eq!(mac(&shape(&a), &shape(&[("x", 1.0)])), None);
    }

    /// Three set-ups in a chain: the third meets the second alone. By hand: the second is twice the
    /// first at y, so that w is 3; the third turns by 180° and is half of it at w, so that v is −8.
    #[test]
    fn set_ups_are_joined_by_their_common_responses() {
        let [a, b, c] = [
            shape(&[("x", 1.0), ("y", 2.0)]),
            shape(&[("y", 4.0), ("w", 6.0)]),
            shape(&[("w", -1.5), ("v", 4.0)]),
        ];
        let all = together(&[&a, &c, &b]);
        let at = |name: &str| all.iter().find(|part| part.response == name).unwrap();
        for (name, value) in [("x", 1.0), ("y", 2.0), ("w", 3.0), ("v", -8.0)] {
            assert!((at(name).value - C64::new(value / -8.0, 0.0)).norm() < 1e-9, "{all:?}");
        }
        // By hand: y is known from two records, as 2 ± 0.01/√(1 + 4), and v, that all are related
        // to, as ± 0.04.
        assert!((0.002..0.006).contains(&at("y").std) && at("v").std == 0.0, "{all:?}");
        let alone = together(&[&a, &shape(&[("q", 1.0)])]);
        assert_eq!(alone.len(), 2);
    }

    #[test]
    fn a_missed_mode_leaves_its_place_empty_where_shapes_say_so() {
        let shapes = [
            shape(&[("x", 1.0), ("y", 0.5), ("z", 0.2)]),
            shape(&[("x", -0.5), ("y", 1.0), ("z", 0.4)]),
            shape(&[("x", 0.1), ("y", -0.4), ("z", 1.0)]),
        ];
        let placed = |hz: f64, at: usize| Placed { hz, shape: &shapes[at] };
        let full = [placed(10.0, 0), placed(20.0, 1), placed(30.0, 2)];
        assert_eq!(places(&[placed(11.0, 0), placed(28.0, 2)], &full), Some(vec![0, 2]));
        assert_eq!(places(&[placed(21.0, 1)], &full), Some(vec![1]));
        // One response tells nothing; nor do shapes that are alike.
        let one = shape(&[("x", 1.0)]);
        assert_eq!(places(&[Placed { hz: 20.0, shape: &one }], &full), None);
        let alike = [placed(10.0, 0), placed(11.0, 0), placed(30.0, 2)];
        assert_eq!(places(&[placed(10.5, 0), placed(30.0, 2)], &alike), None);
    }
}
