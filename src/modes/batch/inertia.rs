//! M(q), K_g(q) and the tool's Jacobian on lanes, over coordinates scaled by √k: composite bodies
//! from the tip inwards, each in the frame of its own node (Featherstone, Rigid Body Dynamics
//! Algorithms, 2008, §6.2), and each coordinate's momentum carried inwards past the axes that carry
//! it.
//!
//! Bodies are combined about their common centre of mass, so the diagonal of M is a sum of squares.

use fearless_simd::{Simd, prelude::*};

use super::lanes::{Lanes, Triple, sin_cos, splat};
use super::plan::{Along, Body, NodePlan, Plan, Screw, Turn};
use crate::model::CoordinateKind;

/// Mass properties on lanes; the mass itself does not depend on the pose.
#[derive(Clone, Copy)]
pub(super) struct Composite<S: Simd> {
    com: Triple<S>,
    /// About the centre of mass: xx, yy, zz, xy, xz, yz.
    inertia: [Lanes<S>; 6],
}

/// Buffers of the assembly, made once for many blocks of poses.
pub(super) struct Assembly<S: Simd> {
    /// Sine and cosine of every spin.
    turns: Vec<(Lanes<S>, Lanes<S>)>,
    composites: Vec<Composite<S>>,
    /// Gravity in each node's frame.
    gravity: Vec<Triple<S>>,
    /// K^-½ M K^-½, upper triangle row by row.
    pub(super) mass: Vec<Lanes<S>>,
    /// K^-½ (K + K_g) K^-½ likewise; empty without gravity.
    pub(super) stiffness: Vec<Lanes<S>>,
    /// J K^-½, the translational part, three entries a coordinate.
    pub(super) jacobian: Vec<Lanes<S>>,
}

/// Where entry (i, j), i ≤ j < n, of an upper triangle lies.
#[inline(always)]
pub(super) fn packed(n: usize, i: usize, j: usize) -> usize {
    i * n - i * (i + 1) / 2 + j
}

impl<S: Simd> Assembly<S> {
    pub(super) fn new(simd: S, plan: &Plan) -> Self {
        let zero = splat(simd, 0.0);
        let n = plan.coordinates.len();
        let triangle = n * (n + 1) / 2;
        let nothing = Composite { com: [zero; 3], inertia: [zero; 6] };
        Self {
            turns: vec![(zero, zero); plan.spins.len()],
            composites: vec![nothing; plan.nodes.len()],
            gravity: vec![[zero; 3]; plan.nodes.len()],
            mass: vec![zero; triangle],
            stiffness: vec![zero; if plan.gravity.is_some() { triangle } else { 0 }],
            jacobian: vec![zero; 3 * n],
        }
    }

    /// Fills everything but the Jacobian for the poses whose joint positions are `q`, one entry a
    /// joint.
    #[inline(always)]
    pub(super) fn place(&mut self, simd: S, plan: &Plan, q: &[Lanes<S>]) {
        for (turn, spin) in self.turns.iter_mut().zip(&plan.spins) {
            let (sine, cosine) = sin_cos(simd, q[spin.joint]);
            *turn = (sine * splat(simd, spin.sign), cosine);
        }
        if let Some(gravity) = plan.gravity {
            self.turn_gravity(simd, plan, gravity);
        }
        self.combine(simd, plan, q);
        for j in 0..plan.coordinates.len() {
            self.carry(simd, plan, q, j);
        }
    }

    #[inline(always)]
    fn turn_gravity(&mut self, simd: S, plan: &Plan, gravity: [f64; 3]) {
        for (i, node) in plan.nodes.iter().enumerate() {
            let mut g = match node.parent {
                None => splats(simd, &gravity),
                Some(parent) => self.gravity[parent],
            };
            if let Some(tilt) = &node.tilt {
                g = tilted_back(simd, tilt, &g);
            }
            if let Turn::About(along, spin) = node.turn {
                let (sine, cosine) = self.turns[spin];
                g = turned::<S>(along, -sine, cosine, &g);
            }
            self.gravity[i] = g;
        }
    }

