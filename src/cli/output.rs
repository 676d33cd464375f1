//! Files that are written whole or not at all.

use std::fs;
use std::io::{self, BufWriter, IsTerminal, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::Failure;
use super::staged::{Staged, landing};
use crate::notes::{Code, Note, Place};
use crate::paths::folder_of;

/// What `--output` takes for standard output; behind the devices may be a file that others write
/// to, too.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// What is written piece by piece stands in memory up to this size, bytes.
const MAX_IN_MEMORY: usize = 64 << 20;

/// Where data goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Sink {
    /// Standard output.
    Standard,
    /// A file that is replaced in one step.
    File(PathBuf),
    /// A device or pipe, which cannot be replaced.
    Device(PathBuf),
}

impl Sink {
    /// Where `--output` points; an error before the long work if nothing can be written there.
    pub(super) fn open(output: Option<&Path>) -> Result<Self, Vec<Note>> {
        let Some(path) =
            output.filter(|path| STANDARD_OUTPUT.iter().all(|name| *path != Path::new(name)))
        else {
            return Ok(Self::Standard);
        };
        let fault = |what: &str| vec![Note::error(Code::Unwritable, Place::file(path), what)];
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(fault("is a folder, must be a file to write")),
            Ok(found) if found.is_file() => match fs::canonicalize(path) {
                _ if is_protected(path, &found) => {
                    Err(fault("is write-protected; name another file, or take the protection off"))
                }
                // A link stays a link.
                Ok(target) => Ok(Self::File(target)),
                Err(error) => Err(fault(&format!("cannot be written: {error}"))),
            },
            Ok(_) => Ok(Self::Device(path.to_owned())),
            Err(_) if folder_of(path).is_dir() => Ok(Self::File(path.to_owned())),
            Err(_) => Err(fault(&format!(
                "folder '{}' does not exist; create it first",
                folder_of(path).display()
            ))),
        }
    }

    /// Refuses to write over a file that the run reads, by whatever name it goes.
    pub(super) fn refuse_inputs<'p>(
        &self,
        inputs: impl IntoIterator<Item = &'p PathBuf>,
    ) -> Result<(), Vec<Note>> {
        let Self::File(output) = self else { return Ok(()) };
        let Some(input) = inputs.into_iter().find(|input| are_one_file(input, output)) else {
            return Ok(());
        };
        let what = format!(
            "is read by this run as {}, so nothing is written to it; name another file",
            input.display()
        );
        Err(vec![Note::error(Code::Unwritable, Place::file(output), what)])
    }

    /// Whether what goes to one would overwrite or mix with what goes to the other. Devices swallow
    /// both.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Standard, Self::Standard) => true,
            (Self::File(a), Self::File(b)) => are_one_file(a, b) || in_folder(a) == in_folder(b),
            _ => false,
        }
    }

    /// Whether data goes to standard output.
    pub(super) fn is_standard(&self) -> bool {
        *self == Self::Standard
    }

    /// Colour is for a terminal whose user has not switched it off (`NO_COLOR`, `TERM=dumb`).
    pub(super) fn shows_colour(&self) -> bool {
        let stdout = io::stdout();
        self.is_standard()
            && stdout.is_terminal()
            && anstream::AutoStream::choice(&stdout) != anstream::ColorChoice::Never
    }

    /// Writes all of `text`; `out` is standard output, where a reader that leaves early is no
    /// failure.
    pub(super) fn write(&self, text: &str, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Standard => {
                super::unless_closed(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
            }
            Self::File(path) => replace(path, text).map_err(|error| named(path, &error)),
            Self::Device(path) => fs::write(path, text).map_err(|error| named(path, &error)),
        }
    }
}

impl Sink {
    /// Writes bytes that need not be text.
    pub(super) fn write_bytes(&self, bytes: &[u8], out: &mut dyn Write) -> Result<(), Failure> {
        self.stream(out, |out| Ok(out.write_all(bytes)?))
    }

