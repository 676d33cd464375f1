//! Which RAPID instructions move the robot, and which certainly do not.

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

/// What an instruction changes of how the arm moves that is not read.
pub(super) fn changes(key: &str) -> Option<&'static str> {
    match key {
        "motionprocessmodeset" | "softact" | "tuneservo" => {
            Some("how stiff the drives hold the arm")
        }
        "speedlimaxis" | "speedlimcheckpoint" => Some("how fast the arm may be"),
        "syncmoveon" | "syncmoveresume" => Some(TOGETHER),
        _ => None,
    }
}

/// The same of moves of several robots at once.
pub(super) const TOGETHER: &str =
    "how fast the arm moves, as robots that move together wait for each other";

/// Names that only motion has, beside those that are read.
pub(super) fn sounds_like_motion(key: &str) -> bool {
    const STARTS: [&str; 12] = [
        "move", "search", "trigg", "arcl", "arcc", "arcmove", "smove", "fcpress", "indamove",
        "indrmove", "egmmove", "egmrun",
    ];
    // Of options for painting, welding, dispensing, and of sensors.
    const OTHERS: [&str; 15] = [
        "calibj", "calibl", "capc", "capl", "contactl", "dispc", "displ", "nutj", "nutl", "paintc",
        "paintl", "spotj", "spotl", "spotmj", "spotml",
    ];
    STARTS.iter().any(|start| key.starts_with(start)) && !is_ignored(key) || OTHERS.contains(&key)
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
        format!("instruction '{shown}' moves and is not understood")
    } else if is_calibration(key) {
        format!(
            "'{shown}' is an instruction of the controller, and what it does is not read: leave it \
             out of a copy of the program, and write what it would set there"
        )
    } else {
        format!("'{shown}' moves to what it is given, and is {FILES}")
    }
}

/// Instructions without motion of their own and without effect on later motion.
pub(super) fn is_ignored(key: &str) -> bool {
    const IGNORED: [&str; 90] = [
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
        "softact",
        "softdeact",
        "speedlimaxis",
        "speedlimcheckpoint",
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
        "tunereset",
        "tuneservo",
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
    const MONITORS: [&str; 21] = [
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
        // What they change is told.
        "syncmoveon",
        "syncmoveoff",
        "syncmoveresume",
        "syncmovesuspend",
        "motionprocessmodeset",
    ];
    // Files, channels, sockets, messages, services, interrupts, tests.
    const BESIDE: &str = "\
        cancelload checkprogref cleariobuff clearrawbytes copyfile copyrawbytes getdataval \
        getsysdata gettrapdata ierror ipers ivarvalue makedir packdnheader packrawbytes \
        pathrecstart pathrecstop readerrdata readrawbytes removedir removefile renamefile \
        resetretrycount savecfgdata setdatasearch socketaccept socketbind socketclose \
        socketconnect socketcreate socketlisten socketreceive socketreceivefrom socketsend \
        socketsendto spystart spystop testsigndefine testsignreset texttabinstall tpreaddnum \
        uimsgwrite uimsgwriteabort unpackrawbytes writerawbytes writestrbin";
    MONITORS.contains(&key)
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
    const READ: [&str; 9] = [
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
