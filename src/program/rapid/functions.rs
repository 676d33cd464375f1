//! RAPID's own functions, as far as targets and speeds are computed with them. Lengths in mm and
//! angles in degrees, as RAPID has them.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::bits;
use super::number::Number;
use super::value::{Value, from_orientation, from_pose, orientation, pose, position};
use crate::program::functions::function;
use crate::units::{deg_from_rad, m_from_mm, rad_from_deg};

/// Arguments of a call: those without backslash, and those with, by name in lower case.
pub(super) struct Given<'a> {
    pub(super) positional: &'a [Value],
    pub(super) optional: &'a [(String, Value)],
}

impl Given<'_> {
    pub(super) fn at(&self, index: usize) -> Result<&Value, String> {
        self.positional.get(index).ok_or_else(|| format!("argument {} is missing", index + 1))
    }

    pub(super) fn num(&self, index: usize) -> Result<f64, String> {
        self.at(index)?.num()
    }

    pub(super) fn text(&self, index: usize) -> Result<&str, String> {
        match self.at(index)? {
            Value::Text(text) => Ok(text),
            Value::Unknown(why) => Err(why.to_string()),
            _ => Err(format!("argument {} must be a string", index + 1)),
        }
    }

    fn option(&self, name: &str) -> Option<&Value> {
        self.optional.iter().find(|(found, _)| found == name).map(|(_, value)| value)
    }

    fn option_num(&self, name: &str) -> Result<f64, String> {
        self.option(name).map_or(Ok(0.0), Value::num)
    }
}

/// The value of function `key` (lower case); `None` if there is no such function here.
pub(super) fn call(key: &str, given: &Given) -> Option<Result<Value, String>> {
    let value = match key {
        "offs" => offs(given),
        "reltool" => rel_tool(given),
        "max" | "min" => given.at(0).and_then(Value::number).and_then(|left| {
            let larger = if key == "max" { f64::max } else { f64::min };
            Ok(Value::Num(left.with(given.at(1)?.number()?, larger)))
        }),
        "abs" => given
            .at(0)
            .and_then(Value::number)
            .map(|number| Value::Num(number.with(number, |number, _| number.abs()))),
        "numtodnum" => given.at(0).and_then(Value::number).map(|own| Value::Num(own.to_dnum())),
        "dnumtonum" => dnum_to_num(given),
        "dim" => dim(given),
        // Without a program displacement, which is refused, it is the point itself.
        "orobt" => given.at(0).cloned(),
        "round" | "rounddnum" => at_decimals(given, Number::rounded),
        "trunc" | "truncdnum" => at_decimals(given, Number::truncated),
        _ if key.starts_with("bit") => {
            bits::call(key, given.positional, !given.optional.is_empty())?
        }
        _ => worked_out(key, given)?.map(|value| {
            let options = given.optional.iter().map(|(_, value)| value);
            value.worked_out(given.positional.iter().chain(options))
        }),
    };
    Some(value.and_then(finite))
}

/// The same of functions that work in double: what the controller rounds is not followed.
fn worked_out(key: &str, given: &Given) -> Option<Result<Value, String>> {
    Some(match key {
        "posemult" => given.at(0).and_then(pose).and_then(|left| {
            let product = left * pose(given.at(1)?)?;
            Ok(Value::List(from_pose(&product).to_vec()))
        }),
        "poseinv" => given
            .at(0)
            .and_then(pose)
            .map(|given| Value::List(from_pose(&given.inverse()).to_vec())),
        "posevect" => pose_vect(given),
        "defframe" => def_frame(given),
        "orientzyx" => orient_zyx(given),
        "eulerzyx" => euler_zyx(given),
        "norient" => given.at(0).and_then(normalised),
        "distance" => given.at(0).and_then(position).and_then(|from| {
            let to = position(given.at(1)?)?;
            Ok(Value::Num((to - from).norm().into()))
        }),
        "vectmagn" => given.at(0).and_then(position).map(|vector| Value::Num(vector.norm().into())),
        "dotprod" => given
            .at(0)
            .and_then(position)
            .and_then(|left| Ok(Value::Num(left.dot(&position(given.at(1)?)?).into()))),
        "crossprod" => given
            .at(0)
            .and_then(position)
            .and_then(|left| Ok(Value::nums(left.cross(&position(given.at(1)?)?).as_slice()))),
        "pow" | "powdnum" => {
            given.num(0).and_then(|base| Ok(Value::Num(base.powf(given.num(1)?).into())))
        }
        "atan2" | "atan2dnum" => {
            given.num(0).and_then(|y| Ok(Value::Num(deg_from_rad(y.atan2(given.num(1)?)).into())))
        }
        _ => {
            let function = numeric(key.strip_suffix("dnum").unwrap_or(key))?;
            given.num(0).map(|x| Value::Num(function(x).into()))
        }
    })
}

