//! Which program of Fanuc's runs: `O5` or `:5` at its head says so.

/// The head of a program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Head {
    pub(super) number: i64,
    /// Whether blocks begin on its line.
    pub(super) has_words: bool,
    has_colon: bool,
}

impl Head {
    /// Of a line without the blanks, the `/` and the N word that it begins with, and which is no
    /// O-word.
    pub(super) fn of(line: &str) -> Option<Self> {
        let behind = line.strip_prefix(['O', 'o', ':'])?.trim_start();
        let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
        let (number, behind) = behind.split_at_checked(digits)?;
        let behind = behind.trim_start();
        Some(Self {
            number: number.parse().ok()?,
            has_words: behind.starts_with(|c: char| c.is_ascii_alphabetic() || c == '#'),
            has_colon: line.starts_with(':'),
        })
    }

    /// Whether it is a main block of ISO, `:20 G1 X5`, where nothing calls its number.
    pub(super) fn may_be_block(&self) -> bool {
        self.has_colon && self.has_words
    }
}

/// Which program runs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Running {
    number: Option<i64>,
    /// Whether it has had blocks.
    has_blocks: bool,
}

impl Running {
    /// One that is called.
    pub(super) fn called(number: Option<i64>) -> Self {
        Self { number, has_blocks: false }
    }

    /// Takes in the line that comes next: the head of another program is no part of the one that
    /// runs, which has no end then.
    pub(super) fn goes_on(&mut self, line: &str, head: Option<Head>) -> Result<(), String> {
        let Some(Head { number, has_words, .. }) = head else {
            let begins = |c: char| c.is_ascii_alphanumeric() || matches!(c, '#' | ':');
            self.has_blocks |= line.starts_with(begins);
            return Ok(());
        };
        match self.number {
            Some(own) if own != number && self.has_blocks => Err(format!(
                "O{number} begins another program here, and the one before has no end: Fanuc and \
                 Haas controls do not run on into it; write M30 before it, or M99 where what ends \
                 is called"
            )),
            None if self.has_blocks => Err(format!(
                "O{number} begins a program here, and blocks stand before it: write O{number} \
                 before them if they are part of it, else M30 behind them, or M99 where they are \
                 called"
            )),
            // Some posts write the number before each block.
            _ => {
                self.number = Some(number);
                self.has_blocks |= has_words;
                Ok(())
            }
        }
    }
}
