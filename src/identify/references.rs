//! Responses to several references, as a roving hammer or a roving sensor gives them → one shape.
//!
//! A mode's residue of response i to a force at j is c φ_i φ_j. So the residues of a mode over all
//! measured pairs are a product of a vector over responses and one over references, which
//! alternating least squares find; where a point is response and reference, both are one shape, by
//! reciprocity.

use super::estimate::C64;

/// A point and direction as files name it (`12-X`), turned so that its direction is positive.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Freedom {
    name: String,
    is_turned: bool,
}

impl Freedom {
    fn of(name: &str) -> Self {
        match name.rsplit_once('-') {
            Some((node, axis)) if matches!(axis, "X" | "Y" | "Z" | "RX" | "RY" | "RZ") => {
                Self { name: format!("{node}+{axis}"), is_turned: true }
            }
            _ => Self { name: name.to_owned(), is_turned: false },
        }
    }

    fn sign(&self) -> f64 {
        if self.is_turned { -1.0 } else { 1.0 }
    }
}

/// Which response and which reference each function is of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pairs {
    responses: Vec<String>,
    references: Vec<String>,
    /// By function: places of its response and its reference, and the sign of both directions.
    at: Vec<(usize, usize, f64)>,
}

/// A part of a shape over points: its name, its value and the standard deviation of both parts of
/// it.
pub(super) type PointPart = (String, C64, f64);

/// The shape that the residues of all pairs show.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PointShape {
    /// By point; the scale is that of the residues where `is_scaled`: then φ_i φ_j is the residue.
    pub(super) parts: Vec<PointPart>,
    /// Whether a point is response and reference.
    pub(super) is_scaled: bool,
    /// Share of the residues' power that is not of one shape, and what noise alone leaves.
    pub(super) apart: f64,
    pub(super) by_noise: f64,
}

impl Pairs {
    /// Of the names of each function's response and reference; `None` where there is one reference.
    pub(super) fn of<'n>(functions: impl Iterator<Item = (&'n str, &'n str)>) -> Option<Self> {
        let mut pairs = Self { responses: Vec::new(), references: Vec::new(), at: Vec::new() };
        let place = |names: &mut Vec<String>, name: &str| {
            names.iter().position(|own| own == name).unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        for (response, reference) in functions {
            let [response, reference] = [response, reference].map(Freedom::of);
            let sign = response.sign() * reference.sign();
            let response = place(&mut pairs.responses, &response.name);
            let reference = place(&mut pairs.references, &reference.name);
            pairs.at.push((response, reference, sign));
        }
        (pairs.references.len() > 1).then_some(pairs)
    }

    /// Functions that reciprocity makes equal, each pair once, with the sign between them.
    pub(super) fn reciprocal(&self) -> Vec<(usize, usize, f64)> {
        let names = |&(i, j, _): &(usize, usize, f64)| (&self.responses[i], &self.references[j]);
        let mut found = Vec::new();
        for (a, of_a) in self.at.iter().enumerate() {
            let (response, reference) = names(of_a);
            for (b, of_b) in self.at.iter().enumerate().skip(a + 1) {
                if names(of_b) == (reference, response) {
                    found.push((a, b, of_a.2 * of_b.2));
                }
            }
        }
        found
    }

    /// The shape of a mode, from each function's residue with the standard deviation of both its
    /// parts.
    pub(super) fn shape(&self, residues: &[(C64, f64)]) -> PointShape {
        let weights: Vec<f64> = residues.iter().map(|(_, std)| std.powi(-2)).collect();
        let is_known = weights.iter().all(|w| w.is_finite() && *w > 0.0);
        let weight = |k: usize| if is_known { weights[k] } else { 1.0 };
        let (rows, columns) = (self.responses.len(), self.references.len());
        let mut left = vec![C64::default(); rows];
        // The reference whose residues are loudest, to begin with.
        let power = |column: usize| -> f64 {
            let of = self.at.iter().zip(residues).filter(|((_, j, _), _)| *j == column);
            of.map(|(_, (a, _))| a.norm_sqr()).sum()
        };
        let loudest = (0..columns).max_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap_or(0);
        for (&(i, j, sign), (a, _)) in self.at.iter().zip(residues) {
            if j == loudest {
                left[i] = a * sign;
            }
        }
        let mut right = vec![C64::default(); columns];
        let solve = |known: &[C64], count: usize, is_row: bool| -> (Vec<C64>, Vec<f64>) {
            let (mut sums, mut norms) = (vec![C64::default(); count], vec![0.0; count]);
            for (k, (&(i, j, sign), (a, _))) in self.at.iter().zip(residues).enumerate() {
                let (own, other) = if is_row { (i, j) } else { (j, i) };
                sums[own] += known[other].conj() * a * sign * weight(k);
                norms[own] += known[other].norm_sqr() * weight(k);
            }
            let safe = |norm: &f64| norm.max(f64::MIN_POSITIVE);
            let values = sums.iter().zip(&norms).map(|(sum, norm)| sum / safe(norm)).collect();
            let stds = norms.iter().map(|norm| if *norm > 0.0 { norm.powf(-0.5) } else { 0.0 });
            (values, stds.collect())
        };
        let (mut left_std, mut right_std) = (vec![0.0; rows], vec![0.0; columns]);
        for _ in 0..50 {
            (right, right_std) = solve(&left, columns, false);
            (left, left_std) = solve(&right, rows, true);
        }
        let (mut apart, mut whole, mut noise) = (0.0, f64::MIN_POSITIVE, 0.0);
        for (&(i, j, sign), (a, std)) in self.at.iter().zip(residues) {
            apart += (a * sign - left[i] * right[j]).norm_sqr();
            whole += a.norm_sqr();
            noise += 2.0 * std * std;
        }
        let (parts, is_scaled) = self.joined((&left, &left_std), (&right, &right_std));
        PointShape { parts, is_scaled, apart: apart / whole, by_noise: noise / whole }
    }

