//! What the arm carries: the tool's own load, `GripLoad`, `\TLoad`.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3};

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr};
use super::value::{Value, load_of_new_tool, orientation};
use crate::motion::Load;
use crate::notes::Code;
use crate::units::m_from_mm;

/// Up to this mass, kg, a load says nothing: ABB's own templates and `load0` have it.
pub(super) const PLACEHOLDER_KG: f64 = 0.001;

impl<'a> Interpreter<'a> {
    /// What the tip carries on a move; `gripped_in` is the frame of what `GripLoad` says, in the
    /// tip frame: that of the tool, or of the work object where the arm holds that. What is not
    /// known leaves the job's, with a doubt.
    pub(super) fn note_load(
        &mut self,
        line: usize,
        tool: &'a Expr,
        gripped_in: Option<&Isometry3<f64>>,
        args: &'a Args,
    ) {
        let carried = self.carried(line, tool, gripped_in, args).unwrap_or_else(|why| {
            let what = format!("what the arm carries is not known: {why}");
            self.log.warning(Code::ChangeIgnored, line, what);
            None
        });
        self.log.load(carried.map(Arc::new).as_ref());
    }

    /// The load of `\TLoad`, which counts for all, else the tool's own with what the gripper holds.
    /// `tool0` and a load without mass say nothing.
    fn carried(
        &mut self,
        line: usize,
        tool: &'a Expr,
        gripped_in: Option<&Isometry3<f64>>,
        args: &'a Args,
    ) -> Result<Option<Load>, String> {
        let total = args.optional_value("tload");
        if let Some(expr) = total {
            let value = self.eval(expr);
            let total = self.load(line, expr, &value).map_err(|why| format!("\\TLoad: {why}"))?;
            if total.is_some() {
                return Ok(total);
            }
        }
        let own = match self.eval(tool) {
            Value::List(parts) => {
                let own = parts.get(2).ok_or("tool: expected a load, found fewer values")?;
                let load = self.load(line, tool, own).map_err(|why| format!("tool: {why}"))?;
                let is_placeholder = *own == load_of_new_tool();
                load.map(|load| Load { is_placeholder, ..load })
            }
            _ => None,
        };
        match (own, self.gripped.clone()?) {
            (own, None) => Ok(own),
            (Some(own), Some(held)) if !own.is_placeholder => {
                let frame =
                    gripped_in.ok_or("GripLoad without a work object that the arm holds")?;
                Ok(Some(own.with(&held.placed(frame))))
            }
            (_, Some(held)) => Err(format!(
                "GripLoad {} adds {} kg to a tool whose load the program does not state",
                held.name, held.mass_kg
            )),
        }
    }

    /// `GripLoad load;`: from here on the gripper holds it.
    pub(super) fn grip(&mut self, line: usize, args: &'a Args) {
        let Some(expr) = args.positional.first() else {
            self.log.error(Code::Motion, line, "GripLoad: the load is missing");
            return;
        };
        let value = self.eval(expr);
        let held = self.load(line, expr, &value);
        self.gripped = held.map_err(|why| format!("GripLoad: {why}"));
    }

    /// `LoadId TOOL_LOAD_ID, MASS_WITH_AX3, tool1 \PayLoad:=load1;`: the arm moves until the load
    /// is known, which is written into the tool or the payload.
    pub(super) fn identify_load(&mut self, line: usize, args: &'a Args) {
        let found = || Value::unknown("LoadId finds the load: known only at run time");
        let what = "LoadId moves the arm and writes the load that it finds: neither is read";
        self.log.warning(Code::MotionLeftOut, line, what);
        if let Some(Expr::Ref(path)) = args.positional.get(2) {
            match self.read(path) {
                Value::List(mut parts) if parts.len() == 3 => {
                    parts[2] = found();
                    if self.write(path, Value::List(parts)).is_err() {
                        self.forget(&path.name, &found());
                    }
                }
                _ => self.forget(&path.name, &found()),
            }
        }
        for name in ["payload", "accuracy"] {
            if let Some(Expr::Ref(path)) = args.optional_value(name) {
                self.forget(&path.name, &found());
            }
        }
    }

    /// A loaddata: mass, centre of mass, axes of moment about it, moments about these; `None` where
    /// it has no mass.
    fn load(&self, line: usize, expr: &Expr, value: &Value) -> Result<Option<Load>, String> {
        let mass_kg = value.part(0, "a load")?.num()?;
        if mass_kg <= PLACEHOLDER_KG {
            return Ok(None);
        }
        let com_mm: [f64; 3] = value.part(1, "a centre of mass")?.numbers("a centre of mass")?;
        let axes = orientation(value.part(2, "axes of moment")?)?.to_rotation_matrix();
        let mut moments = [0.0; 3];
        for (index, moment) in moments.iter_mut().enumerate() {
            *moment = value.part(3 + index, "a moment of inertia")?.num()?;
        }
        let inertia_kgm2 = axes * Matrix3::from_diagonal(&moments.into()) * axes.transpose();
        let (name, line) = match expr {
            Expr::Ref(path) => {
                let declared = self.file.data.get(&path.name.key);
                (path.name.shown.clone(), declared.map_or(line, |data| data.line.max(1)))
            }
            _ => ("of the instruction".to_owned(), line),
        };
        let com_m = com_mm.map(m_from_mm).into();
        Ok(Some(Load { name, line, mass_kg, com_m, inertia_kgm2, is_placeholder: false }))
    }
}
