//! STL, text and binary.

use std::io::Cursor;

use super::Triangles;

const HEADER_BYTES: usize = 80;
const TRIANGLE_BYTES: usize = 50;

pub(super) fn triangles(mut bytes: Vec<u8>) -> Result<Triangles, String> {
    // Exporters write headers of binary files that begin like a text.
    if is_binary(&bytes) {
        bytes[..HEADER_BYTES].fill(0);
    }
    let mut bytes = Cursor::new(bytes);
    let unread = |error: std::io::Error| format!("cannot be read as STL: {error}");
    let mut out = Triangles::default();
    for triangle in stl_io::create_stl_reader(&mut bytes).map_err(unread)? {
        let corners = triangle.map_err(unread)?.vertices;
        out.push(corners.map(|corner| corner.0.map(f64::from)))?;
    }
    Ok(out)
}

/// Whether the file is as long as its count of triangles says.
fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(HEADER_BYTES..HEADER_BYTES + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
    count.is_some_and(|count| {
        let count = u32::from_le_bytes(count) as usize;
        bytes.len() == HEADER_BYTES + 4 + TRIANGLE_BYTES * count
    })
}
