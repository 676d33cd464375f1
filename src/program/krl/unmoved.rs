//! Why a program contains no motion that is read.

/// What may be the reason, as the program runs.
#[derive(Debug, Default)]
pub(super) struct Unmoved<'a> {
    /// The first endless loop that may move otherwise in a further pass, and what is told of it.
    pub(super) looped: Option<(usize, String)>,
    /// The line of the first move to a home position that no file declares, and the name of that.
    pub(super) home: Option<(usize, String)>,
    /// Routines that are in no file, and the line of the first call of each.
    pub(super) unread: Vec<(usize, &'a str)>,
}

impl Unmoved<'_> {
    /// An error with its line, where this says more than what else is in no file: an endless loop
    /// first, then a home position, then more than one routine.
    pub(super) fn error(self) -> Option<(usize, String)> {
        const NONE: &str = "the program contains no motion that is read";
        const FILES: &str = "path.program.files in the job can name the files";
        let unread = self.names();
        if let Some((line, why)) = self.looped {
            return Some((line, format!("{NONE}: {why}")));
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

    /// The routines that are in no file, as many as a message shows.
    fn names(&self) -> String {
        const SHOWN: usize = 4;
        let shown = self.unread.iter().take(SHOWN).map(|(_, name)| format!("'{name}'"));
        let others = if self.unread.len() > SHOWN { " and others" } else { "" };
        shown.collect::<Vec<_>>().join(", ") + others
    }
}
