//! Files that are complete before they have their names, and gone if they never get them: also
//! where a signal ends the program.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

/// The files that are there and have not got their names.
static STAGED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn staged() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A new file that is removed unless it gets its name.
#[derive(Debug)]
pub(super) struct Staged {
    file: NamedTempFile,
    // Dropped behind the file: the list never lacks one that is there.
    listed: Listed,
}

/// An entry of the list, as long as it lives.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        staged().remove(&self.0);
    }
}

impl Staged {
    /// In a folder.
    pub(super) fn new(builder: &mut tempfile::Builder, folder: &Path) -> io::Result<Self> {
        // A signal waits for the list, and then finds the file on it.
        let mut list = staged();
        let file = builder.tempfile_in(folder)?;
        list.insert(file.path().to_owned());
        Ok(Self { listed: Listed(file.path().to_owned()), file })
    }

    /// The file.
    pub(super) fn as_file(&self) -> &File {
        self.file.as_file()
    }

    /// Gives it its name, in place of whatever has that.
    pub(super) fn persist(self, path: &Path) -> io::Result<()> {
        let Self { file, listed } = self;
        file.persist(path).map_err(|error| error.error)?;
        drop(listed);
        Ok(())
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Removes what is staged when a signal asks the program to end, which then ends as by the signal.
#[cfg(unix)]
pub(super) fn clear_on_signals() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    // Without the watch the program ends as before.
    let Ok(mut signals) = Signals::new([SIGHUP, SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let list = staged();
            list.iter().for_each(|path| drop(std::fs::remove_file(path)));
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            // Held until here: nothing is staged once the program ends.
            drop(list);
        }
    });
}

#[cfg(not(unix))]
pub(super) fn clear_on_signals() {}
