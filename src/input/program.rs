//! path.program of a job → the moves that a robot or CAM program asks for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Isometry3, Unit, Vector3};

use super::files::{MAX_FILE_BYTES, named_file, relative_to};
use super::frame::frame;
use super::program_files::members;
use super::raw::job as raw;
use super::waypoints::{FromPrograms, OperationContext, PathMoves, ProgramSays};
use crate::formats::text::read_bytes;
use crate::formats::yaml::{Node, Step};
use crate::model::{JointKind, Placement, Robot, forward_kinematics};
use crate::motion::{MechanicalUnit, UnitAxis};
use crate::notes::{Code, Note, Notes};
use crate::paths::{folder_of, tidied};
use crate::program::{
    self, Assumed, Companion, Coordinates, Dialect, DwellUnit, J3From, LengthUnit, Program,
    RAPID_M_PER_S, RotaryAxis, SetBy, Setter, Settings, TipAt,
};

/// Languages of programs that are known by their extensions and not read.
const NOT_YET: [(&str, &str); 20] = [
    ("i", "Heidenhain ISO"),
    ("jbi", "Yaskawa INFORM"),
    ("jbr", "Yaskawa INFORM"),
    ("as", "Kawasaki AS"),
    ("pg", "Kawasaki AS"),
    ("pgx", "Staubli VAL3"),
    ("val3", "Staubli VAL3"),
    ("script", "URScript"),
    ("urp", "Universal Robots PolyScope"),
    ("tp", "Fanuc TP in binary form (save it as .ls)"),
    ("kl", "Fanuc KAREL"),
    ("min", "Okuma OSP"),
    ("mazatrol", "Mazatrol"),
    ("pbg", "Mazatrol"),
    ("prg_", "Comau PDL2"),
    ("pdl", "Comau PDL2"),
    ("mb4", "Mitsubishi MELFA-BASIC"),
    ("mb5", "Mitsubishi MELFA-BASIC"),
    ("drl", "Doosan DRL"),
    ("lua", "Lua"),
];

/// The moves that a robot or CAM program asks for.
pub(super) fn program_moves(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    notes: &mut Notes,
    programs: &mut FromPrograms,
) -> Option<PathMoves> {
    let name = raw.file.as_deref()?;
    let line = path.line_at(&[Step::Key("program")]);
    let named = relative_to(context.job, name);
    // As the job names it.
    let mut called = PathBuf::from(name);
    let (file, modules) = match members(&named, raw.procedure.as_deref().unwrap_or("main")) {
        Some(Ok((file, modules))) => {
            let [folder, own] = match named.is_dir() {
                true => [named.as_path(), &called],
                false => [folder_of(&named), called.parent().unwrap_or(Path::new(""))],
            };
            called = file.strip_prefix(folder).map_or_else(|_| file.clone(), |file| own.join(file));
            programs.reading.files.push(named);
            (tidied(&file), modules)
        }
        Some(Err(what)) => {
            let what = format!("{}: path.program.file '{name}': {what}", context.called);
            notes.error(Code::Unreadable, line, what);
            return None;
        }
        None if programs.reading.pending_at(&named).is_some() => (named, Vec::new()),
        None => {
            let file = named_file(context.job, "path.program.file", name, line, notes)?;
            (file, Vec::new())
        }
    };
    let pending = programs.reading.pending_at(&file).map(<[u8]>::to_vec);
    let dialect = match dialect_of(&file) {
        Ok(dialect) => dialect,
        Err(what) => {
            let what = format!("{}: path.program.file '{name}': {what}", context.called);
            notes.error(Code::Unreadable, line, what);
            return None;
        }
    };
    keys_without_effect(context, raw, path, dialect, notes);
    programs.reading.files.push(file.clone());
    let bytes = match pending.map_or_else(|| read_bytes(&file, MAX_FILE_BYTES), Ok) {
        Ok(bytes) => bytes,
        Err(fault) => {
            programs.errors.push(fault);
            return None;
        }
    };
    let companions = companions(context, raw, path, modules, notes, programs)?;
    let settings = Settings { companions, ..settings(context, raw, path, notes)? };
    let texts = settings.companions.iter().map(|own| own.text.as_bytes()).chain([&bytes[..]]);
    programs.assumed.extend(named_in(context.assume.keys(), texts));
    programs.reading.programs.push((file.clone(), settings.clone()));
    let located = |mut note: Note| {
        note.place.file = Some(file.clone());
        note
    };
    match program::read(&bytes, dialect, &settings) {
        Ok(program) => {
            let speed_step_rpm = program.speed_step_rpm();
            let Program { moves, spindle, feeds, warnings, .. } = program;
            programs.reading.warnings.extend(warnings.into_iter().map(located));
            Some(PathMoves {
                moves,
                program: Some(ProgramSays {
                    called,
                    file,
                    dialect,
                    spindle,
                    speed_step_rpm,
                    feeds,
                }),
            })
        }
        Err(found) => {
            programs.errors.extend(found.into_iter().map(located));
            None
        }
    }
}

