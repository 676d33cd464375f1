//! Files that are complete before they have their names, and gone if they never get them; files
//! that are to land together: also where a signal ends the program.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

/// The files that are there and have not got their names, and what is to go again with them.
static STAGED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Held while files land. Locked before the list.
static LANDING: Mutex<()> = Mutex::new(());

fn staged() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps signals waiting until files that belong together have all got their names.
pub(super) fn landing() -> MutexGuard<'static, ()> {
    LANDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or an empty folder; one that is not there is gone already.
fn remove(path: &Path) {
    let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
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

/// Files and folders that are there under their names and go again unless they are kept.
#[derive(Debug, Default)]
pub(super) struct Passing(Vec<PathBuf>);

impl Passing {
    /// Makes a folder and those above it, where they are missing.
    pub(super) fn make_folders(&mut self, folder: &Path) -> io::Result<()> {
        let is_missing = |up: &&Path| !up.as_os_str().is_empty() && !up.exists();
        let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
        for up in missing.into_iter().rev() {
            // `new/..` is there as soon as `new` is.
            if up.exists() {
                continue;
            }
            // A signal waits for the list, and then finds the folder on it.
            let mut list = staged();
            fs::create_dir(up)?;
            list.insert(up.to_owned());
            self.0.push(up.to_owned());
        }
        Ok(())
    }

    /// A file that is about to be written where none is.
    pub(super) fn add(&mut self, file: &Path) {
        staged().insert(file.to_owned());
        self.0.push(file.to_owned());
    }

    /// All of them stay.
    pub(super) fn keep(mut self) {
        let mut list = staged();
        for path in self.0.drain(..) {
            list.remove(&path);
        }
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        // The files in a folder go before it.
        let mut list = staged();
        for path in self.0.iter().rev() {
            remove(path);
            list.remove(path);
        }
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
            let landed = landing();
            let list = staged();
            // The files in a folder stand behind it.
            list.iter().rev().for_each(|path| remove(path));
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            // Held until here: nothing is staged once the program ends.
            drop((list, landed));
        }
    });
}

#[cfg(not(unix))]
pub(super) fn clear_on_signals() {}
