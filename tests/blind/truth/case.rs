//! One blind case: an arm, what is hidden in it, poses, noise, and the table that an experimenter would write.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::arm::Arm;
use super::dice::Dice;
use super::drawing::effect;
use super::effects::{BEYOND, Change, Effect, Known};
use super::robots::{Family, arm, pose, pose_of, row_at};
use super::world::{Row, World};
use super::write::{self, Columns};

/// What a table is rounded to, Hz.
const STEP_HZ: f64 = 0.05;

/// Effects whose signatures are more alike than this are one effect to anybody who sees frequencies alone.
const MAX_ALIKE: f64 = 0.95;

/// Draws before a case counts as impossible.
const MAX_DRAWS: u64 = 400;

/// Causes that may be hidden together.
const TOGETHER: [&str; 12] = [
    "joint_stiffness",
    "link_inertia",
    "com_offset",
    "joint_zero_offset",
    "payload",
    "base_compliance",
    "transverse_compliance",
    "link_flexibility",
    "drive_inertia",
    "load_dependent_stiffness",
    "amplitude_dependence",
    "temperature_drift",
];

/// What is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scenario {
    Nothing,
    Single(&'static str),
    /// So many effects at different places.
    Several(usize),
    /// An effect that the vocabulary lacks.
    Beyond(&'static str),
}

impl Scenario {
    pub(crate) fn name(self) -> String {
        match self {
            Self::Nothing => "nothing".to_owned(),
            Self::Single(cause) | Self::Beyond(cause) => cause.to_owned(),
            Self::Several(count) => format!("{count} effects"),
        }
    }
}

/// How far an effect moves the frequencies (root mean square over poses and modes, relative), in units of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Strength {
    /// 4 to 12.
    Plain,
    /// 2 to 4.
    Weak,
}

impl Strength {
    fn range(self) -> [f64; 2] {
        match self {
            Self::Plain => [4.0, 12.0],
            Self::Weak => [2.0, 4.0],
        }
    }
}

/// What to draw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Order {
    pub(crate) family: Family,
    pub(crate) scenario: Scenario,
    pub(crate) strength: Strength,
    /// Fewest and most poses.
    pub(crate) poses: [usize; 2],
    pub(crate) seed: u64,
}

/// An effect with its size.
#[derive(Debug, Clone)]
pub(crate) struct Hidden {
    pub(crate) effect: Effect,
    pub(crate) size: f64,
    /// Root mean square of the relative change that it alone makes, over the noise.
    pub(crate) over_noise: f64,
    pub(crate) known: Vec<Known>,
}

/// A blind case.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) order: Order,
    /// What the robot file says.
    pub(crate) nominal: Arm,
    pub(crate) hidden: Vec<Hidden>,
    pub(crate) world: World,
    pub(crate) rows: Vec<Row>,
    pub(crate) modes: usize,
    /// Standard deviation of the relative noise.
    pub(crate) noise: f64,
    /// Noise and rounding together, relative: the best that any model can do.
    pub(crate) floor: f64,
    /// The same as it came out in this table: heavy tails make a difference.
    pub(crate) realised: f64,
    heavy_tails: bool,
    columns: Columns,
    pub(crate) measured_hz: Vec<Vec<Option<f64>>>,
}

impl Case {
    /// The case of an order, or `None` where the arm has no such effect of that size.
    pub(crate) fn draw(order: Order) -> Option<Self> {
        (0..MAX_DRAWS).find_map(|attempt| Self::attempt(order, attempt))
    }

    /// `family-scenario-strength-seed`, fit for a folder.
    pub(crate) fn name(&self) -> String {
        let Order { family, scenario, strength, seed, .. } = self.order;
        let strength = if strength == Strength::Weak { "-weak" } else { "" };
        let scenario = scenario.name().replace(' ', "-");
        format!("{}-{scenario}{strength}-{seed}", family.name())
    }

