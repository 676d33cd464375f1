//! Why something is not known, and what `assume` in the job can give that settles it.

use std::fmt;

/// Behind the name of a register or a signal.
const IS_SET: &str = "is set to what is known only at run time";

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Why {
    text: String,
    /// Names of registers and signals; none where `assume` does not help, or the text tells what
    /// does.
    rests_on: Vec<String>,
}

impl Why {
    /// Of what the job can give by this name.
    pub(super) fn of(text: impl Into<String>, name: &str) -> Self {
        Self { text: text.into(), rests_on: vec![name.to_owned()] }
    }

    /// Of a name that the program has set to what is not known for this reason.
    pub(super) fn set(self, name: &str) -> Self {
        let head = format!("{name} {IS_SET}");
        if self.is_empty() || !self.rests_on.is_empty() {
            return self.told(head);
        }
        // Of names that are set to each other the cause is told.
        let inner = format!("{IS_SET}: ");
        let cause = self.text.rsplit(&*inner).next().unwrap_or_default();
        let text = format!("{head}: {cause}");
        self.told(text)
    }

    /// Two reasons at once: one that `assume` does not settle is told alone.
    pub(super) fn and(mut self, other: Self) -> Self {
        if self.rests_on.is_empty() {
            return self;
        }
        if other.rests_on.is_empty() {
            return other;
        }
        let new = other.rests_on.into_iter().filter(|name| !self.rests_on.contains(name));
        let new: Vec<String> = new.collect();
        self.rests_on.extend(new);
        self
    }

    /// Beside those that are there.
    pub(super) fn add_to(self, others: &mut Option<Self>) {
        *others = Some(match others.take() {
            Some(first) => first.and(self),
            None => self,
        });
    }

    /// Of two ways to read a text: the other one, if `assume` settles that.
    pub(super) fn or(self, other: Self) -> Self {
        if other.rests_on.is_empty() { self } else { other }
    }

    /// The same in other words.
    pub(super) fn told(self, text: String) -> Self {
        Self { text, ..self }
    }

    /// The same, and what helps.
    pub(super) fn with(mut self, hint: &str) -> Self {
        self.text.push_str(hint);
        self
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Whether there is no reason: the program has not set it.
    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty()
    }
}

/// Both, or why they are not known.
pub(super) fn both<A, B>(one: Result<A, Why>, other: Result<B, Why>) -> Result<(A, B), Why> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok((one, other)),
        (Err(one), Err(other)) => Err(one.and(other)),
        (Err(why), Ok(_)) | (Ok(_), Err(why)) => Err(why),
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        if self.rests_on.is_empty() {
            return Ok(());
        }
        let given: Vec<String> =
            self.rests_on.iter().map(|name| format!("\"{name}\": …")).collect();
        let them = if given.len() > 1 { "them" } else { "it" };
        write!(f, "; assume: {{{}}} in the job can give {them}", given.join(", "))
    }
}

impl From<String> for Why {
    fn from(text: String) -> Self {
        Self { text, rests_on: Vec::new() }
    }
}

impl From<&str> for Why {
    fn from(text: &str) -> Self {
        Self::from(text.to_owned())
    }
}

impl From<Why> for String {
    fn from(why: Why) -> Self {
        why.to_string()
    }
}