/// Why function `key` (lower case) has no value, however the controller rounds: it stops there.
pub(super) fn undefined(key: &str, given: &[Value]) -> Option<String> {
    /// What rounding leaves.
    const ROUNDED: f64 = 1e-4;
    let at = |index: usize| given.get(index)?.num().ok();
    let x = at(0)?;
    let is_undefined = match key {
        "sqrt" => x < -ROUNDED,
        "asin" | "acos" => x.abs() > 1.0 + ROUNDED,
        "pow" => {
            let power = at(1)?;
            x < -ROUNDED && power.fract() != 0.0 || x == 0.0 && power < 0.0
        }
        _ => false,
    };
    is_undefined.then(|| format!("the result for {x} is not finite"))
}

fn numeric(key: &str) -> Option<fn(f64) -> f64> {
    match key {
        "atan" => Some(|x| deg_from_rad(x.atan())),
        // RAPID has no natural logarithm.
        "ln" => None,
        _ => function(&key.to_ascii_uppercase()),
    }
}

/// Numbers that are not finite never get further than the line that makes them.
pub(super) fn finite(value: Value) -> Result<Value, String> {
    match value {
        Value::Num(number) if !number.is_finite() => Err("the result is not finite".to_owned()),
        value => Ok(value),
    }
}

/// `Offs(p, x, y, z)`: moved along the axes of the work object.
fn offs(given: &Given) -> Result<Value, String> {
    const AT: &str = "a position";
    let at = given.at(0)?.part(0, "a robtarget")?;
    position(at)?;
    let moved = (0..3).map(|axis| {
        let (own, by) = (at.part(axis, AT)?.number()?, given.at(axis + 1)?.number()?);
        Ok(Value::Num(own.with(by, |own, by| own + by)))
    });
    let moved = moved.collect::<Result<Vec<_>, String>>()?;
    with_parts(given.at(0)?, &[(0, Value::List(moved))])
}

/// `RelTool(p, x, y, z \Rx \Ry \Rz)`: moved along the axes of the tool, then turned about its x,
/// its new y and its new z axis.
fn rel_tool(given: &Given) -> Result<Value, String> {
    let turn = |axis, name| -> Result<UnitQuaternion<f64>, String> {
        Ok(UnitQuaternion::from_axis_angle(&axis, rad_from_deg(given.option_num(name)?)))
    };
    let rotation = turn(Vector3::x_axis(), "rx")?
        * turn(Vector3::y_axis(), "ry")?
        * turn(Vector3::z_axis(), "rz")?;
    let shift = Vector3::new(given.num(1)?, given.num(2)?, given.num(3)?).map(m_from_mm);
    let target = given.at(0)?;
    let moved = pose(target)? * Isometry3::from_parts(Translation3::from(shift), rotation);
    let [translation, rotation] = from_pose(&moved).map(Value::opened);
    with_parts(target, &[(0, translation), (1, rotation)])
}

fn with_parts(record: &Value, parts: &[(usize, Value)]) -> Result<Value, String> {
    let Value::List(mut items) = record.clone() else {
        return Err("expected a robtarget".to_owned());
    };
    for (index, part) in parts {
        match items.get_mut(*index) {
            Some(item) => *item = part.clone(),
            None => return Err("expected a robtarget, found fewer values".to_owned()),
        }
    }
    Ok(Value::List(items))
}

