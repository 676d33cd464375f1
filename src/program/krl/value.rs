//! Values of KRL, and what positions and frames mean in SI.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::program::span::Span;
use crate::units::{deg_from_rad, m_from_mm, mm_from_m, rad_from_deg};

/// Components by name in lower case.
pub(super) type Parts = BTreeMap<String, Value>;

/// How a number divides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    Real,
    /// INT.
    Whole,
    /// A whole number where no file says whether it is an INT.
    Open,
}

/// What a declaration says of numbers, and of the components that a position keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Int,
    Real,
    Frame,
    Pos,
    Axis,
    Other,
}

impl Type {
    /// By its name in lower case.
    pub(super) fn named(name: &str) -> Self {
        match name {
            "int" => Self::Int,
            "real" => Self::Real,
            "frame" => Self::Frame,
            "pos" => Self::Pos,
            "axis" => Self::Axis,
            _ => Self::Other,
        }
    }

    /// Whether its data have a component of this name.
    fn has(self, component: &str) -> bool {
        match self {
            Self::Frame => FRAME.contains(&component),
            Self::Pos => FRAME.contains(&component) || matches!(component, "s" | "t"),
            Self::Axis => AXES.contains(&component),
            Self::Int | Self::Real | Self::Other => true,
        }
    }
}

/// INT has 32 bits.
pub(super) const INT: std::ops::RangeInclusive<f64> = -2_147_483_648.0..=2_147_483_647.0;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// With the place of the number in the text that it is, if it is one.
    Num(f64, Option<Span>, Sort),
    Bool(bool),
    Text(String),
    Enum(String),
    Parts(Parts),
    /// Known only at run time, declared elsewhere or wrong: why.
    Unknown(String),
}

impl Value {
    pub(super) fn unknown(why: impl Into<String>) -> Self {
        Self::Unknown(why.into())
    }

    pub(super) const fn real(number: f64) -> Self {
        Self::Num(number, None, Sort::Real)
    }

    pub(super) fn num(&self) -> Result<f64, String> {
        self.number().map(|(number, _)| number)
    }

    pub(super) fn number(&self) -> Result<(f64, Sort), String> {
        match self {
            Self::Num(number, _, sort) => Ok((*number, *sort)),
            other => Err(other.instead_of("a number")),
        }
    }

    /// As a datum of this type holds it; `None` where no file declares the datum.
    pub(super) fn held_as(self, declared: Option<Type>) -> Self {
        match (self, declared) {
            (Self::Num(number, span, Sort::Whole), None) => Self::Num(number, span, Sort::Open),
            (Self::Num(number, span, _), Some(Type::Real)) => Self::Num(number, span, Sort::Real),
            (Self::Num(number, span, _), Some(Type::Int)) => {
                let rounded = number.round();
                if !INT.contains(&rounded) {
                    return Self::unknown(format!("{number} is beyond what an INT holds"));
                }
                Self::Num(rounded, span.filter(|_| rounded == number), Sort::Whole)
            }
            // INT of a CHAR is the code of the character.
            (Self::Text(text), Some(Type::Int)) if text.len() == 1 => {
                let code = text.bytes().next().map_or(0.0, f64::from);
                Self::Num(code, None, Sort::Whole)
            }
            (Self::Parts(mut parts), Some(declared)) => {
                parts.retain(|name, _| declared.has(name));
                Self::Parts(parts)
            }
            (value, _) => value,
        }
    }

    /// As a component of this name holds it.
    pub(super) fn held_in(self, component: &str) -> Self {
        let declared = match component {
            "s" | "t" => Some(Type::Int),
            _ if POSITION.contains(&component) || EXTERNAL.contains(&component) => Some(Type::Real),
            _ => None,
        };
        self.held_as(declared)
    }

    pub(super) fn bool(&self) -> Result<bool, String> {
        match self {
            Self::Bool(value) => Ok(*value),
            other => Err(other.instead_of("TRUE or FALSE")),
        }
    }

    pub(super) fn parts(&self) -> Result<&Parts, String> {
        match self {
            Self::Parts(parts) => Ok(parts),
            other => Err(other.instead_of("a position or a frame")),
        }
    }

    pub(super) fn instead_of(&self, expected: &str) -> String {
        match self {
            Self::Unknown(why) => why.clone(),
            Self::Num(number, ..) => format!("expected {expected}, found {number}"),
            Self::Bool(_) => format!("expected {expected}, found TRUE or FALSE"),
            Self::Text(_) => format!("expected {expected}, found a text"),
            Self::Enum(name) => format!("expected {expected}, found #{name}"),
            Self::Parts(_) => format!("expected {expected}, found {{…}}"),
        }
    }
}

/// A component as a number, if it is there.
pub(super) fn part(parts: &Parts, name: &str) -> Result<Option<f64>, String> {
    parts.get(name).map(Value::num).transpose()
}

/// Names of the components of a frame: mm and degrees about z, the new y and the new x.
pub(super) const FRAME: [&str; 6] = ["x", "y", "z", "a", "b", "c"];

/// {X, Y, Z, A, B, C} in m; what is absent is zero.
pub(super) fn frame(parts: &Parts) -> Result<Isometry3<f64>, String> {
    let mut numbers = [0.0; 6];
    for (number, name) in numbers.iter_mut().zip(FRAME) {
        *number = part(parts, name)?.unwrap_or(0.0);
    }
    Ok(pose(numbers))
}

pub(super) fn pose([x, y, z, a, b, c]: [f64; 6]) -> Isometry3<f64> {
    let at = Translation3::new(m_from_mm(x), m_from_mm(y), m_from_mm(z));
    let [a, b, c] = [a, b, c].map(rad_from_deg);
    Isometry3::from_parts(at, UnitQuaternion::from_euler_angles(c, b, a))
}

/// The other way round.
pub(super) fn numbers(pose: &Isometry3<f64>) -> [f64; 6] {
    let at = pose.translation.vector.map(mm_from_m);
    let (c, b, a) = pose.rotation.euler_angles();
    [at.x, at.y, at.z, deg_from_rad(a), deg_from_rad(b), deg_from_rad(c)]
}

pub(super) fn of_frame(pose: &Isometry3<f64>) -> Value {
    let parts = FRAME.into_iter().zip(numbers(pose));
    Value::Parts(parts.map(|(name, n)| (name.to_owned(), Value::real(n))).collect())
}

/// Components of a position that make it one.
const POSITION: [&str; 12] = ["x", "y", "z", "a", "b", "c", "a1", "a2", "a3", "a4", "a5", "a6"];

/// Components of a position in joints, degrees.
pub(super) const AXES: [&str; 6] = ["a1", "a2", "a3", "a4", "a5", "a6"];

/// Components of external axes.
pub(super) const EXTERNAL: [&str; 6] = ["e1", "e2", "e3", "e4", "e5", "e6"];

/// Whether a value is a position that an unknown procedure may go to.
pub(super) fn is_position(value: &Value) -> bool {
    matches!(value, Value::Parts(parts) if parts.keys().any(|key| POSITION.contains(&key.as_str())))
}

/// `a[3]` is an element of `a`.
pub(super) fn base(key: &str) -> &str {
    key.split('[').next().unwrap_or(key)
}

/// A datum that is declared and has no value yet.
pub(super) fn unset(key: &str) -> Value {
    Value::unknown(format!("'{key}' is read before it is set"))
}
