//! Natural frequencies of a chain in twice the digits of a double: M as the sum of every body's kinetic
//! energy, and the eigenvalues by textbook Jacobi rotations. Shares no code with the crate.

use std::ops::{Add, Div, Mul, Neg, Sub};

use detune::model::{Description, ElasticJoint, Inertial, Joint, JointKind, Link};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// An unevaluated sum of two doubles (Dekker, Numer. Math. 18, 1971), about 32 digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Double(f64, f64);

fn two_sum(a: f64, b: f64) -> Double {
    let s = a + b;
    let t = s - a;
    Double(s, (a - (s - t)) + (b - t))
}

fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

fn two_product(a: f64, b: f64) -> Double {
    let p = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Double(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl Add for Double {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (s, t) = (two_sum(self.0, o.0), two_sum(self.1, o.1));
        let s = two_sum(s.0, s.1 + t.0);
        two_sum(s.0, s.1 + t.1)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = two_product(self.0, o.0);
        two_sum(p.0, p.1 + (self.0 * o.1 + self.1 * o.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let first = d(self.0 / o.0);
        let rest = self - first * o;
        let second = d(rest.0 / o.0);
        let rest = rest - second * o;
        first + second + d(rest.0 / o.0)
    }
}

fn d(x: f64) -> Double {
    Double(x, 0.0)
}

fn root(x: Double) -> Double {
    if x.0 <= 0.0 {
        return d(0.0);
    }
    let guess = d(x.0.sqrt());
    let better = guess + (x - guess * guess) / (guess + guess);
    better + (x - better * better) / (better + better)
}

/// Sine and cosine by their series at x/64, doubled six times.
fn sin_cos(x: f64) -> (Double, Double) {
    let small = d(x) * d(1.0 / 64.0);
    let square = small * small;
    let (mut sine, mut versine) = (d(0.0), d(0.0));
    let mut term = small;
    for k in 1..30 {
        sine = sine + term;
        term = term * small / d(f64::from(2 * k));
        // 1 − cos, so that doubling loses no digits.
        versine = versine + term;
        term = -(term * small / d(f64::from(2 * k + 1)));
        if k % 2 == 1 && square.0 == 0.0 {
            break;
        }
    }
    // term runs x, x²/2, −x³/6, −x⁴/24, …: the signs of both series alternate together.
    for _ in 0..6 {
        let cosine = d(1.0) - versine;
        let doubled = d(2.0) * sine * cosine;
        versine = d(2.0) * sine * sine;
        sine = doubled;
    }
    (sine, d(1.0) - versine)
}

type Triple = [Double; 3];

fn cross(a: &Triple, b: &Triple) -> Triple {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &Triple, b: &Triple) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: &Triple, b: &Triple) -> Triple {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn difference(a: &Triple, b: &Triple) -> Triple {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// One link and the joint before it, which turns about axis x, y or z of its own frame.
#[derive(Clone, Debug)]
pub(crate) struct ChainLink {
    pub(crate) axis: usize,
    pub(crate) origin_m: [f64; 3],
    pub(crate) mass_kg: f64,
    pub(crate) com_m: [f64; 3],
    /// Principal moments along the link's axes.
    pub(crate) inertia_kgm2: [f64; 3],
    /// `None` for a rigid joint.
    pub(crate) stiffness: Option<f64>,
}

/// A chain of turning joints, all frames parallel at zero.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) links: Vec<ChainLink>,
}

impl Chain {
    /// n links, each smaller than the one before.
    pub(crate) fn new(n: usize, stiffness: impl Fn(usize) -> f64) -> Self {
        let links = (0..n)
            .map(|i| {
                let size = 0.85_f64.powi(i as i32);
                ChainLink {
                    axis: [2, 1, 1, 0, 1, 0][i % 6],
                    origin_m: [0.15 * size, 0.02 * size, 0.4 * size],
                    mass_kg: 60.0 * size,
                    com_m: [0.08 * size, 0.02 * size, 0.15 * size],
                    inertia_kgm2: [1.8 * size * size, 1.2 * size * size, 1.5 * size * size],
                    stiffness: Some(stiffness(i)),
                }
            })
            .collect();
        Self { links }
    }

    pub(crate) fn description(&self) -> Description {
        let name = |i: usize| format!("link_{i}");
        let mut links = vec![Link { name: name(0), inertial: None, ..Link::default() }];
        let (mut joints, mut elastic_joints) = (Vec::new(), Vec::new());
        for (i, link) in self.links.iter().enumerate() {
            links.push(Link {
                name: name(i + 1),
                inertial: Some(Inertial {
                    mass_kg: link.mass_kg,
                    com_m: link.com_m.into(),
                    inertia_kgm2: Matrix3::from_diagonal(&link.inertia_kgm2.into()),
                }),
                ..Link::default()
            });
            let [x, y, z] = link.origin_m;
            joints.push(Joint {
                name: format!("joint_{i}"),
                kind: JointKind::Revolute,
                parent: name(i),
                child: name(i + 1),
                origin: Isometry3::translation(x, y, z),
                axis: Vector3::ith(link.axis, 1.0),
                position_limit: Some([-3.0, 3.0]),
                velocity_limit: None,
                mimics: None,
            });
            if let Some(stiffness) = link.stiffness {
                elastic_joints.push(ElasticJoint {
                    joint: format!("joint_{i}"),
                    stiffness,
                    is_linear: false,
                    std: None,
                    damping: None,
                });
            }
        }
        Description {
            name: "chain".into(),
            links,
            joints,
            base: None,
            tip: None,
            elastic_joints,
            extra: vec![],
            default_damping_ratio: 0.02,
            gravity_m_per_s2: -9.81 * Vector3::z(),
            gravity_stiffness: false,
            drives: vec![],
            payload: None,
            beta1: None,
            beta2: None,
            calibration: None,
            corrections: vec![],
        }
    }
}

/// Natural frequencies at pose `q`, Hz, ascending, rounded to a double at the very end.
pub(crate) fn frequencies_hz(chain: &Chain, q: &[f64]) -> Vec<f64> {
    let (mut m, springs) = mass(chain, q);
    for (i, ki) in springs.iter().enumerate() {
        for (j, kj) in springs.iter().enumerate() {
            m[i][j] = m[i][j] / (*ki * *kj);
        }
    }
    frequencies_of(m)
}

fn frequencies_of(mut a: Vec<Vec<Double>>) -> Vec<f64> {
    diagonalise(&mut a);
    let tau = Double(std::f64::consts::TAU, 2.449_293_598_294_706_4e-16);
    let mut found: Vec<f64> = (0..a.len()).map(|i| (d(1.0) / (tau * root(a[i][i]))).0).collect();
    found.sort_by(f64::total_cmp);
    found
}

/// M over the elastic joints, M_ij = Σ over the bodies behind both joints of m vᵢ·vⱼ + ωᵢ·I ωⱼ, and the roots of
/// their springs.
fn mass(chain: &Chain, q: &[f64]) -> (Vec<Vec<Double>>, Vec<Double>) {
    let n = chain.links.len();
    // Columns of the rotation.
    let mut axes = [[d(1.0), d(0.0), d(0.0)], [d(0.0), d(1.0), d(0.0)], [d(0.0), d(0.0), d(1.0)]];
    let place = |axes: &[Triple; 3], v: &[f64; 3]| {
        let part = |k: usize| [axes[k][0] * d(v[k]), axes[k][1] * d(v[k]), axes[k][2] * d(v[k])];
        sum(&sum(&part(0), &part(1)), &part(2))
    };
    let mut origin = [d(0.0); 3];
    let (mut joints, mut m) = (Vec::new(), vec![vec![d(0.0); n]; n]);
    for (link, &angle) in chain.links.iter().zip(q) {
        origin = sum(&origin, &place(&axes, &link.origin_m));
        joints.push((axes[link.axis], origin));
        let (sine, cosine) = sin_cos(angle);
        let (u, v) = (axes[(link.axis + 1) % 3], axes[(link.axis + 2) % 3]);
        #[allow(clippy::needless_range_loop)]
        for k in 0..3 {
            axes[(link.axis + 1) % 3][k] = cosine * u[k] + sine * v[k];
            axes[(link.axis + 2) % 3][k] = cosine * v[k] - sine * u[k];
        }
        let com = sum(&origin, &place(&axes, &link.com_m));
        for (i, (axis_i, at_i)) in joints.iter().enumerate() {
            let v_i = cross(axis_i, &difference(&com, at_i));
            for (j, (axis_j, at_j)) in joints.iter().enumerate() {
                let v_j = cross(axis_j, &difference(&com, at_j));
                let mut entry = d(link.mass_kg) * dot(&v_i, &v_j);
                for (axis, moment) in axes.iter().zip(link.inertia_kgm2) {
                    let about = dot(axis_i, axis) * dot(axis_j, axis);
                    entry = entry + d(moment) * about;
                }
                m[i][j] = m[i][j] + entry;
            }
        }
    }
    let elastic: Vec<(usize, Double)> =
        (0..n).filter_map(|i| chain.links[i].stiffness.map(|k| (i, root(d(k))))).collect();
    let rows = elastic.iter().map(|&(i, _)| elastic.iter().map(|&(j, _)| m[i][j]).collect());
    (rows.collect(), elastic.iter().map(|&(_, root)| root).collect())
}

#[allow(clippy::needless_range_loop)]
fn diagonalise(a: &mut [Vec<Double>]) {
    let n = a.len();
    for _ in 0..30 {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let apq = a[p][q];
                if apq.0.abs() <= 1e-32 * (a[p][p].0 * a[q][q].0).sqrt() {
                    continue;
                }
                rotated = true;
                let theta = (a[q][q] - a[p][p]) / (apq + apq);
                let size = if theta.0 < 0.0 { -theta } else { theta };
                let t = d(1.0) / (size + root(theta * theta + d(1.0)));
                let t = if theta.0 < 0.0 { -t } else { t };
                let c = d(1.0) / root(t * t + d(1.0));
                let s = t * c;
                for row in a.iter_mut() {
                    let (kp, kq) = (row[p], row[q]);
                    row[p] = c * kp - s * kq;
                    row[q] = s * kp + c * kq;
                }
                for k in 0..n {
                    let (pk, qk) = (a[p][k], a[q][k]);
                    a[p][k] = c * pk - s * qk;
                    a[q][k] = s * pk + c * qk;
                }
            }
        }
        if !rotated {
            return;
        }
    }
}
