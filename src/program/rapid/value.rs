//! Values of RAPID data, and what they mean in SI.

use std::rc::Rc;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::number::Number;
use super::syntax::File;
use super::why::Why;
use crate::program::Assumed;
use crate::units::{m_from_mm, mm_from_m};

/// Programs round quaternions to three to six digits; a length further from 1 is another mistake.
const QUATERNION_LENGTH_TOLERANCE: f64 = 0.02;

/// External axes that are not there are written 9E9.
pub(super) const NO_AXIS: f64 = 8.9e9;

/// Elements of all arrays together that a declaration may ask for.
const MAX_ARRAY: usize = 10_000;

/// Characters of a string, as the controller has it.
const MAX_STRING_CHARS: usize = 80;

/// Values in a list, those of the lists in it counted, too: some 45 000 targets.
const MAX_LIST: usize = 1_000_000;

/// Lists in one another.
const MAX_LIST_DEPTH: usize = 20;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Num(Number),
    Bool(bool),
    Text(Rc<str>),
    /// A record or an array.
    List(Vec<Value>),
    /// The flange, where the job may put a tool.
    Tool0,
    /// The world, where the job may put a work object.
    Wobj0,
    /// An optional parameter that the caller left out.
    Absent,
    /// Known only at run time, declared elsewhere or wrong: why.
    Unknown(Why),
}

impl From<Assumed> for Value {
    fn from(assumed: Assumed) -> Self {
        match assumed {
            Assumed::Truth(value) => Self::Bool(value),
            Assumed::Number(value) => Self::Num(Number::of(value)),
        }
    }
}

impl Value {
    pub(super) fn unknown(why: impl Into<String>) -> Self {
        Self::Unknown(Why::from(why.into()))
    }

    pub(super) fn text(text: &str) -> Result<Self, String> {
        if text.chars().count() > MAX_STRING_CHARS {
            return Err(format!("a string has more than {MAX_STRING_CHARS} characters"));
        }
        Ok(Self::Text(Rc::from(text)))
    }

    /// Values in all, this one and those of lists.
    pub(super) fn size(&self) -> usize {
        match self {
            Self::List(items) => 1 + items.iter().map(Self::size).sum::<usize>(),
            _ => 1,
        }
    }

    /// What stands for the controller's own tool0 or wobj0, in its parts, with what the job has for
    /// them.
    pub(super) fn in_parts(self, [tool0, wobj0]: [Option<Isometry3<f64>>; 2]) -> Self {
        let pose = |of_job: Option<Isometry3<f64>>| {
            Self::List(from_pose(&of_job.unwrap_or_default()).to_vec())
        };
        match self {
            Self::Tool0 => Self::List(vec![Self::Bool(true), pose(tool0), load0()]),
            Self::Wobj0 => {
                let is_held = Self::Bool(false);
                let unit = Self::Text(Rc::from(""));
                let frames = [pose(wobj0), pose(None)];
                let parts = [is_held, Self::Bool(true), unit].into_iter().chain(frames);
                Self::List(parts.collect())
            }
            other => other,
        }
    }

    fn depth(&self) -> usize {
        match self {
            Self::List(items) => 1 + items.iter().map(Self::depth).max().unwrap_or(0),
            _ => 0,
        }
    }

    pub(super) fn nums(numbers: &[f64]) -> Self {
        Self::List(numbers.iter().map(|&number| Self::Num(number.into())).collect())
    }