    fn attempt(order: Order, attempt: u64) -> Option<Self> {
        let mut dice = Dice::new(mix(order, attempt));
        let dice = &mut dice;
        let mut nominal = arm(order.family, dice);
        if order.scenario == Scenario::Single("gravity_stiffness") {
            // Gravity's share of K is g / (r ω²): it shows in arms that rock at a hertz or two.
            let first_hz = World::of(&nominal).frequencies_hz(&row_at(pose(&nominal, dice)), 1)[0];
            let softer = (dice.even(1.2, 2.6) / first_hz).powi(2);
            for joint in &mut nominal.joints {
                joint.stiffness_nm_per_rad = (joint.stiffness_nm_per_rad * softer).round();
            }
        }
        let [fewest, most] = order.poses;
        let rows = rows(order.family, &nominal, dice.between(fewest, most), dice);
        let n = nominal.joints.len();
        let modes = if nominal.planar { n } else { dice.between(3, n) };
        let small = order.scenario == Scenario::Single("gravity_stiffness");
        let noise = dice.log_even(0.003, if small { 0.004 } else { 0.01 });
        let plain = World::of(&nominal);
        let floor = noise.hypot(rounding(&plain, &rows, modes));
        let wanted: Vec<&'static str> = match order.scenario {
            Scenario::Nothing => Vec::new(),
            Scenario::Single(cause) | Scenario::Beyond(cause) => vec![cause],
            Scenario::Several(count) => (0..count).map(|_| dice.pick(&TOGETHER)).collect(),
        };
        let mut hidden: Vec<Hidden> = Vec::new();
        let mut signatures: Vec<Vec<f64>> = Vec::new();
        for cause in wanted {
            let effect = effect(cause, &nominal, &rows, modes, dice)?;
            if hidden.iter().any(|other| other.effect.at[0] == effect.at[0]) {
                return None;
            }
            let [low, high] = order.strength.range();
            let multiple = dice.even(low, high);
            let size = size_for(&effect.change, &plain, &rows, modes, multiple * floor)?;
            let signature = signature(&plain, &with(&plain, &effect.change, size), &rows, modes);
            let over_noise = rms(&signature) / floor;
            let gravity = matches!(effect.change, Change::Gravity);
            if over_noise < low || gravity && over_noise > high {
                return None;
            }
            if signatures.iter().any(|s| alike(s, &signature) > MAX_ALIKE) {
                return None;
            }
            let known = effect.change.known(&plain, size);
            signatures.push(signature);
            hidden.push(Hidden { effect, size, over_noise, known });
        }
        let mut world = plain;
        for part in &hidden {
            part.effect.change.apply(&mut world, part.size);
        }
        let has = |cause: &str| hidden.iter().any(|part| part.effect.cause == cause);
        let columns = Columns {
            temperature: has("temperature_drift") || dice.chance(0.2),
            payload: rows.iter().any(|row| row.payload_kg > 0.0) || dice.chance(0.1),
            deviations: dice.chance(0.15).then_some(noise),
            amplitude: has("amplitude_dependence") || dice.chance(0.2),
            sample_rate_hz: world.instrument.sample_rate_hz.or_else(|| {
                // Fast enough for all that is measured, and of no use.
                let top = rows.iter().flat_map(|row| world.frequencies_hz(row, modes));
                let top = top.fold(0.0, f64::max);
                dice.chance(0.2).then(|| (top / 20.0).ceil() * 50.0)
            }),
        };
        let heavy_tails = dice.chance(0.2);
        let mut case = Self {
            order,
            nominal,
            hidden,
            world,
            rows,
            modes,
            noise,
            floor,
            realised: floor,
            heavy_tails,
            columns,
            measured_hz: Vec::new(),
        };
        case.measured_hz = case.rows.iter().map(|row| case.measure(row, dice)).collect();
        if dice.chance(0.2) {
            for cells in &mut case.measured_hz {
                // The first stays, so that no row is empty.
                for cell in cells.iter_mut().skip(1) {
                    if dice.chance(0.05) {
                        *cell = None;
                    }
                }
            }
        }
        case.realised = case.realised_noise();
        Some(case)
    }

    /// Root mean square of the relative error of the table.
    fn realised_noise(&self) -> f64 {
        let mut errors = Vec::new();
        for (row, measured) in self.rows.iter().zip(&self.measured_hz) {
            let seen = self.world.seen_hz(row, self.modes);
            let both = seen.iter().zip(measured).filter_map(|(seen, f)| Some(((*f)?, (*seen)?)));
            errors.extend(both.map(|(f, seen)| f / seen - 1.0));
        }
        rms(&errors)
    }

    /// One row as written down: noisy, ascending, rounded.
    fn measure(&self, row: &Row, dice: &mut Dice) -> Vec<Option<f64>> {
        let seen = self.world.seen_hz(row, self.modes);
        let mut noisy: Vec<f64> = seen
            .iter()
            .flatten()
            .map(|f| {
                let error = if self.heavy_tails { dice.student(4) } else { dice.normal() };
                f * (1.0 + self.noise * error)
            })
            .collect();
        noisy.sort_by(f64::total_cmp);
        let rounded = noisy.iter().map(|f| Some((f / STEP_HZ).round() * STEP_HZ));
        rounded.chain(std::iter::repeat(None)).take(self.modes).collect()
    }

    /// The table.
    pub(crate) fn table(&self) -> String {
        write::table(&self.nominal, &self.rows, &self.measured_hz, self.columns)
    }

    /// The case with further poses measured; circumstances and noise from a seed.
    pub(crate) fn measured_also_at(&self, poses_rad: &[Vec<f64>], seed: u64) -> Self {
        let mut dice = Dice::new(mix(self.order, seed ^ 0x5eed));
        let mut case = self.clone();
        for joints_rad in poses_rad {
            let previous = case.rows.last().map(|row| row.joints_rad.clone());
            let drift = case.rows.last().map_or(20.0, |row| row.temperature_c);
            let row = circumstances(joints_rad.clone(), 0.0, previous, drift, &mut dice);
            case.measured_hz.push(self.measure(&row, &mut dice));
            case.rows.push(row);
        }
        case.realised = case.realised_noise();
        case
    }

    /// Writes robot, table and truth into a folder.
    pub(crate) fn write(&self, folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        write::robot(&self.nominal, folder);
        fs::write(folder.join("measured.csv"), self.table()).unwrap();
        let truth = serde_json::to_string_pretty(&self.truth()).unwrap();
        fs::write(folder.join("truth.json"), truth).unwrap();
    }

    /// What is hidden, for people.
    pub(crate) fn truth(&self) -> Value {
        let hidden: Vec<Value> = self
            .hidden
            .iter()
            .map(|part| {
                let known: Vec<Value> = part
                    .known
                    .iter()
                    .map(|k| json!({"ending": k.ending, "nominal": k.nominal, "value": k.value}))
                    .collect();
                json!({
                    "cause": part.effect.cause,
                    "at": part.effect.at,
                    "size": part.size,
                    "over_noise": part.over_noise,
                    "change": format!("{:?}", part.effect.change),
                    "known": known,
                })
            })
            .collect();
        json!({
            "case": self.name(),
            "hidden": hidden,
            "beyond_vocabulary": self.is_beyond(),
            "poses": self.rows.len(),
            "modes": self.modes,
            "noise": self.noise,
            "noise_and_rounding": self.floor,
            "realised_noise": self.realised,
            "heavy_tails": self.heavy_tails,
        })
    }

    /// The best that any model can do: the noise as drawn, or as it was to be if that is more.
    pub(crate) fn noise_to_beat(&self) -> f64 {
        self.floor.max(self.realised)
    }

    /// Whether the vocabulary lacks what is hidden.
    pub(crate) fn is_beyond(&self) -> bool {
        self.hidden.iter().any(|part| BEYOND.contains(&part.effect.cause))
    }
}

