//! Sinumerik's jumps, conditions and loops: GOTO with labels and block numbers, IF, CASE, FOR,
//! WHILE, LOOP, REPEAT to UNTIL, and REPEAT of what stands behind a label (Siemens, SINUMERIK 840D
//! sl/828D Job Planning, "Program jumps", "Control structures").

use super::expression::{Reader, not_vacant};
use super::flow::Flow;
use super::parameters::Key;
use super::structure::{code, is_block, is_synchronized, labelled, split, stripped, within};

impl Flow<'_> {
    /// Whether the line directs the flow; then it is done.
    pub(super) fn structured(&mut self, content: &str, line: usize) -> Result<bool, String> {
        let (_, text) = labelled(code(stripped(content)));
        if is_synchronized(text) {
            return Err("a synchronized action (WHEN … DO) runs beside the program whenever its \
                        condition holds, and may stop or change feed and speed: not read; leave \
                        it out if it changes no motion, speed or tool"
                .to_owned());
        }
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
                let truth = self.truth(rest);
                self.enter_loop(truth, end + 1)?;
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
            "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" => match target(rest) {
                (target, "") => self.go_to(word, target, line)?,
                (target, behind) => return Err(not_read(behind, word, target)),
            },
            "CASE" => self.case(rest, line)?,
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

    /// `IF R1<5 GOTOB LOOP1`, or IF up to ELSE or ENDIF. Of several jumps in a block the first is
    /// made whose condition holds.
    fn if_(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let upper = rest.to_ascii_uppercase();
        if let Some(at) = upper.find("GOTO") {
            let (condition, jump) = rest.split_at(at);
            let jump = split(jump).ok_or("IF: expected GOTO, GOTOF, GOTOB or GOTOC")?;
            let (word, (target, behind)) = (jump.0, target(jump.1));
            let next = split(behind).filter(|(word, _)| *word == "IF");
            if next.is_none() && !behind.is_empty() {
                return Err(not_read(behind, word, target));
            }
            return match (self.truth(condition)?, next) {
                (true, _) => self.go_to(word, target, line),
                (false, Some((_, rest))) => self.if_(rest, line),
                (false, None) => Ok(()),
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
        let before = self.files.around(line).start..line;
        let head = match within(self.structure.labelled(&label.to_uppercase()), before) {
            [head] => *head,
            [] => return Err(format!("REPEAT: there is no label {label} before it")),
            _ => {
                return Err(format!(
                    "REPEAT: the label {label} stands more than once before it; give each a name \
                     of its own"
                ));
            }
        };
        if !within(self.structure.labelled("ENDLABEL"), head..line).is_empty() {
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

    /// To a label or a block number, of which each may stand more than once: GOTOF to the next
    /// towards the end, GOTOB to the next towards the beginning, GOTO and GOTOC to either, the end
    /// first. GOTOC goes on where there is none, if it names a label or a number.
    fn go_to(&mut self, word: &str, target: &str, line: usize) -> Result<(), String> {
        let target = target.trim().to_uppercase();
        let digits = target.strip_prefix('N').filter(|digits| {
            !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
        });
        let all = match digits.and_then(|digits| digits.parse().ok()) {
            Some(number) => self.numbered(number),
            None => self.structure.labelled(&target),
        };
        let file = self.files.around(line);
        let ahead = within(all, line + 1..file.end).first().copied();
        // The block of the jump itself may be its place.
        let back = within(all, file.start..line + 1).last().copied();
        let found = match word {
            "GOTOF" => ahead,
            "GOTOB" => back,
            _ => ahead.or(back),
        };
        match found {
            Some(found) => self.next = found,
            None if word == "GOTOC" && (digits.is_some() || is_label(&target)) => {}
            None => return Err(format!("{word}: {target} is not there")),
        }
        Ok(())
    }

    /// `CASE R1 OF 1 GOTOF A 2 GOTOB B DEFAULT GOTOF C`: where the value is none of these, without
    /// DEFAULT, on to the next block.
    fn case(&mut self, rest: &str, line: usize) -> Result<(), String> {
        let wrong = "CASE: expected a number, OF, numbers each with a jump, and DEFAULT with one";
        let mut reader = Reader::new(rest.as_bytes(), 0, &self.parameters);
        let value = not_vacant(reader.expression()?)?;
        if reader.letters() != "OF" {
            return Err(wrong.to_owned());
        }
        if value.fract() != 0.0 {
            return Err(format!("CASE: the value is {value}, must be a whole number"));
        }
        let words: Vec<&str> = rest.get(reader.at..).unwrap_or("").split_whitespace().collect();
        let (cases @ [.., last], []) = words.as_chunks::<3>() else { return Err(wrong.to_owned()) };
        let mut chosen = None;
        for case in cases {
            let [constant, jump, target] = case;
            let Some((word, "")) = split(jump).filter(|(word, _)| word.starts_with("GOTO")) else {
                return Err(wrong.to_owned());
            };
            let is_own = match constant.parse::<i32>() {
                Ok(constant) => f64::from(constant) == value,
                Err(_) if constant.eq_ignore_ascii_case("DEFAULT") && case == last => true,
                Err(_) => return Err(wrong.to_owned()),
            };
            if is_own && chosen.is_none() {
                chosen = Some((word, *target));
            }
        }
        chosen.map_or(Ok(()), |(word, target)| self.go_to(word, target, line))
    }
}

/// Whether a target in upper case is a label as it stands, and none to be worked out: labels begin
/// with two letters or underscores.
fn is_label(target: &str) -> bool {
    let begins = target.bytes().take_while(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
    begins.count() >= 2 && target.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// Where a jump leads, and what stands behind that.
fn target(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (target, behind) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (target, behind.trim_start())
}

fn not_read(behind: &str, word: &str, target: &str) -> String {
    format!("'{behind}' behind {word} {target} is not read")
}
