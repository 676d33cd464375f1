//! Variables of Sinumerik's: those that a program declares (DEF), its arrays, and the control's.

use super::expression::{Reader, not_vacant};
use super::parameters::{Key, Parameters, Set};
use super::words::is_word;

/// Of an array.
const MOST_ELEMENTS: u32 = 1000;

impl Reader<'_> {
    /// A variable, or an element of an array.
    pub(super) fn of_variable(&mut self) -> Result<f64, String> {
        let name = self.variable();
        match self.bytes.get(self.at) {
            Some(b'[') => {
                let key = self.indexed(name)?;
                self.parameter(key)
            }
            other if other != Some(&b'(') && name.len() > 1 && !is_word(&name) => {
                self.parameter(Key::Name(name))
            }
            _ => Err(format!("'{}' is not understood in an expression", name.to_uppercase())),
        }
    }

    /// `[2]` behind the name of an array in lower case, or behind R.
    pub(super) fn indexed(&mut self, name: String) -> Result<Key, String> {
        let index = whole(self.deeper(Self::value)?)?;
        Ok(Key::Name(if name == "r" { format!("r{index}") } else { format!("{name}[{index}]") }))
    }

    /// A variable of the control, `$MN_USER_DATA_INT[1]`, `$MA_MAX_AX_VELO[X1]`, whose indices are
    /// numbers or axes.
    pub(super) fn of_control(&mut self) -> Result<f64, String> {
        self.at += 1;
        let name = format!("${}", self.variable());
        if !self.take(b'[') {
            return self.parameter(Key::Name(name));
        }
        let mut all = vec![self.deeper(Self::index_of_control)?];
        while self.take(b',') {
            all.push(self.deeper(Self::index_of_control)?);
        }
        if !self.take(b']') {
            return Err(format!("expected ']' behind the index of {}", name.to_uppercase()));
        }
        self.parameter(Key::Name(format!("{name}[{}]", all.join(","))))
    }

    /// A number that is worked out, or the name of an axis as it stands there.
    fn index_of_control(&mut self) -> Result<String, String> {
        let begins = self.peek().is_some_and(|byte| byte.is_ascii_alphabetic());
        let before = self.at;
        let name = self.variable();
        let is_alone = matches!(self.peek(), Some(b',' | b']'));
        let key = Key::Name(name);
        if begins && is_alone && !self.parameters.is_variable(&key) {
            return Ok(key.name().unwrap_or_default().to_owned());
        }
        self.at = before;
        whole(not_vacant(self.expression()?)?).map(|index| index.to_string())
    }
}

/// The index of an element.
fn whole(index: f64) -> Result<f64, String> {
    if index >= 0.0 && index.fract() == 0.0 {
        Ok(index)
    } else {
        Err(format!("the index is {index}, expected a whole number from 0"))
    }
}

/// The names behind `DEF STRING[80]`.
pub(super) fn texts(text: &str) -> Option<impl Iterator<Item = String>> {
    const KIND: &str = "STRING";
    let (kind, behind) = text.split_at_checked(KIND.len())?;
    let behind = behind.trim_start();
    let behind = match behind.strip_prefix('[').map(|own| own.split_once(']')) {
        Some(length) => length?.1,
        None => behind,
    };
    let name = |part: &str| part.split(['=', '[']).next().unwrap_or("").trim().to_lowercase();
    kind.eq_ignore_ascii_case(KIND).then(|| behind.split(',').map(name))
}

/// Sets what stands behind DEF: `REAL _depth = 5, _feeds[3]`. Numbers, 0 where nothing is said, and
/// not a number where it cannot be read.
pub(super) fn define(text: &str, known: &Parameters, sets: &mut Vec<Set>) -> Result<(), String> {
    let (kind, names) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let key: fn(String) -> Key = match kind.to_ascii_uppercase().as_str() {
        "REAL" => Key::Name,
        "INT" => Key::Whole,
        "BOOL" => Key::Truth,
        _ => return Ok(()),
    };
    let mut done = Ok(());
    for part in names.split(',') {
        if let Some((name, size)) = part.split_once('[') {
            let name = name.trim().to_ascii_lowercase();
            let size = size.trim_end().strip_suffix(']').and_then(|size| size.trim().parse().ok());
            let size = size.filter(|size| (1..=MOST_ELEMENTS).contains(size)).ok_or_else(|| {
                format!(
                    "DEF of the array '{name}': arrays are read with one dimension, a number for \
                     their size up to {MOST_ELEMENTS} and no values behind it"
                )
            })?;
            sets.extend((0..size).map(|index| (key(format!("{name}[{index}]")), 0.0, None)));
            continue;
        }
        let (name, value) = part.split_once('=').unwrap_or((part, "0"));
        let value = first_value(value, known);
        let key = key(name.trim().to_ascii_lowercase());
        sets.push((key, value.as_ref().copied().unwrap_or(f64::NAN), None));
        done = done.and(value.map(|_| ()));
    }
    done
}

/// The value that a variable is declared with.
fn first_value(text: &str, known: &Parameters) -> Result<f64, String> {
    let mut reader = Reader::new(text.as_bytes(), 0, known);
    let value = not_vacant(reader.expression()?)?;
    match reader.peek() {
        None => Ok(value),
        Some(byte) => Err(format!("'{}' is not understood behind DEF", char::from(byte))),
    }
}

/// `R[4]=`, `FEEDS[2]=`, whose `[` is at a place: what is set, and where the value begins.
pub(super) fn element(
    name: &str,
    line: &[u8],
    at: usize,
    known: &Parameters,
) -> Result<(Key, usize), String> {
    let wrong = |more: &str| {
        format!("'{name}[ ]' is no R parameter, and no element of an array of DEF{more}")
    };
    let mut reader = Reader::new(line, at, known);
    let key = reader.indexed(name.to_ascii_lowercase()).map_err(|why| format!("{name}: {why}"))?;
    if !(name == "R" || known.may_set(&key)) {
        return Err(wrong(&known.declared_by_job(&key)));
    }
    if reader.take(b'=') { Ok((key, reader.at)) } else { Err(wrong("")) }
}
