//! Stability of cuts against closed forms and figures that other programs give.

use std::f64::consts::{PI, TAU};

use detune::excitation::Engagement;
use detune::stability::{
    Chart, Cut, Exact, Kind, Milling, Process, Term, ToolMode, coupling_limit, milling_grows,
    milling_limit, milling_radius,
};
use nalgebra::{Matrix3x2, Vector3};

fn agree(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() <= share, "{found} {expected}");
}

fn mode(hz: f64, damping_ratio: f64, mass_kg: f64, axis_deg: f64) -> ToolMode {
    let (y, x) = axis_deg.to_radians().sin_cos();
    ToolMode {
        omega_rad_per_s: TAU * hz,
        damping_ratio,
        motion: Vector3::new(x, y, 0.0) / mass_kg.sqrt(),
    }
}

fn slot(teeth: usize) -> Cut {
    Cut {
        engagement: Engagement { entry_rad: 0.0, exit_rad: PI },
        pitch_rad: vec![TAU / teeth as f64; teeth],
        coefficients_n_per_m2: [6e8, 2e8, 0.0],
        lag_rad_per_m: 0.0,
        lip_n_per_m2: None,
        rubbing_n_per_m2: 0.0,
    }
}

/// Figures of issue 18, by semi-discretisation with extrapolation.
#[test]
fn spectral_radii_of_a_slot() {
    let modes = [mode(922.0, 0.011, 0.03993, 0.0)];
    for (depth_mm, expected) in
        [(0.2, 0.8197427843), (0.5, 1.0739755867), (0.7, 1.2215561357), (1.0, 1.4064735253)]
    {
        let found = milling_radius(&modes, &slot(2), 5000.0, depth_mm * 1e-3).unwrap();
        println!("{depth_mm} mm: {:.1e} off", found - expected);
        assert!((found - expected).abs() < 1e-9, "{depth_mm} mm: {found} {expected}");
    }
}

/// Four even teeth in a slot: the coefficients are constant, so the zeroth order is exact.
#[test]
fn four_teeth_in_a_slot_feel_the_same_at_all_times() {
    let modes = [mode(922.0, 0.011, 0.03993, 0.0), mode(922.0, 0.011, 0.03993, 90.0)];
    let cut = slot(4);
    let chart = Chart::new(&modes, &cut);
    let zeroth = chart.limit(5000.0).unwrap();
    agree(zeroth.depth_m, 0.036776536e-3, 2e-8);
    for rpm in [700.0, 2_100.0, 5_000.0, 8_300.0, 13_830.0, 20_000.0] {
        let zeroth = chart.limit(rpm).unwrap();
        let exact = milling_limit(&modes, &cut, &chart, rpm).unwrap().unwrap();
        println!("{rpm} rpm: {} {:?}", zeroth.depth_m / exact.depth_m - 1.0, exact);
        agree(zeroth.depth_m, exact.depth_m, 1e-7);
        agree(zeroth.frequency_hz, exact.frequency_hz, 1e-6);
        assert_eq!(exact.kind, Kind::Hopf);
    }
}

/// A turning tool: one delay, constant coefficients.
struct Turning {
    delay_s: f64,
    n_per_m2: f64,
    /// What damps per width, N s/m².
    n_s_per_m2: f64,
}

impl Process for Turning {
    fn period_s(&self) -> f64 {
        self.delay_s
    }
    fn delays_s(&self) -> Vec<f64> {
        vec![self.delay_s]
    }
    fn corners_s(&self, _: f64) -> Vec<f64> {
        Vec::new()
    }
    fn fastest_rad_per_s(&self) -> f64 {
        1.0
    }
    fn term(&self, _: usize, _: f64, depth_m: f64) -> Option<Term> {
        let mut force = Matrix3x2::zeros();
        force[(0, 0)] = -self.n_per_m2 * depth_m;
        let mut rate = Matrix3x2::zeros();
        rate[(0, 0)] = -self.n_s_per_m2 * depth_m;
        let rate = (self.n_s_per_m2 > 0.0).then_some(rate);
        Some(Term { now: force, before: force, rate })
    }
}