/// A seed from an order and an attempt.
fn mix(order: Order, attempt: u64) -> u64 {
    let text = format!("{order:?} {attempt}");
    // FNV-1a: the same on every machine.
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// A morning's work: poses at random, a hall that warms up, hammer blows of several strengths.
fn rows(family: Family, arm: &Arm, count: usize, dice: &mut Dice) -> Vec<Row> {
    let (from, to) = (dice.even(12.0, 20.0), dice.even(26.0, 40.0));
    // One test in eight is repeated with masses that were weighed.
    let weighed = dice.chance(0.12);
    let known_kg = |dice: &mut Dice| if weighed { dice.pick(&[0.0, 2.0, 5.0]) } else { 0.0 };
    let mut rows: Vec<Row> = Vec::with_capacity(count);
    for i in 0..count {
        let drift = from + (to - from) * i as f64 / count as f64;
        let previous = rows.last().map(|row| row.joints_rad.clone());
        rows.push(circumstances(pose_of(family, arm, dice), known_kg(dice), previous, drift, dice));
    }
    rows
}

fn circumstances(
    joints_rad: Vec<f64>,
    payload_kg: f64,
    previous: Option<Vec<f64>>,
    drift_c: f64,
    dice: &mut Dice,
) -> Row {
    Row {
        previous_rad: previous.unwrap_or_else(|| vec![0.0; joints_rad.len()]),
        joints_rad,
        payload_kg,
        temperature_c: ((drift_c + dice.normal()) * 10.0).round() / 10.0,
        amplitude_nm: (dice.log_even(4.0, 80.0) * 100.0).round() / 100.0,
        unseen: dice.chance(0.5),
        scatter: dice.normal(),
        overlooked: dice.chance(0.3),
    }
}

/// Root mean square of the relative error of rounding.
fn rounding(world: &World, rows: &[Row], modes: usize) -> f64 {
    let relative: Vec<f64> = rows
        .iter()
        .flat_map(|row| world.frequencies_hz(row, modes))
        .map(|f| STEP_HZ / 12_f64.sqrt() / f)
        .collect();
    rms(&relative)
}

fn with(plain: &World, change: &Change, size: f64) -> World {
    let mut world = plain.clone();
    change.apply(&mut world, size);
    world
}

/// Relative change of every frequency that both show.
fn signature(plain: &World, world: &World, rows: &[Row], modes: usize) -> Vec<f64> {
    let mut relative = Vec::with_capacity(rows.len() * modes);
    for row in rows {
        let before = plain.seen_hz(row, modes);
        let after = world.seen_hz(row, modes);
        for (before, after) in before.iter().zip(&after) {
            relative.push(match (before, after) {
                (Some(before), Some(after)) => after / before - 1.0,
                _ => 0.0,
            });
        }
    }
    relative
}

pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Cosine between two signatures.
fn alike(a: &[f64], b: &[f64]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    (dot / (norm(a) * norm(b))).abs()
}

/// A size that moves the frequencies by `wanted` (root mean square, relative) while half of it moves them less; any
/// size where a change has none.
fn size_for(
    change: &Change,
    plain: &World,
    rows: &[Row],
    modes: usize,
    wanted: f64,
) -> Option<f64> {
    let moved = |size: f64| rms(&signature(plain, &with(plain, change, size), rows, modes));
    let most = change.most();
    if !change.has_size() {
        return Some(most);
    }
    if moved(most) < wanted {
        return None;
    }
    let mut high = most;
    let mut low = 0.5 * high;
    while moved(low) >= wanted && low > 1e-6 * most {
        high = low;
        low *= 0.5;
    }
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if moved(middle) >= wanted { high = middle } else { low = middle }
    }
    Some(high)
}