    /// What is worked out of others: exact at most where all numbers in these are.
    pub(super) fn worked_out<'v>(self, given: impl IntoIterator<Item = &'v Self>) -> Self {
        let (mut is_exact, mut is_of_robot) = (true, false);
        for own in given {
            is_exact &= own.is_exact();
            is_of_robot |= own.is_of_robot();
        }
        match self {
            Self::Num(number) if is_of_robot => Self::Num(number.of_robot()),
            _ if is_exact => self,
            _ => self.opened(),
        }
    }

    /// Whether it is a number that depends on the robot.
    pub(super) fn is_of_robot(&self) -> bool {
        matches!(self, Self::Num(number) if number.is_of_robot())
    }

    fn is_exact(&self) -> bool {
        match self {
            Self::Num(number) => number.is_exact(),
            Self::List(items) => items.iter().all(Self::is_exact),
            _ => true,
        }
    }

    /// The same with numbers of which the rounding is not known.
    pub(super) fn opened(self) -> Self {
        match self {
            Self::Num(number) => Self::Num(number.opened()),
            Self::List(items) => Self::List(items.into_iter().map(Self::opened).collect()),
            other => other,
        }
    }

    pub(super) fn num(&self) -> Result<f64, String> {
        match self {
            Self::Num(number) => number.known(),
            other => Err(other.instead_of("a number")),
        }
    }

    /// The same with what the controller makes of it.
    pub(super) fn number(&self) -> Result<Number, String> {
        match self {
            Self::Num(number) => number.settled(),
            other => Err(other.instead_of("a number")),
        }
    }

    pub(super) fn bool(&self) -> Result<bool, String> {
        match self {
            Self::Bool(value) => Ok(*value),
            other => Err(other.instead_of("TRUE or FALSE")),
        }
    }

    /// The component `index` of a record of which `expected` says what it is.
    pub(super) fn part(&self, index: usize, expected: &str) -> Result<&Value, String> {
        match self {
            Self::List(items) => {
                items.get(index).ok_or_else(|| format!("expected {expected}, found fewer values"))
            }
            other => Err(other.instead_of(expected)),
        }
    }

    pub(super) fn numbers<const N: usize>(&self, expected: &str) -> Result<[f64; N], String> {
        match self {
            Self::List(items) if items.len() == N => {
                let mut numbers = [0.0; N];
                for (number, item) in numbers.iter_mut().zip(items) {
                    *number = item.num()?;
                }
                Ok(numbers)
            }
            Self::List(items) => {
                Err(format!("expected {expected} ({N} numbers), found {} values", items.len()))
            }
            other => Err(other.instead_of(expected)),
        }
    }

    /// Why the first component of a record is not known, and so the record as such.
    pub(super) fn why_first_unknown(&self) -> Option<&Why> {
        match self {
            Self::List(parts) => match parts.first() {
                Some(Self::Unknown(why)) => Some(why),
                _ => None,
            },
            _ => None,
        }
    }

    pub(super) fn instead_of(&self, expected: &str) -> String {
        match self {
            Self::Unknown(why) => why.to_string(),
            Self::Absent => format!("expected {expected}, but the caller left this argument out"),
            Self::Num(number) => format!("expected {expected}, found {number}"),
            Self::Bool(_) => format!("expected {expected}, found a bool"),
            Self::Text(_) => format!("expected {expected}, found a string"),
            Self::List(_) => format!("expected {expected}, found a record or an array"),
            Self::Tool0 => format!("expected {expected}, found tool0"),
            Self::Wobj0 => format!("expected {expected}, found wobj0"),
        }
    }
}

/// No load, as the controller declares it.
pub(super) fn load0() -> Value {
    point_load(0.001, 0.001)
}

/// The load that RobotStudio gives to a new tool.
pub(super) fn load_of_new_tool() -> Value {
    point_load(1.0, 1.0)
}

fn point_load(mass_kg: f64, z_mm: f64) -> Value {
    let [centre, axes] = [Value::nums(&[0.0, 0.0, z_mm]), Value::nums(&[1.0, 0.0, 0.0, 0.0])];
    let [mass, none] = [mass_kg, 0.0].map(|number| Value::Num(Number::of(number)));
    Value::List(vec![mass, centre, axes, none.clone(), none.clone(), none])
}

/// A size that data may have: loops must not ask for all memory.
pub(super) fn within_size(size: usize) -> Result<usize, String> {
    if size > MAX_LIST {
        return Err(format!("the list is too large: more than {MAX_LIST} values"));
    }
    Ok(size)
}

/// A value that may be kept `under` so many lists.
pub(super) fn within_depth(value: Value, under: usize) -> Result<Value, String> {
    if under + value.depth() > MAX_LIST_DEPTH {
        return Err("lists are nested too deep".to_owned());
    }
    Ok(value)
}

/// `[[x,y,z],[q1,q2,q3,q4]]` in the first two components → a pose in metres.
pub(super) fn pose(value: &Value) -> Result<Isometry3<f64>, String> {
    let translation: [f64; 3] = value.part(0, "a position")?.numbers("a position")?;
    let rotation = orientation(value.part(1, "an orientation")?)?;
    Ok(Isometry3::from_parts(Translation3::from(translation.map(m_from_mm)), rotation))
}

/// A pose in metres → `[[x,y,z],[q1,q2,q3,q4]]` in mm.
pub(super) fn from_pose(pose: &Isometry3<f64>) -> [Value; 2] {
    let at = pose.translation.vector.map(mm_from_m);
    [Value::nums(at.as_slice()), from_orientation(&pose.rotation)]
}

pub(super) fn orientation(value: &Value) -> Result<UnitQuaternion<f64>, String> {
    let [w, x, y, z] = value.numbers("a quaternion")?;
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() > QUATERNION_LENGTH_TOLERANCE {
        return Err(format!("quaternion [{w}, {x}, {y}, {z}] has length {length:.4}, must be 1"));
    }
    // q and −q are one rotation; with a real part ≥ 0 neighbours are near each other as numbers,
    // too.
    let quaternion = if w < 0.0 { -quaternion } else { quaternion };
    Ok(UnitQuaternion::from_quaternion(quaternion))
}

pub(super) fn from_orientation(rotation: &UnitQuaternion<f64>) -> Value {
    Value::nums(&[rotation.w, rotation.i, rotation.j, rotation.k])
}