/// Those of the names, in lower case, that stand in a text. `pr[14,3]` does where PR[14] stands,
/// and where another register or an argument gives the number; `$mode_op==#ex` does where
/// $MODE_OP stands.
fn named_in<'n, 't>(
    names: impl Iterator<Item = &'n String>,
    texts: impl Iterator<Item = &'t [u8]> + Clone,
) -> Vec<String> {
    let stands = |name: &&String| {
        let name = Assumed::enumeration(name).map_or(name.as_str(), |(datum, _)| datum);
        let end = name.find([',', ']', '.', '{']).unwrap_or(name.len());
        let head = name.get(..end).unwrap_or(name);
        let list = head.split('[').next().unwrap_or(head);
        let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let has = |text: &[u8], part: &str, is_whole: bool| {
            let part = part.as_bytes();
            text.windows(part.len().max(1)).enumerate().any(|(at, own)| {
                let behind = text.get(at + part.len());
                own.eq_ignore_ascii_case(part) && !(is_whole && behind.is_some_and(is_part))
            })
        };
        texts.clone().any(|text| {
            let by_another = |by: &str| has(text, &format!("{list}[{by}["), false);
            has(text, head, true) || head != list && (by_another("r") || by_another("ar"))
        })
    };
    names.filter(stands).cloned().collect()
}

/// The language of a file by its extension, or why it is not read.
fn dialect_of(file: &Path) -> Result<Dialect, String> {
    if let Some(dialect) = Dialect::of_file(file) {
        return Ok(dialect);
    }
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let known = NOT_YET.into_iter().find(|(own, _)| *own == extension);
    Err(match (known, extension.as_str()) {
        (Some((_, language)), _) => format!("{language} is not supported yet"),
        (None, "dat") => "is a data list of KRL: name the .src, and this under files".to_owned(),
        (None, _) => format!(
            "what language '.{extension}' stands for is not known; rename it to .mod (RAPID), .apt \
             (APT), .nc (G-code), .mpf (Sinumerik), .h (Heidenhain), .src (KRL) or .ls (Fanuc TP)"
        ),
    })
}

