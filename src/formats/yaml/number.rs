//! Which plain scalars spell numbers: the core schema of YAML 1.2.

/// The finite number that a plain scalar spells.
pub(super) fn number_of(text: &str) -> Option<f64> {
    let first = *text.as_bytes().first()?;
    if !(first.is_ascii_digit() || matches!(first, b'+' | b'-' | b'.')) {
        return None;
    }
    if let Some(digits) = text.strip_prefix("0x") {
        return u32::from_str_radix(digits, 16).ok().map(f64::from);
    }
    if let Some(digits) = text.strip_prefix("0o") {
        return u32::from_str_radix(digits, 8).ok().map(f64::from);
    }
    let spelled = text
        .bytes()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E'));
    if !spelled {
        return None;
    }
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// `.nan`, `.inf`, and decimal numbers too large for a double.
pub(super) fn is_not_finite(text: &str) -> bool {
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    matches!(unsigned, ".inf" | ".Inf" | ".INF" | ".nan" | ".NaN" | ".NAN")
        || (unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.')
            && unsigned.parse::<f64>().is_ok_and(f64::is_infinite))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_core_schema_and_finite() {
        for (text, number) in [
            ("0", 0.0),
            ("-1.2e5", -1.2e5),
            ("+.5", 0.5),
            ("5.", 5.0),
            ("0x1F", 31.0),
            ("0o17", 15.0),
            ("007", 7.0),
        ] {
            assert_eq!(number_of(text), Some(number), "{text}");
        }
        for text in [
            "", "-", ".", "+.e3", "1e", "1_000", "1,5", ".nan", ".inf", "nan", "inf", "1e999",
            "0x", "1 2", "e5",
        ] {
            assert_eq!(number_of(text), None, "{text}");
        }
    }
}
