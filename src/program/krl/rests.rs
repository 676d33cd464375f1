//! What data rest on that may be other than they are read here: the counter of a FOR loop behind
//! it, or what others may set while the program waits.

use std::collections::{HashMap, HashSet};

use super::syntax::What;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rests {
    /// The counter of a FOR loop behind it, by its name.
    Counter(String),
    /// A datum that is there for all, by its name, behind a wait.
    Others { name: String, is_set: bool, is_declared: bool },
}

impl Rests {
    /// Whether it is a datum of the cell that no statement sets: a speed or a place in it is a
    /// constant, but a branch asks for it because others set it.
    pub(super) fn is_of_cell(&self) -> bool {
        matches!(self, Self::Others { is_set: false, .. })
    }

    pub(super) fn told(&self) -> String {
        match self {
            Self::Counter(counter) => format!(
                "{counter} has counted a FOR loop, and is taken here as its end value plus one \
                 step: set {counter} anew behind the loop"
            ),
            Self::Others { name, is_set, is_declared } => {
                let why = match is_declared {
                    true => "is declared for all programs",
                    false => "is declared in no file that is read",
                };
                let job = match is_set {
                    true => String::new(),
                    false => format!(", or give it by assume: {{\"{name}\": …}} in the job"),
                };
                let file = match is_declared {
                    true => "",
                    false => {
                        ", or name the .dat that declares it under path.program.files, if it is \
                         this program's own"
                    }
                };
                format!(
                    "{name} {why}: another program may set it while this one waits for a signal, \
                     and what depends on it here is read as if none did; in the file that is \
                     checked set {name} behind the wait to what it is then{job}{file}"
                )
            }
        }
    }
}

/// What is known of waits while which others may set data.
#[derive(Debug, Default)]
pub(super) struct Waits {
    /// Whether there has been one.
    pub(super) any: bool,
    /// Data and components that the program itself has set since the last, by their whole names.
    pub(super) set_since: HashSet<String>,
}

/// What statements of the files do with data.
#[derive(Debug, Default)]
pub(super) struct Uses<'a> {
    pub(super) set: HashSet<&'a str>,
    /// Counters of FOR loops: these are the program's own, whether or not a file declares them.
    pub(super) counters: HashSet<&'a str>,
    /// Whether statements matter that rest on others: a loop asks often.
    pub(super) matter: HashMap<*const What, bool>,
}