    /// Writes what `write` writes, piece by piece: a file takes the old one's place only if all
    /// went well. Until then the pieces stand in memory, or, if they are many, in a file without a
    /// name that goes when the process goes, however it ends.
    pub(super) fn stream(
        &self,
        out: &mut dyn Write,
        write: impl FnOnce(&mut dyn Write) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::Standard => write(out),
            Self::File(path) => {
                let mut pieces = tempfile::spooled_tempfile_in(MAX_IN_MEMORY, folder_of(path));
                write(&mut pieces)?;
                replace_from(path, &mut pieces).map_err(|error| named(path, &error))?;
                Ok(())
            }
            Self::Device(path) => {
                let device = fs::OpenOptions::new().write(true).open(path);
                let mut buffered = BufWriter::new(device.map_err(|error| named(path, &error))?);
                write(&mut buffered)?;
                buffered.flush().map_err(|error| named(path, &error))?;
                Ok(())
            }
        }
    }
}

/// Two outputs of one run go to two places, or one of them would be lost. Each with its option and
/// the path given.
pub(super) fn keep_apart(
    outputs: &[(&str, Option<&Sink>, Option<&Path>)],
) -> Result<(), Vec<Note>> {
    for (index, (name, sink, path)) in outputs.iter().enumerate() {
        for (earlier, other, _) in &outputs[..index] {
            let (Some(sink), Some(other)) = (sink, other) else { continue };
            if sink.is_same(other) {
                let what = if sink.is_standard() {
                    format!("{name} and {earlier} both go to standard output; name a file for one")
                } else {
                    format!("{name} and {earlier} name the same file; name two")
                };
                let place = path.map(Place::file).unwrap_or_default();
                return Err(vec![Note::error(Code::Usage, place, what)]);
            }
        }
    }
    Ok(())
}

/// Writes several outputs so that either all land or none: each file is complete beside its place
/// before the first takes it, and what has landed is taken back if a later one cannot.
pub(super) fn write_all(outputs: &[(&Sink, &[u8])], out: &mut dyn Write) -> Result<(), Failure> {
    let mut staged = Vec::new();
    for (sink, bytes) in outputs {
        if let Sink::File(path) = sink {
            let file = staged_file(path, bytes).and_then(|file| ready(file, path));
            staged.push((file.map_err(|error| named(path, &error))?, path));
        }
    }
    for (sink, bytes) in outputs {
        match sink {
            Sink::Standard => {
                super::unless_closed(out.write_all(bytes).and_then(|()| out.flush()))?;
            }
            Sink::Device(_) => sink.write_bytes(bytes, out)?,
            Sink::File(_) => {}
        }
    }
    let mut landed: Vec<(&Path, Option<Vec<u8>>)> = Vec::new();
    let _together = landing();
    for (file, path) in staged {
        let old = fs::read(path).ok();
        if let Err(error) = file.persist(path) {
            landed.iter().for_each(|(path, old)| take_back(path, old.as_deref()));
            return Err(named(path, &error).into());
        }
        landed.push((path, old));
    }
    landed.iter().for_each(|(path, _)| sync_folder(folder_of(path)));
    Ok(())
}

/// Puts back what a file held before, if it was there. The error that led here is the one to
/// report.
fn take_back(path: &Path, old: Option<&[u8]>) {
    let _ = match old {
        Some(old) => staged_file(path, old).and_then(|file| put_in_place(file, path)),
        None => fs::remove_file(path),
    };
}

