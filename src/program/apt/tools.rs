//! Tools in the words of the CAM systems, and what names one, or states a speed, without doing it.

use std::collections::HashMap;

use super::lexer::{self, Statement, Word};
use super::{Reader, name, number};
use crate::notes::Code;

/// What the words before the next motion say of the tool.
#[derive(Debug, Default)]
pub(super) struct Tools {
    /// By word, as it was named last.
    named: HashMap<String, String>,
    /// That a word names another tool, and its line.
    other: Option<(usize, String)>,
    is_loaded: bool,
    /// The line of LOADTL, and the speed that it states.
    speed: Option<(usize, f64)>,
}

impl Tools {
    /// A speed of SPINDL counts more than that of LOADTL.
    pub(super) fn has_spindle(&mut self) {
        self.speed = None;
    }
}

impl Reader<'_> {
    /// `LOADTL/1,…`, `LOAD/TOOL,1,…`, `TURRET/1`: the first number is the tool's.
    pub(super) fn load_tool(
        &mut self,
        line: usize,
        major: &str,
        minor: &[Word<'_>],
    ) -> Result<(), String> {
        if minor.first().and_then(name).is_some_and(|word| lexer::is(word, "HEAD")) {
            self.other_head(line);
            return Ok(());
        }
        self.tools.is_loaded = true;
        let speed = minor.windows(2).find_map(|pair| match pair {
            [Word::Name(word), Word::Number(rpm, _)] if lexer::is(word, "SPINDL") => Some(*rpm),
            _ => None,
        });
        self.tools.speed = speed.map(|rpm| (line, rpm));
        match minor.iter().find_map(number) {
            Some((number, _)) => {
                // A turret turns beside the spindle; a speed of LOADTL's own is told of elsewhere.
                if major != "TURRET" && speed.is_none() && self.cutter.has_other_than(number) {
                    self.cutter.change();
                }
                self.cutter.tool(number)
            }
            None => {
                self.cutter.left_out(line, "a tool without a number is left out".to_owned());
                Ok(())
            }
        }
    }

    pub(super) fn other_head(&mut self, line: usize) {
        let what = "HEAD: the job's tcp is used with every head";
        self.cutter.log.warning(Code::ChangeIgnored, line, what);
    }

    /// `CUTTER/10`, `TOOLNO/2`, `TOOL/2`, `TOOL PATH/…,TOOL,END_MILL`: no tool is loaded.
    pub(super) fn name_tool(&mut self, line: usize, statement: &Statement<'_>) {
        let major = statement.major().to_ascii_uppercase();
        let minor = statement.minor();
        let named = if major == "TOOL PATH" {
            let words: Vec<&str> = minor.iter().filter_map(name).collect();
            words.windows(2).find(|pair| lexer::is(pair[0], "TOOL")).map(|pair| pair[1].to_owned())
        } else {
            minor.first().map(|word| match word {
                Word::Number(number, _) => number.to_string(),
                Word::Name(name) => (*name).to_owned(),
            })
        };
        let Some(named) = named else { return };
        if let Some(before) = self.tools.named.insert(major.clone(), named.clone())
            && before != named
        {
            let what = format!(
                "{major} names another tool ({named}, before {before}), and nothing loads one: \
                 the tool before is taken to stay"
            );
            self.tools.other.get_or_insert((line, what));
        }
    }

    /// Motion follows: tells of a tool that is named and not loaded, and of a speed that no SPINDL
    /// bears out.
    pub(super) fn settle_tool(&mut self) {
        let other = self.tools.other.take();
        if let Some((line, what)) = other.filter(|_| !self.tools.is_loaded) {
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        self.tools.is_loaded = false;
        if let Some((line, rpm)) = self.tools.speed.take()
            && self.cutter.rpm != Some(rpm)
        {
            let what = format!(
                "the tool is loaded with SPINDL,{rpm}, and no SPINDL statement follows: some \
                 posts start the spindle at that speed, which is not read"
            );
            self.cutter.log.warning(Code::SpindleCommand, line, what);
        }
    }
}