/// The lobes of turning with one mode in closed form (Altintas, Manufacturing Automation, 2nd ed.,
/// section 4.2): at ω = rω₀ with the phase φ of 1/(k (1 − r² + 2iζr)) and its real part R < 0, the
/// width is −1/(2KR) and the waves between two turns are ωτ = 2πn + 3π + 2φ. The lowest point of
/// each is b = 2kζ(1 + ζ)/K.
#[test]
fn the_whole_lobe_of_turning() {
    let (hz, zeta, mass) = (150.0, 0.03, 12.0);
    let modes = [mode(hz, zeta, mass, 0.0)];
    let omega0 = TAU * hz;
    let (k, per_depth) = (mass * omega0 * omega0, 1.5e9);
    let parts = |r: f64| (1.0 - r * r, 2.0 * zeta * r);
    let width = |r: f64| {
        let (a, b) = parts(r);
        -k * (a * a + b * b) / (2.0 * per_depth * a)
    };
    let waves = |r: f64| {
        let (a, b) = parts(r);
        3.0 * PI + 2.0 * (-b).atan2(a)
    };
    let lowest = 2.0 * k * zeta * (1.0 + zeta) / per_depth;
    agree(width((1.0 + 2.0 * zeta).sqrt()), lowest, 1e-12);
    let mut highest: f64 = 0.0;
    for delay_s in (1..=40).map(|i| 0.0023 + 0.0007 * f64::from(i)) {
        let on_lobe = |n: i32| {
            let (mut low, mut high) = (1.0 + 1e-12, 50.0);
            let off = |r: f64| r * omega0 * delay_s - waves(r) - TAU * f64::from(n);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if off(middle) < 0.0 { low = middle } else { high = middle }
            }
            width(0.5 * (low + high))
        };
        let limit = (0..20).map(on_lobe).fold(f64::INFINITY, f64::min);
        highest = highest.max(limit);
        assert!(limit >= lowest * (1.0 - 1e-12));
        let turning = Turning { delay_s, n_per_m2: per_depth, n_s_per_m2: 0.0 };
        let radius = |depth| Exact::new(&modes, &turning).multiplier(depth).unwrap().norm();
        assert!((radius(limit) - 1.0).abs() < 1e-9, "{delay_s}: {}", radius(limit));
        assert!(radius(0.999 * limit) < 1.0 && radius(1.001 * limit) > 1.0, "{delay_s}");
    }
    assert!(highest > 3.0 * lowest);
}

/// x″ + (δ + ε cos t) x = b x(t − 2π): a periodic motion obeys Mathieu's equation with δ − b, one
/// that changes sign every period that with δ + b (Insperger & Stépán, Proc. R. Soc. A 458, 2002).
struct DelayedMathieu {
    stiffness: f64,
    epsilon: f64,
    gain: f64,
}

impl Process for DelayedMathieu {
    fn period_s(&self) -> f64 {
        TAU
    }
    fn delays_s(&self) -> Vec<f64> {
        vec![TAU]
    }
    fn corners_s(&self, _: f64) -> Vec<f64> {
        Vec::new()
    }
    fn fastest_rad_per_s(&self) -> f64 {
        1.0
    }
    fn term(&self, _: usize, time_s: f64, _: f64) -> Option<Term> {
        let mut now = Matrix3x2::zeros();
        now[(0, 0)] = -self.stiffness - self.epsilon * time_s.cos();
        let mut before = Matrix3x2::zeros();
        before[(0, 0)] = -self.gain;
        Some(Term { now, before, rate: None })
    }
}

