//! Which RAPID instructions move the robot, and which certainly do not.

use super::syntax::{Args, Name, Optional};

/// How the robot goes to the target of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Linear,
    Joint,
    Circular,
    AbsoluteJoints,
}

/// Where an instruction has its tool among the arguments without backslash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolAt {
    Index(usize),
    Last,
}

/// How a motion instruction is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Motion {
    pub(super) way: Way,
    pub(super) tool: ToolAt,
    /// Whether `\V` may stand behind the speed; others take `\T` alone.
    pub(super) takes_v: bool,
}

/// A motion instruction by its name in lower case.
pub(super) fn motion(key: &str) -> Option<Motion> {
    let (way, tool) = match key {
        "movel" | "moveldo" | "movelao" | "movelgo" | "movelsync" => {
            (Way::Linear, ToolAt::Index(3))
        }
        "movej" | "movejdo" | "movejao" | "movejgo" | "movejsync" => (Way::Joint, ToolAt::Index(3)),
        "movec" | "movecdo" | "movecao" | "movecgo" | "movecsync" => {
            (Way::Circular, ToolAt::Index(4))
        }
        "moveabsj" => (Way::AbsoluteJoints, ToolAt::Index(3)),
        "triggl" | "triggllios" => (Way::Linear, ToolAt::Last),
        "triggj" | "triggjios" => (Way::Joint, ToolAt::Last),
        "triggc" => (Way::Circular, ToolAt::Last),
        _ => return None,
    };
    let takes_v = matches!(key, "movel" | "movej" | "movec" | "moveabsj");
    Some(Motion { way, tool, takes_v })
}

/// Whether a motion instruction, by its name in lower case, calls a procedure on its way.
pub(super) fn is_synced(key: &str) -> bool {
    key.ends_with("sync") && motion(key).is_some()
}

/// Whether an instruction of the controller works with the targets that it is given as data.
pub(super) fn copies(key: &str) -> bool {
    is_ignored(key) || key == "setdataval"
}

/// Whether an instruction of the controller calibrates a tool by targets, or follows a sensor.
fn is_calibration(key: &str) -> bool {
    matches!(
        key,
        "mtooltcpcalib" | "mtoolrotcalib" | "stooltcpcalib" | "stoolrotcalib" | "synctosensor"
    )
}

/// Instructions that shift later targets: to leave one out would be to misplace motion.
pub(super) fn displaces(key: &str) -> bool {
    matches!(key, "pdispset" | "pdispon" | "eoffsset" | "eoffson" | "corrcon" | "corrwrite")
}

/// Why they are not read, and what helps.
pub(super) fn why_displaced(key: &str) -> &'static str {
    match key.starts_with("corr") {
        true => {
            "a correction of the path by a sensor is not read: leave it, and \\Corr of the moves, \
             out of a copy of the program, which is checked as it is programmed"
        }
        false => "program displacement is not supported",
    }
}

