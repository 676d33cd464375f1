//! Which words of KRL move, and which certainly do not.

/// Procedures and statements without motion and without effect on later motion.
pub(super) fn is_harmless(name: &str) -> bool {
    const HARMLESS: [&str; 44] = [
        "wait for",
        "continue",
        "interrupt",
        "global",
        "ext",
        "extfct",
        "signal",
        "enum",
        "struc",
        "import",
        "trigger",
        "pulse",
        "anout",
        "anin",
        "digin",
        "confirm",
        "channel",
        "copen",
        "cclose",
        "cread",
        "cwrite",
        "sread",
        "swrite",
        "cast_to",
        "cast_from",
        "user",
        "bas_ini",
        "user_ini",
        "initmov",
        "msgnotify",
        "msgquit",
        "msgstate",
        "msgdialog",
        "set_krlmsg",
        "set_krldlg",
        "varstate",
        "strcopy",
        "strclear",
        "stradd",
        "clear_krlmsg",
        "public",
        "p00",
        "ir_stopm",
        "delay",
    ];
    HARMLESS.contains(&name)
}

pub(super) fn sounds_like_motion(name: &str) -> bool {
    const PARTS: [&str; 8] = ["move", "ptp", "lin_", "circ", "home", "goto", "search", "approach"];
    PARTS.iter().any(|part| name.contains(part))
}

/// System variables that neither move nor set frames or speeds.
pub(super) fn is_without_effect(name: &str) -> bool {
    const STARTS: [&str; 22] = [
        "$out",
        "$anout",
        "$timer",
        "$cyc",
        "$flag",
        "$advance",
        "$apo",
        "$acc",
        "$ori_type",
        "$circ_type",
        "$h_pos",
        "$bwdstart",
        "$pal_mode",
        "$jerk",
        "$gear_jerk",
        "$cp_ve",
        "$stop",
        "$sen_",
        "$loop_",
        "$spl_",
        "$pro_",
        "$msg",
    ];
    STARTS.iter().any(|start| name.starts_with(start))
}