    #[inline(always)]
    fn combine(&mut self, simd: S, plan: &Plan, q: &[Lanes<S>]) {
        for (i, node) in plan.nodes.iter().enumerate().rev() {
            if !node.vibrates || node.mass == 0.0 {
                continue;
            }
            let mut all = constant(simd, &node.body);
            let mut is_empty = node.body.mass == 0.0;
            for join in &node.joining {
                let child = &plan.nodes[join.child];
                let moved = self.moved_inwards(simd, child, q, &self.composites[join.child]);
                if is_empty {
                    all = moved;
                    is_empty = false;
                } else {
                    add(simd, &mut all, &moved, join.share, join.reduced);
                }
            }
            self.composites[i] = all;
        }
    }

    #[inline(always)]
    fn moved_inwards(
        &self,
        simd: S,
        node: &NodePlan,
        q: &[Lanes<S>],
        body: &Composite<S>,
    ) -> Composite<S> {
        let mut moved = *body;
        if let Turn::About(along, spin) = node.turn {
            let (sine, cosine) = self.turns[spin];
            moved.com = turned::<S>(along, sine, cosine, &moved.com);
            moved.inertia = turned_inertia::<S>(along, sine, cosine, &moved.inertia);
        }
        if let Turn::Slide { joint, direction } = node.turn {
            for (c, d) in moved.com.iter_mut().zip(direction) {
                *c = q[joint].mul_add(splat(simd, d), *c);
            }
        }
        if let Some(tilt) = &node.tilt {
            moved.com = tilted(simd, tilt, &moved.com);
            moved.inertia = tilted_inertia(simd, tilt, &moved.inertia);
        }
        for (c, o) in moved.com.iter_mut().zip(node.offset) {
            *c += splat(simd, o);
        }
        moved
    }

    /// Column j of the upper triangles: the momentum per unit rate of coordinate j, carried
    /// inwards.
    #[inline(always)]
    fn carry(&mut self, simd: S, plan: &Plan, q: &[Lanes<S>], j: usize) {
        let zero = splat(simd, 0.0);
        let n = plan.coordinates.len();
        let coordinate = &plan.coordinates[j];
        let mut at = coordinate.node;
        let mass = plan.nodes[at].mass;
        let body = &self.composites[at];
        let (mut linear, mut angular) =
            (velocity_at(simd, &coordinate.screw, &body.com), [zero; 3]);
        let mut own = dot::<S>(&linear, &linear) * splat(simd, mass);
        linear = times::<S>(&linear, splat(simd, mass));
        if coordinate.kind == CoordinateKind::Rotation {
            angular = spun(simd, &coordinate.screw, &body.inertia);
            own += about(simd, &coordinate.screw, &angular);
        }
        angular = plus::<S>(&angular, &cross::<S>(&body.com, &linear));
        let scale = coordinate.scale;
        let own = own.mul_add(splat(simd, scale * scale), splat(simd, coordinate.drive));
        self.mass[packed(n, j, j)] = own;
        loop {
            let node = &plan.nodes[at];
            for i in node.coordinates.start..node.coordinates.end.min(j + 1) {
                let outer = &plan.coordinates[i];
                let scale = splat(simd, scale * outer.scale);
                if i != j {
                    let entry = along_screw(simd, &outer.screw, &linear, &angular);
                    self.mass[packed(n, i, j)] = entry * scale;
                }
                if plan.gravity.is_some() {
                    let pull = if outer.kind == CoordinateKind::Rotation {
                        about(simd, &outer.screw, &cross::<S>(&self.gravity[at], &linear)) * scale
                    } else {
                        zero
                    };
                    let spring = splat(simd, if i == j { 1.0 } else { 0.0 });
                    self.stiffness[packed(n, i, j)] = pull + spring;
                }
            }
            let (true, Some(parent)) = (node.carried, node.parent) else { break };
            if let Turn::About(along, spin) = node.turn {
                let (sine, cosine) = self.turns[spin];
                linear = turned::<S>(along, sine, cosine, &linear);
                angular = turned::<S>(along, sine, cosine, &angular);
            }
            if let Turn::Slide { joint, direction } = node.turn {
                let arm = times::<S>(&splats(simd, &direction), q[joint]);
                angular = plus::<S>(&angular, &cross::<S>(&arm, &linear));
            }
            if let Some(tilt) = &node.tilt {
                linear = tilted(simd, tilt, &linear);
                angular = tilted(simd, tilt, &angular);
            }
            angular = shifted(simd, &node.offset, &linear, &angular);
            at = parent;
        }
    }