/// What an instruction does with the arm that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Does {
    /// How it moves, and what helps.
    Moves(&'static str),
    /// What it changes of how the arm moves.
    Changes(&'static str),
    /// What it ends such a change of.
    Ends(&'static str),
}

const BY_ITSELF: &str = "moves and is not understood: put the moves that it makes (MoveL, MoveC, \
                         MoveJ) in its place in a copy of the program";
const BACK: &str = "moves the arm back or forth along its path, which is not read: put a move \
                    (MoveL, MoveJ) to where it ends in its place in a copy of the program";
const APART: &str = "moves an axis beside the moves of the robot, which is not read: leave it out \
                     of a copy of the program where that axis carries neither the arm nor the work";

const STIFFNESS: &str = "how stiff the drives hold the arm";
const SPEED: &str = "how fast the arm may be";
const BY_FORCE: &str = "how fast the arm moves, as a force slows it";
const CONVEYOR: &str = "how fast the arm moves, as it follows the work on a conveyor";
const AXIS: &str = "where an axis is that moves by itself";

/// How changes of the path begin.
pub(super) const WHERE: &str = "where the arm goes";
const BY_HAND: &str = "where the arm goes, as a person leads it by hand";
const SEEKS: &str = "where the arm goes, as it seeks a force";

/// Of moves of several robots at once.
pub(super) const TOGETHER: &str =
    "how fast the arm moves, as robots that move together wait for each other";

/// Of the controller and its options, by names in lower case.
const UNREAD: [(&str, Does); 46] = [
    ("motionprocessmodeset", Does::Changes(STIFFNESS)),
    ("softact", Does::Changes(STIFFNESS)),
    ("softdeact", Does::Ends(STIFFNESS)),
    ("tuneservo", Does::Changes(STIFFNESS)),
    ("tunereset", Does::Ends(STIFFNESS)),
    ("speedlimaxis", Does::Changes(SPEED)),
    ("speedlimcheckpoint", Does::Changes(SPEED)),
    ("syncmoveon", Does::Changes(TOGETHER)),
    ("syncmoveresume", Does::Changes(TOGETHER)),
    // Independent axes, the path backwards.
    ("indamove", Does::Moves(APART)),
    ("indcmove", Does::Moves(APART)),
    ("inddmove", Does::Moves(APART)),
    ("indrmove", Does::Moves(APART)),
    ("indreset", Does::Ends(AXIS)),
    ("pathrecmovebwd", Does::Moves(BACK)),
    ("pathrecmovefwd", Does::Moves(BACK)),
    ("stepbwdpath", Does::Moves(BACK)),
    // Soft servo in space, force control, lead-through.
    ("cssact", Does::Changes(STIFFNESS)),
    ("cssdeact", Does::Ends(STIFFNESS)),
    ("cssforceoffsetact", Does::Changes(STIFFNESS)),
    ("cssforceoffsetdeact", Does::Ends(STIFFNESS)),
    ("cssdeactmovel", Does::Moves(BY_ITSELF)),
    ("fcact", Does::Changes(STIFFNESS)),
    ("fcdeact", Does::Ends(STIFFNESS)),
    ("fcspdchgact", Does::Changes(BY_FORCE)),
    ("fcspdchgdeact", Does::Ends(BY_FORCE)),
    ("fcrefstart", Does::Changes(SEEKS)),
    ("fcrefstop", Does::Ends(SEEKS)),
    ("setleadthrough", Does::Changes(BY_HAND)),
    // Conveyors.
    ("dropwobj", Does::Changes(CONVEYOR)),
    ("waitwobj", Does::Changes(CONVEYOR)),
    // Painting, welding, dispensing, sensors.
    ("calibj", Does::Moves(BY_ITSELF)),
    ("calibl", Does::Moves(BY_ITSELF)),
    ("capc", Does::Moves(BY_ITSELF)),
    ("capl", Does::Moves(BY_ITSELF)),
    ("contactl", Does::Moves(BY_ITSELF)),
    ("dispc", Does::Moves(BY_ITSELF)),
    ("displ", Does::Moves(BY_ITSELF)),
    ("nutj", Does::Moves(BY_ITSELF)),
    ("nutl", Does::Moves(BY_ITSELF)),
    ("paintc", Does::Moves(BY_ITSELF)),
    ("paintl", Does::Moves(BY_ITSELF)),
    ("spotj", Does::Moves(BY_ITSELF)),
    ("spotl", Does::Moves(BY_ITSELF)),
    ("spotmj", Does::Moves(BY_ITSELF)),
    ("spotml", Does::Moves(BY_ITSELF)),
];

fn does(key: &str) -> Option<Does> {
    UNREAD.iter().find(|(own, _)| *own == key).map(|(_, does)| *does)
}

/// What an instruction changes of how the arm moves that is not read, and whether it begins that.
pub(super) fn change(name: &Name, args: &Args) -> Option<(&'static str, bool)> {
    let is_off = |(own, value): &(String, Optional)| own == "off" && *value == Optional::Switch;
    match does(&name.key)? {
        Does::Changes(what) => Some((what, !args.optional.iter().any(is_off))),
        Does::Ends(what) => Some((what, false)),
        Does::Moves(_) => None,
    }
}

/// Names that only motion has, beside those that are read.
pub(super) fn sounds_like_motion(key: &str) -> bool {
    const STARTS: [&str; 10] = [
        "move", "search", "trigg", "arcl", "arcc", "arcmove", "smove", "fcpress", "egmmove",
        "egmrun",
    ];
    STARTS.iter().any(|start| key.starts_with(start)) && !is_ignored(key)
        || matches!(does(key), Some(Does::Moves(_)))
}

/// Why a call that moves, by its name or by what it is given, is not read, and what helps.
pub(super) fn why_not_read(key: &str, shown: &str) -> String {
    const FILES: &str = "in no file that is read: path.program.files in the job can name its file";
    // The controller's own have no such names.
    let is_programs = key.contains('_') || key.starts_with("move") && key != "moveextj";
    // `EGMRunPose`, `EGMRunJoint`.
    if key.starts_with("egmrun") {
        format!(
            "'{shown}' moves the robot by what comes from outside, and no program says where to: \
             leave it out of a copy of the program"
        )
    } else if sounds_like_motion(key) && is_programs {
        format!("'{shown}' moves by its name, and is {FILES}")
    } else if sounds_like_motion(key) {
        let how = match does(key) {
            Some(Does::Moves(how)) => how,
            _ => BY_ITSELF,
        };
        format!("instruction '{shown}' {how}")
    } else if is_calibration(key) {
        format!(
            "'{shown}' is an instruction of the controller, and what it does is not read: leave it \
             out of a copy of the program, and write what it would set there"
        )
    } else {
        format!("'{shown}' moves to what it is given, and is {FILES}")
    }
}

/// Instructions without motion of their own. What some of them change of later motion, or end such
/// a change of, is told apart from that.
pub(super) fn is_ignored(key: &str) -> bool {
    const IGNORED: [&str; 84] = [
        "accset",
        "actunit",
        "add",
        "bitclear",
        "bitset",
        "clear",
        "clearpath",
        "clkreset",
        "clkstart",
        "clkstop",
        "close",
        "closedir",
        "connect",
        "deactunit",
        "decr",
        "eoffsoff",
        "errlog",
        "errwrite",
        "corrdiscon",
        "corrclear",
        "idelete",
        "idisable",
        "ienable",
        "incr",
        "invertdo",
        "iodisable",
        "ioenable",
        "isignalai",
        "isignalao",
        "isignaldi",
        "isignaldo",
        "isignalgi",
        "isignalgo",
        "isleep",
        "itimer",
        "iwatch",
        "load",
        "open",
        "opendir",
        "pathacclim",
        "pathresol",
        "pdispoff",
        "pulsedo",
        "readanybin",
        "reset",
        "resetaxisdistance",
        "restopath",
        "rewind",
        "save",
        "setallgo",
        "setao",
        "setdo",
        "setgo",
        "set",
        "singarea",
        "startload",
        "stop",
        "stopmove",
        "stopmovereset",
        "storepath",
        "startmove",
        "systemstopaction",
        "tperase",
        "tpreadfk",
        "tpreadnum",
        "tpshow",
        "tpwrite",
        "triggcheckio",
        "triggequip",
        "triggint",
        "triggio",
        "triggrampao",
        "triggspeed",
        "uimsgbox",
        "uishow",
        "unload",
        "waitai",
        "waitao",
        "waitdi",
        "waitdo",
        "waitgi",
        "waitload",
        "waitrob",
        "waittime",
    ];
    const MONITORS: [&str; 18] = [
        "wzboxdef",
        "wzcyldef",
        "wzsphdef",
        "wzlimjointdef",
        "wzdoset",
        "wzlimsup",
        "wzfree",
        "wzenable",
        "wzdisable",
        "motionsup",
        "cornerpathwarning",
        "frictioncompensation",
        "bookerrno",
        "setsysdata",
        "waitsynctask",
        "waittestandset",
        "syncmoveoff",
        "syncmovesuspend",
    ];
    // Files, channels, sockets, messages, services, interrupts, tests, and what is only made ready.
    const BESIDE: &str = "\
        acteventbuffer cancelload checkprogref cleariobuff clearrawbytes copyfile copyrawbytes \
        deacteventbuffer egmactjoint egmactmove egmactpose egmgetid egmreset egmsetupai \
        egmsetupao egmsetupgi egmsetupuc egmstreamstart egmstreamstop erasemodule getdataval \
        getsysdata gettrapdata ierror ipers ivarvalue makedir packdnheader packrawbytes \
        pathrecstart pathrecstop readerrdata readrawbytes removedir removefile renamefile \
        resetretrycount savecfgdata setdatasearch socketaccept socketbind socketclose \
        socketconnect socketcreate socketlisten socketreceive socketreceivefrom socketsend \
        socketsendto spystart spystop testsigndefine testsignreset texttabinstall tpreaddnum \
        uimsgwrite uimsgwriteabort unpackrawbytes writerawbytes writestrbin";
    MONITORS.contains(&key)
        || matches!(does(key), Some(Does::Changes(_) | Does::Ends(_)))
        || matches!(
            key,
            "aliasio"
                | "aliasioreset"
                | "waituntil"
                | "worldacclim"
                | "write"
                | "writeanybin"
                | "writebin"
                | "break"
        )
        || IGNORED.contains(&key)
        || BESIDE.split_ascii_whitespace().any(|own| own == key)
}

/// Whether an instruction of which nothing else is known may set what it is given.
pub(super) fn may_set(key: &str) -> bool {
    const READ: [&str; 10] = [
        "errraise",
        "gripload",
        "ierror",
        "ipers",
        "mechunitload",
        "raise",
        "setdataval",
        "speedrefresh",
        "startmoveretry",
        "velset",
    ];
    let is_known = is_ignored(key) || motion(key).is_some() || READ.contains(&key);
    !is_known && !key.starts_with("write")
}

/// Whether a call may set data of this type: the others are given to be moved with.
pub(super) fn may_be_set(kind: &str) -> bool {
    const USED: [&str; 5] = ["speeddata", "stoppointdata", "tooldata", "wobjdata", "zonedata"];
    !USED.contains(&kind) && !kind.starts_with("signal")
}

/// Whether a function is the controller's own: it neither moves nor sets an output.
pub(super) fn is_own_function(key: &str) -> bool {
    const OWN: &str = "\
        abs absdnum acos acosdnum ainput aoutput argname asin asindnum atan atan2 atan2dnum \
        atandnum bitand bitanddnum bitcheck bitcheckdnum bitlsh bitlshdnum bitneg bitnegdnum \
        bitor bitordnum bitrsh bitrshdnum bitxor bitxordnum bytetostr calcjointt calcrobt \
        calcrotaxframez calcrotaxisframe camnumberofresults cdate cjointt clkread corrread cos \
        cosdnum cpos crobt crossprod cspeedoverride ctime ctool cwobj dectohex defaccframe \
        defdframe defframe dim dinput distance dnumtonum dnumtostr dotprod doutput egmgetstate \
        eulerzyx eventtype exechandler execlevel exp fcgetforce fcisforcemode filesize filetime \
        fssize getaxisdistance getmecunitname getmodalpayloadmode getmotortorque getnextmechunit \
        getnextsym getserviceinfo getsignalorigin getsysinfo gettaskname gettime ginput \
        ginputdnum goutput goutputdnum hextodec indinpos indspeed iodevicestate iounitstate \
        iscyclicbool isfile ismechunitactive ispers isstopmoveact isstopstateevent issyncmoveon \
        issysid isvar max maxrobreorientspeed maxrobspeed min mirpos modexist modtime \
        motionplannerno nonmotionmode norient numtodnum numtostr offs opmode orientzyx orobt \
        paridposvalid paridrobvalid pathlevel pfrestart poseinv posemult posevect pow powdnum \
        ppmovedinmanmode present progmemfree rawbyteslen readbin readdir readmotor readnum \
        readstr readstrbin readvar reltool remainingretries rmqgetslotname robname robos round \
        rounddnum runmode sin sindnum socketgetstatus socketpeek sqrt sqrtdnum strdigcalc \
        strdigcmp strfind strformat strlen strmap strmatch strmemb strorder strpart strtobyte \
        strtoval tan tandnum taskisactive taskisexecuting taskrunmec taskrunrob tasksinsync \
        testandset testdi testsignread textget texttabfreetouse texttabget texttabinstall \
        triggdatavalid trunc truncdnum type uialphaentry uiclientexist uidnumentry uidnumtune \
        uilistview uimessagebox uinumentry uinumtune validio valtostr vectmagn";
    OWN.split(' ').any(|own| own == key)
}

/// Whether a function of the controller gives a text, a frame or a tool.
pub(super) fn gives_no_number(key: &str) -> bool {
    const OTHER: [&str; 20] = [
        "argname",
        "cdate",
        "corrread",
        "ctime",
        "ctool",
        "cwobj",
        "dectohex",
        "dnumtostr",
        "fcgetforce",
        "getmecunitname",
        "getserviceinfo",
        "getsysinfo",
        "gettaskname",
        "hextodec",
        "readstr",
        "readstrbin",
        "rmqgetslotname",
        "robname",
        "textget",
        "uialphaentry",
    ];
    OTHER.contains(&key)
}

/// Whether a function gives the same for the same arguments, whatever the controller does.
pub(super) fn is_calculation(key: &str) -> bool {
    const PURE: [&str; 23] = [
        "bytetostr",
        "calcjointt",
        "calcrobt",
        "calcrotaxframez",
        "calcrotaxisframe",
        "dectohex",
        "defaccframe",
        "defdframe",
        "defframe",
        "dnumtostr",
        "hextodec",
        "mirpos",
        "numtostr",
        "strdigcalc",
        "strdigcmp",
        "strformat",
        "strmap",
        "strmemb",
        "strorder",
        "strpart",
        "strtobyte",
        "strtoval",
        "valtostr",
    ];
    PURE.contains(&key)
}