/// Whether two paths lead to one file, through links and detours. What does not exist is no file.
#[cfg(unix)]
fn are_one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |path| fs::metadata(path).map(|found| (found.dev(), found.ino()));
    matches!((place(a), place(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(not(unix))]
fn are_one_file(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

/// A file that need not exist yet, by its folder's own name.
fn in_folder(path: &Path) -> PathBuf {
    let folder = fs::canonicalize(folder_of(path)).unwrap_or_else(|_| folder_of(path).to_owned());
    folder.join(path.file_name().unwrap_or_default())
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// Writes a new file beside the old one and puts it in its place.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    put_in_place(staged_file(path, text.as_bytes())?, path)
}

/// A new file beside the old one, complete.
fn staged_file(path: &Path, bytes: &[u8]) -> io::Result<Staged> {
    let mut file = beside(path)?;
    file.write_all(bytes)?;
    file.flush()?;
    Ok(file)
}

/// The same with what stands in `pieces`.
fn replace_from(path: &Path, pieces: &mut (impl Read + Seek)) -> io::Result<()> {
    pieces.rewind()?;
    let mut file = beside(path)?;
    io::copy(pieces, &mut file)?;
    put_in_place(file, path)
}

/// A new file in the same folder, with the rights of any new file.
fn beside(path: &Path) -> io::Result<Staged> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".detune-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any other new file: what the process's mask leaves of it.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    Staged::new(&mut builder, folder_of(path))
}

/// Whether the owner of a file, or who runs this, is kept from writing to it. A new file in its
/// place would ask nobody.
fn is_protected(path: &Path, found: &fs::Metadata) -> bool {
    let is_refused = || {
        let opened = fs::OpenOptions::new().append(true).open(path);
        opened.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
    };
    found.permissions().readonly() || is_refused()
}

/// The new file with the old one's rights. Its bytes are on the disk before its name is, so that a
/// power cut leaves the old file or the new one.
fn ready(file: Staged, path: &Path) -> io::Result<Staged> {
    if let Ok(old) = fs::metadata(path) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.as_file().sync_all()?;
    Ok(file)
}

/// Puts the new file in the old one's place.
fn put_in_place(file: Staged, path: &Path) -> io::Result<()> {
    ready(file, path)?.persist(path)?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Puts the names in a folder on the disk. Where a file system knows no such thing, the files are
/// whole all the same.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = fs::File::open(folder) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.json");
        for text in ["first", "second, longer"] {
            Sink::open(Some(&path)).unwrap().write(text, &mut io::sink()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(names(folder.path()), ["out.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_a_device() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        Sink::open(Some(&link)).unwrap().write("new", &mut io::sink()).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        let null = Path::new("/dev/null");
        assert_eq!(Sink::open(Some(null)).unwrap(), Sink::Device(null.to_owned()));
    }

    #[test]
    fn places_that_cannot_be_written_are_told_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let reported = |path: &Path| Sink::open(Some(path)).unwrap_err().remove(0).what;
        assert_eq!(reported(folder.path()), "is a folder, must be a file to write");
        let what = reported(&folder.path().join("missing/out.json"));
        assert!(what.starts_with("folder '") && what.ends_with("does not exist; create it first"));
        for name in ["-", "/dev/stdout"] {
            assert!(Sink::open(Some(Path::new(name))).unwrap().is_standard());
        }
        assert!(Sink::open(None).unwrap().is_standard());
    }

    /// The second place turns into a folder after it was opened, so it cannot be replaced.
    #[test]
    fn several_outputs_land_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "old a").unwrap();
        let [a, b, c] = ["a", "b", "c"].map(|name| Sink::open(Some(&path(name))).unwrap());
        let outputs: [(&Sink, &[u8]); 3] = [(&a, b"new a"), (&b, b"new b"), (&c, b"new c")];
        fs::create_dir(path("c")).unwrap();
        fs::write(path("c").join("inside"), "").unwrap();
        assert!(write_all(&outputs, &mut io::sink()).is_err());
        assert_eq!(fs::read_to_string(path("a")).unwrap(), "old a");
        assert_eq!(names(folder.path()), ["a", "c"]);
        fs::remove_dir_all(path("c")).unwrap();
        write_all(&outputs, &mut io::sink()).unwrap();
        assert_eq!(names(folder.path()), ["a", "b", "c"]);
        assert_eq!(fs::read_to_string(path("c")).unwrap(), "new c");
    }

    #[test]
    fn a_reader_that_left_is_no_failure() {
        struct Closed;
        impl Write for Closed {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
        }
        assert!(Sink::Standard.write("text", &mut Closed).is_ok());
        // The files of the run land all the same.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let file = Sink::open(Some(&path)).unwrap();
        write_all(&[(&Sink::Standard, b"text"), (&file, b"bytes")], &mut Closed).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"bytes");
    }
}
