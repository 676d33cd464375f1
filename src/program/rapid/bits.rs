//! Bits of byte and dnum data; bit 1 is the lowest.

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Path};
use super::value::Value;

const BYTE_BITS: u32 = 8;
const DNUM_BITS: u32 = 52;

const KNOWN: [&str; 7] = ["bitand", "bitcheck", "bitlsh", "bitneg", "bitor", "bitrsh", "bitxor"];

/// A number of so many bits.
fn whole(value: f64, bits: u32) -> Result<u64, String> {
    let is_one = value >= 0.0 && value.fract() == 0.0 && value < 2_f64.powi(bits as i32);
    // Whole and below 2^52, checked above.
    is_one.then_some(value as u64).ok_or_else(|| {
        let most = (1_u64 << bits) - 1;
        format!("expected a whole number from 0 to {most}, found {value}")
    })
}

/// A place or a number of places among so many bits.
fn places(value: f64, bits: u32) -> Result<u32, String> {
    let is_one = (1.0..=f64::from(bits)).contains(&value) && value.fract() == 0.0;
    // Whole and at most 52, checked above.
    is_one
        .then_some(value as u32)
        .ok_or_else(|| format!("expected a whole number from 1 to {bits}, found {value}"))
}

/// The value of a function of bits (lower case); `None` if there is no such function.
pub(super) fn call(key: &str, args: &[Value], has_options: bool) -> Option<Result<Value, String>> {
    let (own, bits) = key.strip_suffix("dnum").map_or((key, BYTE_BITS), |own| (own, DNUM_BITS));
    let at = |index: usize| -> Result<f64, String> {
        args.get(index).ok_or_else(|| format!("argument {} is missing", index + 1))?.num()
    };
    let all = (1_u64 << bits) - 1;
    let (of_one, of_two) = (|| whole(at(0)?, bits), || whole(at(1)?, bits));
    let steps = || places(at(1)?, bits);
    let bits_of = || -> Result<u64, String> {
        Ok(match own {
            "bitand" => of_one()? & of_two()?,
            "bitor" => of_one()? | of_two()?,
            "bitxor" => of_one()? ^ of_two()?,
            "bitneg" => !of_one()? & all,
            "bitlsh" => (of_one()? << steps()?) & all,
            "bitrsh" => of_one()? >> steps()?,
            _ => (of_one()? >> (steps()? - 1)) & 1,
        })
    };
    let value = match (KNOWN.contains(&own), has_options) {
        (false, _) => return None,
        (_, true) => Err("with options it is not read".to_owned()),
        _ => bits_of(),
    };
    Some(value.map(|value| match own {
        "bitcheck" => Value::Bool(value == 1),
        _ => Value::Num((value as f64).into()),
    }))
}

impl<'a> Interpreter<'a> {
    /// `BitSet b, 3;`, `BitClear b, 3;`.
    pub(super) fn change_bit(&mut self, line: usize, key: &str, args: &'a Args) {
        let Some(Expr::Ref(path)) = args.positional.first() else { return };
        self.refuse_constant(line, path);
        self.doubt_assignment(line, path, None);
        let place = args.positional.get(1).map(|expr| self.eval(expr).num());
        let place = place.unwrap_or_else(|| Err("the bit is missing".to_owned()));
        let value = self.with_bit(path, key == "bitset", place).unwrap_or_else(Value::unknown);
        self.assign(path, value, Some(line));
    }

    fn with_bit(
        &mut self,
        path: &'a Path,
        is_set: bool,
        place: Result<f64, String>,
    ) -> Result<Value, String> {
        let is_dnum = self.kind_of(&path.name.key) == Some("dnum");
        let bits = if is_dnum { DNUM_BITS } else { BYTE_BITS };
        let bit = 1 << (places(place?, bits)? - 1);
        let value = whole(self.read(path).num()?, bits)?;
        let value = if is_set { value | bit } else { value & !bit };
        Ok(Value::Num((value as f64).into()))
    }
}
