//! Data of inline forms, which BAS reads: PDAT_ACT, LDAT_ACT, FDAT_ACT.

use super::run::Run;
use super::turns::Turns;
use super::value::{Value, part};
use super::words::ON_KINEMATIC;

/// Of what a form states.
pub(super) const TOOL: usize = 0;
pub(super) const BASE: usize = 1;

impl Run<'_> {
    /// VEL of the data of an inline form.
    pub(super) fn velocity_of_form(&mut self, data: &str) -> Result<Value, String> {
        let name = data.to_uppercase();
        match self.datum(data) {
            Value::Parts(mut form) => form.remove("vel").ok_or(format!("{name} has no VEL")),
            Value::Unknown(why) => Err(format!("{name}.VEL is not known: {why}")),
            _ => Err(format!("{name} is no structure")),
        }
    }

    /// How the tool turns by LDAT_ACT (bas.src, CP_DAT).
    pub(super) fn turns_of_form(&mut self) {
        self.turns = self.usual_turns();
        match self.datum("ldat_act") {
            Value::Parts(form) => {
                form.get("ori_typ").into_iter().for_each(|own| self.turns.set_type(own));
                form.get("circ_typ").into_iter().for_each(|own| self.turns.set_arc(own));
            }
            unknown => {
                self.turns.set_type(&unknown);
                self.turns.set_arc(&unknown);
            }
        }
    }

    /// #VAR and DEF_CIRC_TYP, which is #BASE where no file declares it.
    pub(super) fn usual_turns(&mut self) -> Turns {
        let mut turns = Turns::default();
        match self.datum("def_circ_typ") {
            Value::Unknown(_) => {}
            own => turns.set_arc(&own),
        }
        turns
    }

    /// The program states its tool or its base beside the inline form, which need not be known
    /// then.
    pub(super) fn states(&mut self, which: usize) {
        if let Some((_, stated)) = &mut self.unknown_form {
            stated[which] = true;
            if *stated == [true; 2] {
                self.unknown_form = None;
            }
        }
    }

    /// Tool and base of FDAT_ACT, which the inline form has set.
    pub(super) fn frames_of_form(&mut self, line: usize) -> Result<(), String> {
        let form = match self.datum("fdat_act") {
            Value::Parts(form) => form,
            // Homes have one, too, whose data are the controller's: only a move to a pose needs it.
            Value::Unknown(why) if self.globals.contains_key("fdat_act") => {
                let what = format!("tool and base are not known: FDAT_ACT: {why}");
                self.unknown_form = Some((what, [false; 2]));
                return Ok(());
            }
            _ => return Ok(()),
        };
        self.unknown_form = None;
        if let Some(Value::Enum(mode)) = form.get("ipo_frame")
            && mode == "tcp"
        {
            return Err("a stationary tool (#TCP) is not supported".to_owned());
        }
        if let Some(number) = part(&form, "tool_no")? {
            self.choose_tool(line, number)?;
        }
        if let Some(number) = part(&form, "base_no")? {
            self.chooses_base_number(number);
            let moved = self.is_on_kinematic(number);
            self.no_base = moved.or_else(|| self.no_base.take());
        }
        Ok(())
    }

    /// Why BASE_DATA[n] is not the base: MACHINE_FRAME_DAT[n] lays it on an external kinematic, the
    /// robot aside (bas.src, FRAMES; BAS(#BASE,n) does not ask for that).
    fn is_on_kinematic(&mut self, number: f64) -> Option<String> {
        let list = format!("machine_frame_dat[{number}]");
        let of = |value: Value, name: &str| value.parts().ok()?.get(name).cloned();
        let index = of(self.datum(&list), "mach_def_index")?.num().ok()?;
        let kind = of(self.datum(&format!("machine_def[{index}]")), "mech_type");
        let is_robot = |kind: &str| matches!(kind, "robot" | "none");
        if index == 0.0 || matches!(kind, Some(Value::Enum(kind)) if is_robot(&kind)) {
            return None;
        }
        let list = list.to_uppercase();
        Some(format!("MACH_DEF_INDEX {index} of {list} {ON_KINEMATIC}"))
    }
}
