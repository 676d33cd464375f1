//! Cutting coefficients of materials, and how far they may be off.

use crate::job::{Cutting, CuttingCoefficients};
use crate::units::{n_per_m_from_n_per_mm, n_per_m2_from_n_per_mm2};

/// A material by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// As jobs spell it.
    pub name: &'static str,
    /// Its coefficients.
    pub coefficients: CuttingCoefficients,
}

/// Between which multiples of a coefficient of [`MATERIALS`] those of other laboratories lie: K_tc
/// of Al 7075 runs from 600 to 1319 N/mm² (the same Table 5), 0.78 to 1.72 times the 767 that is
/// taken. Of the other alloys one laboratory tells; they are trusted no further.
const SPREAD: [f64; 2] = [0.78, 1.72];

const fn of(name: &'static str, [tc, rc, te, re]: [f64; 4], axial: Option<[f64; 2]>) -> Material {
    Material {
        name,
        coefficients: CuttingCoefficients {
            tangential_n_per_m2: n_per_m2_from_n_per_mm2(tc),
            radial_n_per_m2: n_per_m2_from_n_per_mm2(rc),
            tangential_edge_n_per_m: n_per_m_from_n_per_mm(te),
            radial_edge_n_per_m: n_per_m_from_n_per_mm(re),
            axial: match axial {
                Some([ac, ae]) => Some([n_per_m2_from_n_per_mm2(ac), n_per_m_from_n_per_mm(ae)]),
                None => None,
            },
            exponents: [0.0; 3],
        },
    }
}

/// K_tc, K_rc in N/mm² and K_te, K_re in N/mm, then K_ac and K_ae, from the review in Chin. J.
/// Mech. Eng. 2021, DOI 10.1186/s10033-021-00536-9, Table 5.
pub const MATERIALS: [Material; 3] = [
    of("al-6082", [631.0, 99.0, 13.0, 10.0], Some([273.0, 2.8])),
    of("al-7075", [767.0, 169.0, 27.7, 26.6], Some([222.0, 0.7])),
    of("al-6061", [244.0, 113.5, 7.53, 7.83], None),
];

/// The material that jobs call `name`, temper and case aside: `al-6082-T6` is `al-6082`.
pub fn material(name: &str) -> Option<&'static Material> {
    let name = name.trim().to_ascii_lowercase().replace([' ', '_'], "-");
    MATERIALS.iter().find(|material| {
        name.strip_prefix(material.name)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    })
}

/// The coefficients that hold for a cut: its own, else those of its material.
pub fn coefficients(cutting: &Cutting) -> Option<CuttingCoefficients> {
    cutting.coefficients.or_else(|| Some(material(&cutting.material)?.coefficients))
}

/// Where nobody knows the axial coefficients: at most this share of the tangential ones. In Table 5
/// of the same review K_ac is 0.04 to 0.43 of K_tc, K_ae 0.03 to 0.22 of K_te.
const MOST_AXIAL: f64 = 0.45;

/// The least and the most that the coefficients of a cut may be: those of a material by `SPREAD`, a
/// job's own as they stand; axial ones that nobody knows are none, and as much as is seen.
pub fn coefficient_range(cutting: &Cutting) -> Option<[CuttingCoefficients; 2]> {
    let nominal = coefficients(cutting)?;
    let spread = if cutting.coefficients.is_some() { [1.0; 2] } else { SPREAD };
    let [least, mut most] = spread.map(|factor| CuttingCoefficients {
        tangential_n_per_m2: factor * nominal.tangential_n_per_m2,
        radial_n_per_m2: factor * nominal.radial_n_per_m2,
        tangential_edge_n_per_m: factor * nominal.tangential_edge_n_per_m,
        radial_edge_n_per_m: factor * nominal.radial_edge_n_per_m,
        axial: nominal.axial.map(|axial| axial.map(|k| factor * k)),
        exponents: nominal.exponents,
    });
    if most.axial.is_none() {
        let guessed = [most.tangential_n_per_m2, most.tangential_edge_n_per_m];
        most.axial = Some(guessed.map(|k| MOST_AXIAL * k));
        most.exponents[2] = most.exponents[0];
    }
    Some([least, most])
}
