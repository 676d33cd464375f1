//! Arithmetic on lanes, one pose a lane: reciprocal square root, sine and cosine.
//!
//! Every operation acts on each lane by itself, so the result of a pose does not depend on its
//! neighbours.

use fearless_simd::{Level, Simd, SimdBase, SimdFloat, prelude::*};

/// One number of each lane's pose.
pub(super) type Lanes<S> = <S as Simd>::f64s;

/// Yes or no for each lane.
pub(super) type Mask<S> = <S as Simd>::mask64s;

/// A vector of each lane's pose.
pub(super) type Triple<S> = [Lanes<S>; 3];

/// Positions beyond this many radians are left to the scalar path: the reduction below multiplies
/// 33-bit parts of π/2 with the quadrant's number, which is exact up to 2²⁰ quadrants.
pub(super) const MAX_ANGLE_RAD: f64 = 1.0e6;

/// π/2 in three parts, of which the first two have 33 bits (as in FreeBSD's e_rem_pio2.c).
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// 1.5 · 2⁵²: added to a small number, it leaves the nearest integer in the low bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// sin r = r + r³ (S₀ + S₁ r² + …) on |r| ≤ π/4, minimax to 2⁻⁵⁸ (as in FreeBSD's k_sin.c).
const SINE: [f64; 6] = [
    f64::from_bits(0xBFC5_5555_5555_5549),
    f64::from_bits(0x3F81_1111_1110_F8A6),
    f64::from_bits(0xBF2A_01A0_19C1_61D5),
    f64::from_bits(0x3EC7_1DE3_57B1_FE7D),
    f64::from_bits(0xBE5A_E5E6_8A2B_9CEB),
    f64::from_bits(0x3DE5_D93A_5ACF_D57C),
];

/// cos r = 1 − r²/2 + r⁴ (C₀ + C₁ r² + …) on |r| ≤ π/4, minimax to 2⁻⁵⁸ (as in FreeBSD's k_cos.c).
const COSINE: [f64; 6] = [
    f64::from_bits(0x3FA5_5555_5555_554C),
    f64::from_bits(0xBF56_C16C_16C1_5177),
    f64::from_bits(0x3EFA_01A0_19CB_1590),
    f64::from_bits(0xBE92_7E4F_809C_52AD),
    f64::from_bits(0x3E21_EE9E_BDB4_B1C4),
    f64::from_bits(0xBDA8_FAE9_BE88_38D4),
];

/// The same number in every lane.
#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, x: f64) -> Lanes<S> {
    Lanes::<S>::splat(simd, x)
}

/// 1/√x for normal positive x, to about one unit in the last place.
///
/// With AVX-512 from the machine's estimate of 14 bits, by the fourth-order step
/// y (1 + e/2 + 3e²/8 + 5e³/16), e = 1 − x y²; elsewhere by root and division.
#[inline(always)]
pub(super) fn inverse_root<S: Simd>(simd: S, x: Lanes<S>) -> Lanes<S> {
    match estimate(simd, x) {
        Some(y) => {
            let xy = x * y;
            let e = splat(simd, 1.0) - xy * y;
            let step = e.mul_add(splat(simd, 0.3125), splat(simd, 0.375));
            let step = step.mul_add(e, splat(simd, 0.5)) * e;
            y.mul_add(step, y)
        }
        None => splat(simd, 1.0) / x.sqrt(),
    }
}

