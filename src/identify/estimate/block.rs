//! Spectra to be fitted, and the poles that are fitted to them.

use nalgebra::Complex;

pub(in crate::identify) type C64 = Complex<f64>;

/// Envelopes that a pole may drift with.
pub(in crate::identify) const MAX_ENVELOPES: usize = 6;

/// Sensors' gain and phase vary over frequency by this share.
pub(in crate::identify) const OF_SENSORS: f64 = 0.01;

/// How a set of spectra came about.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) enum Origin {
    /// Sampled records.
    Sampled {
        /// Time from one sample to the next, s.
        step_s: f64,
        /// Samples in the record.
        samples: usize,
        /// The force where it is not zero; `None` for a free decay.
        force: Option<Vec<ForceSample>>,
    },
    /// Frequency response functions.
    Responses {
        /// Length of the stretches with a Hann window that they were averaged over, s; `None` where
        /// they show no window.
        hann_s: Option<f64>,
    },
}

/// A sample of the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct ForceSample {
    /// When, in steps from the record's first sample.
    pub(in crate::identify) at: f64,
    /// How much.
    pub(in crate::identify) value: f64,
    /// The impact that it belongs to.
    pub(in crate::identify) impact: usize,
}

/// Spectra over the same lines, with the same force.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Block {
    /// How they came about.
    pub(in crate::identify) origin: Origin,
    /// Lines, rad/s, ascending.
    pub(in crate::identify) omega: Vec<f64>,
    /// Spectrum of the force on the lines; empty where it is one.
    pub(in crate::identify) drive: Vec<C64>,
    /// Variance of the force on each line, relative to its power; empty where the force is known
    /// exactly.
    pub(in crate::identify) drive_error: Vec<f64>,
    /// Least variance of a line by response, such as rounding brings; empty where nothing is known.
    pub(in crate::identify) min_noise: Vec<f64>,
    /// Whether the arm may have been moving when the record began.
    pub(in crate::identify) begins_moving: bool,
    /// Amplitudes that poles may drift with.
    pub(in crate::identify) envelopes: Vec<Envelope>,
    /// Whether modes may lie outside of the lines, whose skirts bend the background; and how far
    /// the background bends.
    pub(in crate::identify) is_cut_out: bool,
    pub(in crate::identify) bend: usize,
    /// Power of the loudest line by response, where these lines are cut out of more; else empty.
    pub(in crate::identify) loudest: Vec<f64>,
    /// The spectra, one for each response.
    pub(in crate::identify) spectra: Vec<Vec<C64>>,
}

/// How poles move with an amplitude, in the order in which a fit takes them up.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(in crate::identify) enum Law {
    /// With its square, as springs with a cubic part make them.
    Square,
    /// In proportion, as friction below its slip makes them.
    Proportional,
    /// Less and less, as friction makes them where joints slip through.
    Saturating,
}

impl Law {
    pub(in crate::identify) const ALL: [Self; 3] =
        [Self::Square, Self::Proportional, Self::Saturating];

    /// The move at an amplitude relative to the largest, relative to that there.
    pub(in crate::identify) fn at(self, amplitude: f64) -> f64 {
        /// Amplitude at which about half of the move is done.
        const HALF: f64 = 0.25;
        match self {
            Self::Square => amplitude * amplitude,
            Self::Proportional => amplitude,
            Self::Saturating => amplitude * (1.0 + HALF) / (amplitude + HALF),
        }
    }
}

/// How the amplitude of one mode goes in a block.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Envelope {
    /// Natural frequency of the mode, rad/s.
    pub(in crate::identify) omega: f64,
    pub(in crate::identify) law: Law,
    /// The law's value at each sample, 1 at the largest amplitude of all blocks.
    pub(in crate::identify) values: Vec<f64>,
}

/// A pole as it is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::identify) struct Pole {
    /// λ with positive imaginary part, rad/s.
    pub(in crate::identify) lambda: C64,
    /// Whether the force drives it; a disturbance such as a line of the mains goes its own way.
    pub(in crate::identify) is_driven: bool,
    /// Whether it is known from elsewhere: only its residues are fitted.
    pub(in crate::identify) is_held: bool,
    /// By envelope: how far λ moves at its highest, rad/s; `None` where it does not.
    pub(in crate::identify) rates: [Option<C64>; MAX_ENVELOPES],
}