/// Characteristic values of Mathieu's equation at q = 2 (δ = a/4, ε = 2q/4 = 1): a₀, b₁, a₁, b₂
/// from scipy.special.mathieu_a and mathieu_b. On the boundary a multiplier is exactly 1 or −1;
/// with a small |b| it is the largest.
#[test]
fn the_delayed_mathieu_equation_has_its_boundaries() {
    let omega0 = 0.3;
    let modes = [ToolMode {
        omega_rad_per_s: omega0,
        damping_ratio: 1e-12,
        motion: Vector3::new(1.0, 0.0, 0.0),
    }];
    let near = |a: f64, gain: f64, sign: f64| {
        let delta = 0.25 * a + sign * gain;
        let process = DelayedMathieu { stiffness: delta - omega0 * omega0, epsilon: 1.0, gain };
        Exact::new(&modes, &process).multiplier(1.0).unwrap()
    };
    // a₀ and b₂ (period 2π in t) with δ − b; b₁ and a₁ (period 4π) with δ + b.
    for (a, sign, expected, largest_gain) in [
        (-1.513_956_885_056_520_2, 1.0, 1.0, 0.006),
        (-1.390_676_501_225_323_2, -1.0, -1.0, 0.006),
        (2.379_199_880_488_686, -1.0, -1.0, -0.1),
        (3.672_232_706_497_191, 1.0, 1.0, -0.1),
    ] {
        for gain in [0.5 * largest_gain, largest_gain] {
            let found = near(a, gain, sign);
            println!("a = {a}, b = {gain}: {found}");
            let off = (found - nalgebra::Complex::from(expected)).norm();
            assert!(off < 1e-9, "{a} {gain}: {found}");
        }
    }
}

/// 100 kg, 18 and 20 Hz on axes at 35°, c = 2·0.02·2π·19 per second, 2·10⁸ N/m² at 70°: figures of
/// issue 18, by eigenvalues of the equations of motion.
#[test]
fn modes_feed_each_other_without_regeneration() {
    let damping = 0.02 * TAU * 19.0;
    let of = |hz: f64, axis_deg: f64| mode(hz, damping / (TAU * hz), 100.0, axis_deg);
    let modes = [of(18.0, 35.0), of(20.0, 125.0)];
    let (y, x) = 70.0_f64.to_radians().sin_cos();
    let mut mean = Matrix3x2::zeros();
    mean[(0, 0)] = -2e8 * x;
    mean[(1, 0)] = -2e8 * y;
    let found = coupling_limit(&modes, &mean).unwrap();
    agree(found.depth_m, 0.892046e-3, 1e-6);
    agree(found.frequency_hz, 19.228, 2e-5);
    assert_eq!(found.kind, Kind::Coupling);
}

/// On a flip u(t − τ) = −u(t): the tip obeys an ordinary differential equation with twice the
/// directional coefficient, whose multiplier is −1. The equation is integrated by Runge and Kutta.
#[test]
fn a_flip_is_an_ordinary_equation_with_twice_the_coefficient() {
    let (zeta, mass) = (0.011, 0.03993);
    let modes = [mode(922.0, zeta, mass, 0.0)];
    let omega = TAU * 922.0;
    // Down-milling of a twentieth of the diameter.
    let entry_rad = PI - (1.0_f64 - 0.1).acos();
    let cut = Cut { engagement: Engagement { entry_rad, exit_rad: PI }, ..slot(2) };
    let chart = Chart::new(&modes, &cut);
    let mut flips = 0;
    for rpm in [16_500.0, 17_500.0, 18_200.0, 19_000.0] {
        let limit = milling_limit(&modes, &cut, &chart, rpm).unwrap().unwrap();
        println!("{rpm}: {limit:?}, zeroth {:?}", chart.limit(rpm).map(|l| l.depth_m));
        if limit.kind != Kind::Flip {
            continue;
        }
        flips += 1;
        let tau = 30.0 / rpm;
        let halves = limit.frequency_hz * tau * 2.0;
        assert!((halves - halves.round()).abs() < 1e-5 && (halves.round() as i64) % 2 == 1);
        let turning = TAU * rpm / 60.0;
        let enters = entry_rad / turning;
        let mut columns = [[1.0, 0.0], [0.0, omega]];
        for y in &mut columns {
            // Either side of where the tooth enters by itself.
            for (from, to, cuts) in [(0.0, enters, 0.0), (enters, tau, 1.0)] {
                let rate = |t: f64, [x, v]: [f64; 2]| {
                    let (s, c) = (turning * t).sin_cos();
                    let h = cuts * (-6e8 * s * c - 2e8 * s * s);
                    let force = 2.0 * limit.depth_m * h * x;
                    [v, force / mass - 2.0 * zeta * omega * v - omega * omega * x]
                };
                let steps = 20_000;
                let dt = (to - from) / f64::from(steps);
                for i in 0..steps {
                    let t = from + f64::from(i) * dt;
                    let step =
                        |y: &[f64; 2], k: [f64; 2], by: f64| [y[0] + by * k[0], y[1] + by * k[1]];
                    let k1 = rate(t, *y);
                    let k2 = rate(t + 0.5 * dt, step(y, k1, 0.5 * dt));
                    let k3 = rate(t + 0.5 * dt, step(y, k2, 0.5 * dt));
                    let k4 = rate(t + dt, step(y, k3, dt));
                    for j in 0..2 {
                        y[j] += dt / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
                    }
                }
            }
        }
        let [[a, c], [b, d]] = columns;
        let (trace, determinant) = (a + d / omega, a * d / omega - b * c / omega);
        // −1 is an eigenvalue: 1 + trace + determinant = 0.
        let off = (1.0 + trace + determinant) / (1.0 + determinant);
        assert!(off.abs() < 1e-7, "{rpm}: {off:e}");
    }
    assert!(flips >= 1);
}

