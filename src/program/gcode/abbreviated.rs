//! Words of Fanuc's macros, which may be cut down to their first two letters: `WH[#1 LT 3] DO1`
//! (Fanuc, Series 0i Operator's Manual, "Custom macro", "Abbreviation").

const WORDS: [&str; 21] = [
    "WHILE", "GOTO", "THEN", "END", "AND", "XOR", "MOD", "SIN", "COS", "TAN", "ASIN", "ACOS",
    "ATAN", "SQRT", "ABS", "ROUND", "EXP", "FIX", "FUP", "BIN", "BCD",
];

/// Statements that send data to another device.
const OUTPUTS: [&str; 4] = ["POPEN", "DPRNT", "BPRNT", "PCLOS"];

/// The whole of the name of such a statement, which may be cut, too.
pub(super) fn output(word: &str) -> Option<&'static str> {
    OUTPUTS.into_iter().find(|known| word.len() > 1 && known.starts_with(word))
}

/// The whole of a word in upper case that may be cut; others stay.
pub(super) fn whole(word: &str) -> &str {
    let is_begun = |known: &&str| word.len() > 1 && known.starts_with(word);
    WORDS.into_iter().find(is_begun).unwrap_or(word)
}
