//! Videos: folders of pictures, files and streams of YUV4MPEG.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::Reading;
use crate::formats::text::lower_first;
use crate::formats::video::{Frame, Video};
use crate::notes::{Code, Note, Place};
use crate::trace::Picture;

/// The pictures of a video, one at a time.
pub struct Pictures {
    name: PathBuf,
    video: Video,
    frame: Frame,
}

impl std::fmt::Debug for Pictures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pictures").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Pictures {
    /// What the video is called.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Frames a second, where the file states them.
    pub fn frame_rate_hz(&self) -> Option<f64> {
        self.video.frame_rate_hz()
    }

    /// The next picture; `None` at the end.
    ///
    /// # Errors
    /// A picture that cannot be read.
    pub fn next_picture(&mut self) -> Result<Option<Picture<'_>>, Note> {
        let is_there = self.video.next(&mut self.frame)?;
        let Frame { width, height, bits, ref bytes } = self.frame;
        Ok(is_there.then_some(Picture { width, height, bits, bytes }))
    }
}

/// Opens a folder of PNG or JPEG pictures or a file of YUV4MPEG; `standard` is read in place of a
/// file that is called `-`.
///
/// # Errors
/// A file that cannot be read, or is no such video.
pub fn open_video(
    path: &Path,
    standard: impl FnOnce() -> Box<dyn Read + Send>,
    reading: &mut Reading,
) -> Result<Pictures, Vec<Note>> {
    let video = if path == Path::new("-") {
        Video::stream(Path::new("standard input"), standard())?
    } else if path.is_dir() {
        Video::folder(path)?
    } else {
        reading.files.push(path.to_owned());
        let file = File::open(path).map_err(|error| {
            let what = match error.kind() {
                std::io::ErrorKind::NotFound => "no such file or folder".to_owned(),
                _ => format!("cannot be read: {}", lower_first(&error.to_string())),
            };
            Note::error(Code::Unreadable, Place::file(path), what)
        })?;
        Video::stream(path, Box::new(file))?
    };
    let name = path.to_owned();
    Ok(Pictures { name, video, frame: Frame::default() })
}
