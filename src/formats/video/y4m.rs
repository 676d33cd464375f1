//! YUV4MPEG2, of which the luma plane is kept. The crate `y4m` takes a frame that breaks off for
//! the end, and multiplies sizes of the header unchecked.

use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::{Frame, size_fault};
use crate::notes::{Code, Note, Place};

/// Longest header that is read, bytes.
const MAX_HEADER: usize = 4096;

pub(crate) struct Stream {
    name: PathBuf,
    reader: BufReader<Box<dyn Read + Send>>,
    width: usize,
    height: usize,
    bits: u32,
    /// Bytes of the colour planes of a frame.
    colour: usize,
    rate: Option<f64>,
    frames: usize,
}

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stream").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Stream {
    pub(super) fn open(name: &Path, reader: Box<dyn Read + Send>) -> Result<Self, Note> {
        let mut reader = BufReader::with_capacity(1 << 20, reader);
        let fault = |code, what: String| Note::error(code, Place::file(name), what);
        let mut magic = [0; 9];
        let start = reader.read_exact(&mut magic);
        if start.is_err() || magic != *b"YUV4MPEG2" {
            let what = "is not YUV4MPEG; make it of a video by: ffmpeg -i clip.mov -fps_mode \
                        passthrough -pix_fmt gray -f yuv4mpegpipe -";
            return Err(fault(Code::Syntax, what.to_owned()));
        }
        let header = line(&mut reader).map_err(|what| fault(Code::Unreadable, what))?;
        let fields = header.unwrap_or_default();
        let (mut width, mut height, mut colours, mut rate) = (0, 0, "420", None);
        for field in fields.split_ascii_whitespace() {
            let value = field.get(1..).unwrap_or("");
            let number = || {
                value.parse::<usize>().map_err(|_| {
                    let what = format!("the header has '{field}', must have a number of pixels");
                    fault(Code::Syntax, what)
                })
            };
            match field.as_bytes()[0] {
                b'W' => width = number()?,
                b'H' => height = number()?,
                b'C' => colours = value,
                b'F' => {
                    let parts = value.split_once(':');
                    let parts = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
                    let hz = parts.map(|(a, b): (f64, f64)| a / b);
                    rate = hz.filter(|hz| hz.is_finite() && *hz > 0.0);
                }
                b'I' if !matches!(value, "p" | "?") => {
                    let what = "is interlaced: a frame holds two times; deinterlace it first";
                    return Err(fault(Code::Value, what.to_owned()));
                }
                _ => {}
            }
        }
        if let Some(what) = size_fault(width, height) {
            return Err(fault(Code::Value, what));
        }
        let (bits, colour) = planes(colours, width, height).ok_or_else(|| {
            let what = format!("has the colour space '{colours}', must be mono, 420, 422 or 444");
            fault(Code::Value, what)
        })?;
        let name = name.to_owned();
        Ok(Self { name, reader, width, height, bits, colour, rate, frames: 0 })
    }

    pub(super) fn frame_rate_hz(&self) -> Option<f64> {
        self.rate
    }

    pub(super) fn next(&mut self, frame: &mut Frame) -> Result<bool, Note> {
        let number = self.frames + 1;
        let fault = |what: String| Note::error(Code::Syntax, Place::file(&self.name), what);
        match line(&mut self.reader).map_err(&fault)? {
            None => return Ok(false),
            Some(head) if head.starts_with("FRAME") => {}
            Some(_) => return Err(fault(format!("frame {number} does not begin with FRAME"))),
        }
        let bytes = self.width * self.height * if self.bits > 8 { 2 } else { 1 };
        frame.bytes.resize(bytes, 0);
        (frame.width, frame.height, frame.bits) = (self.width, self.height, self.bits);
        let broken = |error: std::io::Error| {
            fault(match error.kind() {
                ErrorKind::UnexpectedEof => format!("breaks off in frame {number}"),
                _ => format!("cannot be read: {error}"),
            })
        };
        self.reader.read_exact(&mut frame.bytes).map_err(broken)?;
        let colour = self.colour as u64;
        let skipped = std::io::copy(&mut self.reader.by_ref().take(colour), &mut std::io::sink());
        if skipped.map_err(broken)? < colour {
            return Err(broken(ErrorKind::UnexpectedEof.into()));
        }
        self.frames += 1;
        Ok(true)
    }
}

