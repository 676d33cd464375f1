//! The text of a Fanuc TP program → its statements and positions.

use std::collections::{BTreeSet, HashMap};

use super::words::{end_of_statement, is_of_arm, register};
use crate::program::span::Span;

/// A statement without its number and its `;`, continued lines joined.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Statement {
    pub(super) line: usize,
    pub(super) text: String,
    /// Where each byte of `text` stands in the file's text.
    places: Vec<usize>,
}

impl Statement {
    /// The place of a part of the statement in the file's text, if it is in one piece there.
    pub(super) fn span(&self, start: usize, end: usize) -> Option<Span> {
        let (first, last) = (*self.places.get(start)?, *self.places.get(end.checked_sub(1)?)?);
        (last - first == end - 1 - start).then(|| Span::new(first, last + 1))
    }
}

/// A group of a position: components in mm and degrees.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Group {
    /// `None`: as UFRAME_NUM says.
    pub(super) frame: Option<u32>,
    pub(super) tool: Option<u32>,
    /// Letters of CONFIG for wrist, elbow and shoulder, and turns.
    pub(super) config: Option<String>,
    /// X, Y, Z, W, P, R, J1 … and E1 …, in lower case.
    pub(super) parts: HashMap<String, f64>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Position {
    /// By number of the group.
    pub(super) groups: Vec<(u32, Group)>,
}

/// Numbers of user frames or of tools.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    /// Those in which positions are taught.
    pub(super) of_positions: BTreeSet<u32>,
    /// Whether any statement chooses one.
    pub(super) are_chosen: bool,
}

#[derive(Debug, Default)]
pub(super) struct Source {
    /// Behind /PROG.
    pub(super) name: String,
    /// Where it stands among the programs that are read.
    pub(super) index: usize,
    /// The further file that it is of.
    pub(super) file: Option<String>,
    pub(super) statements: Vec<Statement>,
    /// Statements with labels, by number.
    pub(super) labels: HashMap<i64, Vec<usize>>,
    /// The statements of each FOR and its ENDFOR.
    pub(super) loops: Vec<[usize; 2]>,
    pub(super) positions: HashMap<u32, Position>,
    pub(super) frames: Numbers,
    pub(super) tools: Numbers,
    /// Line and number of the schedule by which positions follow a conveyor.
    pub(super) tracks: Option<(usize, String)>,
    /// DEFAULT_GROUP as it stands, where it leaves out group 1, the arm.
    pub(super) without_arm: Option<String>,
    /// Line and name of what is DEFAULT_GROUP in another language.
    pub(super) translated: Option<(usize, String)>,
    /// Line and remark behind a statement, from its `;` on.
    pub(super) remarks_behind: Vec<(usize, String)>,
    /// Line and what is wrong.
    pub(super) faults: Vec<(usize, String)>,
    /// Line and what may be an instruction.
    pub(super) doubts: Vec<(usize, String)>,
    pub(super) has_end: bool,
    pub(super) moves_behind_end: Option<usize>,
    pub(super) lines: usize,
}

impl Source {
    /// The same in a further file: nothing is written there.
    pub(super) fn of_file(mut self, name: &str) -> Self {
        self.statements.iter_mut().for_each(|own| own.places = Vec::new());
        self.file = Some(name.to_owned());
        self
    }

    pub(super) fn shown_file(&self) -> &str {
        self.file.as_deref().unwrap_or("the file that is checked")
    }
}

