//! Data that every controller has.

use std::rc::Rc;

use super::number::Number;
use super::value::{Value, load0};

/// The speeddata of the controller's own that programs set.
pub(super) const VMAX: &str = "vmax";

/// The speed that the controller caps `vmax` at on most arms, mm/s; the arm's own may differ.
pub(super) const VMAX_MM_PER_S: f64 = 5000.0;

const PREDEFINED_SPEEDS_MM_PER_S: [u16; 25] = [
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500,
    3000, 4000, 5000, 6000, 7000,
];

/// Signals; answers, buttons and icons of messages; operating modes; modes of the run. Names in
/// lower case.
const NUMBERS: [(&str, f64); 32] = [
    ("low", 0.0),
    ("high", 1.0),
    ("pi", std::f64::consts::PI),
    ("resunkwn", 0.0),
    ("resok", 1.0),
    ("resabort", 2.0),
    ("resretry", 3.0),
    ("resignore", 4.0),
    ("rescancel", 5.0),
    ("resyes", 6.0),
    ("resno", 7.0),
    ("btnnone", -1.0),
    ("btnok", 0.0),
    ("btnabrtrtryign", 1.0),
    ("btnokcancel", 2.0),
    ("btnretrycancel", 3.0),
    ("btnyesno", 4.0),
    ("btnyesnocancel", 5.0),
    ("iconnone", 0.0),
    ("iconinfo", 1.0),
    ("iconwarning", 2.0),
    ("iconerror", 3.0),
    ("op_undef", 0.0),
    ("op_auto", 1.0),
    ("op_man_prog", 2.0),
    ("op_man_test", 3.0),
    ("run_undef", 0.0),
    ("run_cont_cycle", 1.0),
    ("run_instr_fwd", 2.0),
    ("run_instr_bwd", 3.0),
    ("run_sim", 4.0),
    ("run_step_move", 5.0),
];

/// Constants whose numbers are not read, beside those of errors.
const UNREAD: &str = "\
    eof_bin eof_num socket_bound socket_closed socket_connected socket_created socket_listening \
    wait_max";

/// Numbers of errors, which are not read either: the controller has 0 for none, so that they are
/// not 0. Another name may be that of a constant in another file, with any number.
const ERRORS: &str = "\
    err_axis_act err_cnv_not_act err_coll_stop err_dev_maxtime err_divzero err_fileacc \
    err_filnotfnd err_ioerror err_loaded err_norununit err_notsaved err_outofbnd err_overflow \
    err_path err_pathdist err_path_stop err_progstop err_rcvdata err_roblimit err_sigsupsearch \
    err_sig_not_valid err_sock_addr_inuse err_sock_closed err_sock_timeout \
    err_speed_refresh_lim err_startmove err_tp_dibreak err_tp_dobreak err_tp_maxtime \
    err_tp_no_client err_tp_persboolbreak err_uishow_fatal err_unload err_wait_max \
    err_wait_maxtime err_waitsynctask err_whlsearch err_wobj_moving";

/// Whether a name in lower case is that of the number of an error of the controller's.
pub(super) fn is_error(key: &str) -> bool {
    ERRORS.split_ascii_whitespace().any(|own| own == key)
}

/// Whether a name in lower case is that of a constant of the controller whose number is not read.
pub(super) fn is_unread(key: &str) -> bool {
    is_error(key) || UNREAD.split_ascii_whitespace().any(|own| own == key)
}

/// Sets of characters for functions of strings, by names in lower case.
const CHARACTERS: [(&str, &str); 4] = [
    ("str_digit", "0123456789"),
    ("str_upper", "ABCDEFGHIJKLMNOPQRSTUVWXYZÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖØÙÚÛÜÝÞ"),
    ("str_lower", "abcdefghijklmnopqrstuvwxyzàáâãäåæçèéêëìíîïðñòóôõöøùúûüýþßÿ"),
    ("str_white", " "),
];

/// Stop points: in position, by per cent of a fine point.
const IN_POSITION: [(&str, f64); 3] = [("inpos20", 20.0), ("inpos50", 50.0), ("inpos100", 100.0)];

