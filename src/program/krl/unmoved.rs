//! Why a program contains no motion that is read.

/// What may be the reason, as the program runs.
#[derive(Debug, Default)]
pub(super) struct Unmoved<'a> {
    /// The first endless loop that may move otherwise in a further pass, and what is told of it.
    pub(super) looped: Option<(usize, String)>,
    /// The line of the first move to a home position that no file declares, and the name of that.
    pub(super) home: Option<(usize, String)>,
    /// The first line that rests on what others may set, and what is told of it.
    pub(super) rests: Option<(usize, String)>,
    /// Routines that are in no file, and the line of the first call of each.
    pub(super) unread: Vec<(usize, &'a str)>,
    /// Those of them, too, that no statement which has run calls.
    pub(super) missing: Vec<&'a str>,
}

impl Unmoved<'_> {
    /// An error with its line, where this says more than what else is in no file: an endless loop
    /// first, then a home position, then what rests on others, then more than one routine.
    pub(super) fn error(self) -> Option<(usize, String)> {
        const NONE: &str = "the program contains no motion that is read";
        const FILES: &str = "path.program.files in the job can name the files";
        let unread = names(self.unread.iter().map(|(_, name)| *name));
        let rests = self.rests.filter(|_| self.home.is_none());
        if let Some((line, why)) = self.looped.or(rests) {
            let missing = match self.missing.is_empty() {
                true => String::new(),
                false => format!(
                    "; what may move is in no file that is read: {}; {FILES}",
                    names(self.missing.into_iter())
                ),
            };
            return Some((line, format!("{NONE}: {why}{missing}")));
        }
        if let Some((line, home)) = self.home {
            let others = match unread.is_empty() {
                true => String::new(),
                false => format!(", and nothing of {unread} is read"),
            };
            let what = format!(
                "{NONE}: PTP {home} is skipped, as no file that is read gives {home}{others}; \
                 {FILES}"
            );
            return Some((line, what));
        }
        let (line, _) = *self.unread.first().filter(|_| self.unread.len() > 1)?;
        let what = format!(
            "{NONE}: {unread} are in no file that is read: if they move, or set frames or data, \
             that is not read; {FILES}"
        );
        Some((line, what))
    }
}

/// As many names as a message shows.
fn names<'a>(all: impl ExactSizeIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 4;
    let others = if all.len() > SHOWN { " and others" } else { "" };
    let shown = all.take(SHOWN).map(|name| format!("'{name}'"));
    shown.collect::<Vec<_>>().join(", ") + others
}
