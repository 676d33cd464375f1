//! The meshes that show a robot's links, each read once. What cannot be read is told, and never a
//! fault: nothing but pictures depends on it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::formats::mesh::{Reduced, read};
use crate::model::Mesh;

/// A mesh is thinned out to about so many triangles.
const MAX_TRIANGLES: usize = 3000;

/// So many meshes of a robot are drawn: with their triangles, a page stays below 5 MB.
pub const MAX_MESHES: usize = 40;

/// Packages are looked for in so many folders above the URDF.
const MAX_ABOVE: usize = 8;

/// A surface as a page holds it: points as 16-bit shares of a box.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Surface {
    /// Names it by its contents.
    #[serde(skip)]
    pub key: String,
    /// The corner of its box with the smallest coordinates.
    pub low: [f64; 3],
    /// The sides of the box.
    pub size: [f64; 3],
    /// Points: three little-endian numbers of 16 bit each, in base 64.
    pub points: String,
    /// Triangles: three numbers of points, likewise.
    pub triangles: String,
}

impl Surface {
    fn of(reduced: &Reduced) -> Self {
        let packed = |numbers: &[[u16; 3]]| -> String {
            let bytes: Vec<u8> =
                numbers.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
            STANDARD.encode(bytes)
        };
        let mut surface = Self {
            key: String::new(),
            low: reduced.low,
            size: reduced.size,
            points: packed(&reduced.points),
            triangles: packed(&reduced.triangles),
        };
        let mut digest = Sha256::new();
        for number in surface.low.iter().chain(&surface.size) {
            digest.update(number.to_le_bytes());
        }
        digest.update(&surface.points);
        digest.update("|");
        digest.update(&surface.triangles);
        surface.key = STANDARD.encode(digest.finalize());
        surface
    }
}

type Found = Result<Arc<Surface>, String>;

/// What was read of each file.
#[derive(Debug, Default)]
pub struct Meshes {
    by_file: Mutex<BTreeMap<PathBuf, Found>>,
}

impl Meshes {
    /// The surface of a mesh.
    ///
    /// # Errors
    /// Why there is none.
    pub fn surface(&self, mesh: &Mesh) -> Found {
        let file = found(mesh).ok_or("no such file")?;
        // Held while a file is read, so that no other job reads it, too.
        let mut by_file = self.by_file.lock().unwrap_or_else(PoisonError::into_inner);
        let read = || read(&file, MAX_TRIANGLES).map(|reduced| Arc::new(Surface::of(&reduced)));
        by_file.entry(file.clone()).or_insert_with(read).clone()
    }
}

/// The file: relative to the URDF, or in a package that lies beside or above it. No network, and no
/// settings of the machine.
fn found(mesh: &Mesh) -> Option<PathBuf> {
    let name = mesh.file.trim();
    if let Some(rest) = name.strip_prefix("package://") {
        let (package, inside) = rest.split_once('/')?;
        let start = std::path::absolute(&mesh.beside).ok()?;
        let above = || start.ancestors().take(MAX_ABOVE);
        let own = above().filter(|folder| folder.ends_with(package));
        let folders = own.map(Path::to_owned).chain(above().map(|at| at.join(package)));
        return folders.map(|folder| folder.join(inside)).find(|file| file.is_file());
    }
    let path = name.strip_prefix("file://").unwrap_or(name);
    if path.contains("://") {
        return None;
    }
    Some(mesh.beside.join(path)).filter(|file| file.is_file())
}