    /// J K^-½ for the point `tool` of the tip's node, in the frame of the innermost elastic node:
    /// its lengths are those in the base frame.
    #[inline(always)]
    pub(super) fn tip(&mut self, simd: S, plan: &Plan, q: &[Lanes<S>], tool: &[f64; 3]) {
        let zero = splat(simd, 0.0);
        self.jacobian.fill(zero);
        let mut p = splats(simd, tool);
        let mut at = plan.tip_node;
        loop {
            let node = &plan.nodes[at];
            for i in node.coordinates.clone() {
                let coordinate = &plan.coordinates[i];
                let column = velocity_at(simd, &coordinate.screw, &p);
                for (k, entry) in column.iter().enumerate() {
                    self.jacobian[3 * i + k] = *entry * splat(simd, coordinate.scale);
                }
            }
            let (true, Some(parent)) = (node.carried, node.parent) else { break };
            // All columns so far belong to coordinates at or behind this node.
            for i in node.coordinates.start..plan.coordinates.len() {
                let [x, y, z] =
                    [self.jacobian[3 * i], self.jacobian[3 * i + 1], self.jacobian[3 * i + 2]];
                let [x, y, z] = self.direction_inwards(simd, node, &[x, y, z]);
                self.jacobian[3 * i] = x;
                self.jacobian[3 * i + 1] = y;
                self.jacobian[3 * i + 2] = z;
            }
            if let Turn::Slide { joint, direction } = node.turn {
                for (c, d) in p.iter_mut().zip(direction) {
                    *c = q[joint].mul_add(splat(simd, d), *c);
                }
            }
            p = self.direction_inwards(simd, node, &p);
            for (c, o) in p.iter_mut().zip(node.offset) {
                *c += splat(simd, o);
            }
            at = parent;
        }
    }

    #[inline(always)]
    fn direction_inwards(&self, simd: S, node: &NodePlan, v: &Triple<S>) -> Triple<S> {
        let mut v = *v;
        if let Turn::About(along, spin) = node.turn {
            let (sine, cosine) = self.turns[spin];
            v = turned::<S>(along, sine, cosine, &v);
        }
        if let Some(tilt) = &node.tilt {
            v = tilted(simd, tilt, &v);
        }
        v
    }
}

// No closures on lanes (array::map and the like): a function of the standard library between this
// code and its instructions is compiled for the baseline, and lanes cross its border through
// memory.

#[inline(always)]
fn splats<S: Simd>(simd: S, v: &[f64; 3]) -> Triple<S> {
    [splat(simd, v[0]), splat(simd, v[1]), splat(simd, v[2])]
}

#[inline(always)]
fn times<S: Simd>(v: &Triple<S>, by: Lanes<S>) -> Triple<S> {
    [v[0] * by, v[1] * by, v[2] * by]
}

#[inline(always)]
fn constant<S: Simd>(simd: S, body: &Body) -> Composite<S> {
    Composite {
        com: splats(simd, &body.com),
        inertia: [
            splat(simd, body.inertia[0]),
            splat(simd, body.inertia[1]),
            splat(simd, body.inertia[2]),
            splat(simd, body.inertia[3]),
            splat(simd, body.inertia[4]),
            splat(simd, body.inertia[5]),
        ],
    }
}

/// `all` with `other` beside it: `share` of the mass and the `reduced` mass are the plan's.
#[inline(always)]
fn add<S: Simd>(simd: S, all: &mut Composite<S>, other: &Composite<S>, share: f64, reduced: f64) {
    let (a, b) = (&all.com, &other.com);
    let [x, y, z] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let [mx, my, mz] = times::<S>(&[x, y, z], splat(simd, reduced));
    let (xx, yy, zz) = (mx * x, my * y, mz * z);
    let point = [yy + zz, xx + zz, xx + yy];
    for (k, point) in point.iter().enumerate() {
        all.inertia[k] = (all.inertia[k] + other.inertia[k]) + *point;
        all.inertia[k + 3] += other.inertia[k + 3];
    }
    all.inertia[3] = less::<S>(all.inertia[3], mx, y);
    all.inertia[4] = less::<S>(all.inertia[4], mx, z);
    all.inertia[5] = less::<S>(all.inertia[5], my, z);
    for (c, r) in all.com.iter_mut().zip([x, y, z]) {
        *c = r.mul_add(splat(simd, share), *c);
    }
}