impl Pole {
    pub(in crate::identify) fn new(lambda: C64) -> Self {
        Self { lambda, is_driven: true, is_held: false, rates: [None; MAX_ENVELOPES] }
    }

    /// Complex parameters: λ and the rates; none where it is held.
    pub(in crate::identify) fn parameters(&self) -> usize {
        if self.is_held { 0 } else { 1 + self.rates.iter().flatten().count() }
    }

    /// Whether it moves with any amplitude.
    pub(in crate::identify) fn drifts(&self) -> bool {
        self.rates.iter().any(Option::is_some)
    }

    /// With its parameters, in that order, moved by real and imaginary parts in turn.
    pub(in crate::identify) fn moved(mut self, steps: &[f64]) -> Self {
        if self.is_held {
            return self;
        }
        let parameters = std::iter::once(&mut self.lambda).chain(self.rates.iter_mut().flatten());
        for (parameter, step) in parameters.zip(steps.chunks_exact(2)) {
            *parameter += C64::new(step[0], step[1]);
        }
        self
    }

    /// From natural frequency and damping ratio.
    pub(in crate::identify) fn from_modal(omega: f64, ratio: f64) -> Self {
        Self::new(C64::new(-ratio * omega, omega * (1.0 - ratio * ratio).max(0.0).sqrt()))
    }

    /// Natural frequency |λ|, rad/s.
    pub(in crate::identify) fn omega(&self) -> f64 {
        self.lambda.norm()
    }

    /// Damping ratio −Re λ/|λ|.
    pub(in crate::identify) fn ratio(&self) -> f64 {
        -self.lambda.re / self.lambda.norm()
    }
}

impl Block {
    /// Spectra without force, noise limits or envelopes.
    pub(in crate::identify) fn new(
        origin: Origin,
        omega: Vec<f64>,
        spectra: Vec<Vec<C64>>,
    ) -> Self {
        Self {
            origin,
            omega,
            drive: Vec::new(),
            drive_error: Vec::new(),
            min_noise: Vec::new(),
            begins_moving: false,
            envelopes: Vec::new(),
            is_cut_out: false,
            bend: 0,
            loudest: Vec::new(),
            spectra,
        }
    }

    /// Whether it is a record of what a measured force drives.
    pub(super) fn is_forced(&self) -> bool {
        matches!(self.origin, Origin::Sampled { force: Some(_), .. })
    }

    /// Whether an analyser made its spectra.
    pub(in crate::identify) fn is_given(&self) -> bool {
        matches!(self.origin, Origin::Responses { .. })
    }

    /// From line to line, rad/s; 0 of one line alone.
    pub(super) fn spacing(&self) -> f64 {
        match self.omega[..] {
            [first, second, ..] => second - first,
            _ => 0.0,
        }
    }

    /// Highest line, rad/s.
    pub(in crate::identify) fn highest(&self) -> f64 {
        self.omega.last().copied().unwrap_or(1.0)
    }

    /// Whether a pole can be evaluated at all.
    pub(in crate::identify) fn admits(&self, pole: &Pole) -> bool {
        match &self.origin {
            // Above half the sampling rate a pole is the image of one below.
            Origin::Sampled { step_s, samples, .. } => {
                // More growth over a record is no vibration, and would overflow.
                pole.lambda.re * step_s * (*samples as f64) < 8.0
                    && pole.lambda.im * step_s < std::f64::consts::PI
            }
            Origin::Responses { .. } => pole.lambda.re < 0.0,
        }
    }

    /// First column of each pole among the columns of the linear problem, and whether a second pair
    /// follows it for the vibration from before the record.
    pub(in crate::identify) fn columns_of(&self, poles: &[Pole]) -> Vec<(usize, bool)> {
        let mut next = 0;
        poles
            .iter()
            .map(|pole| {
                let is_double = pole.is_driven && self.begins_moving;
                let first = next;
                next += if is_double { 4 } else { 2 };
                (first, is_double)
            })
            .collect()
    }

    /// The rates of a pole with the envelopes that they go with.
    pub(in crate::identify) fn rates_of(&self, pole: &Pole) -> Vec<(C64, &[f64])> {
        pole.rates
            .iter()
            .zip(&self.envelopes)
            .filter_map(|(rate, envelope)| Some(((*rate)?, envelope.values.as_slice())))
            .collect()
    }
}
