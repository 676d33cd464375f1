//! Where the robot stood, and how a table of modes names it.

use crate::units::{deg_read_as, m_from_mm, mm_read_as, rad_from_deg};

/// Where the robot stood.
#[derive(Debug, Clone, PartialEq)]
pub enum Pose {
    /// Angles of the two-link model, rad.
    Angles {
        /// β1, where it is known.
        beta1: Option<f64>,
        /// β2.
        beta2: f64,
    },
    /// Joint positions from base to tip, rad or m.
    Joints(Vec<f64>),
}

/// Unit of a joint's column in a table of modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionUnit {
    /// Radians.
    Rad,
    /// Degrees.
    Deg,
    /// Metres.
    M,
    /// Millimetres.
    Mm,
}

/// Column of a joint in a table of modes. Without a robot only the column's name says whether the
/// joint slides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointColumn {
    /// Title of the column, which ends in its unit.
    pub title: String,
    /// Unit of the column.
    pub unit: PositionUnit,
}

impl JointColumn {
    /// The column of a joint: a name that ends in `_rad`, `_deg`, `_m` or `_mm` is the title as it
    /// is; any other gets `_deg`.
    pub fn of(name: &str) -> Self {
        let units = [
            ("_rad", PositionUnit::Rad),
            ("_deg", PositionUnit::Deg),
            ("_mm", PositionUnit::Mm),
            ("_m", PositionUnit::M),
        ];
        match units.into_iter().find(|(ending, _)| name.ends_with(ending)) {
            Some((_, unit)) => Self { title: name.to_owned(), unit },
            None => Self { title: format!("{name}_deg"), unit: PositionUnit::Deg },
        }
    }

    /// The column of a joint without a name; `number` counts from 1 at the base.
    fn numbered(number: usize) -> Self {
        Self::of(&format!("joint_{number}"))
    }

    /// The columns of `count` joints: as named, else numbered.
    pub fn list(named: Option<&[Self]>, count: usize) -> Vec<Self> {
        let named = named.unwrap_or(&[]);
        (0..count).map(|i| named.get(i).cloned().unwrap_or_else(|| Self::numbered(i + 1))).collect()
    }

    fn slides(&self) -> bool {
        matches!(self.unit, PositionUnit::M | PositionUnit::Mm)
    }

    /// Position in rad or m of one in degrees or millimetres.
    pub fn si_from_degrees_or_mm(&self, value: f64) -> f64 {
        if self.slides() { m_from_mm(value) } else { rad_from_deg(value) }
    }

    /// Position in degrees or millimetres of one in rad or m.
    pub fn degrees_or_mm(&self, si: f64) -> f64 {
        if self.slides() { mm_read_as(si) } else { deg_read_as(si) }
    }

    /// Position in the column's unit of one in rad or m.
    pub fn in_unit(&self, si: f64) -> f64 {
        match self.unit {
            PositionUnit::Rad | PositionUnit::M => si,
            PositionUnit::Deg | PositionUnit::Mm => self.degrees_or_mm(si),
        }
    }
}
