//! The length of the tool: G43, G44 and G49 with H, D of Sinumerik's, and tool data that a program
//! sets.

use super::block::Block;
use super::lengths::{Setter, Uncompensated, Used};
use super::state::Machine;
use crate::notes::Code;
use crate::program::tool_number;

impl Machine<'_> {
    /// H or D of a block, and whether the length is added or taken off.
    pub(super) fn take_length(&mut self, line: usize, block: &Block) -> Result<(), String> {
        if self.is_sinumerik {
            let edge = block.get('D');
            let by_name = || block.names.iter().any(|(own, _)| own == "T=");
            let selects = block.word(b'T').is_some() || by_name();
            if selects && self.waits_for_change && !block.codes('M').any(|code| code == 60) {
                self.lengths.selected = edge.map(|edge| (edge, line));
                return Ok(());
            }
            return edge.map_or(Ok(()), |edge| self.take_edge(line, edge));
        }
        if let Some(length) = self.length_in(block) {
            let number = tool_number(length)?;
            if number != 0 {
                self.cutter.measure_length(number, false)?;
                self.lengths.chosen = Some((number, line));
            }
        }
        let of_g43 = |code: &i64| matches!(code, 430 | 431 | 434 | 440);
        if let Some(code) = block.codes('G').find(of_g43) {
            self.lengths.takes_off = code == 440;
            self.lengths.compensates_at = Some(line);
        }
        Ok(())
    }

    /// D of Sinumerik's: an edge of the tool, each with its own length.
    fn take_edge(&mut self, line: usize, edge: f64) -> Result<(), String> {
        let number = tool_number(edge)?;
        self.lengths.uncompensated = (number == 0).then_some(Uncompensated::D0);
        if number != 0 {
            self.cutter.measure_length(number, true)?;
            self.lengths.chosen = Some((number, line));
        }
        Ok(())
    }

    /// A tool comes into the spindle; of one that is there already the length stays.
    pub(super) fn load(&mut self, tool: f64) -> Result<(), String> {
        let before = self.cutter.numbered();
        self.cutter.tool(tool)?;
        if self.cutter.numbered() != before {
            (self.lengths.chosen, self.lengths.compensates_at) = (None, None);
        }
        Ok(())
    }

    /// M6: behind D0 the control chooses the first length of the new tool, unless a D stood beside
    /// its T.
    pub(super) fn take_selected_edge(&mut self) -> Result<(), String> {
        let why = &mut self.lengths.uncompensated;
        *why = why.filter(|why| *why != Uncompensated::D0);
        let selected = self.lengths.selected.take();
        selected.map_or(Ok(()), |(edge, line)| self.take_edge(line, edge))
    }

    /// The number of a tool's length: H beside G43 or G44, or while they hold where it is none of a
    /// call, a radius or a work offset of Okuma's.
    pub(super) fn length_in(&self, block: &Block) -> Option<f64> {
        let is_other = || {
            block.codes('G').any(|code| matches!(code, 150 | 160 | 410 | 420 | 650))
                || block.codes('M').any(|code| code == 980)
        };
        let holds = || self.lengths.is_compensated && !is_other();
        block.get('H').filter(|_| block.compensates() || holds())
    }

    /// G43, G44 and the like.
    pub(super) fn compensate(&mut self) {
        self.lengths.is_compensated = true;
        self.lengths.uncompensated = None;
    }

    /// G49: at the head of a program it ends nothing.
    pub(super) fn end_compensation(&mut self) {
        if std::mem::take(&mut self.lengths.is_compensated) {
            self.lengths.uncompensated = Some(Uncompensated::G49);
        }
    }

    /// A move: which length is no part of it, or another than before. Under G49 tools are taken
    /// away at rapid.
    pub(super) fn tell_length(&mut self, line: usize, is_cut: bool, states_z: bool) {
        self.tell_other_length(line, is_cut, states_z);
        let moves = match self.lengths.uncompensated {
            Some(Uncompensated::D0) => "moves under D0",
            Some(Uncompensated::G49) if is_cut => "moves at feed under G49 or H0",
            _ => return,
        };
        let what = format!("{moves}, without the tool's length: the job's tcp is used");
        self.cutter.log.warning(Code::ChangeIgnored, line, what);
    }

    /// A move with a length, against that of the last cut of the same tool, and a cut against the
    /// one under which Z was stated. Where nothing chooses one, a move is taken to be with the
    /// first edge, or the length that has the tool's number.
    fn tell_other_length(&mut self, line: usize, is_cut: bool, states_z: bool) {
        let counts = match self.is_sinumerik {
            true => self.lengths.uncompensated != Some(Uncompensated::D0),
            false => self.lengths.is_compensated,
        };
        if !counts {
            return;
        }
        let tool = self.cutter.loaded();
        let own = if self.is_sinumerik { Some(1) } else { tool };
        let lengths = &mut self.lengths;
        let number = lengths.chosen.map(|(number, _)| number).or(own);
        let used = Used { number, takes_off: lengths.takes_off };
        let last = lengths.used.get(&tool).copied();
        let of_z = lengths.of_z.filter(|(of, _)| is_cut && *of == tool).map(|(_, used)| used);
        if is_cut {
            lengths.used.insert(tool, used);
        }
        if is_cut || states_z {
            lengths.of_z = Some((tool, used));
        }
        if !is_cut && lengths.chosen.is_none() {
            return;
        }
        let other = |before: &Used| before.is_other_than(used);
        let (before, of_z) = (last.filter(other), of_z.filter(other));
        let remedy = match (before, of_z) {
            (None, Some(_)) => ", and Z was stated under that one; state Z again before the cut",
            _ => "",
        };
        let before = before.or(of_z).unwrap_or(used);
        if let (Some(now), Some(before)) = (number, before.number)
            && now != before
        {
            let what = format!(
                "length {now} behind length {before} of one tool: the tcp stays the same{remedy}"
            );
            let line = lengths.chosen.map_or(line, |(_, line)| line);
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        if used.takes_off != before.takes_off {
            let what = format!(
                "G43 and G44 of one tool, whose length the one adds to Z and the other takes off: \
                 the tcp stays the same{remedy}"
            );
            let line = lengths.compensates_at.unwrap_or(line);
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        if is_cut && !self.is_sinumerik {
            self.tell_tool_data(number);
        }
    }

    /// A cut with the length of a number, whose data the program may have set since the cut before.
    fn tell_tool_data(&mut self, number: Option<u32>) {
        let mut data = std::mem::take(&mut self.lengths.data);
        for (of, data) in &mut data {
            let is_own = of.is_none() || number.is_none() || *of == number;
            let Some(line) = data.line.take_if(|_| is_own) else { continue };
            if self.lengths.have_cut(*of) && data.now != data.at_cut {
                let (what, remedy) = match data.now.last() {
                    Some((Setter::Parameter(parameter), _)) => (
                        format!("#{parameter} is the length of a tool on Fanuc and Haas"),
                        "; for a number of the program's own take #100 to #199",
                    ),
                    _ => ("G10 sets the length of a tool".to_owned(), ""),
                };
                let what = format!(
                    "{what}, and the tool has cut before and cuts again: the job's tcp is used \
                     throughout{remedy}"
                );
                self.cutter.log.warning(Code::ChangeIgnored, line, what);
            }
            data.at_cut.clone_from(&data.now);
        }
        self.lengths.data = data;
        if !self.lengths.cut_with.contains(&number) {
            self.lengths.cut_with.push(number);
        }
    }

    /// G10 L1 and L10 to L13. What counts from the value before is not known. L12 and L13 set a
    /// radius, which a path that is read as programmed does not have.
    pub(super) fn set_tool_data(&mut self, line: usize, kind: i64, block: &Block) {
        let words = block.words.iter().filter(|word| !b"GNLP".contains(&word.letter));
        let value = |value: f64| if self.relative { f64::NAN } else { self.mm(value) };
        let values = words.map(|word| (word.letter, value(word.value))).collect();
        let tool = block.get('P').and_then(|number| tool_number(number).ok());
        if !matches!(kind, 12 | 13) {
            self.lengths.set(line, tool, Setter::G10(kind), values);
        }
        let what = "G10 sets tool data: the job's tcp is used";
        self.cutter.left_out(line, what.to_owned());
    }

    /// Fanuc and Haas keep lengths of tools in parameters, which are the program's own elsewhere.
    pub(super) fn set_parameter_of_tool(&mut self, line: usize, parameter: i64, value: f64) {
        let tool = match parameter {
            2001..=2400 => (parameter - 1) % 200 + 1,
            10_001..=11_999 => parameter % 1000,
            _ => return,
        };
        let values = vec![(b'#', self.mm(value))];
        // At most 999.
        self.lengths.set(line, Some(tool as u32), Setter::Parameter(parameter), values);
    }
}
