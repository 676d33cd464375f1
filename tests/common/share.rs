//! `DETUNE_SHARE=3`: tests that draw cases take a third of them.

/// Of so many cases one is taken.
pub(crate) fn one_in() -> usize {
    std::env::var("DETUNE_SHARE").map_or(1, |text| {
        text.parse().ok().filter(|n| *n > 0).expect("DETUNE_SHARE is a whole number above 0")
    })
}