/// Reads a listing that has so many lines and bytes of its file before it.
pub(super) fn parse(text: &str, lines: usize, bytes: usize) -> Source {
    let mut source = Source::default();
    let mut section = "";
    let mut open: Option<Statement> = None;
    let mut positions = String::new();
    let mut offset = bytes;
    let mut positions_line = 1;
    let mut has_group = false;
    for (index, whole) in (lines..).zip(text.split_inclusive('\n')) {
        let start = offset;
        offset += whole.len();
        source.lines = index + 1;
        let line = whole.trim_end();
        let trimmed = line.trim_start();
        if section == "END" {
            let (_, text) = without_number(trimmed);
            if is_motion(text.trim_start()) {
                source.moves_behind_end.get_or_insert(index + 1);
            }
            continue;
        }
        if trimmed.starts_with('/') && !trimmed.starts_with("//") {
            match section_of(trimmed, section) {
                Some(new) => section = new,
                None => {
                    source.faults.push((index + 1, no_section(trimmed)));
                    // Lines are counted on.
                    positions.extend((section == "POS").then_some('\n'));
                }
            }
            source.has_end = section == "END";
            if section == "PROG" {
                let name = trimmed.split_whitespace().nth(1);
                source.name = name.unwrap_or("").to_owned();
            }
            if section == "POS" && positions.is_empty() {
                positions_line = index + 2;
            }
            continue;
        }
        match section {
            "MN" => statement(&mut source, &mut open, index + 1, line, start),
            "POS" => {
                positions.push_str(line);
                positions.push('\n');
            }
            _ => {
                let name = trimmed.split('=').next().unwrap_or("").trim();
                if section == "ATTR" && name.eq_ignore_ascii_case("DEFAULT_GROUP") {
                    let groups = trimmed.split('=').nth(1).unwrap_or("").trim();
                    let is_without = groups.starts_with('*');
                    source.without_arm = is_without.then(|| trimmed.replace(';', ""));
                    has_group = true;
                }
                if section == "ATTR"
                    && let Some(name) = named_groups(trimmed)
                {
                    source.translated.get_or_insert((index + 1, name.to_owned()));
                }
                if let Some(schedule) = tracking(trimmed) {
                    source.tracks = Some((index + 1, schedule.to_owned()));
                }
            }
        }
    }
    if has_group {
        source.translated = None;
    }
    if let Some(open) = open {
        source.faults.push((open.line, "the statement has no ';': is the file whole?".to_owned()));
    }
    read_positions(&positions, positions_line, &mut source);
    source.labels = labels(&source.statements);
    pair(&mut source);
    let groups = source.positions.values().flat_map(|position| &position.groups);
    for (_, group) in groups.filter(|(number, _)| *number == 1) {
        // Joints need no frame.
        let frame = group.frame.filter(|_| !group.parts.contains_key("j1"));
        source.frames.of_positions.extend(frame);
        source.tools.of_positions.extend(group.tool);
    }
    let chooses = |name: &str| {
        let mut texts = source.statements.iter().map(|own| own.text.as_str());
        texts.any(|text| {
            let own = text.find(name).and_then(|at| text.get(at..));
            own.is_some_and(|own| is_of_arm(own, name) != Ok(false))
        })
    };
    source.frames.are_chosen = chooses("UFRAME_NUM");
    source.tools.are_chosen = chooses("UTOOL_NUM");
    source
}

fn labels(statements: &[Statement]) -> HashMap<i64, Vec<usize>> {
    let mut found: HashMap<i64, Vec<usize>> = HashMap::new();
    for (index, statement) in statements.iter().enumerate() {
        if let Some((number, _)) = register(statement.text.trim(), "LBL") {
            found.entry(number).or_default().push(index);
        }
    }
    found
}

/// FOR and ENDFOR, IF … THEN, ELSE and ENDIF go in pairs, one within another.
fn pair(source: &mut Source) {
    let mut open: Vec<(usize, &str)> = Vec::new();
    let lone = |what: &str, of: &str| format!("{what} has no {of}: the controller stops there");
    for (index, statement) in source.statements.iter().enumerate() {
        let text = statement.text.trim();
        let word = text.split([' ', '[', '(', '=', ',']).next().unwrap_or("");
        let last = open.last().map(|(_, word)| *word);
        let fault = match word {
            "FOR" => {
                open.push((index, "FOR"));
                None
            }
            "IF" if text.ends_with("THEN") => {
                open.push((index, "IF"));
                None
            }
            "ELSE" if text == "ELSE" => (last != Some("IF")).then(|| lone("ELSE", "IF")),
            "ENDIF" => match open.pop_if(|(_, word)| *word == "IF") {
                Some(_) => None,
                None => Some(lone("ENDIF", "IF … THEN")),
            },
            "ENDFOR" => match open.pop_if(|(_, word)| *word == "FOR") {
                Some((start, _)) => {
                    source.loops.push([start, index]);
                    None
                }
                None => Some(lone("ENDFOR", "FOR")),
            },
            _ => None,
        };
        source.faults.extend(fault.map(|what| (statement.line, what)));
    }
    for (index, word) in open {
        let end = if word == "FOR" { "ENDFOR" } else { "ENDIF" };
        let line = source.statements.get(index).map_or(0, |own| own.line);
        source.faults.push((line, lone(word, end)));
    }
}

