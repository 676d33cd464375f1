//! Lengths of tools, as far as a program says.

use std::collections::{BTreeMap, HashMap};

/// Why the tool's length does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Uncompensated {
    /// Sinumerik's.
    D0,
    /// Behind G43 or G44.
    G49,
}

/// What a tool moves with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Used {
    /// Of the length; `None` where nothing gives it.
    pub(super) number: Option<u32>,
    /// By G44.
    pub(super) takes_off: bool,
}

/// What sets tool data: G10 by its L, or a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Setter {
    G10(i64),
    Parameter(i64),
}

/// Data of one tool, in the order in which they were set, with their values by letter.
#[derive(Debug, Default)]
pub(super) struct ToolData {
    pub(super) now: Vec<(Setter, Vec<(u8, f64)>)>,
    pub(super) at_cut: Vec<(Setter, Vec<(u8, f64)>)>,
    /// Of the last that was set, if no cut has come behind it.
    pub(super) line: Option<usize>,
}

/// Lengths of tools, as far as the program says.
#[derive(Debug, Default)]
pub(super) struct Lengths {
    /// The length counts by G43 or the like.
    pub(super) is_compensated: bool,
    pub(super) uncompensated: Option<Uncompensated>,
    pub(super) takes_off: bool,
    /// Line of G43 or G44 since the change of tool.
    pub(super) compensates_at: Option<usize>,
    /// H or D since the change of tool, and its line.
    pub(super) chosen: Option<(u32, usize)>,
    /// The same of a tool that is selected: D counts from M6 on.
    pub(super) selected: Option<(f64, usize)>,
    /// Of its last cut, by the tool's number.
    pub(super) used: HashMap<Option<u32>, Used>,
    /// The tool, and the length under which Z was last stated or cut at.
    pub(super) of_z: Option<(Option<u32>, Used)>,
    /// Numbers of the lengths of cuts under G43 and the like.
    pub(super) cut_with: Vec<Option<u32>>,
    /// By the number of the length; `None` is of any tool.
    pub(super) data: BTreeMap<Option<u32>, ToolData>,
}

impl Used {
    /// Whether another length counts, or the other way; one that nothing gives is no other.
    pub(super) fn is_other_than(self, other: Self) -> bool {
        let numbers = self.number.zip(other.number);
        numbers.is_some_and(|(own, other)| own != other) || self.takes_off != other.takes_off
    }
}

impl Lengths {
    /// Whether a cut was made, or may have been, with the length of a number; any where none is
    /// given.
    pub(super) fn have_cut(&self, number: Option<u32>) -> bool {
        self.cut_with.iter().any(|own| own.is_none() || number.is_none() || *own == number)
    }

    /// Radii that G10 sets for a tool, mm.
    pub(super) fn radii_mm(&self, tool: Option<u32>) -> Vec<f64> {
        let of_tool = [tool, None].into_iter().filter_map(|own| self.data.get(&own));
        let set = of_tool.flat_map(|data| data.now.iter().chain(&data.at_cut));
        let values = set.filter(|(by, _)| matches!(by, Setter::G10(_))).flat_map(|(_, all)| all);
        values.filter(|(letter, _)| *letter == b'R').map(|(_, value)| *value).collect()
    }

    /// Data of a tool that the program sets.
    pub(super) fn set(
        &mut self,
        line: usize,
        tool: Option<u32>,
        by: Setter,
        values: Vec<(u8, f64)>,
    ) {
        let data = self.data.entry(tool).or_default();
        data.now.retain(|(own, _)| *own != by);
        data.now.push((by, values));
        data.line = Some(line);
    }
}