fn keys_without_effect(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    dialect: Dialect,
    notes: &mut Notes,
) {
    use Dialect::{Apt, Fanuc, GCode, Heidenhain, Krl, Rapid, Sinumerik};
    let keys: [(&str, bool, &[Dialect]); 13] = [
        ("procedure", raw.procedure.is_some(), &[Rapid, Krl]),
        ("spindle_from", raw.spindle_from.is_some(), &[Rapid, Krl, Fanuc]),
        ("tool_from", raw.tool_from.is_some(), &[Rapid, Krl, Fanuc]),
        ("files", raw.files.is_some(), &[Rapid, Krl, Fanuc, GCode, Sinumerik]),
        ("arguments", raw.arguments.is_some(), &[Rapid]),
        (
            "tool_frames",
            raw.tool_frames.is_some(),
            &[Krl, Fanuc, GCode, Sinumerik, Apt, Heidenhain],
        ),
        ("base_frames", raw.base_frames.is_some(), &[Krl, Fanuc]),
        ("rotary_axes", raw.rotary_axes.is_some(), &[GCode, Sinumerik]),
        ("mechanical_units", raw.mechanical_units.is_some(), &[Rapid]),
        ("coordinates", raw.coordinates.is_some(), &[Apt]),
        ("unit", raw.unit.is_some(), &[GCode, Sinumerik, Apt]),
        ("dwell_unit", raw.dwell_unit.is_some(), &[GCode, Sinumerik]),
        ("j3_from", raw.j3_from.is_some(), &[Fanuc]),
    ];
    for (key, given, of) in keys {
        if !given || of.contains(&dialect) {
            continue;
        }
        let line = path.line_at(&[Step::Key("program"), Step::Key(key)]);
        let why = match (key, &raw.procedure) {
            ("procedure", Some(name)) => {
                format!("procedure '{name}' has no effect: {dialect} has no procedures")
            }
            ("spindle_from" | "tool_from", _) => {
                format!("{key} has no effect: {dialect} has words of its own for it")
            }
            _ => format!("{key} has no effect on {dialect}"),
        };
        notes.warning(Code::Unused, line, format!("{}: path.program.{why}", context.called));
    }
}

/// The further files that the job names, and the modules of a list or folder.
fn companions(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    modules: Vec<PathBuf>,
    notes: &mut Notes,
    programs: &mut FromPrograms,
) -> Option<Vec<Companion>> {
    let mut files = Vec::new();
    for (index, name) in raw.files.iter().flatten().enumerate() {
        let steps = [Step::Key("program"), Step::Key("files"), Step::Index(index)];
        let line = path.line_at(&steps);
        let file = named_file(context.job, "path.program.files", name, line, notes)?;
        files.push((name.clone(), file));
    }
    files.extend(modules.into_iter().map(|file| {
        let name = file.file_name().unwrap_or_default().to_string_lossy().to_string();
        (name, file)
    }));
    let mut found = Vec::new();
    for (name, file) in files {
        programs.reading.files.push(file.clone());
        let read = read_bytes(&file, MAX_FILE_BYTES);
        match read.and_then(|bytes| Companion::new(name, &bytes)) {
            Ok(companion) => found.push(companion),
            Err(mut fault) => {
                fault.place.file = Some(file);
                programs.errors.push(fault);
                return None;
            }
        }
    }
    Some(found)
}

fn tip_at(robot: &Robot) -> TipAt {
    let (robot, placement) = (robot.clone(), Placement::new(robot));
    TipAt::new(move |q| {
        robot.check_pose(q).ok()?;
        let mut placement = placement.clone();
        placement.place_joints(&robot, q);
        Some(forward_kinematics(&robot, &placement))
    })
}

/// The joints that slide.
fn sliding(robot: &Robot) -> Vec<usize> {
    let joints = robot.joints().iter().enumerate();
    joints.filter(|(_, joint)| joint.kind == JointKind::Prismatic).map(|(i, _)| i).collect()
}

