//! What all JSON outputs have in common: numbers that are finite, text that nothing takes for a
//! command, and a layout that people can read.

mod finite;
mod warning;

use std::fmt;
use std::io;

pub(super) use self::warning::{Warning, notices};
use crate::wording::printable_json;
use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter};

/// A number was not finite and could not be written.
#[derive(Debug)]
pub struct NotFinite(serde_json::Error);

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for NotFinite {}

/// An output as text: objects and lists nested deeper than `deepest_spread` stand on one line.
pub(super) fn laid_out(
    output: &impl Serialize,
    deepest_spread: usize,
) -> Result<String, NotFinite> {
    output.serialize(finite::Finite).map_err(NotFinite)?;
    spread(output, deepest_spread).map_err(NotFinite)
}

/// The same, where a number that is not finite becomes null.
pub(super) fn spread(
    output: &impl Serialize,
    deepest_spread: usize,
) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    let layout = Layout { spread: PrettyFormatter::new(), depth: 0, deepest_spread };
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, layout);
    output.serialize(&mut serializer)?;
    bytes.push(b'\n');
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// For [`spread`]: all of it.
pub(super) const WHOLE: usize = usize::MAX;

/// Pretty down to a depth, and one line a value below it.
struct Layout {
    spread: PrettyFormatter<'static>,
    depth: usize,
    deepest_spread: usize,
}

impl Layout {
    /// What stands inside the innermost open bracket is spread.
    fn is_spread(&self) -> bool {
        self.depth <= self.deepest_spread
    }
}

/// Writes a step of the spread layout or the compact one.
macro_rules! either {
    ($self:ident, $step:ident($($argument:expr),*)) => {
        if $self.is_spread() {
            $self.spread.$step($($argument),*)
        } else {
            CompactFormatter.$step($($argument),*)
        }
    };
}

impl Formatter for Layout {
    /// Nothing in a name steers a terminal or a build server.
    fn write_string_fragment<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        fragment: &str,
    ) -> io::Result<()> {
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b' ';
        if fragment.bytes().all(is_plain) {
            return writer.write_all(fragment.as_bytes());
        }
        writer.write_all(printable_json(fragment).as_bytes())
    }

    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        either!(self, begin_array(writer))
    }

    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        either!(self, end_array(writer))?;
        self.depth -= 1;
        Ok(())
    }

    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        w: &mut W,
        first: bool,
    ) -> io::Result<()> {
        either!(self, begin_array_value(w, first))
    }

    fn end_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        either!(self, end_array_value(writer))
    }

    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        either!(self, begin_object(writer))
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        either!(self, end_object(writer))?;
        self.depth -= 1;
        Ok(())
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        w: &mut W,
        first: bool,
    ) -> io::Result<()> {
        either!(self, begin_object_key(w, first))
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        either!(self, begin_object_value(writer))
    }

    fn end_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        either!(self, end_object_value(writer))
    }
}
