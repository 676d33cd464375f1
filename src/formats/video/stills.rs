//! A folder of PNG or JPEG pictures, in the order of the numbers in their names.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Transformations};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{Frame, MAX_PIXELS, MAX_SIDE, size_fault};
use crate::formats::text::read_bytes;
use crate::notes::{Code, Note, Place};

/// Largest picture file that is read.
const MAX_FILE_BYTES: u64 = 512 << 20;

const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

#[derive(Debug)]
pub(crate) struct Stills {
    files: std::vec::IntoIter<PathBuf>,
    /// The first picture and its size: the others have the same.
    first: Option<(PathBuf, usize, usize)>,
}

/// What pictures are sorted by: numbers in names count as numbers.
fn order(path: &Path) -> Vec<(u128, String)> {
    let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let mut parts = Vec::new();
    let mut rest: &str = &name;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let number = rest[..digits].parse().unwrap_or(0);
        let behind = &rest[digits..];
        let words = behind.find(|c: char| c.is_ascii_digit()).unwrap_or(behind.len());
        parts.push((number, behind[..words].to_owned()));
        rest = &behind[words..];
    }
    parts
}

impl Stills {
    pub(super) fn open(folder: &Path) -> Result<Self, Note> {
        let fault = |what: String| Note::error(Code::Unreadable, Place::file(folder), what);
        let entries =
            std::fs::read_dir(folder).map_err(|error| fault(format!("cannot be read: {error}")))?;
        let is_picture = |path: &PathBuf| {
            let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
        };
        let mut files: Vec<PathBuf> =
            entries.flatten().map(|entry| entry.path()).filter(is_picture).collect();
        if files.is_empty() {
            return Err(fault("holds no picture, must hold .png or .jpg files".to_owned()));
        }
        files.sort_by_cached_key(|path| (order(path), path.clone()));
        Ok(Self { files: files.into_iter(), first: None })
    }

    pub(super) fn next(&mut self, frame: &mut Frame) -> Result<bool, Note> {
        let Some(path) = self.files.next() else { return Ok(false) };
        let bytes = read_bytes(&path, MAX_FILE_BYTES)?;
        let read = if bytes.starts_with(b"\x89PNG") {
            png(bytes, frame)
        } else if bytes.starts_with(&[0xFF, 0xD8]) {
            jpeg(bytes, frame)
        } else {
            Err("is neither PNG nor JPEG".to_owned())
        };
        let fault = |what| Note::error(Code::Unreadable, Place::file(&path), what);
        read.map_err(fault)?;
        let (width, height) = (frame.width, frame.height);
        match &self.first {
            None => self.first = Some((path, width, height)),
            Some((first, across, down)) if (*across, *down) != (width, height) => {
                return Err(fault(format!(
                    "has {width} × {height} pixels, must have {across} × {down} as {}",
                    first.display()
                )));
            }
            Some(_) => {}
        }
        Ok(true)
    }
}

fn png(bytes: Vec<u8>, frame: &mut Frame) -> Result<(), String> {
    let told = |error: png::DecodingError| format!("is not a whole PNG: {error}");
    let limits = png::Limits { bytes: 8 * MAX_PIXELS };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(told)?;
    let info = reader.info();
    let (width, height) = (info.width as usize, info.height as usize);
    size_fault(width, height).map_or(Ok(()), Err)?;
    let size = reader.output_buffer_size().ok_or("is too large")?;
    let mut values = vec![0; size];
    let info = reader.next_frame(&mut values).map_err(told)?;
    let channels = match info.color_type {
        ColorType::Grayscale | ColorType::Indexed => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
    };
    let is_deep = info.bit_depth == BitDepth::Sixteen;
    (frame.width, frame.height, frame.bits) = (width, height, if is_deep { 16 } else { 8 });
    frame.bytes.clear();
    if is_deep {
        for pixel in values.chunks_exact(2 * channels) {
            let value = |k: usize| u32::from(u16::from_be_bytes([pixel[2 * k], pixel[2 * k + 1]]));
            let grey = if channels < 3 { value(0) } else { luma([value(0), value(1), value(2)]) };
            frame.bytes.extend((grey as u16).to_le_bytes());
        }
    } else if channels == 1 {
        frame.bytes = values;
    } else {
        let grey = |pixel: &[u8]| match pixel {
            [r, g, b, ..] => luma([*r, *g, *b].map(u32::from)) as u8,
            [grey, ..] => *grey,
            [] => 0,
        };
        frame.bytes.extend(values.chunks_exact(channels).map(grey));
    }
    Ok(())
}

/// The grey value of a colour, as in JPEG and television (ITU-R BT.601).
fn luma([r, g, b]: [u32; 3]) -> u32 {
    (299 * r + 587 * g + 114 * b + 500) / 1000
}

fn jpeg(bytes: Vec<u8>, frame: &mut Frame) -> Result<(), String> {
    let options = DecoderOptions::default()
        .set_max_width(MAX_SIDE)
        .set_max_height(MAX_SIDE)
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let told = |error| format!("is not a whole JPEG: {error}");
    decoder.decode_headers().map_err(told)?;
    let info = decoder.info().ok_or("has no header")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    size_fault(width, height).map_or(Ok(()), Err)?;
    frame.bytes = decoder.decode().map_err(told)?;
    (frame.width, frame.height, frame.bits) = (width, height, 8);
    if frame.bytes.len() != width * height {
        return Err("has colours that cannot be turned to grey".to_owned());
    }
    Ok(())
}