    /// Both vectors as one shape where they share points, with φ_i φ_j the residue; else the longer
    /// one.
    fn joined(&self, left: (&[C64], &[f64]), right: (&[C64], &[f64])) -> (Vec<PointPart>, bool) {
        let parts = |names: &[String], (values, stds): (&[C64], &[f64])| -> Vec<PointPart> {
            let both = values.iter().zip(stds);
            names.iter().zip(both).map(|(name, (v, std))| (name.clone(), *v, *std)).collect()
        };
        let (left, right) = (parts(&self.responses, left), parts(&self.references, right));
        let shared = || {
            left.iter().filter_map(|own| Some((own, right.iter().find(|other| other.0 == own.0)?)))
        };
        // left = g · right at the shared points.
        let norm: f64 = shared().map(|(_, (_, v, _))| v.norm_sqr()).sum();
        let g = shared().map(|((_, u, _), (_, v, _))| u * v.conj()).sum::<C64>() / norm;
        if !(norm > 0.0 && g.norm() > 0.0 && g.norm().is_finite()) {
            return (if right.len() > left.len() { right } else { left }, false);
        }
        let root = g.sqrt();
        let scaled = |part: &PointPart, by: C64| -> PointPart {
            (part.0.clone(), part.1 * by, part.2 * by.norm())
        };
        let mut all: Vec<PointPart> = left.iter().map(|part| scaled(part, root.inv())).collect();
        for part in right.iter().map(|part| scaled(part, root)) {
            match all.iter_mut().find(|own| own.0 == part.0) {
                // Each by the inverse of its variance.
                Some(own) => {
                    let [a, b] = [own.2, part.2].map(|std| std.max(1e-12 * own.1.norm()).powi(-2));
                    if a.is_finite() && b.is_finite() && a + b > 0.0 {
                        *own = (part.0, (own.1 * a + part.1 * b) / (a + b), (a + b).powf(-0.5));
                    }
                }
                None => all.push(part),
            }
        }
        (all, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points hit, two of them with a sensor, one direction turned; and a sensor that is hit
    /// nowhere.
    #[test]
    fn residues_of_all_pairs_are_one_shape() {
        let shape = [("1+Z", 2.0), ("2+Z", -1.0), ("3+Z", 0.5)];
        let of = |name: &str| -> f64 {
            let Freedom { name, is_turned } = Freedom::of(name);
            let own = shape.iter().find(|(own, _)| *own == name).unwrap().1;
            if is_turned { -own } else { own }
        };
        let names =
            [("1+Z", "1-Z"), ("1+Z", "2+Z"), ("2+Z", "1-Z"), ("2+Z", "3+Z"), ("1+Z", "3+Z")];
        let pairs = Pairs::of(names.into_iter()).unwrap();
        assert_eq!(pairs.reciprocal(), [(1, 2, -1.0)]);
        let c = C64::new(0.0, -3.0);
        let residues: Vec<(C64, f64)> =
            names.iter().map(|(i, j)| (c * of(i) * of(j), 1e-6)).collect();
        let found = pairs.shape(&residues);
        assert!(found.is_scaled && found.apart < 1e-12, "{found:?}");
        let first = found.parts[0].1;
        assert!((first * first - c * 4.0).norm() < 1e-6, "{found:?}");
        for (name, value, _) in &found.parts {
            assert!((value / first - of(name) / 2.0).norm() < 1e-6, "{found:?}");
        }
        assert_eq!(found.parts.len(), 3);
        // A sensor elsewhere: the shape is over the points that were hit.
        let names = [("9+X", "1+Z"), ("9+X", "2+Z"), ("9+X", "3+Z")];
        let pairs = Pairs::of(names.into_iter()).unwrap();
        let residues: Vec<(C64, f64)> = names.iter().map(|(_, j)| (c * of(j), 1e-6)).collect();
        let found = pairs.shape(&residues);
        assert!(!found.is_scaled && found.parts.len() == 3, "{found:?}");
        assert!((found.parts[1].1 / found.parts[0].1 + 0.5).norm() < 1e-9, "{found:?}");
        assert!(Pairs::of([("1+Z", "2+Z"), ("3+Z", "2+Z")].into_iter()).is_none());
    }
}
