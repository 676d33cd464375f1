//! Which words of KRL move, and which certainly do not.

/// Behind the name of a routine: why what it may set is not known.
pub(super) const MAY_SET: &str = "is in no file that is read and may set it";

/// Behind "the robot's position": why the job cannot assume it.
pub(super) const BEHIND_MOVE: &str =
    "behind a move to a place that no file gives is known only at run time";

/// Behind what lays a base so.
pub(super) const ON_KINEMATIC: &str = "lays the base on an external kinematic, and where that is \
                                       is not read: state $BASE behind it in the file that is \
                                       checked, as it lies in the robot's base frame";

/// Lines that begin so neither move nor change anything that is read here.
pub(super) fn is_harmless_keyword(word: &str) -> bool {
    const HARMLESS: [&str; 25] = [
        "interrupt",
        "ext",
        "extfct",
        "signal",
        "enum",
        "struc",
        "import",
        "pulse",
        "anout",
        "anin",
        "digin",
        "continue",
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
        "const_key",
        // Of a SPLINE: where its speed stays the same.
        "const_vel",
        "public",
    ];
    HARMLESS.contains(&word)
}

/// Types that need no DECL.
pub(super) fn is_predefined_type(word: &str) -> bool {
    const TYPES: [&str; 27] = [
        "int",
        "real",
        "bool",
        "char",
        "pos",
        "e3pos",
        "e6pos",
        "axis",
        "e3axis",
        "e6axis",
        "frame",
        "load",
        "inertia",
        "fdat",
        "ldat",
        "pdat",
        "cdat",
        "basis_sugg_t",
        "bas_command",
        "circ_type",
        "ori_type",
        "ipo_mode",
        "mode_op",
        "state_t",
        "date",
        "krlmsg_t",
        "modus_t",
    ];
    TYPES.contains(&word)
}

/// Procedures and statements without motion and without effect on later motion.
pub(super) fn is_harmless(name: &str) -> bool {
    const PROCEDURES: [&str; 24] = [
        "wait for",
        "set_cd_params",
        "scirc_typ",
        "scirc_m",
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
        "p00",
        "ir_stopm",
        "delay",
        "on_error_proceed",
        "err_clear",
    ];
    is_harmless_keyword(name) || PROCEDURES.contains(&name)
}

/// Functions of the controller: they neither move nor set anything that is read here.
pub(super) fn is_own_function(name: &str) -> bool {
    const OWN: &str = "\
        abs acos ascii asin atan atan2 cast_from cast_to cclose check_pidonrdc cioctl copen cos \
        cread cstate cwrite eb ek eo eof exp forward forward_kin frand get_decl_place \
        get_sig_inf getcycdef getvarsize inv_frame inv_pos inverse is_key_pressed log max min \
        round sbase sin sipo_mode sload sqrt sread stool stool2 stradd strclear strcomp strcopy \
        strdecllen strfind strlen strtoaxis strtobool strtoe3axis strtoe3pos strtoe6axis \
        strtoe6pos strtoframe strtoint strtopos strtoreal strtostring svel_cp svel_joint swrite \
        tan timediff trunc varstate vartype sacc_cp sacc_joint sapo sapo_ptp sgear_jerk sjerk \
        sori_typ use_cm_pro_values";
    OWN.split(' ').any(|own| own == name) || is_harmless(name)
}

/// What writes into what it is given.
pub(super) fn fills(name: &str) -> bool {
    const FILL: [&str; 6] = ["anin", "cast_from", "cread", "digin", "get_sig_inf", "sread"];
    FILL.contains(&name) || name.starts_with("strto")
}

/// System variables that later motion depends on.
pub(super) fn sets_motion(name: &str) -> bool {
    const STARTS: [&str; 13] = [
        "$ori_type",
        "$circ_type",
        "$tech",
        "$vel",
        "$ov_pro",
        "$tool",
        "$base",
        "$load",
        "$ipo_mode",
        "$robroot",
        "$world",
        "$corr",
        "$red_vel",
    ];
    STARTS.iter().any(|start| name.starts_with(start))
}

/// Switches of the basic package by which it shifts the frames that it takes.
pub(super) fn corrects_frames(name: &str) -> bool {
    matches!(name, "base_corr_on" | "m_bas_cor_on" | "tool_corr_on" | "tool_corr_w_on")
}

pub(super) fn sounds_like_motion(name: &str) -> bool {
    const PARTS: [&str; 8] = ["move", "ptp", "lin_", "circ", "home", "goto", "search", "approach"];
    PARTS.iter().any(|part| name.contains(part))
}

/// System variables that neither move nor set frames or speeds.
pub(super) fn is_without_effect(name: &str) -> bool {
    const STARTS: [&str; 20] = [
        "$out",
        "$anout",
        "$timer",
        "$cyc",
        "$flag",
        "$advance",
        "$apo",
        "$acc",
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