/// Stop points of a time, by the ends of their names.
const TIMES_S: [(&str, f64); 3] = [("0_5", 0.5), ("1_0", 1.0), ("1_5", 1.5)];

/// Types of stop points: in position, for a time, while a conveyor is followed.
const STOP_POINTS: [(&str, f64); 3] = [("inpos", 1.0), ("stoptime", 2.0), ("fllwtime", 3.0)];

/// The number of a type of stop points by its name in lower case.
pub(super) fn stop_point(name: &str) -> Option<f64> {
    STOP_POINTS.iter().find(|(own, _)| *own == name).map(|(_, number)| *number)
}

/// The name of a type of stop points by its number.
pub(super) fn stop_point_of(number: f64) -> Option<&'static str> {
    STOP_POINTS.iter().find(|(_, own)| *own == number).map(|(name, _)| *name)
}

/// The value of what every controller has, by its name in lower case, and its type.
pub(super) fn predefined(key: &str) -> Option<(Value, &'static str)> {
    let of_stop = || stop_point_data(key).map(|value| (value, "stoppointdata"));
    let found = match key {
        "tool0" => (Value::Tool0, "tooldata"),
        "wobj0" => (Value::Wobj0, "wobjdata"),
        "load0" => (load0(), "loaddata"),
        // A zone, of which the first part alone is asked for: whether the arm stops.
        "fine" => (Value::List(vec![Value::Bool(true)]), "zonedata"),
        VMAX => (speed(Number::of(VMAX_MM_PER_S).of_robot()), "speeddata"),
        "stempty" => (Value::Text(Rc::from("")), "string"),
        // What ReadStr gives at the end of a file.
        "eof" => (Value::Text(Rc::from("EOF")), "string"),
        _ => {
            let found = of_number(key).or_else(|| of_characters(key));
            return found.or_else(|| of_speed(key)).or_else(of_stop);
        }
    };
    Some(found)
}

fn of_number(key: &str) -> Option<(Value, &'static str)> {
    let number = NUMBERS.iter().find(|(name, _)| *name == key)?.1;
    Some((Value::Num(Number::of(number)), "num"))
}

fn of_characters(key: &str) -> Option<(Value, &'static str)> {
    let characters = CHARACTERS.iter().find(|(name, _)| *name == key)?.1;
    Some((Value::Text(Rc::from(characters)), "string"))
}

fn of_speed(key: &str) -> Option<(Value, &'static str)> {
    let mm_per_s = key.strip_prefix('v')?.parse::<u16>().ok()?;
    let known = PREDEFINED_SPEEDS_MM_PER_S.contains(&mm_per_s);
    known.then(|| (speed(f64::from(mm_per_s).into()), "speeddata"))
}

fn speed(mm_per_s: Number) -> Value {
    let others = [500.0, 5000.0, 1000.0].map(Number::from);
    Value::List([mm_per_s].into_iter().chain(others).map(Value::Num).collect())
}

/// `inpos20`, for which the program waits; `stoptime0_5` and `fllwtime0_5`, for which it is taken
/// not to.
fn stop_point_data(key: &str) -> Option<Value> {
    let of_time = |start: &str| {
        let end = key.strip_prefix(start)?;
        TIMES_S.iter().find(|(name, _)| *name == end).map(|(_, seconds)| *seconds)
    };
    let share = IN_POSITION.iter().find(|(name, _)| *name == key).map(|(_, share)| *share);
    let (kind, share, times) = match (share, of_time("stoptime"), of_time("fllwtime")) {
        (Some(share), ..) => (1.0, share, [0.0, 0.0]),
        (_, Some(seconds), _) => (2.0, 0.0, [seconds, 0.0]),
        (.., Some(seconds)) => (3.0, 0.0, [0.0, seconds]),
        _ => return None,
    };
    let max_s = if share > 0.0 { 2.0 } else { 0.0 };
    let number = |number: f64| Value::Num(Number::of(number));
    Some(Value::List(vec![
        number(kind),
        Value::Bool(kind == 1.0),
        Value::nums(&[share, share, 0.0, max_s]),
        number(times[0]),
        number(times[1]),
        Value::Text(Rc::from("")),
        number(0.0),
        number(0.0),
    ]))
}
