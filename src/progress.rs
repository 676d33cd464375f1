//! How far long work has come.

/// How far the work has come since the last call, or in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Done {
    /// So many more items (poses, records).
    More(usize),
    /// This share of all, 0..=1.
    Share(f64),
}

/// Called from any thread while the work goes on.
pub type Progress<'a> = &'a (dyn Fn(Done) + Sync);

/// For work that nobody watches.
pub fn silent(_: Done) {}