/// What the job says beside the program; `None` where there are faults.
fn settings(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    notes: &mut Notes,
) -> Option<Settings> {
    let before = notes.errors();
    let settings = Settings {
        procedure: raw.procedure.clone(),
        arguments: raw.arguments.clone().unwrap_or_default(),
        tcp: context.tcp,
        work_object: context.work_object,
        feed_m_per_s: context.feed_m_per_s,
        rapid_m_per_s: RAPID_M_PER_S,
        joint_count: context.robot?.joints().len(),
        sliding: sliding(context.robot?),
        tip_at: Some(tip_at(context.robot?)),
        spindle_from: raw.spindle_from.as_ref().and_then(|from| {
            let raw::SpindleFrom { signal, procedure, argument, comment, rpm_per_unit } = from;
            let what = [signal, procedure, comment];
            setter(context, path, "spindle_from", what, *argument, *rpm_per_unit, notes)
        }),
        spindle_rpm: context.spindle_rpm,
        tool_from: raw.tool_from.as_ref().and_then(|from| {
            let raw::ToolFrom { signal, procedure, argument, comment } = from;
            setter(context, path, "tool_from", [signal, procedure, comment], *argument, None, notes)
        }),
        rotary_axes: rotary_axes(context, raw, path, notes),
        coordinates: raw.coordinates.map(|coordinates| match coordinates {
            raw::Coordinates::Local => Coordinates::Local,
            raw::Coordinates::World => Coordinates::World,
        }),
        unit: raw.unit.map(|unit| match unit {
            raw::LengthUnit::Mm => LengthUnit::Mm,
            raw::LengthUnit::Inch => LengthUnit::Inch,
        }),
        dwell_unit: raw.dwell_unit.map(|unit| match unit {
            raw::DwellUnit::S => DwellUnit::Seconds,
            raw::DwellUnit::Ms => DwellUnit::Milliseconds,
        }),
        is_scheduled: context.is_scheduled,
        j3_from: raw.j3_from.map(|from| match from {
            raw::J3From::Horizontal => J3From::Horizontal,
            raw::J3From::UpperArm => J3From::UpperArm,
        }),
        tool_frames: frames(context, path, "tool_frames", raw.tool_frames.as_ref(), notes),
        tool_names: context.tool_names.clone(),
        tool_diameters_mm: context.tool_diameters_mm.clone(),
        base_frames: frames(context, path, "base_frames", raw.base_frames.as_ref(), notes),
        external_axes: context.external_axes.clone(),
        mechanical_units: mechanical_units(context, raw, path, notes),
        assume: context.assume.clone(),
        companions: Vec::new(),
    };
    (notes.errors() == before).then_some(settings)
}

/// Frames by the number that the program gives them.
fn frames(
    context: &OperationContext<'_>,
    path: &Node,
    key: &str,
    given: Option<&BTreeMap<String, raw::Frame>>,
    notes: &mut Notes,
) -> BTreeMap<u32, Isometry3<f64>> {
    let mut found = BTreeMap::new();
    for (number, raw) in given.into_iter().flatten() {
        let placed = frame(raw.xyz_m.unwrap_or_default(), raw.rpy_rad.unwrap_or_default());
        match number.parse() {
            Ok(number) => drop(found.insert(number, placed)),
            Err(_) => {
                let line = path.line_at(&[Step::Key("program"), Step::Key(key)]);
                let what = format!(
                    "{}: path.program.{key} has the key '{number}', must be a number of the \
                     program",
                    context.called
                );
                notes.error(Code::Value, line, what);
            }
        }
    }
    found
}

fn rotary_axes(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    notes: &mut Notes,
) -> Vec<RotaryAxis> {
    let mut found = Vec::new();
    for (index, axis) in raw.rotary_axes.iter().flatten().enumerate() {
        let (Some(letter), Some(direction)) = (&axis.letter, axis.axis) else { continue };
        let unit = Unit::try_new(Vector3::from(direction), 1e-9);
        match (letter.as_bytes(), unit) {
            ([letter @ (b'A' | b'B' | b'C')], Some(unit)) => found.push(RotaryAxis {
                letter: *letter,
                axis: unit,
                turns_work: axis.turns == Some(raw::Turns::Work),
                origin_mm: axis.origin_mm.unwrap_or_default().into(),
            }),
            _ => {
                let steps = [Step::Key("program"), Step::Key("rotary_axes"), Step::Index(index)];
                let what = format!(
                    "{}: path.program.rotary_axes[{index}]: must be A, B or C about an axis that \
                     is not zero",
                    context.called
                );
                notes.error(Code::Value, path.line_at(&steps), what);
            }
        }
    }
    found
}