/// The section that begins at `/MN` or `/PROG NAME` within another; none where a line only looks
/// so: behind `/MN` only `/POS` and `/END` can come, behind `/POS` only `/END`.
fn section_of(line: &str, within: &str) -> Option<&'static str> {
    const ALL: [&str; 6] = ["PROG", "ATTR", "APPL", "MN", "POS", "END"];
    let (name, rest) = line.split_at(line.find(char::is_whitespace).unwrap_or(line.len()));
    let name = name.strip_prefix('/')?.trim_end_matches('.');
    let own = ALL.into_iter().find(|own| own.eq_ignore_ascii_case(name))?;
    let is_whole = own == "PROG" || rest.is_empty();
    let may_come = match within {
        "MN" => matches!(own, "POS" | "END"),
        "POS" => own == "END",
        _ => true,
    };
    (is_whole && may_come).then_some(own)
}

fn no_section(line: &str) -> String {
    format!(
        "'{line}' is not understood: a line that begins with '/' begins a section (/MN, then /POS, \
         then /END); write '!' before a remark, '//' before an instruction that is commented out"
    )
}

/// The number behind `LINE_TRACK_SCHEDULE_NUMBER : 1;` in the program's head; 0 tracks nothing.
fn tracking(line: &str) -> Option<&str> {
    let (name, value) = line.split_once(':')?;
    let schedule = value.trim().trim_end_matches(';').trim_end();
    let is_it = name.trim().eq_ignore_ascii_case("LINE_TRACK_SCHEDULE_NUMBER");
    (is_it && schedule != "0").then_some(schedule)
}

/// The name in `DEFAULT_GROUP = 1,*,*,*,*;`, in any language.
fn named_groups(line: &str) -> Option<&str> {
    let (name, value) = line.split_once('=')?;
    let groups: Vec<&str> = value.trim().trim_end_matches(';').split(',').map(str::trim).collect();
    let is_groups = groups.len() > 1 && groups.iter().all(|own| matches!(*own, "1" | "*"));
    is_groups.then_some(name.trim())
}

/// `-- text`, `--eg:text`, `--- text ---`, and dashes that end what stands behind P-SPS.
pub(super) fn is_dashed_remark(text: &str) -> bool {
    text.starts_with("--")
}

/// `! text`, `// L P[1] …`, `-- text`, or nothing.
pub(super) fn is_remark(text: &str) -> bool {
    text.is_empty() || text.starts_with('!') || text.starts_with("//") || is_dashed_remark(text)
}

/// Whether a text may be an instruction: motion, what sets something, or what leads elsewhere.
fn may_be_instruction(text: &str) -> bool {
    const PLAIN: [&str; 5] = ["CALL ", "RUN ", "ABORT", "END", "PAUSE"];
    text.contains(['[', '=']) || PLAIN.iter().any(|own| text.starts_with(own))
}

/// Looks at what stands behind the `;` of a statement, which is refused if it is no remark, or at a
/// remark as a whole: it goes on to the last `;` of its line.
fn look_behind(source: &mut Source, line: usize, text: &str) {
    let tail = text.trim_matches([' ', '\t', ';']);
    let mut behind = tail.split(';').skip(1).map(str::trim);
    if !is_remark(tail) {
        let what = format!(
            "'{tail}' stands behind the ';' of another instruction: TP has one on a line; write it \
             on a line of its own"
        );
        source.faults.push((line, what));
        return;
    }
    if let Some(own) = behind.find(|own| !is_remark(own) && may_be_instruction(own)) {
        let what = format!(
            "'{own}' stands behind a ';' within a remark, and is taken as part of it; if it is an \
             instruction, write it on a line of its own"
        );
        source.doubts.push((line, what));
    }
    if text.starts_with(';') && !tail.is_empty() {
        source.remarks_behind.push((line, text.to_owned()));
    }
}

/// What stands behind the number of a line and its colon, both of which may be missing, and where.
fn without_number(content: &str) -> (usize, &str) {
    let rest = content.trim_start();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let behind = rest.get(digits..).and_then(|rest| rest.trim_start().strip_prefix(':'));
    let rest = behind.unwrap_or(rest);
    (content.len() - rest.len(), rest)
}

