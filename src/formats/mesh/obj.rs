//! Wavefront OBJ: its surfaces alone, without materials.

use super::Triangles;

pub(super) fn triangles(bytes: Vec<u8>) -> Result<Triangles, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    // Files that it names are not opened.
    let no_material = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut bytes.as_slice(), &options, no_material)
        .map_err(|error| format!("cannot be read as OBJ: {error}"))?;
    let mut out = Triangles::default();
    for mesh in models.iter().map(|model| &model.mesh) {
        let corner = |index: &u32| -> Option<[f64; 3]> {
            let at = 3 * *index as usize;
            let point = <[f32; 3]>::try_from(mesh.positions.get(at..at + 3)?).ok()?;
            Some(point.map(f64::from))
        };
        for triangle in mesh.indices.chunks_exact(3) {
            let corners: Option<Vec<[f64; 3]>> = triangle.iter().map(corner).collect();
            let corners = corners.and_then(|corners| <[[f64; 3]; 3]>::try_from(corners).ok());
            out.push(corners.ok_or("a face names a point that is not there")?)?;
        }
    }
    Ok(out)
}