pub(super) fn position(value: &Value) -> Result<Vector3<f64>, String> {
    let numbers: [f64; 3] = value.numbers("a position")?;
    Ok(Vector3::from(numbers))
}

const POSE: &[(&str, &str)] = &[("trans", "pos"), ("rot", "orient")];

/// Fields (name, type) of RAPID's own records.
fn built_in_fields(kind: &str) -> Option<&'static [(&'static str, &'static str)]> {
    let fields: &[(&str, &str)] = match kind {
        "pos" => &[("x", "num"), ("y", "num"), ("z", "num")],
        "orient" => &[("q1", "num"), ("q2", "num"), ("q3", "num"), ("q4", "num")],
        "pose" => POSE,
        "confdata" => &[("cf1", "num"), ("cf4", "num"), ("cf6", "num"), ("cfx", "num")],
        "extjoint" => &[
            ("eax_a", "num"),
            ("eax_b", "num"),
            ("eax_c", "num"),
            ("eax_d", "num"),
            ("eax_e", "num"),
            ("eax_f", "num"),
        ],
        "robjoint" => &[
            ("rax_1", "num"),
            ("rax_2", "num"),
            ("rax_3", "num"),
            ("rax_4", "num"),
            ("rax_5", "num"),
            ("rax_6", "num"),
        ],
        "robtarget" => {
            &[("trans", "pos"), ("rot", "orient"), ("robconf", "confdata"), ("extax", "extjoint")]
        }
        "jointtarget" => &[("robax", "robjoint"), ("extax", "extjoint")],
        "loaddata" => &[
            ("mass", "num"),
            ("cog", "pos"),
            ("aom", "orient"),
            ("ix", "num"),
            ("iy", "num"),
            ("iz", "num"),
        ],
        "tooldata" => &[("robhold", "bool"), ("tframe", "pose"), ("tload", "loaddata")],
        "wobjdata" => &[
            ("robhold", "bool"),
            ("ufprog", "bool"),
            ("ufmec", "string"),
            ("uframe", "pose"),
            ("oframe", "pose"),
        ],
        "speeddata" => &[("v_tcp", "num"), ("v_ori", "num"), ("v_leax", "num"), ("v_reax", "num")],
        "zonedata" => &[
            ("finep", "bool"),
            ("pzone_tcp", "num"),
            ("pzone_ori", "num"),
            ("pzone_eax", "num"),
            ("zone_ori", "num"),
            ("zone_leax", "num"),
            ("zone_reax", "num"),
        ],
        "stoppointdata" => &[
            ("type", "num"),
            ("progsynch", "bool"),
            ("inpos", "inposdata"),
            ("stoptime", "num"),
            ("followtime", "num"),
            ("signal", "string"),
            ("relation", "num"),
            ("checkvalue", "num"),
        ],
        "inposdata" => {
            &[("position", "num"), ("speed", "num"), ("mintime", "num"), ("maxtime", "num")]
        }
        _ => return None,
    };
    Some(fields)
}

/// Place and type of a field of a record.
pub(super) fn field<'a>(file: &'a File, kind: &str, name: &str) -> Option<(usize, &'a str)> {
    if let Some(fields) = built_in_fields(kind) {
        let index = fields.iter().position(|(field, _)| *field == name)?;
        return fields.get(index).map(|(_, kind)| (index, *kind));
    }
    let fields = file.records.get(kind)?;
    let index = fields.iter().position(|(field, _)| field == name)?;
    fields.get(index).map(|(_, kind)| (index, kind.as_str()))
}

/// What a datum of a type holds when nothing was given to it: zeros, as the controller has it.
pub(super) fn initial(file: &File, kind: &str) -> Value {
    initial_at(file, kind, 0)
}

fn initial_at(file: &File, kind: &str, depth: usize) -> Value {
    match kind {
        "num" | "dnum" | "intnum" | "byte" | "errnum" => return Value::Num(Number::of(0.0)),
        "bool" => return Value::Bool(false),
        "string" => return Value::Text(Rc::from("")),
        _ => {}
    }
    if let Some(fields) = built_in_fields(kind) {
        return Value::List(fields.iter().map(|(_, kind)| initial_at(file, kind, 0)).collect());
    }
    match file.records.get(kind) {
        // A record that holds itself is no RAPID; the depth only keeps it from running away.
        Some(fields) if depth < 3 && fields.len() < 64 => {
            Value::List(fields.iter().map(|(_, kind)| initial_at(file, kind, depth + 1)).collect())
        }
        _ => Value::unknown(format!("nothing is known of the type '{kind}'")),
    }
}

/// An array of initial values.
pub(super) fn initial_array(element: Value, dimensions: &[usize]) -> Value {
    let size = dimensions.iter().try_fold(1_usize, |size, &n| size.checked_mul(n));
    if size.is_none_or(|size| size > MAX_ARRAY) {
        return Value::unknown("the array is too large");
    }
    dimensions.iter().rev().fold(element, |inner, &n| Value::List(vec![inner; n]))
}
