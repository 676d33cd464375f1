//! Tones that a record may hold beside modes: of the mains and of a spindle.

use crate::notes::Code;
use crate::units::hz_from_rpm;

/// Harmonics of a source that makes tones.
pub(super) struct Harmonics {
    pub(super) base_hz: f64,
    count: u32,
    /// Relative distance of a tone from the exact multiple.
    tolerance: f64,
    pub(super) code: Code,
}

/// One of them, as a record shows it.
pub(super) struct Harmonic {
    pub(super) order: u32,
    /// Where it shows, Hz, and how far a tone may lie from there.
    pub(super) seen_hz: f64,
    pub(super) within_hz: f64,
    pub(super) is_alias: bool,
}

impl Harmonics {
    /// Those that a session states.
    pub(super) fn all(mains_hz: &[f64], spindle_rpm: Option<f64>) -> Vec<Self> {
        let mains = mains_hz.iter().map(|&hz| Self::of_mains(hz));
        mains.chain(spindle_rpm.map(Self::of_spindle)).collect()
    }

    /// The mains varies little.
    fn of_mains(base_hz: f64) -> Self {
        Self { base_hz, count: 20, tolerance: 2e-3, code: Code::Mains }
    }

    /// Spindles slip.
    fn of_spindle(rpm: f64) -> Self {
        Self { base_hz: hz_from_rpm(rpm), count: 10, tolerance: 5e-3, code: Code::Spindle }
    }

    /// What makes them, in words.
    pub(super) fn name(&self) -> &'static str {
        if self.code == Code::Mains { "mains" } else { "spindle" }
    }

    /// Each of them, folded at half the sampling rate.
    pub(super) fn seen(&self, nyquist_hz: Option<f64>) -> impl Iterator<Item = Harmonic> {
        const MOST_HZ: f64 = 0.25;
        (1..=self.count).map(move |order| {
            let true_hz = f64::from(order) * self.base_hz;
            let seen_hz = match nyquist_hz {
                Some(nyquist) => {
                    let rest = true_hz % (2.0 * nyquist);
                    if rest > nyquist { 2.0 * nyquist - rest } else { rest }
                }
                None => true_hz,
            };
            let is_alias = (seen_hz - true_hz).abs() > 1e-9;
            // An alias of a high harmonic would lie anywhere.
            let most = if is_alias { MOST_HZ } else { f64::INFINITY };
            let within_hz = (self.tolerance * true_hz).min(most);
            Harmonic { order, seen_hz, within_hz, is_alias }
        })
    }

    /// The harmonic at which a frequency with this deviation lies, Hz, and whether it is an alias
    /// of it.
    pub(super) fn at(
        &self,
        (hz, std_hz): (f64, f64),
        nyquist_hz: Option<f64>,
    ) -> Option<(u32, bool)> {
        // A mode that is known worse than that lies at every harmonic.
        let is_at = |own: &Harmonic| {
            3.0 * std_hz < own.within_hz.max(0.1) && (hz - own.seen_hz).abs() <= own.within_hz
        };
        self.seen(nyquist_hz).find(is_at).map(|own| (own.order, own.is_alias))
    }
}
