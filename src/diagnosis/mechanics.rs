//! M and K of the robot with causes put into it, at the rows of a table, and what moving one
//! parameter does to them.

use nalgebra::{DMatrix, Vector3};

use super::data::{Load, Row};
use crate::identify::{MeasuredRotation, RotationAxis};
use crate::model::{
    Cause, Correction, Description, Placement, Robot, link_rotation, mass_matrix, spring_constant,
    stiffness_matrix,
};

/// The robot with `corrections` beside its own, and `load` at the tip.
fn robot(description: &Description, corrections: &[Correction], load: &Load) -> Option<Robot> {
    let mut description = description.clone();
    description.corrections.extend_from_slice(corrections);
    if load.share == 0.0 {
        description.payload = None;
    } else if let Some(payload) = &mut description.payload {
        payload.inertial.mass_kg *= load.share;
        payload.inertial.inertia_kgm2 *= load.share;
    }
    if load.more_kg > 0.0 {
        let tip = match &description.tip {
            Some(tip) => tip.clone(),
            None => Robot::new(&description).ok()?.tip_link().to_owned(),
        };
        description.corrections.push(Correction {
            cause: Cause::Payload,
            at: Some(tip),
            parameters: vec![("mass_kg".to_owned(), load.more_kg)],
            hinge: None,
        });
    }
    for (at, mass_kg) in &load.added_kg {
        let link = description.links.iter().find(|link| link.name == *at)?;
        let com_m = link.inertial.map_or_else(Vector3::zeros, |own| own.com_m);
        let com = ["com_x_m", "com_y_m", "com_z_m"].into_iter().zip(com_m.iter().copied());
        let own = std::iter::once(("mass_kg", *mass_kg)).chain(com);
        description.corrections.push(Correction {
            cause: Cause::Payload,
            at: Some(at.clone()),
            parameters: own.map(|(name, value)| (name.to_owned(), value)).collect(),
            hinge: None,
        });
    }
    Robot::of(description)
}

/// The robot under every load of a table, placed at one of its rows.
pub(super) struct Mechanics {
    robots: Vec<(Load, Robot)>,
    at: Placed,
}

/// Where a robot stands at a row, with its M and K there.
#[derive(Clone)]
pub(super) struct Placed {
    placement: Placement,
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

impl Mechanics {
    /// `None` if there is no such robot.
    pub(super) fn new(
        description: &Description,
        corrections: &[Correction],
        rows: &[Row],
    ) -> Option<Self> {
        let mut robots: Vec<(Load, Robot)> = Vec::new();
        for row in rows {
            if robots.iter().all(|(load, _)| *load != row.load) {
                let robot = robot(description, corrections, &row.load)?;
                robots.push((row.load.clone(), robot));
            }
        }
        let first = &robots.first()?.1;
        let n = first.coordinates().len();
        let at = Placed {
            placement: Placement::new(first),
            mass: DMatrix::zeros(n, n),
            stiffness: DMatrix::zeros(n, n),
        };
        Some(Self { robots, at })
    }

    pub(super) fn mass(&self) -> &DMatrix<f64> {
        &self.at.mass
    }

    pub(super) fn stiffness(&self) -> &DMatrix<f64> {
        &self.at.stiffness
    }

    /// Where it was placed last.
    pub(super) fn stand(&self) -> Placed {
        self.at.clone()
    }

    /// Puts it back to where it was placed before.
    pub(super) fn put_back(&mut self, at: &Placed) {
        self.at.clone_from(at);
    }

    /// The robot under the load of a row.
    pub(super) fn robot(&self, row: &Row) -> Option<&Robot> {
        self.robots.iter().find(|(load, _)| *load == row.load).map(|(_, robot)| robot)
    }

    /// How much each elastic coordinate turns a link as measured, at the row at which the robot is
    /// placed.
    pub(super) fn turns(&self, row: &Row, measured: &MeasuredRotation) -> Option<Vec<f64>> {
        let direction = match measured.about {
            RotationAxis::Joint => None,
            RotationAxis::Base(axis) => {
                Some(Vector3::from_fn(|i, _| f64::from(u8::from(i == axis))))
            }
        };
        link_rotation(self.robot(row)?, &self.at.placement, &measured.link, direction)
    }

    /// Where the robot was placed last.
    pub(super) fn placement(&self) -> &Placement {
        &self.at.placement
    }

    /// M and K at a row of the table that the model was made for.
    pub(super) fn place(&mut self, row: &Row) -> Option<()> {
        let Self { robots, at: Placed { placement, mass, stiffness } } = self;
        let (_, robot) = robots.iter().find(|(load, _)| *load == row.load)?;
        placement.place(robot, &row.q);
        mass_matrix(robot, placement, mass);
        stiffness_matrix(robot, placement, &row.conditions, stiffness);
        Some(())
    }