/// A vector of a node's frame as the frame stood before it was turned about one of its axes.
#[inline(always)]
fn turned<S: Simd>(along: Along, sine: Lanes<S>, cosine: Lanes<S>, v: &Triple<S>) -> Triple<S> {
    let [x, y, z] = *v;
    match along {
        Along::X => [x, less::<S>(cosine * y, sine, z), sine.mul_add(y, cosine * z)],
        Along::Y => [sine.mul_add(z, cosine * x), y, less::<S>(cosine * z, sine, x)],
        Along::Z => [less::<S>(cosine * x, sine, y), sine.mul_add(x, cosine * y), z],
    }
}

#[inline(always)]
fn turned_inertia<S: Simd>(
    along: Along,
    sine: Lanes<S>,
    cosine: Lanes<S>,
    inertia: &[Lanes<S>; 6],
) -> [Lanes<S>; 6] {
    let [xx, yy, zz, xy, xz, yz] = *inertia;
    match along {
        Along::X => {
            let ([yy, zz, yz], [xy, xz]) = turned_pair::<S>(sine, cosine, [yy, zz, yz], [xy, xz]);
            [xx, yy, zz, xy, xz, yz]
        }
        Along::Y => {
            let ([zz, xx, xz], [yz, xy]) = turned_pair::<S>(sine, cosine, [zz, xx, xz], [yz, xy]);
            [xx, yy, zz, xy, xz, yz]
        }
        Along::Z => {
            let ([xx, yy, xy], [xz, yz]) = turned_pair::<S>(sine, cosine, [xx, yy, xy], [xz, yz]);
            [xx, yy, zz, xy, xz, yz]
        }
    }
}

/// R A Rᵀ in the plane of the turn, (aa, bb, ab), and the mixed entries (ac, bc).
#[inline(always)]
fn turned_pair<S: Simd>(
    sine: Lanes<S>,
    cosine: Lanes<S>,
    [aa, bb, ab]: [Lanes<S>; 3],
    [ac, bc]: [Lanes<S>; 2],
) -> ([Lanes<S>; 3], [Lanes<S>; 2]) {
    let first = [less::<S>(cosine * aa, sine, ab), less::<S>(cosine * ab, sine, bb)];
    let second = [sine.mul_add(aa, cosine * ab), sine.mul_add(ab, cosine * bb)];
    (
        [
            less::<S>(cosine * first[0], sine, first[1]),
            sine.mul_add(second[0], cosine * second[1]),
            sine.mul_add(first[0], cosine * first[1]),
        ],
        [less::<S>(cosine * ac, sine, bc), sine.mul_add(ac, cosine * bc)],
    )
}

#[inline(always)]
fn tilted<S: Simd>(simd: S, tilt: &[[f64; 3]; 3], v: &Triple<S>) -> Triple<S> {
    [
        dot::<S>(v, &splats(simd, &tilt[0])),
        dot::<S>(v, &splats(simd, &tilt[1])),
        dot::<S>(v, &splats(simd, &tilt[2])),
    ]
}

#[inline(always)]
fn tilted_back<S: Simd>(simd: S, tilt: &[[f64; 3]; 3], v: &Triple<S>) -> Triple<S> {
    let [a, b, c] = tilt;
    tilted(simd, &[[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]], v)
}

#[inline(always)]
fn tilted_inertia<S: Simd>(
    simd: S,
    tilt: &[[f64; 3]; 3],
    inertia: &[Lanes<S>; 6],
) -> [Lanes<S>; 6] {
    let [xx, yy, zz, xy, xz, yz] = *inertia;
    // Columns of A Rᵀ are R times the columns of A.
    let x = tilted(simd, tilt, &[xx, xy, xz]);
    let y = tilted(simd, tilt, &[xy, yy, yz]);
    let z = tilted(simd, tilt, &[xz, yz, zz]);
    let first = tilted(simd, tilt, &[x[0], y[0], z[0]]);
    let second = tilted(simd, tilt, &[x[1], y[1], z[1]]);
    let third = tilted(simd, tilt, &[x[2], y[2], z[2]]);
    [first[0], second[1], third[2], first[1], first[2], second[2]]
}