/// Takes a line of `/MN`: `  12:L P[1] 100mm/sec FINE ;`, or what continues the one before.
fn statement(
    source: &mut Source,
    open: &mut Option<Statement>,
    line: usize,
    content: &str,
    start: usize,
) {
    let goes_on = content.trim_start().starts_with(':');
    let (at, rest) = without_number(content);
    let at = start + at;
    if rest.trim().is_empty() {
        return;
    }
    // A remark without its ';' hides no statement behind it.
    if !goes_on && let Some(remark) = open.take_if(|own| is_dashed_remark(own.text.trim_start())) {
        source.statements.push(remark);
    }
    let is_numbered = at > start + content.len() - content.trim_start().len();
    if !goes_on
        && is_numbered
        && let Some(cut) = open.take()
    {
        // The last case of a SELECT is listed without one.
        let is_case = ["=", "ELSE,"].iter().any(|own| cut.text.trim_start().starts_with(own));
        if !is_case {
            let what = "the statement has no ';' before the next line";
            source.faults.push((cut.line, what.to_owned()));
        }
        source.statements.push(cut);
    }
    let mut new =
        open.take().unwrap_or(Statement { line, text: String::new(), places: Vec::new() });
    let own = rest.trim_start();
    let is_remark = is_remark(own);
    let end = match end_of_statement(rest).filter(|_| !is_remark) {
        Some(end) => Some(end),
        None => rest.trim_end().ends_with(';').then(|| rest.trim_end().len() - 1),
    };
    let (part, behind) = rest.split_at(end.unwrap_or(rest.len()));
    look_behind(source, line, if is_remark { own } else { behind });
    new.text.push_str(part);
    new.places.extend((0..part.len()).map(|i| at + i));
    if end.is_some() || part.trim_start().starts_with('!') {
        source.statements.push(new);
    } else {
        new.text.push(' ');
        new.places.push(at + part.len());
        *open = Some(new);
    }
}

/// `P[1:"name"]{ GP1: UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0', X = 1 mm, … };`
fn read_positions(text: &str, first_line: usize, source: &mut Source) {
    let line_at = |at: usize| {
        first_line
            + text
                .get(..at)
                .map_or(0, |before| memchr::memchr_iter(b'\n', before.as_bytes()).count())
    };
    let mut at = 0;
    // Lines are counted as positions are read: a file has thousands.
    let (mut counted, mut line) = (0, first_line);
    while let Some(found) = text.get(at..).and_then(|rest| rest.find("P[")) {
        let start = at + found;
        line += text
            .get(counted..start)
            .map_or(0, |between| memchr::memchr_iter(b'\n', between.as_bytes()).count());
        counted = start;
        let rest = text.get(start + 2..).unwrap_or("");
        let number: String = rest.chars().take_while(char::is_ascii_digit).collect();
        let Some(open) = rest.find('{') else {
            source.faults.push((line, "a position has no '{': is the file whole?".to_owned()));
            return;
        };
        let Some(close) = rest.get(open..).and_then(|rest| rest.find('}')) else {
            source.faults.push((line, "a position has no '}': is the file whole?".to_owned()));
            return;
        };
        let body = rest.get(open + 1..open + close).unwrap_or("");
        match (number.parse(), position(body)) {
            (Ok(number), Ok(position)) => {
                let other = source.positions.insert(number, position.clone());
                if other.is_some_and(|other| other != position) {
                    let what = format!(
                        "P[{number}] stands twice in /POS with different values, and which one \
                         counts is not known: delete one"
                    );
                    source.faults.push((line, what));
                }
            }
            (_, Err(why)) => source.faults.push((line, format!("P[{number}]: {why}"))),
            (Err(_), _) => {
                source.faults.push((line_at(start), "a position has no number".to_owned()));
            }
        }
        at = start + 2 + open + close + 1;
    }
}

