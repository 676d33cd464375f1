//! LinuxCNC's statements with O-words: subroutines, conditions and loops.

use std::collections::HashMap;

use super::flow::{Behind, Flow, OWord};
use super::parameters::Key;

impl Flow<'_> {
    pub(super) fn o_statement(&mut self, here: &OWord, behind: Behind<'_>) -> Result<(), String> {
        let (line, label) = (here.line, here.label.as_str());
        match here.keyword.as_str() {
            // A subroutine is run where it is called.
            "SUB" => self.go_behind(label, line, &["ENDSUB"]),
            "ENDSUB" | "RETURN" => {
                self.give_back(behind)?;
                self.back();
                Ok(())
            }
            "CALL" => {
                let head = self.o_words.iter().find(|o| o.label == label && o.keyword == "SUB");
                let head = head.ok_or_else(|| format!("O<{label}> is not in this file"))?.line;
                // Of 30, those that are not given are zero.
                let mut locals: HashMap<i64, f64> = (1..=30).map(|number| (number, 0.0)).collect();
                let mut reader = behind.reader(&self.parameters);
                let mut next = 0;
                while reader.peek() == Some(b'[') {
                    next += 1;
                    locals.insert(next, reader.value()?);
                }
                self.set_returned([f64::NAN; 2])?;
                self.enter(head + 1, 1, Some(locals), false)
            }
            "IF" | "ELSEIF" if here.keyword == "IF" || self.arrived(line) => {
                let (truth, _) = self.condition(behind.content, behind.rest)?;
                if truth {
                    return Ok(());
                }
                let next = ["ELSEIF", "ELSE", "ENDIF"];
                let at = self.find(label, line, &next)?;
                let of = self.o_words.iter().find(|o| o.line == at);
                let is_elseif = of.is_some_and(|o| o.keyword == "ELSEIF");
                self.next = if is_elseif { at } else { at + 1 };
                if is_elseif {
                    self.repeats.insert(at, 0);
                }
                Ok(())
            }
            // Reached from the branch before, which has run.
            "ELSEIF" | "ELSE" => self.go_behind(label, line, &["ENDIF"]),
            "WHILE" | "ENDWHILE" | "REPEAT" | "ENDREPEAT" | "CONTINUE" | "BREAK" => {
                self.o_loop(here, behind)
            }
            "DO" | "ENDIF" => Ok(()),
            other => Err(format!("O-word '{other}' is not understood")),
        }
    }

    /// What `return [expr]` and `endsub [expr]` give back, and whether they do.
    fn give_back(&mut self, behind: Behind<'_>) -> Result<(), String> {
        let mut reader = behind.reader(&self.parameters);
        let value = if reader.peek() == Some(b'[') { Some(reader.value()?) } else { None };
        self.set_returned(value.map_or([0.0; 2], |value| [value, 1.0]))
    }

    /// `#<_value>` and `#<_value_returned>` of LinuxCNC. A call clears them, to what is not
    /// documented: not a number.
    fn set_returned(&mut self, [value, is_given]: [f64; 2]) -> Result<(), String> {
        self.parameters.set(Key::Name("_value".to_owned()), value, None)?;
        self.parameters.set(Key::Name("_value_returned".to_owned()), is_given, None)
    }

    /// The last statement with one of these words before the one at hand, of the same label.
    fn head(&self, here: &OWord, keywords: &[&str]) -> Option<&OWord> {
        self.o_words.iter().rfind(|o| {
            o.line < here.line && o.label == here.label && keywords.contains(&o.keyword.as_str())
        })
    }

    fn o_loop(&mut self, here: &OWord, behind: Behind<'_>) -> Result<(), String> {
        let (line, label) = (here.line, here.label.as_str());
        match here.keyword.as_str() {
            "WHILE" => {
                // The WHILE of a DO stands at its end.
                let head = self.head(here, &["DO", "ENDWHILE"]);
                let of_do = head.filter(|o| o.keyword == "DO").map(|o| o.line);
                let truth = self.condition(behind.content, behind.rest).map(|(truth, _)| truth);
                match of_do {
                    Some(head) => {
                        if truth? {
                            self.next = head + 1;
                        }
                        Ok(())
                    }
                    None => {
                        let end = self.find(label, line, &["ENDWHILE"])?;
                        self.enter_loop(truth, end + 1)
                    }
                }
            }
            "ENDWHILE" | "ENDREPEAT" => {
                let head = self.head(here, &["WHILE", "REPEAT"]);
                self.next = head.ok_or("a loop ends that has no beginning")?.line;
                Ok(())
            }
            "REPEAT" => {
                let left = match self.repeats.remove(&line) {
                    Some(left) => left,
                    None => {
                        let count = behind.reader(&self.parameters).value()?.max(0.0);
                        count as u64
                    }
                };
                match left.checked_sub(1) {
                    Some(left) => {
                        self.repeats.insert(line, left);
                        Ok(())
                    }
                    None => self.go_behind(label, line, &["ENDREPEAT"]),
                }
            }
            _ => self.leave_body(here),
        }
    }

    /// CONTINUE goes on where the loop asks or counts, which of DO is the WHILE at its end; BREAK
    /// goes behind the loop.
    fn leave_body(&mut self, here: &OWord) -> Result<(), String> {
        let head = self.head(here, &["WHILE", "REPEAT", "DO"]);
        let head = head.ok_or_else(|| format!("{} outside of a loop", here.keyword))?;
        let (from, is_do) = (head.line, head.keyword == "DO");
        let ends: &[&str] = if is_do { &["WHILE"] } else { &["ENDWHILE", "ENDREPEAT"] };
        let end = self.find(&here.label, here.line, ends)?;
        let breaks = here.keyword == "BREAK";
        // Loops within count anew.
        self.repeats.retain(|at, _| !(from..here.line).contains(at) || *at == from && !breaks);
        self.next = match (breaks, is_do) {
            (true, _) => end + 1,
            (false, true) => end,
            (false, false) => from,
        };
        Ok(())
    }

    /// Whether an ELSEIF was come to because the condition before was false.
    fn arrived(&mut self, line: usize) -> bool {
        self.repeats.remove(&line).is_some()
    }

    fn find(&self, label: &str, line: usize, keywords: &[&str]) -> Result<usize, String> {
        let behind = self
            .o_words
            .iter()
            .find(|o| o.line > line && o.label == label && keywords.contains(&o.keyword.as_str()));
        behind
            .map(|o| o.line)
            .ok_or_else(|| format!("expected {} of O<{label}> behind", keywords.join(" or ")))
    }

    fn go_behind(&mut self, label: &str, line: usize, keywords: &[&str]) -> Result<(), String> {
        self.next = self.find(label, line, keywords)? + 1;
        Ok(())
    }
}
