//! Mechanical units that are switched off: their axes stay where they are, whatever targets say.

use super::carried::UnitOff;
use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name};
use crate::notes::Code;

/// Two positions of an external axis nearer than this are one, mm or degrees.
const SAME_POSITION: f64 = 1e-2;

fn unit(args: &Args) -> Option<&Name> {
    match args.positional.first() {
        Some(Expr::Ref(path)) => Some(&path.name),
        _ => None,
    }
}

impl Interpreter<'_> {
    /// The axes of a unit, where the job says them.
    fn axes_of(&self, key: &str) -> Option<Vec<String>> {
        let unit = self.settings.mechanical_units.get(key)?;
        Some(unit.axes.iter().map(|axis| axis.name.clone()).collect())
    }

    /// `DeactUnit STN1;`; `is_sure`: in no branch that only the run decides.
    pub(super) fn switch_off(&mut self, args: &Args, is_sure: bool) {
        let Some(Name { key, shown }) = unit(args).cloned() else { return };
        let axes = self.axes_of(&key);
        self.off.retain(|off| off.key != key);
        self.off.push(UnitOff { key, shown, axes, is_sure });
    }

    /// `ActUnit STN1;`
    pub(super) fn switch_on(&mut self, args: &Args) {
        let Some(name) = unit(args) else { return };
        self.off.retain(|off| off.key != name.key);
        // Units may share an axis.
        let own = self.axes_of(&name.key).unwrap_or_default();
        for axes in self.off.iter_mut().filter_map(|off| off.axes.as_mut()) {
            axes.retain(|axis| !own.contains(axis));
        }
    }

    /// Whether an axis stays where it is, as its unit is switched off, though a target has another
    /// place for it. Where it is not known whether it is an axis of the unit, it goes on.
    pub(super) fn stays(&mut self, name: &str, value: f64) -> bool {
        let at = self.external.stands_at(name);
        if at.is_some_and(|at| (at - value).abs() <= SAME_POSITION) {
            return false;
        }
        let units = self.settings.mechanical_units.values();
        let is_of_other = units.flat_map(|unit| &unit.axes).any(|axis| axis.name == name);
        let is_its = |off: &&UnitOff| match &off.axes {
            Some(axes) => axes.iter().any(|own| own == name),
            None => !is_of_other,
        };
        let Some(off) = self.off.iter().find(is_its) else { return false };
        let sure = at.filter(|_| off.is_sure && off.axes.is_some());
        let unit = &off.shown;
        let what = match sure {
            Some(at) => format!(
                "DeactUnit has switched off '{unit}': external axis {name} stays at {at}, \
                 whatever targets say"
            ),
            None => format!(
                "DeactUnit may have switched off external axis {name} ('{unit}'), which then \
                 stays where it is: it is read as if it went to where targets have it"
            ),
        };
        let stays = sure.is_some();
        self.log.warning(Code::AxisIgnored, self.line, what);
        stays
    }
}
