//! The one place where units are converted. Inside the crate everything is SI: metres, radians,
//! seconds, kilograms, hertz. Spindle speed alone stays in rev/min, as its users say it.

mod date;
pub mod written;

use std::f64::consts::{PI, TAU};

pub use date::Date;

/// Standard acceleration of free fall, m/s² (CGPM 1901).
pub const STANDARD_GRAVITY_M_PER_S2: f64 = 9.80665;

const SECONDS_PER_MINUTE: f64 = 60.0;
const METRES_PER_MILLIMETRE: f64 = 1e-3;

/// Units by the endings of names that carry them; an ending stands before those that it ends in.
const UNITS: [(&str, &str); 25] = [
    ("_nms_per_rad", "N·m·s/rad"),
    ("_nm_per_rad", "N·m/rad"),
    ("_rpm_per_s", "rpm/s"),
    ("_um_per_n", "µm/N"),
    ("_n_per_mm2", "N/mm²"),
    ("_n_per_mm", "N/mm"),
    ("_ns_per_m", "N·s/m"),
    ("_n_per_m", "N/m"),
    ("_m_per_s2", "m/s²"),
    ("_mm_per_min", "mm/min"),
    ("_per_nm", "per N·m"),
    ("_per_k", "per K"),
    ("_percent", "%"),
    ("_kgm2", "kg·m²"),
    ("_rpm", "rpm"),
    ("_deg", "degrees"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_nm", "N·m"),
    ("_mm", "mm"),
    ("_um", "µm"),
    ("_c", "°C"),
    ("_m", "m"),
    ("_s", "s"),
];

/// What a name says without its unit, and the unit: `spindle_rpm` is ("spindle", "rpm").
pub fn unit_of(name: &str) -> (&str, &'static str) {
    UNITS
        .iter()
        .find_map(|&(ending, unit)| Some((name.strip_suffix(ending)?, unit)))
        .unwrap_or((name, ""))
}

/// Where a frequency shows at a sampling rate: folded about half of it.
pub fn aliased_hz(frequency_hz: f64, sample_rate_hz: f64) -> f64 {
    (frequency_hz - sample_rate_hz * (frequency_hz / sample_rate_hz).round()).abs()
}

/// Degrees to radians.
pub const fn rad_from_deg(deg: f64) -> f64 {
    deg * (PI / 180.0)
}

/// Radians to degrees.
pub fn deg_from_rad(rad: f64) -> f64 {
    rad * (180.0 / PI)
}

/// The number of degrees with the fewest digits that [`rad_from_deg`] turns into this angle: what a
/// user typed comes back as it was typed.
pub fn deg_read_as(rad: f64) -> f64 {
    shortest(rad, deg_from_rad(rad), rad_from_deg)
}

/// The number of millimetres with the fewest digits that [`m_from_mm`] turns into this length.
pub fn mm_read_as(m: f64) -> f64 {
    shortest(m, mm_from_m(m), m_from_mm)
}

/// The per cent with the fewest digits that [`ratio_from_percent`] turns into this ratio.
pub fn percent_read_as(ratio: f64) -> f64 {
    shortest(ratio, percent_from_ratio(ratio), ratio_from_percent)
}

/// The µm/N with the fewest digits that [`m_per_n_from_um_per_n`] turns into this compliance.
pub fn um_per_n_read_as(compliance: f64) -> f64 {
    shortest(compliance, um_per_n_from_m_per_n(compliance), m_per_n_from_um_per_n)
}

/// The number near `guess` with the fewest digits that `read` turns into `value`.
fn shortest(value: f64, guess: f64, read: fn(f64) -> f64) -> f64 {
    let rounded = |digits: usize| format!("{guess:.digits$e}").parse().unwrap_or(guess);
    (0..=16).map(rounded).find(|&number| read(number) == value).unwrap_or(guess)
}

/// Milliradians to radians.
pub fn rad_from_mrad(mrad: f64) -> f64 {
    mrad * 1e-3
}

/// Angular frequency in rad/s to frequency in Hz.
pub fn hz_from_rad_per_s(omega: f64) -> f64 {
    omega / TAU
}

/// Frequency in Hz to angular frequency in rad/s.
pub fn rad_per_s_from_hz(hz: f64) -> f64 {
    hz * TAU
}

/// Frequency in Hz from kHz.
pub fn hz_from_khz(khz: f64) -> f64 {
    1e3 * khz
}

/// Spindle speed in rev/min to revolutions per second.
pub fn hz_from_rpm(rpm: f64) -> f64 {
    rpm / SECONDS_PER_MINUTE
}

/// Revolutions per second to spindle speed in rev/min.
pub fn rpm_from_hz(hz: f64) -> f64 {
    hz * SECONDS_PER_MINUTE
}

/// Feed in mm/min to m/s.
pub fn m_per_s_from_mm_per_min(feed: f64) -> f64 {
    feed * METRES_PER_MILLIMETRE / SECONDS_PER_MINUTE
}

/// Feed in m/s to mm/min.
pub fn mm_per_min_from_m_per_s(feed: f64) -> f64 {
    feed / METRES_PER_MILLIMETRE * SECONDS_PER_MINUTE
}

/// Millimetres to metres.
pub fn m_from_mm(mm: f64) -> f64 {
    mm * METRES_PER_MILLIMETRE
}

/// Metres to millimetres.
pub fn mm_from_m(m: f64) -> f64 {
    m / METRES_PER_MILLIMETRE
}

/// Compliance in m/N to µm/N.
pub fn um_per_n_from_m_per_n(compliance: f64) -> f64 {
    compliance * 1e6
}

/// Compliance in µm/N to m/N.
pub fn m_per_n_from_um_per_n(compliance: f64) -> f64 {
    compliance * 1e-6
}

/// Percent to a plain ratio.
pub fn ratio_from_percent(percent: f64) -> f64 {
    percent / 100.0
}

/// A plain ratio to percent.
pub fn percent_from_ratio(ratio: f64) -> f64 {
    ratio * 100.0
}

/// Millimetres per second to m/s.
pub fn m_per_s_from_mm_per_s(speed: f64) -> f64 {
    speed * METRES_PER_MILLIMETRE
}

/// Inches to millimetres (exact).
pub fn mm_from_inch(inch: f64) -> f64 {
    inch * 25.4
}

/// N/mm² to N/m².
pub const fn n_per_m2_from_n_per_mm2(pressure: f64) -> f64 {
    pressure * 1e6
}

/// N/mm to N/m.
pub const fn n_per_m_from_n_per_mm(force: f64) -> f64 {
    force * 1e3
}

/// Micrometres to metres.
pub fn m_from_um(um: f64) -> f64 {
    um * 1e-6
}

/// Centimetres to metres.
pub fn m_from_cm(cm: f64) -> f64 {
    cm * 1e-2
}

/// Multiples of the standard acceleration of free fall to m/s².
pub fn m_per_s2_from_g(g: f64) -> f64 {
    g * STANDARD_GRAVITY_M_PER_S2
}

/// Kilonewtons to newtons.
pub fn n_from_kn(kn: f64) -> f64 {
    kn * 1e3
}

/// Seconds to milliseconds.
pub fn ms_from_s(s: f64) -> f64 {
    s * 1e3
}

/// Milliseconds to seconds.
pub fn s_from_ms(ms: f64) -> f64 {
    ms * 1e-3
}

/// Microseconds to seconds.
pub fn s_from_us(us: f64) -> f64 {
    us * 1e-6
}

/// Metres to micrometres.
pub fn um_from_m(m: f64) -> f64 {
    m * 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_folds_about_half_the_rate() {
        for (tone, seen) in [(30.0, 30.0), (84.0, 56.0), (140.0, 0.0), (150.0, 10.0), (413.0, 7.0)]
        {
            assert!((aliased_hz(tone, 140.0) - seen).abs() < 1e-12);
        }
    }
}