    /// M and K at the row with the bodies and springs of this robot in the frames of `other`,
    /// placed there already, which stands like it.
    fn place_as(&mut self, other: &Placement, row: &Row) -> Option<()> {
        let Self { robots, at: Placed { placement, mass, stiffness } } = self;
        let (_, robot) = robots.iter().find(|(load, _)| *load == row.load)?;
        placement.place_bodies(robot, other);
        mass_matrix(robot, placement, mass);
        stiffness_matrix(robot, placement, &row.conditions, stiffness);
        Some(())
    }
}

/// What moving one parameter does to M and K.
pub(super) struct Change {
    moved: Mechanics,
    stands: bool,
    weighs: bool,
    /// Whether K changes off its diagonal.
    couples: bool,
    /// Whether springs are coupled.
    has_couplings: bool,
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

impl Change {
    /// From `here` to `moved`, the same robot with one parameter moved a little.
    pub(super) fn new(here: &Mechanics, moved: Mechanics) -> Self {
        let both = || here.robots.iter().zip(&moved.robots).map(|((_, a), (_, b))| (a, b));
        let n = here.mass().nrows();
        Self {
            stands: both().all(|(a, b)| a.stands_like(b)),
            weighs: both().all(|(a, b)| a.weighs_like(b)),
            couples: both().any(|(a, b)| a.has_coupled_stiffness() || b.has_coupled_stiffness()),
            has_couplings: both()
                .any(|(a, b)| !(a.couplings().is_empty() && b.couplings().is_empty())),
            mass: DMatrix::zeros(n, n),
            stiffness: DMatrix::zeros(n, n),
            moved,
        }
    }

    /// Whether M and K change on their diagonals alone: by springs and drives.
    fn is_diagonal(&self) -> bool {
        self.stands && self.weighs && !self.has_couplings
    }

    /// The changes at the row at which `here` is placed.
    pub(super) fn place(&mut self, here: &Mechanics, row: &Row) -> Option<()> {
        if self.is_diagonal() {
            let (robot, before) = (self.moved.robot(row)?, here.robot(row)?);
            let both = robot.coordinates().iter().zip(before.coordinates()).enumerate();
            for (i, (after, before_i)) in both {
                self.mass[(i, i)] = after.drive_inertia - before_i.drive_inertia;
                let constant =
                    |robot| spring_constant(robot, &here.at.placement, &row.conditions, i);
                self.stiffness[(i, i)] = constant(robot) - constant(before);
            }
            return Some(());
        }
        if self.stands {
            self.moved.place_as(&here.at.placement, row)?;
        } else {
            self.moved.place(row)?;
        }
        self.mass.copy_from(&self.moved.at.mass);
        self.mass -= here.mass();
        self.stiffness.copy_from(&self.moved.at.stiffness);
        self.stiffness -= here.stiffness();
        Some(())
    }

    /// d(ω²) = φᵀ (dK − ω² dM) φ of a mode φ, mass-normalised.
    pub(super) fn of_omega_squared(&self, shape: &[f64], omega_squared: f64) -> f64 {
        let mass = if self.is_diagonal() { along_diagonal } else { along };
        let stiffness = if self.is_diagonal() || !self.couples { along_diagonal } else { along };
        stiffness(&self.stiffness, shape) - omega_squared * mass(&self.mass, shape)
    }

    /// (dK − ω² dM) φ of a mode φ: along another mode, what turns the one towards the other.
    pub(super) fn force(&self, shape: &[f64], omega_squared: f64) -> Vec<f64> {
        if self.is_diagonal() {
            let own = |(i, own): (usize, &f64)| {
                (self.stiffness[(i, i)] - omega_squared * self.mass[(i, i)]) * own
            };
            return shape.iter().enumerate().map(own).collect();
        }
        let mut force = vec![0.0; shape.len()];
        for (j, own) in shape.iter().enumerate() {
            let (stiffness, mass) = (self.stiffness.column(j), self.mass.column(j));
            for (force, (k, m)) in force.iter_mut().zip(stiffness.iter().zip(&mass)) {
                *force += (k - omega_squared * m) * own;
            }
        }
        force
    }
}

/// φᵀ A φ of a symmetric A.
fn along(a: &DMatrix<f64>, shape: &[f64]) -> f64 {
    let n = shape.len();
    let columns = a.as_slice().chunks_exact(n).zip(shape).enumerate();
    let sum = |(j, (column, &own)): (usize, (&[f64], &f64))| {
        let above: f64 = column[..j].iter().zip(shape).map(|(a, other)| a * other).sum();
        own * (2.0 * above + column[j] * own)
    };
    columns.map(sum).sum()
}

/// φᵀ A φ of a diagonal A.
fn along_diagonal(a: &DMatrix<f64>, shape: &[f64]) -> f64 {
    shape.iter().enumerate().map(|(i, own)| a[(i, i)] * own * own).sum()
}