fn position(body: &str) -> Result<Position, String> {
    let mut found = Position::default();
    let mut group = Group::default();
    let mut number = 0;
    // CONFIG holds commas in quotes.
    let mut outside = String::with_capacity(body.len());
    let mut in_quotes = false;
    for c in body.chars() {
        match c {
            '\'' => in_quotes = !in_quotes,
            ',' if in_quotes => outside.push(' '),
            c => outside.push(c),
        }
    }
    let fields = outside.replace("GP", ",GP");
    for field in fields.split([',', '\n']).map(str::trim).filter(|field| !field.is_empty()) {
        if let Some(rest) = field.strip_prefix("GP") {
            if number > 0 {
                found.groups.push((number, std::mem::take(&mut group)));
            }
            let (digits, rest) = rest.split_once(':').unwrap_or((rest, ""));
            number = digits.trim().parse().map_err(|_| format!("'{field}' is not understood"))?;
            if !rest.trim().is_empty() {
                component(rest.trim(), &mut group)?;
            }
            continue;
        }
        component(field, &mut group)?;
    }
    if number > 0 {
        found.groups.push((number, group));
    }
    Ok(found)
}

/// `UF : 0`, `X = 1.5 mm`, `J1= 0.000 deg`.
fn component(field: &str, group: &mut Group) -> Result<(), String> {
    let (name, value) = match field.split_once(['=', ':']) {
        Some((name, value)) => (name.trim(), value.trim()),
        None => return Err(format!("'{field}' is not understood")),
    };
    let frame = |value: &str| value.parse::<u32>().ok();
    match name {
        "UF" => group.frame = frame(value),
        "UT" => group.tool = frame(value),
        "CONFIG" => {
            let words: Vec<&str> = value.split_whitespace().collect();
            group.config = Some(words.join(" "));
        }
        _ => {
            let number = value.split_whitespace().next().unwrap_or("");
            // What was never taught is written with stars: an error where a move goes there.
            if number.starts_with('*') {
                return Ok(());
            }
            let number = number.parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| format!("{name} is '{value}', expected a number"))?;
            let of_pose = match name.to_ascii_uppercase().as_str() {
                "X" | "Y" | "Z" => "mm",
                "W" | "P" | "R" => "deg",
                _ => "",
            };
            let unit = value.split_whitespace().nth(1).unwrap_or(of_pose).to_ascii_lowercase();
            let is_unit = matches!(unit.as_str(), "" | "mm" | "deg");
            if !is_unit || !of_pose.is_empty() && unit != of_pose {
                let expected = if of_pose.is_empty() { "mm or deg" } else { of_pose };
                return Err(format!("{name} is '{value}', expected a number in {expected}"));
            }
            group.parts.insert(name.to_ascii_lowercase(), number);
        }
    }
    Ok(())
}

/// Whether a statement moves: `J P[1] …`, `L PR[2] …`.
pub(super) fn is_motion(text: &str) -> bool {
    let rest = text.strip_prefix(['J', 'L', 'C', 'A', 'S']).unwrap_or("").trim_start();
    rest.starts_with("P[") || rest.starts_with("PR[")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "/PROG A\n/ATTR\n/MN\n   1:  UFRAME_NUM=1 ;\n:C P[2]\n    :  P[3] \
                        100mm/sec FINE ;\n! a ; b ;\nL P[1:x] 1cm/min CNT50;\n/POS\n\
                        P[1:\"x\"] {\n   GP1:\n UF : 1, UT : 2, CONFIG : 'N U T, 0, 0, 0',\n \
                        X = 1.5 mm, Y = -2 mm, Z = 3 mm,\n W = 0 deg, P = 1 deg, R = 2 deg\n   \
                        GP2:\n UF : F, UT : F,\n J1= 4 deg\n};\n/END\n";

    #[test]
    fn statements_and_positions_of_both_layouts() {
        let source = parse(TEXT, 0, 0);
        assert!(source.faults.is_empty() && source.has_end, "{:?}", source.faults);
        let lines: Vec<usize> = source.statements.iter().map(|s| s.line).collect();
        assert_eq!(lines, [4, 5, 7, 8]);
        let text = &source.statements[1].text;
        assert!(text.contains("P[2]") && text.contains("100mm/sec"), "{text}");
        let at = text.find("100").unwrap();
        let span = source.statements[1].span(at, at + 3).unwrap();
        assert_eq!(&TEXT[span.start..span.end], "100");
        let position = &source.positions[&1];
        assert_eq!((position.groups[0].1.frame, position.groups[0].1.tool), (Some(1), Some(2)));
        assert_eq!(position.groups[0].1.parts["y"], -2.0);
        assert_eq!(position.groups[1].1.parts["j1"], 4.0);
    }
}