/// Angular momentum about a point `offset` further in: angular + offset × linear.
#[inline(always)]
fn shifted<S: Simd>(
    simd: S,
    offset: &[f64; 3],
    linear: &Triple<S>,
    angular: &Triple<S>,
) -> Triple<S> {
    let mut sum = *angular;
    for (k, &o) in offset.iter().enumerate() {
        // Along most offsets two of the three entries are zero.
        if o != 0.0 {
            let (next, last) = ((k + 1) % 3, (k + 2) % 3);
            sum[last] = linear[next].mul_add(splat(simd, o), sum[last]);
            sum[next] = linear[last].mul_add(splat(simd, -o), sum[next]);
        }
    }
    sum
}

#[inline(always)]
fn velocity_at<S: Simd>(simd: S, screw: &Screw, p: &Triple<S>) -> Triple<S> {
    let zero = splat(simd, 0.0);
    let [x, y, z] = *p;
    match screw {
        Screw::Axis(Along::X) => [zero, -z, y],
        Screw::Axis(Along::Y) => [z, zero, -x],
        Screw::Axis(Along::Z) => [-y, x, zero],
        Screw::General { spin, slide } => {
            plus::<S>(&cross::<S>(&splats(simd, spin), p), &splats(simd, slide))
        }
    }
}

/// Inertia times the screw's spin.
#[inline(always)]
fn spun<S: Simd>(simd: S, screw: &Screw, inertia: &[Lanes<S>; 6]) -> Triple<S> {
    let [xx, yy, zz, xy, xz, yz] = *inertia;
    match screw {
        Screw::Axis(Along::X) => [xx, xy, xz],
        Screw::Axis(Along::Y) => [xy, yy, yz],
        Screw::Axis(Along::Z) => [xz, yz, zz],
        Screw::General { spin, .. } => {
            let spin = splats(simd, spin);
            [
                dot::<S>(&[xx, xy, xz], &spin),
                dot::<S>(&[xy, yy, yz], &spin),
                dot::<S>(&[xz, yz, zz], &spin),
            ]
        }
    }
}

/// The spin's part in a moment.
#[inline(always)]
fn about<S: Simd>(simd: S, screw: &Screw, moment: &Triple<S>) -> Lanes<S> {
    match screw {
        Screw::Axis(Along::X) => moment[0],
        Screw::Axis(Along::Y) => moment[1],
        Screw::Axis(Along::Z) => moment[2],
        Screw::General { spin, .. } => dot::<S>(moment, &splats(simd, spin)),
    }
}

/// Momentum along a screw.
#[inline(always)]
fn along_screw<S: Simd>(
    simd: S,
    screw: &Screw,
    linear: &Triple<S>,
    angular: &Triple<S>,
) -> Lanes<S> {
    match screw {
        Screw::Axis(_) => about(simd, screw, angular),
        Screw::General { slide, .. } => {
            about(simd, screw, angular) + dot::<S>(linear, &splats(simd, slide))
        }
    }
}

#[inline(always)]
fn cross<S: Simd>(a: &Triple<S>, b: &Triple<S>) -> Triple<S> {
    [
        less::<S>(a[1] * b[2], a[2], b[1]),
        less::<S>(a[2] * b[0], a[0], b[2]),
        less::<S>(a[0] * b[1], a[1], b[0]),
    ]
}

#[inline(always)]
fn dot<S: Simd>(a: &Triple<S>, b: &Triple<S>) -> Lanes<S> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

#[inline(always)]
fn plus<S: Simd>(a: &Triple<S>, b: &Triple<S>) -> Triple<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b c.
#[inline(always)]
fn less<S: Simd>(a: Lanes<S>, b: Lanes<S>, c: Lanes<S>) -> Lanes<S> {
    (-b).mul_add(c, a)
}