/// The next line without its end; `None` at the end of the file.
fn line(reader: &mut impl Read) -> Result<Option<String>, String> {
    let mut text = Vec::new();
    let mut byte = [0];
    while text.len() < MAX_HEADER {
        match reader.read(&mut byte) {
            Ok(0) if text.is_empty() => return Ok(None),
            Ok(0) => return Err("breaks off in a header".to_owned()),
            Ok(_) if byte[0] == b'\n' => {
                return Ok(Some(String::from_utf8_lossy(&text).into_owned()));
            }
            Ok(_) => text.push(byte[0]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(format!("cannot be read: {error}")),
        }
    }
    Ok(Some(String::from_utf8_lossy(&text).into_owned()))
}

/// Bits of a value, and bytes of the colour planes.
fn planes(colours: &str, width: usize, height: usize) -> Option<(u32, usize)> {
    let (family, bits) = match colours.strip_prefix("mono") {
        Some("") => ("mono", 8),
        Some(bits) => ("mono", bits.parse().ok()?),
        None => match colours.get(..3)? {
            family @ ("420" | "422" | "444") => match &colours[3..] {
                "" | "jpeg" | "paldv" | "mpeg2" => (family, 8),
                bits => (family, bits.strip_prefix('p')?.parse().ok()?),
            },
            _ => return None,
        },
    };
    let half = |count: usize| count.div_ceil(2);
    let values = match family {
        "420" => 2 * half(width) * half(height),
        "422" => 2 * half(width) * height,
        "444" => 2 * width * height,
        _ => 0,
    };
    (8..=16).contains(&bits).then_some((bits, values * if bits > 8 { 2 } else { 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<Vec<Frame>, String> {
        let told = |note: Note| note.what;
        let reader = Box::new(std::io::Cursor::new(bytes.to_vec()));
        let mut stream = Stream::open(Path::new("-"), reader).map_err(told)?;
        let (mut frame, mut frames) = (Frame::default(), Vec::new());
        while stream.next(&mut frame).map_err(told)? {
            frames.push(frame.clone());
        }
        Ok(frames)
    }

    #[test]
    fn luma_is_kept_of_every_colour_space() {
        for (head, rest) in [("Cmono", 0), ("C420jpeg", 4), ("", 4), ("C422", 4), ("C444", 6)] {
            let mut bytes = format!("YUV4MPEG2 W3 H1 F240:1 Ip {head}\n").into_bytes();
            for k in 0..2 {
                bytes.extend(b"FRAME\n");
                bytes.extend([10 + k, 20 + k, 30 + k]);
                bytes.extend(vec![0; rest]);
            }
            let frames = read(&bytes).unwrap();
            assert_eq!(frames.len(), 2, "{head}");
            assert_eq!((frames[1].bytes.as_slice(), frames[1].bits), (&[11, 21, 31][..], 8));
        }
        let deep = read(b"YUV4MPEG2 W1 H1 Cmono12 F1:1\nFRAME\n\x01\x02").unwrap();
        assert_eq!((deep[0].bytes.as_slice(), deep[0].bits), (&[1, 2][..], 12));
    }

    #[test]
    fn hostile_streams_are_told() {
        let huge = format!("YUV4MPEG2 W{0} H{0}\n", usize::MAX);
        let endless = [b"YUV4MPEG2 ".to_vec(), vec![b'x'; 1 << 20]].concat();
        for (bytes, expected) in [
            (&b""[..], "is not YUV4MPEG"),
            (b"\x89PNG\r\n", "is not YUV4MPEG"),
            (b"YUV4MPEG2 W3", "breaks off in a header"),
            (b"YUV4MPEG2 W0 H2\n", "a picture has 0 × 2 pixels"),
            (b"YUV4MPEG2 Wx H2\n", "the header has 'Wx'"),
            (huge.as_bytes(), "a picture has 18446744073709551615 ×"),
            (&endless, "a picture has 0 × 0"),
            (b"YUV4MPEG2 W1 H1 Cmono99\n", "has the colour space 'mono99'"),
            (b"YUV4MPEG2 W1 H1 C4\xe2\x82\xac\n", "has the colour space"),
            (b"YUV4MPEG2 W1 H1 It\n", "is interlaced"),
            (b"YUV4MPEG2 W2 H2 Cmono\nFRAME\nabc", "breaks off in frame 1"),
            (b"YUV4MPEG2 W2 H2\nFRAME\nabcde", "breaks off in frame 1"),
            (b"YUV4MPEG2 W2 H2 Cmono\nFRAME\nabcdX\n", "frame 2 does not begin with FRAME"),
        ] {
            let told = read(bytes).unwrap_err();
            assert!(told.starts_with(expected), "{told}");
        }
    }
}