/// `Dim(array, 2)`: how long an array is along a dimension.
fn dim(given: &Given) -> Result<Value, String> {
    let (mut value, mut dimension) = (given.at(0)?, given.num(1)?);
    while let Value::List(items) = value {
        if dimension == 1.0 {
            return Ok(Value::Num((items.len() as f64).into()));
        }
        dimension -= 1.0;
        value = items.first().ok_or("the array is empty")?;
    }
    match value {
        Value::Unknown(why) => Err(why.to_string()),
        _ => Err("the array has no such dimension".to_owned()),
    }
}

fn pose_vect(given: &Given) -> Result<Value, String> {
    let frame = pose(given.at(0)?)?;
    let at = position(given.at(1)?)?;
    let rotated = frame.rotation * at + frame.translation.vector.map(crate::units::mm_from_m);
    Ok(Value::nums(rotated.as_slice()))
}

/// `DefFrame(p1, p2, p3 \Origin)`: x from p1 through p2, p3 on the side of y; the origin in p1, in
/// p2, or where the y axis goes through p3.
fn def_frame(given: &Given) -> Result<Value, String> {
    /// Points nearer than this give no direction.
    const NEAR_MM: f64 = 0.1;
    let at = |index: usize| position(given.at(index)?.part(0, "a robtarget")?);
    let (first, second, third) = (at(0)?, at(1)?, at(2)?);
    let x = (second - first).try_normalize(NEAR_MM).ok_or("the first two points are one")?;
    let z = x.cross(&(third - first)).try_normalize(NEAR_MM);
    let z = z.ok_or("the three points lie on a line")?;
    let origin = match given.option("origin").map(Value::num).transpose()? {
        None | Some(1.0) => first,
        Some(2.0) => second,
        Some(3.0) => first + x * x.dot(&(third - first)),
        Some(other) => return Err(format!("\\Origin is {other}, expected 1, 2 or 3")),
    };
    let axes = Rotation3::from_basis_unchecked(&[x, z.cross(&x), z]);
    let turned = UnitQuaternion::from_rotation_matrix(&axes);
    Ok(Value::List(vec![Value::nums(origin.as_slice()), from_orientation(&turned)]))
}

/// Rotations about z, the new y and the new x axis.
fn orient_zyx(given: &Given) -> Result<Value, String> {
    let [z, y, x] = [given.num(0)?, given.num(1)?, given.num(2)?].map(rad_from_deg);
    Ok(from_orientation(&UnitQuaternion::from_euler_angles(x, y, z)))
}

fn euler_zyx(given: &Given) -> Result<Value, String> {
    let (x, y, z) = orientation(given.at(0)?)?.euler_angles();
    let angle = match ["x", "y", "z"].map(|name| given.option(name).is_some()) {
        [true, false, false] => x,
        [false, true, false] => y,
        [false, false, true] => z,
        _ => return Err("expected one of \\X, \\Y, \\Z".to_owned()),
    };
    Ok(Value::Num(deg_from_rad(angle).into()))
}

fn normalised(value: &Value) -> Result<Value, String> {
    let numbers: [f64; 4] = value.numbers("a quaternion")?;
    let length = numbers.iter().map(|number| number * number).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        Ok(Value::nums(&numbers.map(|number| number / length)))
    } else {
        Err(format!("a quaternion of length {length} has no direction"))
    }
}

fn at_decimals(
    given: &Given,
    to_whole: fn(Number) -> Result<Number, String>,
) -> Result<Value, String> {
    let number = given.at(0)?.number()?;
    number.at_decimals(given.option_num("dec")?, to_whole).map(Value::Num)
}

/// `DnumToNum(d \Integer)`.
fn dnum_to_num(given: &Given) -> Result<Value, String> {
    let number = given.at(0)?.number()?;
    if given.option("integer").is_some() && number.known()?.fract() != 0.0 {
        return Err(format!("{number} is no whole number"));
    }
    Ok(Value::Num(number.to_num()))
}