/// Uneven pitch whose angles are nearly even is nearly even pitch, though it goes another way: a
/// turn, several delays, places between nodes.
#[test]
fn uneven_pitch_goes_over_into_even_pitch() {
    let modes = [mode(410.0, 0.03, 0.4, 20.0), mode(930.0, 0.02, 0.06, 80.0)];
    let even = Cut { engagement: Engagement { entry_rad: 1.8, exit_rad: PI }, ..slot(3) };
    let off = 1e-7;
    let third = TAU / 3.0;
    let uneven = Cut { pitch_rad: vec![third + off, third - off, third], ..even.clone() };
    assert!(uneven.even_pitch_rad().is_none());
    for rpm in [3_000.0, 7_700.0] {
        for depth in [0.2e-3, 1e-3] {
            let a = milling_radius(&modes, &even, rpm, depth).unwrap();
            let b = milling_radius(&modes, &uneven, rpm, depth).unwrap();
            println!("{rpm} {depth}: {a} {:.1e}", a - b);
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
        let of = |cut: &Cut| Chart::new(&modes, cut).limit(rpm).unwrap().depth_m;
        agree(of(&even), of(&uneven), 1e-5);
    }
}

/// A helix of one axial pitch at the depth makes the directional matrix constant: the zeroth order
/// is exact there.
#[test]
fn a_helix_of_one_pitch_makes_the_cut_even() {
    let depth = 0.6e-3;
    let entry_rad = 2.2;
    let straight = Cut { engagement: Engagement { entry_rad, exit_rad: PI }, ..slot(2) };
    let cut = Cut { lag_rad_per_m: PI / depth, ..straight };
    let milling = Milling::new(&cut, 5000.0);
    let at = |time: f64| milling.term(0, time, depth).unwrap().now;
    let mean = cut.mean() * depth;
    for share in [0.1, 0.35, 0.77, 0.95] {
        let off = (at(share * milling.period_s()) - mean).norm();
        assert!(off < 1e-9 * mean.norm(), "{share}: {off}");
    }
}

/// Under constant coefficients process damping is damping of the mode: C b / v adds C b / (2 v m ω)
/// to ζ (Tyler, Troutman & Schmitz, Precision Engineering 46, 2016, 65).
#[test]
fn process_damping_of_turning_is_damping_of_its_mode() {
    let (hz, zeta, mass, per_depth) = (150.0, 0.03, 12.0, 1.5e9);
    let (delay_s, n_s_per_m2) = (0.02, 4e6);
    let mut worst = 0.0_f64;
    for depth_m in [2e-5, 1e-4, 5e-4] {
        let damped = Turning { delay_s, n_per_m2: per_depth, n_s_per_m2 };
        let found = Exact::new(&[mode(hz, zeta, mass, 0.0)], &damped).multiplier(depth_m).unwrap();
        let more = zeta + n_s_per_m2 * depth_m / (2.0 * mass * TAU * hz);
        let plain = Turning { delay_s, n_per_m2: per_depth, n_s_per_m2: 0.0 };
        let expected =
            Exact::new(&[mode(hz, more, mass, 0.0)], &plain).multiplier(depth_m).unwrap();
        println!("{depth_m} m: {} {}", found.norm(), expected.norm());
        worst = worst.max((found.norm() - expected.norm()).abs());
    }
    assert!(worst < 1e-9, "{worst}");
}

/// In a slot of four teeth all coefficients are constant, those of process damping, too: both
/// methods agree, by eigenvalues along the frequency and by the motion over a tooth.
#[test]
fn process_damping_raises_the_limit_at_slow_speeds() {
    let (hz, zeta, mass) = (922.0, 0.011, 0.03993);
    let (c, diameter_m) = (2e5, 0.012);
    let damped = |teeth| Cut { rubbing_n_per_m2: 2.0 * c / diameter_m, ..slot(teeth) };
    let both = [mode(hz, zeta, mass, 0.0), mode(hz, zeta, mass, 90.0)];
    for rpm in [3_000.0, 5_000.0, 13_830.0] {
        let cut = damped(4);
        let chart = Chart::new(&both, &cut);
        let zeroth = chart.limit(rpm).unwrap();
        let exact = milling_limit(&both, &cut, &chart, rpm).unwrap().unwrap();
        println!("{rpm} rpm: {} {}", zeroth.depth_m, exact.depth_m);
        agree(zeroth.depth_m, exact.depth_m, 1e-6);
        let plain = Chart::new(&both, &slot(4)).limit(rpm).unwrap();
        assert!(exact.depth_m > plain.depth_m, "{rpm} rpm");
    }
    let rise = |rpm: f64| {
        let cut = damped(2);
        let of = |cut: &Cut| {
            milling_limit(&both, cut, &Chart::new(&both, cut), rpm).unwrap().unwrap().depth_m
        };
        of(&cut) / of(&slot(2))
    };
    let (slow, fast) = (rise(2_000.0), rise(11_000.0));
    println!("the limit rises {slow} times at 2000 rpm, {fast} times at 11000 rpm");
    assert!(slow > 2.0 && slow > 1.5 * fast && fast > 1.0, "{slow} {fast}");
}

/// The side of 1 takes fewer steps than all digits: it is the same, also next to the limit.
#[test]
fn a_motion_grows_where_its_radius_is_above_one() {
    let arm = [14.0, 19.0, 27.0, 48.0, 77.0, 120.0].iter().enumerate();
    let mut modes: Vec<ToolMode> =
        arm.map(|(i, hz)| mode(*hz, 0.03, 80.0 / (1.0 + i as f64), 57.0 * i as f64)).collect();
    modes.extend([mode(900.0, 0.02, 0.3, 0.0), mode(950.0, 0.02, 0.3, 90.0)]);
    let mut sides = [0, 0];
    for (teeth, rpm) in [(2, 1100.0), (2, 9000.0), (3, 4000.0), (4, 14000.0), (4, 24000.0)] {
        let mut cut = slot(teeth);
        cut.engagement = Engagement { entry_rad: PI / 2.0, exit_rad: PI };
        let chart = Chart::new(&modes, &cut);
        let limit = milling_limit(&modes, &cut, &chart, rpm).unwrap().unwrap().depth_m;
        for share in [0.1, 0.3, 0.6, 0.9, 0.99, 1.0 - 1e-6, 1.0 + 1e-6, 1.01, 1.3, 2.0, 3.0] {
            let radius = milling_radius(&modes, &cut, rpm, share * limit).unwrap();
            let grows = milling_grows(&modes, &cut, rpm, share * limit).unwrap();
            assert_eq!(grows, radius > 1.0, "{teeth} teeth, {rpm} rpm, {share}: {radius}");
            sides[usize::from(grows)] += 1;
        }
    }
    assert!(sides.iter().all(|&count| count > 15), "{sides:?}");
}