/// Units that carry the work, by their names in lower case.
fn mechanical_units(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    notes: &mut Notes,
) -> BTreeMap<String, Arc<MechanicalUnit>> {
    let mut found = BTreeMap::new();
    for (name, unit) in raw.mechanical_units.iter().flatten() {
        let mut axes = Vec::new();
        for (index, axis) in unit.axes.iter().flatten().enumerate() {
            let (Some(own), Some(direction)) = (&axis.name, axis.axis) else { continue };
            let Some(unit_axis) = Unit::try_new(Vector3::from(direction), 1e-9) else {
                let steps = [
                    Step::Key("program"),
                    Step::Key("mechanical_units"),
                    Step::Key(name),
                    Step::Key("axes"),
                    Step::Index(index),
                ];
                let what = format!(
                    "{}: path.program.mechanical_units.{name}.axes[{index}].axis is zero, must be \
                     a direction",
                    context.called
                );
                notes.error(Code::Value, path.line_at(&steps), what);
                continue;
            };
            axes.push(UnitAxis {
                name: own.to_lowercase(),
                axis: unit_axis,
                origin_m: axis.origin_m.unwrap_or_default().into(),
                slides: axis.moves == Some(raw::AxisMoves::Slides),
            });
        }
        let is_twice =
            |axis: &UnitAxis| axes.iter().filter(|own| own.name == axis.name).count() > 1;
        let twice = match axes.iter().find(|axis| is_twice(axis)) {
            Some(axis) => Some(format!("{name} has the axis '{}' twice", axis.name)),
            None if found.contains_key(&name.to_lowercase()) => {
                Some(format!("has '{name}' twice: RAPID ignores case"))
            }
            None => None,
        };
        if let Some(what) = twice {
            let steps = [Step::Key("program"), Step::Key("mechanical_units"), Step::Key(name)];
            let what = format!("{}: path.program.mechanical_units: {what}", context.called);
            notes.error(Code::Value, path.line_at(&steps), what);
        }
        let frame = unit.user_frame.as_ref().map_or_else(Isometry3::identity, |raw| {
            frame(raw.xyz_m.unwrap_or_default(), raw.rpy_rad.unwrap_or_default())
        });
        let unit = MechanicalUnit { name: name.clone(), axes, frame };
        found.insert(name.to_lowercase(), Arc::new(unit));
    }
    found
}

/// What of a RAPID program sets a number: a signal, a procedure or a comment.
fn setter(
    context: &OperationContext<'_>,
    path: &Node,
    key: &str,
    what: [&Option<String>; 3],
    argument: Option<u32>,
    per_unit: Option<f64>,
    notes: &mut Notes,
) -> Option<SetBy> {
    let what = match what {
        [Some(signal), None, None] => Setter::Signal(signal.clone()),
        [None, Some(procedure), None] => {
            Setter::Procedure(procedure.clone(), argument.unwrap_or(1) as usize)
        }
        [None, None, Some(comment)] => Setter::Comment(comment.clone()),
        _ => {
            let line = path.line_at(&[Step::Key("program"), Step::Key(key)]);
            let what = "must have one of signal, procedure, comment";
            notes.error(
                Code::Conflict,
                line,
                format!("{}: path.program.{key} {what}", context.called),
            );
            return None;
        }
    };
    Some(SetBy { what, per_unit: per_unit.unwrap_or(1.0) })
}

#[cfg(test)]
mod tests {
    use super::named_in;

    #[test]
    fn an_index_may_be_a_register_or_an_argument() {
        let names = ["pr[41,1]", "pr[4]", "di[1]"].map(str::to_owned);
        let found = |text: &str| named_in(names.iter(), std::iter::once(text.as_bytes()));
        assert_eq!(found("L PR[AR[1]] Offset,PR[4:a]"), ["pr[41,1]", "pr[4]"]);
        assert_eq!(found("PR[41]=PR[R[3:n]]"), ["pr[41,1]", "pr[4]"]);
        assert_eq!(found("PR[2]=P[1]"), [""; 0]);
    }

    #[test]
    fn a_name_of_an_enumeration_counts_where_its_variable_stands() {
        let names = ["$mode_op == #ex", "$mode_op==#t1", "$mode==#t1", "x[2]==#a"];
        let names = names.map(str::to_owned);
        let found = |text: &str| named_in(names.iter(), std::iter::once(text.as_bytes()));
        assert_eq!(found("IF $MODE_OP  ==  #T2 THEN"), names[..2]);
        assert_eq!(found("SWITCH x[2]"), names[3..]);
    }
}
