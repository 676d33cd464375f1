//! Sinumerik's jumps, conditions and loops: GOTO with labels and block numbers, IF, FOR, WHILE,
//! LOOP, REPEAT to UNTIL, and REPEAT of what stands behind a label (Siemens, SINUMERIK 840D sl/828D
//! Job Planning, "Program jumps", "Control structures").

use super::expression::{Key, Reader, not_vacant};
use super::flow::Flow;
use super::structure::{code, is_block, labelled, split, stripped};

impl Flow<'_> {
    /// Whether the line directs the flow; then it is done.
    pub(super) fn structured(&mut self, content: &str, line: usize) -> Result<bool, String> {
        let (_, text) = labelled(code(stripped(content)));
        let Some((word, rest)) = split(text) else { return Ok(false) };
        match word {
            "IF" => self.if_(rest, line)?,
            "ELSE" => {
                let start = self.structure.start(line, word)?;
                self.next = self.structure.end(start, "IF")? + 1;
            }
            "ENDIF" => {}
            "WHILE" => {
                let end = self.structure.end(line, word)?;
                if !self.truth(rest)? {
                    self.next = end + 1;
                }
            }
            "ENDWHILE" | "ENDLOOP" => self.next = self.structure.start(line, word)?,
            "LOOP" => {
                self.structure.end(line, word)?;
            }
            "FOR" => self.begin_for(rest, line)?,
            "ENDFOR" => self.end_for(line)?,
            "REPEAT" if is_block(rest) => {
                self.structure.end(line, word)?;
            }
            "UNTIL" => {
                let start = self.structure.start(line, word)?;
                if !self.truth(rest)? {
                    self.next = start + 1;
                }
            }
            "REPEAT" => self.repeat_from(rest, line)?,
            "GOTO" | "GOTOF" | "GOTOB" => self.go_to(word, rest, line)?,
            _ => return Err(format!("{word} is not supported")),
        }
        Ok(true)
    }

    fn truth(&self, text: &str) -> Result<bool, String> {
        let mut reader = Reader::new(text.as_bytes(), 0, &self.parameters);
        let value = not_vacant(reader.expression()?)?;
        match reader.peek() {
            None => Ok(value != 0.0),
            Some(_) => Err("a condition is followed by what is not understood".to_owned()),
        }
    }

    /// `IF R1<5 GOTOB LOOP1`, or IF up to ELSE or ENDIF.
    fn if_(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let upper = rest.to_ascii_uppercase();
        if let Some(at) = upper.find("GOTO") {
            let (condition, jump) = rest.split_at(at);
            return match (self.truth(condition)?, split(jump)) {
                (true, Some((word, rest))) => self.go_to(word, rest, line),
                (false, Some(_)) => Ok(()),
                (_, None) => Err("IF: expected GOTO, GOTOF or GOTOB".to_owned()),
            };
        }
        let end = self.structure.end(line, "IF")?;
        if !self.truth(rest)? {
            self.next = self.structure.else_of.get(&line).copied().unwrap_or(end) + 1;
        }
        Ok(())
    }

    /// `FOR R1 = 1 TO 5`: the variable, its first value and its last.
    fn counted(&self, rest: &str) -> Result<(Key, f64, f64), String> {
        let wrong = "FOR: expected a variable, '=', a number, TO and a number";
        let (name, values) = rest.split_once('=').ok_or(wrong)?;
        let key = Key::Name(name.trim().to_ascii_lowercase());
        let mut reader = Reader::new(values.as_bytes(), 0, &self.parameters);
        let first = not_vacant(reader.expression()?)?;
        if reader.letters() != "TO" {
            return Err(wrong.to_owned());
        }
        let last = not_vacant(reader.expression()?)?;
        Ok((key, first, last))
    }

    fn begin_for(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let end = self.structure.end(line, "FOR")?;
        let (key, first, last) = self.counted(rest)?;
        self.parameters.set(key, first, None)?;
        if first > last {
            self.next = end + 1;
        }
        Ok(())
    }

    fn end_for(&mut self, line: usize) -> Result<(), String> {
        let start = self.structure.start(line, "ENDFOR")?;
        let (_, head) = labelled(code(stripped(self.lines[start].1)));
        let rest = split(head).map_or("", |(_, rest)| rest);
        let (name, _) = rest.split_once('=').unwrap_or((rest, ""));
        let key = Key::Name(name.trim().to_ascii_lowercase());
        let next = self.parameters.get(&key)? + 1.0;
        let (_, _, last) = self.counted(rest)?;
        self.parameters.set(key, next, None)?;
        if next <= last {
            self.next = start + 1;
        }
        Ok(())
    }

    /// `REPEAT LABEL P=3`: what stands between the label and here so often again.
    fn repeat_from(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let rest = rest.trim();
        let (label, times) = match rest.split_once(char::is_whitespace) {
            None => (rest, "P=1"),
            Some((label, times)) => (label, times.trim()),
        };
        let count = times.strip_prefix(['P', 'p']).and_then(|t| t.trim().strip_prefix('='));
        let count = count.ok_or("REPEAT of two labels is not supported")?;
        let file = self.files.around(line);
        let head = self.structure.label(&label.to_uppercase(), &file);
        let head = head.filter(|head| *head < line);
        let head = head.ok_or_else(|| format!("REPEAT: there is no label {label} before it"))?;
        if self.structure.label("ENDLABEL", &(head..line)).is_some() {
            return Err("REPEAT up to ENDLABEL is not supported".to_owned());
        }
        let left = match self.repeats.remove(&line) {
            Some(left) => left,
            None => {
                let mut reader = Reader::new(count.as_bytes(), 0, &self.parameters);
                let count = not_vacant(reader.expression()?)?;
                if !(0.0..=9999.0).contains(&count) || count.fract() != 0.0 {
                    return Err(format!("REPEAT: P is {count}, must be a whole number"));
                }
                count as u64
            }
        };
        if let Some(left) = left.checked_sub(1) {
            self.repeats.insert(line, left);
            self.next = head;
        }
        Ok(())
    }

    /// To a label or a block number: GOTOF forwards, GOTOB backwards, GOTO either way.
    fn go_to(&mut self, word: &str, rest: &str, line: usize) -> Result<(), String> {
        let target = rest.trim().to_uppercase();
        let file = self.files.around(line);
        let digits = target.strip_prefix('N').filter(|digits| {
            !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
        });
        let found = match digits.and_then(|digits| digits.parse().ok()) {
            Some(number) => {
                let ahead = self.numbered(number, line + 1..file.end);
                let back = || self.last_numbered(number, line).filter(|at| file.contains(at));
                match word {
                    "GOTOF" => ahead,
                    "GOTOB" => back(),
                    _ => ahead.or_else(back),
                }
            }
            None => self.structure.label(&target, &file).filter(|at| match word {
                "GOTOF" => *at > line,
                "GOTOB" => *at <= line,
                _ => true,
            }),
        };
        self.next = found.ok_or_else(|| format!("{word}: {target} is not there"))?;
        Ok(())
    }
}
