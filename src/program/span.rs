//! Where numbers stand in a text.

/// Bytes of the decoded text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Span {
    pub(super) start: usize,
    pub(super) end: usize,
}

impl Span {
    pub(super) fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// The same number where its line begins at `offset`.
    pub(super) fn behind(self, offset: usize) -> Self {
        Self { start: self.start + offset, end: self.end + offset }
    }
}

/// What a parameter is set to, and the number of the text that it is, if it is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    pub(super) value: f64,
    pub(super) span: Option<Span>,
}

impl Held {
    /// One that is worked out.
    pub(super) fn worked_out(value: f64) -> Self {
        Self { value, span: None }
    }
}
