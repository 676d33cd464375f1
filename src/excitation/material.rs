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

/// Between which multiples of the coefficients of [`MATERIALS`] those of other laboratories lie, of
/// Al 7075 in the same Table 5: K_tc from 600 to 1319 N/mm² where 767 is taken, K_rc to 789 where
/// 169 is, K_te and K_re down to 0.40 of what is taken, K_ac down to 0.22. Where the table has
/// nothing farther off, the ends are those of K_tc. Of the other alloys one laboratory tells; they
/// are trusted no further.
const TANGENTIAL: [f64; 2] = [0.78, 1.72];
const RADIAL: [f64; 2] = [0.78, 4.67];
const EDGES: [f64; 2] = [0.40, 1.72];
const AXIAL: [f64; 2] = [0.22, 1.72];

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
const MAX_AXIAL: f64 = 0.45;

/// The corners of what the coefficients of a cut may be: those of a material as laboratories have
/// them, a job's own as they stand; axial ones that nobody knows are none, or as much as is seen.
/// The force is linear in the coefficients, so what it does is largest at a corner.
pub fn coefficient_corners(cutting: &Cutting) -> Option<Vec<CuttingCoefficients>> {
    let nominal = coefficients(cutting)?;
    let of = |ends: [f64; 2]| if cutting.coefficients.is_some() { vec![1.0] } else { ends.into() };
    let mut corners = Vec::new();
    for tangential in of(TANGENTIAL) {
        for radial in of(RADIAL) {
            let edges = of(EDGES);
            let pairs = edges.iter().flat_map(|a| edges.iter().map(move |b| [*a, *b]));
            for [edge, radial_edge] in pairs {
                let corner = CuttingCoefficients {
                    tangential_n_per_m2: tangential * nominal.tangential_n_per_m2,
                    radial_n_per_m2: radial * nominal.radial_n_per_m2,
                    tangential_edge_n_per_m: edge * nominal.tangential_edge_n_per_m,
                    radial_edge_n_per_m: radial_edge * nominal.radial_edge_n_per_m,
                    ..nominal
                };
                match nominal.axial {
                    Some(axial) => corners.extend(of(AXIAL).into_iter().map(|by| {
                        CuttingCoefficients { axial: Some(axial.map(|k| by * k)), ..corner }
                    })),
                    None => {
                        let most = [corner.tangential_n_per_m2, corner.tangential_edge_n_per_m];
                        let [tangential, radial, _] = corner.exponents;
                        let seen = CuttingCoefficients {
                            axial: Some(most.map(|k| MAX_AXIAL * k)),
                            exponents: [tangential, radial, tangential],
                            ..corner
                        };
                        corners.extend([corner, seen]);
                    }
                }
            }
        }
    }
    Some(corners)
}
