//! Names in Sinumerik's language: words that may stand where a variable does, and R parameters.

/// Keywords, operators, and addresses of several letters, which are no variables: in lower case and
/// in order (Siemens, SINUMERIK 840D sl/828D Fundamentals, "Operations").
const WORDS: [&str; 267] = [
    "ac", "acc", "acclim", "acclima", "acn", "acp", "adis", "adispos", "alf", "and", "ang", "ang1",
    "ang2", "ap", "apr", "apw", "apx", "ar", "as", "atol", "ax", "axis", "b_and", "b_not", "b_or",
    "b_xor", "block", "blsync", "bool", "cac", "cacn", "cacp", "call", "callpath", "cancel",
    "case", "cdc", "cdtol", "chan", "char", "chf", "chr", "cic", "cpbc", "cpdef", "cpdel",
    "cpfmof", "cpfmon", "cpfmson", "cpfpos", "cpfrs", "cpla", "cplctid", "cpldef", "cpldel",
    "cplden", "cplinsc", "cplintr", "cplnum", "cplof", "cplon", "cploutsc", "cplouttr", "cplpos",
    "cpmalarm", "cpmbrake", "cpmprt", "cpmreset", "cpmstart", "cpmvdi", "cpof", "cpon", "cpres",
    "cpsyncop", "cpsyncov", "cpsynfip", "cpsynfiv", "cr", "ctol", "ctolg0", "cutmod", "cutmodk",
    "dac", "dc", "def", "default", "define", "dic", "dilf", "disc", "discl", "dispr", "disr",
    "disrp", "dite", "dits", "div", "dl", "do", "duno", "else", "endfor", "endif", "endlabel",
    "endloop", "endproc", "endwhile", "every", "ex", "extcall", "extern", "fa", "fad", "fb", "fd",
    "fda", "fgref", "fi", "fl", "fma", "foc", "focof", "focon", "for", "fp", "fpo", "frame", "frc",
    "frcm", "from", "fxs", "fxst", "fxsw", "fz", "goto", "gotob", "gotoc", "gotof", "gotos", "gp",
    "ic", "id", "ids", "if", "int", "ip", "ir", "isd", "jerklim", "jerklima", "jr", "kr", "lead",
    "liftfast", "lims", "lli", "loop", "mcall", "meac", "meas", "measa", "measf", "meaw", "meawa",
    "mi", "mod", "mov", "nck", "not", "nut", "of", "offn", "oma1", "oma2", "oma3", "oma4", "oma5",
    "or", "os", "osb", "oscill", "osctrl", "ose", "osnsc", "osp1", "osp2", "ost", "ost1", "ost2",
    "otol", "otolg0", "ovr", "ovra", "ovrrap", "pacclim", "pcall", "phi", "phu", "pl", "pm", "po",
    "polf", "pos", "posa", "posm", "posp", "pr", "prio", "prloc", "proc", "psi", "pw", "qu", "rac",
    "real", "redef", "rep", "repeat", "repeatb", "ret", "ric", "rnd", "rndm", "rp", "rpl", "rt",
    "sc", "scc", "scpara", "sd", "set", "setint", "sf", "spi", "spos", "sposa", "sr", "sra", "st",
    "sta", "stat", "stolf", "string", "svc", "synr", "synrw", "synw", "tcarr", "theta", "tilt",
    "to", "toff", "toffl", "tofflr", "toffr", "tr", "tu", "turn", "uli", "until", "var", "velolim",
    "velolima", "when", "whenever", "while", "xor",
];

/// Whether a name in lower case is one of them.
pub(super) fn is_word(name: &str) -> bool {
    WORDS.binary_search(&name).is_ok()
}

/// `r1` and on, of Sinumerik.
pub(super) fn is_r_parameter(name: &str) -> bool {
    let digits = name.strip_prefix('r').unwrap_or("");
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// Why a word with what stands in brackets behind it, an axis as a rule, is not read.
pub(super) fn refuse_with_axis(name: &str, inside: &str) -> Result<(), String> {
    match name {
        "POS" | "POSA" | "POSP" => {
            Err(format!("{name}[ ] moves an axis beside the path: not supported; write G0 or G1"))
        }
        "FL" | "ACC" | "VELOLIM" | "ACCLIM" | "JERKLIM" => {
            Err(format!("{name}[ ]: limits of an axis are not read; leave it out, and lower F"))
        }
        "PO" => {
            Err("PO[ ] gives a polynomial, which is not read: have lines and arcs written"
                .to_owned())
        }
        "FXS" | "FXST" | "FXSW" => Err(format!(
            "{name}[ ] is for the travel to a fixed stop, which ends where the axis is held: not \
             supported; leave it out where it switches that off"
        )),
        _ if is_word(&name.to_ascii_lowercase()) => Err(format!(
            "{name}[{inside}] is a word of the control for one axis or spindle, and is not read: \
             leave it out if it changes no motion and no speed"
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_in_order() {
        assert!(WORDS.is_sorted());
    }
}
