//! Videos as grey pictures, one after the other: YUV4MPEG, and folders of PNG and JPEG.

mod stills;
mod y4m;

use std::io::Read;
use std::path::Path;

use crate::notes::Note;

/// Longest side of a picture, px, and most pixels.
const MAX_SIDE: usize = 16_384;
const MAX_PIXELS: usize = 1 << 26;

/// Grey values row by row; above 8 bits two bytes a value, the low one first.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Frame {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) bits: u32,
    pub(crate) bytes: Vec<u8>,
}

/// A video, of which one frame is held at a time.
pub(crate) enum Video {
    Stream(y4m::Stream),
    Stills(stills::Stills),
}

impl Video {
    /// Opens a folder of pictures.
    pub(crate) fn folder(path: &Path) -> Result<Self, Note> {
        stills::Stills::open(path).map(Self::Stills)
    }

    /// Opens a stream of YUV4MPEG; `name` stands for it in faults.
    pub(crate) fn stream(name: &Path, reader: Box<dyn Read + Send>) -> Result<Self, Note> {
        y4m::Stream::open(name, reader).map(Self::Stream)
    }

    /// Frames a second, where the file states them.
    pub(crate) fn frame_rate_hz(&self) -> Option<f64> {
        match self {
            Self::Stream(stream) => stream.frame_rate_hz(),
            Self::Stills(_) => None,
        }
    }

    /// Reads the next frame; `false` at the end.
    pub(crate) fn next(&mut self, frame: &mut Frame) -> Result<bool, Note> {
        match self {
            Self::Stream(stream) => stream.next(frame),
            Self::Stills(stills) => stills.next(frame),
        }
    }
}

/// Why a picture of this size is not read.
fn size_fault(width: usize, height: usize) -> Option<String> {
    let fits = width > 0
        && height > 0
        && width <= MAX_SIDE
        && height <= MAX_SIDE
        && width * height <= MAX_PIXELS;
    (!fits).then(|| {
        format!(
            "a picture has {width} × {height} pixels, must have 1 to {MAX_SIDE} a side and at most \
             {MAX_PIXELS}"
        )
    })
}
