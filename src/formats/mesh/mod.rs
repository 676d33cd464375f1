//! Surfaces of bodies: STL, OBJ and COLLADA → triangles, thinned out to what a picture needs.
//! Lengths are in the file's unit, COLLADA's in m. The only place that names stl_io and tobj.

mod dae;
mod obj;
mod reduced;
mod stl;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::text::read_bytes;

pub(crate) use reduced::Reduced;

/// A larger file is no drawing of a link.
const MAX_BYTES: u64 = 96 << 20;

/// More triangles are not read.
const MAX_TRIANGLES: usize = 4_000_000;

/// A point farther out than this is a fault of the file.
const FAR: f64 = 1e9;

/// Corners of triangles, three after three.
#[derive(Debug, Clone, Default, PartialEq)]
struct Triangles {
    corners: Vec<[f64; 3]>,
}

impl Triangles {
    /// # Errors
    /// A corner that is not finite or far out; too many triangles.
    fn push(&mut self, triangle: [[f64; 3]; 3]) -> Result<(), String> {
        if triangle.as_flattened().iter().any(|x| !x.is_finite() || x.abs() > FAR) {
            return Err("a point is not finite, or is very far out".to_owned());
        }
        if self.corners.len() >= 3 * MAX_TRIANGLES {
            return Err(format!("holds more than {MAX_TRIANGLES} triangles, the limit"));
        }
        self.corners.extend(triangle);
        Ok(())
    }
}

/// Reads a surface, by the ending of its file's name, with at most about `most` triangles.
///
/// # Errors
/// Why it cannot be read.
pub(crate) fn read(path: &Path, most: usize) -> Result<Reduced, String> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let parse = match ending.to_ascii_lowercase().as_str() {
        "stl" => stl::triangles,
        "obj" => obj::triangles,
        "dae" => dae::triangles,
        _ => return Err("is neither STL, OBJ nor DAE, by its name".to_owned()),
    };
    let bytes = read_bytes(path, MAX_BYTES).map_err(|note| note.what)?;
    let triangles = parse(bytes)?;
    Reduced::of(&triangles, most).ok_or_else(|| "holds no surface".to_owned())
}
