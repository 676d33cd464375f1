//! Coordinate systems of APT: MSYS, CSYS and MCS.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::lexer::Word;
use super::{Reader, name, number};
use crate::program::Coordinates;

/// Axes of a system are unit vectors, and across one another, to about three digits.
const AXES_TOLERANCE: f64 = 0.01;

/// Where coordinates of the program lie in the job's work object, which stands for the first
/// system.
#[derive(Debug)]
pub(super) struct Systems {
    said: Option<Coordinates>,
    /// Whether the program has said it.
    by_program: bool,
    /// The first system, its line, and the system that holds now; mm.
    first: Option<(usize, Isometry3<f64>)>,
    now: Isometry3<f64>,
    has_started: bool,
}

/// From coordinates of the program to those of the job's work object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame(Option<Isometry3<f64>>);

impl Frame {
    pub(super) fn point(&self, at: Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(at, |frame| (frame * nalgebra::Point3::from(at)).coords)
    }

    /// The other way round.
    fn back(&self, at: Vector3<f64>) -> Vector3<f64> {
        let inverse = self.0.map(|frame| frame.inverse());
        Self(inverse).point(at)
    }

    pub(super) fn axis(&self, axis: Unit<Vector3<f64>>) -> Unit<Vector3<f64>> {
        self.0.map_or(axis, |frame| frame.rotation * axis)
    }
}

impl Systems {
    pub(super) fn new(said: Option<Coordinates>) -> Self {
        Self {
            said,
            by_program: false,
            first: None,
            now: Isometry3::identity(),
            has_started: false,
        }
    }

    /// `TRNTYP/WORLD,…` of CAMWorks: in which system coordinates are. The job's word counts more.
    pub(super) fn say(&mut self, minor: &[Word<'_>]) -> Result<(), String> {
        let said = match minor.first().and_then(name).map(str::to_ascii_uppercase).as_deref() {
            Some("WORLD") => Coordinates::World,
            Some("LOCAL") => Coordinates::Local,
            _ => return Err("expected WORLD or LOCAL".to_owned()),
        };
        match self.said {
            Some(before) if before != said && self.by_program => {
                Err("coordinates change between WORLD and LOCAL".to_owned())
            }
            Some(_) => Ok(()),
            None => {
                (self.said, self.by_program) = (Some(said), true);
                Ok(())
            }
        }
    }

    /// The frame of a motion.
    pub(super) fn start(&mut self) -> Frame {
        self.has_started = true;
        self.frame()
    }

    fn frame(&self) -> Frame {
        match (self.said, &self.first) {
            (Some(Coordinates::Local), Some((_, first))) if *first != self.now => {
                Frame(Some(first.inverse() * self.now))
            }
            _ => Frame(None),
        }
    }

    /// The tool axis where none is given: z of the system that holds, in coordinates of the
    /// program.
    pub(super) fn axis(&self) -> Unit<Vector3<f64>> {
        match (self.said, &self.first) {
            (Some(Coordinates::World), Some((_, first))) => {
                (first.inverse() * self.now).rotation * Vector3::z_axis()
            }
            _ => Vector3::z_axis(),
        }
    }

    fn set(&mut self, line: usize, system: Isometry3<f64>) -> Result<(), String> {
        if !self.has_started {
            self.first = Some((line, system));
            self.now = system;
            return Ok(());
        }
        let Some((first_line, first)) = self.first else {
            return Err("a coordinate system behind motion that has none".to_owned());
        };
        let is_first = (first.translation.vector - system.translation.vector).norm() < 1e-6
            && first.rotation.angle_to(&system.rotation) < 1e-9;
        if !is_first && self.said.is_none() {
            return Err(format!(
                "another coordinate system than that of line {first_line}; write \
                 path.program.coordinates: local in the job where the coordinates behind it are \
                 in it, or world where all are in the first"
            ));
        }
        self.now = if is_first { first } else { system };
        Ok(())
    }
}

impl Reader<'_> {
    /// MSYS: origin, x axis, y axis. CSYS, MCS: rows of a matrix with the origin in its last
    /// column, or x, y and z axes and the origin.
    pub(super) fn system(
        &mut self,
        line: usize,
        major: &str,
        minor: &[Word<'_>],
    ) -> Result<(), String> {
        let numbers: Vec<f64> = minor.iter().filter_map(number).map(|(n, _)| n).collect();
        let v = |at: [usize; 3]| Vector3::new(numbers[at[0]], numbers[at[1]], numbers[at[2]]);
        let found = match (major, numbers.len()) {
            ("MSYS", 9) => {
                let (x, y) = (v([3, 4, 5]), v([6, 7, 8]));
                [Some((x, y, x.cross(&y), v([0, 1, 2]))), None]
            }
            (_, 12) => [
                Some((v([0, 4, 8]), v([1, 5, 9]), v([2, 6, 10]), v([3, 7, 11]))),
                Some((v([0, 1, 2]), v([3, 4, 5]), v([6, 7, 8]), v([9, 10, 11]))),
            ],
            // `CSYS/ON`, a name: nothing that could be told apart.
            (_, 0) => return self.named_system(line, minor),
            (_, count) => return Err(format!("expected 9 or 12 numbers, found {count}")),
        };
        let system = found.into_iter().flatten().find_map(|(x, y, z, origin)| {
            let axes = Matrix3::from_columns(&[x, y, z]);
            let off = (axes.transpose() * axes - Matrix3::identity()).amax();
            (off < AXES_TOLERANCE && axes.determinant() > 0.0).then(|| {
                let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&axes));
                let origin = origin.map(|length| self.mm(length));
                Isometry3::from_parts(Translation3::from(origin), turn)
            })
        });
        let system = system.ok_or("the axes are not unit vectors across one another")?;
        self.no_arc_is_open(line);
        self.senses.lose();
        self.systems.set(line, system)?;
        self.axis = self.systems.axis();
        // The tool stays, and its coordinates are others.
        self.at = self.cutter.place().filter(|_| self.at.is_some());
        self.at = self.at.map(|at| self.systems.frame().back(at));
        Ok(())
    }

    fn named_system(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        if minor.is_empty() {
            return self.systems.set(line, Isometry3::identity());
        }
        Err("expected 9 or 12 numbers".to_owned())
    }
}