/// 1/x for normal x, to 2⁻¹⁶ or better.
#[inline(always)]
pub(super) fn rough_inverse<S: Simd>(simd: S, x: Lanes<S>) -> Lanes<S> {
    let y = x.approximate_recip();
    let e = splat(simd, 1.0) - x * y;
    y.mul_add(e, y)
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn estimate<S: Simd>(simd: S, x: Lanes<S>) -> Option<Lanes<S>> {
    use fearless_simd::{f64x8, x86::Avx512};
    use std::arch::x86_64::{__m512d, _mm512_rsqrt14_pd};
    fearless_simd::kernel!(
        #[inline(always)]
        fn machine_estimate(token: Avx512, x: __m512d) -> f64x8<Avx512> {
            _mm512_rsqrt14_pd(x).simd_into(token)
        }
    );
    match simd.level() {
        // The copies through slices vanish: `S` is this very level.
        Level::Avx512(token) if Lanes::<S>::LEN == 8 => {
            let x = f64x8::from_slice(token, x.as_slice());
            let y = machine_estimate(token, x.into());
            Some(Lanes::<S>::from_slice(simd, y.as_slice()))
        }
        _ => None,
    }
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn estimate<S: Simd>(_: S, _: Lanes<S>) -> Option<Lanes<S>> {
    None
}

/// Sine and cosine of |x| ≤ [`MAX_ANGLE_RAD`], each to about one unit in the last place.
#[inline(always)]
pub(super) fn sin_cos<S: Simd>(simd: S, x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let one = splat(simd, 1.0);
    let shifted = x.mul_add(splat(simd, std::f64::consts::FRAC_2_PI), splat(simd, ROUNDING));
    let quadrants = shifted - splat(simd, ROUNDING);
    let back = -quadrants;
    let r = back.mul_add(splat(simd, HALF_PI[0]), x);
    let r = back.mul_add(splat(simd, HALF_PI[1]), r);
    let r = back.mul_add(splat(simd, HALF_PI[2]), r);

    let z = r * r;
    let sine = (r * z).mul_add(polynomial(simd, z, &SINE), r);
    let half = z * splat(simd, 0.5);
    let near = one - half;
    let rest = (one - near) - half;
    let cosine = near + (z * z).mul_add(polynomial(simd, z, &COSINE), rest);

    let bits: S::u64s = shifted.bitcast();
    let first = S::u64s::splat(simd, 1);
    let second = S::u64s::splat(simd, 2);
    let odd = (bits & first).simd_eq(first);
    let sine_sign = (bits & second) << 62;
    let cosine_sign = ((bits + first) & second) << 62;
    (
        flip::<S>(odd.select(cosine, sine), sine_sign),
        flip::<S>(odd.select(sine, cosine), cosine_sign),
    )
}

/// `x` with its sign turned where the top bit of `sign` is set.
#[inline(always)]
fn flip<S: Simd>(x: Lanes<S>, sign: S::u64s) -> Lanes<S> {
    let bits: S::u64s = x.bitcast();
    (bits ^ sign).bitcast()
}

/// `x` with its sign turned where `y` is negative.
#[inline(always)]
pub(super) fn turn_sign<S: Simd>(simd: S, x: Lanes<S>, y: Lanes<S>) -> Lanes<S> {
    let bits: S::u64s = y.bitcast();
    flip::<S>(x, bits & S::u64s::splat(simd, 1 << 63))
}

#[inline(always)]
fn polynomial<S: Simd>(simd: S, z: Lanes<S>, coefficients: &[f64; 6]) -> Lanes<S> {
    let mut sum = splat(simd, coefficients[5]);
    for &c in coefficients[..5].iter().rev() {
        sum = sum.mul_add(z, splat(simd, c));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The levels that this machine has.
    fn levels() -> Vec<Level> {
        let sets = crate::modes::batch::InstructionSet::available();
        sets.into_iter().filter_map(|set| set.level()).collect()
    }

    #[inline(always)]
    fn of_all<S: Simd>(simd: S, angles: &[f64]) -> Vec<(f64, f64)> {
        let solve = |x: &f64| {
            let (sine, cosine) = sin_cos(simd, splat(simd, *x));
            (sine.as_slice()[0], cosine.as_slice()[Lanes::<S>::LEN - 1])
        };
        angles.iter().map(solve).collect()
    }

    #[inline(always)]
    fn roots<S: Simd>(simd: S, squares: &[f64]) -> Vec<f64> {
        squares.iter().map(|x| inverse_root(simd, splat(simd, *x)).as_slice()[0]).collect()
    }

    /// Against the standard library's, which are good to less than one unit in the last place: at
    /// random angles, and at the doubles nearest to multiples of π/2, where all digits but the last
    /// cancel.
    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut angles: Vec<f64> =
            (0..200_000).map(|_| rng.random_range(-1000.0..1000.0)).collect();
        angles.extend((0..200_000).map(|_| rng.random_range(-7.0..7.0)));
        angles.extend((-640..=640).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2));
        angles.extend([0.0, -0.0, 1e-300, 1e5, -MAX_ANGLE_RAD, MAX_ANGLE_RAD]);
        for level in levels() {
            let found = dispatch!(level, simd => of_all(simd, &angles));
            for (x, (sine, cosine)) in angles.iter().zip(found) {
                for (found, expected) in [(sine, x.sin()), (cosine, x.cos())] {
                    let off = (found - expected).abs();
                    assert!(off <= 1.5 * f64::EPSILON * expected.abs(), "{x}: {found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn reciprocal_roots_are_exact_to_the_last_places() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let squares: Vec<f64> =
            (0..100_000).map(|_| 10.0_f64.powf(rng.random_range(-250.0..250.0))).collect();
        for level in levels() {
            let found = dispatch!(level, simd => roots(simd, &squares));
            for (x, y) in squares.iter().zip(found) {
                let expected = 1.0 / x.sqrt();
                assert!((y / expected - 1.0).abs() <= 2.0 * f64::EPSILON, "{x}: {y}, {expected}");
            }
        }
    }
}
