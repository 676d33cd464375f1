//! What a job asks for: valid, in SI, with the files that it came from. Plain data.

mod accept;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Serialize;

use crate::model::Robot;
use crate::motion::{Move, StatedFeeds, Target, Timing};
use crate::units::hz_from_rpm;

pub use accept::{Acceptable, Acceptance, Accepted, Review, Settings, stretch_of};

/// A job: one robot, one tool, some operations.
#[derive(Debug, Clone)]
pub struct Job {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// The robot that runs it, as its file describes it.
    pub robot: Arc<Robot>,
    /// The spindle.
    pub spindle: Spindle,
    /// The operations in order; at least one.
    pub operations: Vec<Operation>,
    /// When a crossing counts.
    pub policy: Policy,
    /// What may be changed besides speed and feed.
    pub levers: Levers,
    /// Warnings on its files, and which findings it accepts.
    pub review: Review,
}

impl Job {
    /// A file that the job names, as seen from where the job file was named.
    pub fn beside(&self, named: &Path) -> PathBuf {
        self.file.parent().unwrap_or(Path::new("")).join(named)
    }

    /// What the tip carries: in the first operation, or in one of which nobody says it.
    pub fn carried(&self) -> Carried {
        let all = || self.operations.iter().map(|operation| operation.carried);
        all().find(|carried| !carried.is_known()).or(all().next()).unwrap_or(Carried::UNKNOWN)
    }

    /// The file that the lines of an operation's moves refer to: its program, or the job itself.
    pub fn file_of_moves(&self, operation: &Operation) -> PathBuf {
        operation.program.as_ref().map_or_else(|| self.file.clone(), |file| self.beside(file))
    }

    /// The same as it is named: the program by the job, the job by the caller.
    pub fn named_file_of_moves<'a>(&'a self, operation: &'a Operation) -> &'a Path {
        operation.program.as_deref().unwrap_or(&self.file)
    }
}

/// What may be changed besides speed and feed, as far as the job says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Levers {
    /// Other cutters that are on hand.
    pub tools_on_hand: Vec<Tool>,
    /// Per operation, how far the tool may be turned about its own axis, rad: from and to.
    pub free_axis_rad: Vec<Option<[f64; 2]>>,
    /// How far the work object may be moved in the base frame, m: least and most along each axis.
    pub work_object_shift_m: Option<[[f64; 2]; 3]>,
}

/// The cutter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tool {
    /// What it is called.
    pub name: Option<String>,
    /// Number of teeth; at least one.
    pub teeth: u32,
    /// Diameter, m.
    pub diameter_m: Option<f64>,
    /// Angle from each tooth to the next, rad, adding up to one turn; `None` for even pitch.
    pub pitch_rad: Option<Vec<f64>>,
    /// Angle of the flutes to the axis, rad.
    pub helix_rad: f64,
    /// Of a drill: the whole angle of its point, rad, where somebody says it.
    pub point_angle_rad: Option<f64>,
    /// Whether it turns about another axis than its own, where somebody knows it.
    pub runout: Option<Runout>,
    /// How the tool itself vibrates in its holder, where somebody knows it.
    pub modes: Vec<TipMode>,
}

/// A mode of the tool tip, as somebody measured it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipMode {
    /// f, Hz.
    pub frequency_hz: f64,
    /// ζ.
    pub damping_ratio: f64,
    /// What vibrates, as seen at the tip, kg.
    pub mass_kg: f64,
    /// The direction in which the tip moves, of length 1: x along the feed, z out of the work,
    /// y = z × x.
    pub axis: Vector3<f64>,
}

/// Modes of a tool tip and what it cuts: all that a stability lobe needs.
#[derive(Debug, Clone, PartialEq)]
pub struct TipCut {
    /// The modes; at least one.
    pub modes: Vec<TipMode>,
    /// The cutter.
    pub tool: Tool,
    /// The cut; its axial depth is what is sought, and is zero here.
    pub cutting: Cutting,
}

/// The spindle's abilities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spindle {
    /// Lowest speed, rev/min.
    pub min_rpm: f64,
    /// Highest speed, rev/min.
    pub max_rpm: f64,
    /// Fastest change of speed, rev/min per second.
    pub max_acceleration_rpm_per_s: Option<f64>,
}

impl Spindle {
    /// What is assumed where the job states no acceleration, rev/min per second: a figure of no
    /// spindle in particular.
    pub const ASSUMED_ACCELERATION_RPM_PER_S: f64 = 500.0;

    /// Fastest change of speed, stated or assumed, rev/min per second.
    pub fn acceleration_rpm_per_s(&self) -> f64 {
        self.max_acceleration_rpm_per_s.unwrap_or(Self::ASSUMED_ACCELERATION_RPM_PER_S)
    }
}

/// What the tip of the arm carries, and who says so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Carried {
    /// Mass, kg; zero where nothing is carried or nobody says.
    pub mass_kg: f64,
    /// Who says so.
    pub source: CarriedBy,
}

impl Carried {
    /// Nothing, as somebody says.
    pub const NOTHING: Self = Self { mass_kg: 0.0, source: CarriedBy::None };
    /// What nobody says anything about.
    pub const UNKNOWN: Self = Self { mass_kg: 0.0, source: CarriedBy::Unknown };

    /// Whether anybody says what is carried.
    pub fn is_known(self) -> bool {
        self.source != CarriedBy::Unknown
    }
}

/// Who says what the tip carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`program`: its tool data. `job`: the job's payload. `robot`: the robot file's. \
                   `none`: the job says that nothing\nis carried. `unknown`: nobody says anything."
)]
pub enum CarriedBy {
    /// The data of the tool in the program.
    Program,
    /// The job: `payload`, or that of one of its tools.
    Job,
    /// The robot file's payload.
    Robot,
    /// The job: nothing is carried.
    None,
    /// Nobody.
    Unknown,
}

/// One operation: a path, or a stretch of one, under one spindle speed (or schedule), with one
/// cutter and one thing carried. A program that changes any of them makes several operations of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Operation {
    /// What it is called; unique within the job.
    pub name: String,
    /// Which of the operations that the job file lists it belongs to, from 0.
    pub entry: usize,
    /// The cutter.
    pub tool: Tool,
    /// Number of the tool in the program.
    pub tool_number: Option<u32>,
    /// The robot with what it carries here; its kinematics are those of the job's robot.
    pub robot: Arc<Robot>,
    /// What it carries.
    pub carried: Carried,
    /// Line of the job file where it starts, counted from 1.
    pub line: usize,
    /// Spindle speed along the path.
    pub speed: SpindleSpeed,
    /// Whether nobody says where the tool ends: it is taken at the robot's tip.
    pub is_tcp_assumed: bool,
    /// Whether the program states the spindle speed, not the job.
    pub is_speed_of_program: bool,
    /// Where the program sets the speed by what takes whole numbers alone: the steps, rev/min.
    pub speed_step_rpm: Option<f64>,
    /// Feed of the tool centre point, m/s: the job's, else that at which the program cuts longest.
    pub feed_m_per_s: f64,
    /// Whether the job gives the feed.
    pub is_feed_of_job: bool,
    /// How the tool cuts, if the job says it.
    pub cutting: Option<Cutting>,
    /// The moves of the whole path, at least one; a path that is divided is shared.
    pub moves: Arc<Vec<Move>>,
    /// The moves that this operation runs: from the end of the move before, or from the first
    /// target.
    pub stretch: Range<usize>,
    /// The file that the moves' lines refer to: the program as the job names it, or `None` where
    /// the path stands in the job itself.
    pub program: Option<PathBuf>,
    /// Feeds that the program states itself; where it states none, it runs at
    /// [`Self::feed_m_per_s`].
    pub program_feeds: StatedFeeds,
    /// Joint positions near which the first target of a pose path is sought; `None` takes zero.
    pub start_near: Option<Vec<f64>>,
}

impl Operation {
    /// A path that is the job's first and only one.
    pub fn new(
        robot: &Arc<Robot>,
        carried: Carried,
        tool: Tool,
        speed: SpindleSpeed,
        feed_m_per_s: f64,
        moves: Vec<Move>,
    ) -> Self {
        Self {
            name: "path".to_owned(),
            entry: 0,
            tool,
            tool_number: None,
            robot: Arc::clone(robot),
            carried,
            line: 1,
            speed,
            is_tcp_assumed: false,
            is_speed_of_program: false,
            speed_step_rpm: None,
            feed_m_per_s,
            is_feed_of_job: true,
            cutting: None,
            stretch: 0..moves.len(),
            moves: Arc::new(moves),
            program: None,
            program_feeds: StatedFeeds::default(),
            start_near: None,
        }
    }

    /// The least of the feeds at which it moves with the spindle on, m/s; its own where it does so
    /// nowhere.
    pub fn least_feed_m_per_s(&self) -> f64 {
        let has_feed = |each: &&Move| matches!(each.timing, Timing::Feed | Timing::Seconds(_));
        // Nothing moves to where the path starts.
        let moves = self.own_moves().iter().skip(usize::from(self.stretch.start == 0));
        let feeds = moves.filter(has_feed).filter(|each| each.spindle_turns);
        feeds.map(|each| each.feed_m_per_s).reduce(f64::min).unwrap_or(self.feed_m_per_s)
    }

    /// The moves that it runs.
    pub fn own_moves(&self) -> &[Move] {
        self.moves.get(self.stretch.clone()).unwrap_or_default()
    }

    /// Whether it is a stretch of a longer path.
    pub fn is_divided(&self) -> bool {
        self.stretch.len() < self.moves.len()
    }

    /// Whether every target of the path is a pose of the tool, none a position of the joints.
    pub fn has_poses(&self) -> bool {
        !self.moves.iter().any(|each| matches!(each.to, Target::Joints(_)))
    }
}

/// Spindle speed over s.
#[derive(Debug, Clone, PartialEq)]
pub enum SpindleSpeed {
    /// One speed, rev/min; zero where the program has stopped the spindle all along.
    Constant(f64),
    /// (s, rev/min) with s in 0..=1, strictly ascending; linear between, constant before the first
    /// and after the last.
    Schedule(Vec<(f64, f64)>),
}

impl SpindleSpeed {
    /// Speed at s in 0..=1, rev/min.
    pub fn rpm_at(&self, s: f64) -> f64 {
        match self {
            Self::Constant(rpm) => *rpm,
            Self::Schedule(points) => {
                let after = points.partition_point(|&(at, _)| at <= s);
                match (after.checked_sub(1).and_then(|i| points.get(i)), points.get(after)) {
                    (Some(&(s0, rpm0)), Some(&(s1, rpm1))) => {
                        rpm0 + (rpm1 - rpm0) * (s - s0) / (s1 - s0)
                    }
                    (Some(&(_, rpm)), None) | (None, Some(&(_, rpm))) => rpm,
                    (None, None) => 0.0,
                }
            }
        }
    }

    /// Lowest and highest speed over 0..=1, rev/min.
    pub fn range_rpm(&self) -> [f64; 2] {
        let ends = [0.0, 1.0].into_iter().chain(self.corners()).map(|s| self.rpm_at(s));
        ends.fold([f64::INFINITY, 0.0], |[low, high], rpm| [low.min(rpm), high.max(rpm)])
    }

    /// The least feed per revolution at a feed, m.
    pub fn feed_m_per_rev(&self, feed_m_per_s: f64) -> f64 {
        feed_m_per_s / hz_from_rpm(self.range_rpm()[1])
    }

    /// Values of s where the speed has a corner.
    pub fn corners(&self) -> impl Iterator<Item = f64> + '_ {
        let points: &[(f64, f64)] = match self {
            Self::Constant(_) => &[],
            Self::Schedule(points) => points,
        };
        points.iter().map(|&(s, _)| s)
    }
}

/// How the tool cuts.
#[derive(Debug, Clone, PartialEq)]
pub struct Cutting {
    /// Radial depth, m; zero in drilling.
    pub radial_depth_m: f64,
    /// Axial depth, m; zero in drilling.
    pub axial_depth_m: f64,
    /// Climb, conventional, slot or drilling.
    pub direction: CuttingDirection,
    /// Name of the material.
    pub material: String,
    /// The user's own coefficients; the material's where absent.
    pub coefficients: Option<CuttingCoefficients>,
    /// Whether a tooth cuts what the one ahead of it has left; `false` where it meets fresh
    /// material.
    pub regenerates: bool,
    /// C: what the flank rubs with on the waves of the surface, N/m: the force per depth, times the
    /// cutting speed over the speed of the tip against the surface; zero for none, and in drilling.
    pub process_damping_n_per_m: f64,
}

impl Cutting {
    /// The hole, where the tool drills.
    pub fn drill(&self) -> Option<Drill> {
        match self.direction {
            CuttingDirection::Drill(drill) => Some(drill),
            CuttingDirection::Climb | CuttingDirection::Conventional | CuttingDirection::Slot => {
                None
            }
        }
    }
}

/// Cutting and edge coefficients of the mechanistic force model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingCoefficients {
    /// K_tc, tangential, N/m².
    pub tangential_n_per_m2: f64,
    /// K_rc, radial, N/m².
    pub radial_n_per_m2: f64,
    /// K_te, tangential at the edge, N/m.
    pub tangential_edge_n_per_m: f64,
    /// K_re, radial at the edge, N/m.
    pub radial_edge_n_per_m: f64,
    /// K_ac and K_ae, out of the holder, N/m² and N/m, where somebody knows them.
    pub axial: Option<[f64; 2]>,
    /// Kienzle's exponents m, tangential, radial and axial: K falls with the chip's thickness h as
    /// (h / 1 mm)^−m, so that K_tc, K_rc and K_ac hold at 1 mm. Zero: K is the same for all chips.
    pub exponents: [f64; 3],
}

impl CuttingCoefficients {
    /// K_tc, K_rc and K_ac, N/m²; one that nobody knows is zero.
    pub fn cutting_n_per_m2(&self) -> [f64; 3] {
        [self.tangential_n_per_m2, self.radial_n_per_m2, self.axial.map_or(0.0, |[k, _]| k)]
    }

    /// K_te, K_re and K_ae, N/m; one that nobody knows is zero.
    pub fn edge_n_per_m(&self) -> [f64; 3] {
        let axial = self.axial.map_or(0.0, |[_, edge]| edge);
        [self.tangential_edge_n_per_m, self.radial_edge_n_per_m, axial]
    }

    /// Whether the force is linear in the chip's thickness.
    pub fn is_linear(&self) -> bool {
        self.exponents == [0.0; 3]
    }
}

/// The axis about which a cutter turns lies beside its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Runout {
    /// How far, m.
    pub offset_m: f64,
    /// Towards which angle of the cutter, counted from its first tooth as the teeth are, rad.
    pub angle_rad: f64,
}

/// On which side of the cut the chip is thick, or whether the tool drills.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CuttingDirection {
    /// Down-milling.
    Climb,
    /// Up-milling.
    Conventional,
    /// Full width.
    Slot,
    /// Along the tool's axis into the work.
    Drill(Drill),
}

/// A hole that is drilled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drill {
    /// Diameter of the hole that is there before, m; zero where there is none.
    pub pilot_diameter_m: f64,
    /// Thrust, as somebody measured it, N.
    pub thrust_n: Option<f64>,
    /// Torque, likewise, N m.
    pub torque_nm: Option<f64>,
    /// Feed at which they were measured; `None`: nothing bounds them at any feed.
    pub measured_at: Option<MeasuredAt>,
}

/// A feed at which something was measured, m/rev.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeasuredAt {
    /// As the job says.
    Stated(f64),
    /// Nobody says it: the least of the operation at its programmed speeds.
    Programmed(f64),
}

impl MeasuredAt {
    /// The feed, m/rev.
    pub fn m_per_rev(self) -> f64 {
        match self {
            Self::Stated(m_per_rev) | Self::Programmed(m_per_rev) => m_per_rev,
        }
    }
}

impl Drill {
    /// Whether thrust or torque was measured.
    pub fn is_measured(&self) -> bool {
        self.thrust_n.is_some() || self.torque_nm.is_some()
    }
}

/// When an excitation line near a mode counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    /// Multiples of the tooth-passing frequency: 1..=h.
    pub tooth_passing_harmonics: u32,
    /// Multiples of the spindle's frequency: 1..=h; 0 switches them off.
    pub spindle_harmonics: u32,
    /// Half width of a mode's band as a share of its frequency.
    pub separation: f64,
    /// What every frequency may lie off by as a share of it, where the job says it; else the robot
    /// does.
    pub model_uncertainty: Option<f64>,
    /// With which frequencies lie within their intervals, 0..1.
    pub confidence: f64,
    /// Excitation in these bands (Hz, ascending) does not count.
    pub ignore_hz: Vec<[f64; 2]>,
    /// A mode that moves the tip less than this at resonance does not count, m/N; where absent,
    /// less than a hundredth of the operation's largest.
    pub min_tip_response_m_per_n: Option<f64>,
    /// How far the mean cutting force may move the tool tip, m.
    pub max_deflection_m: Option<f64>,
    /// How far the tool tip may vibrate under the cutting force, m.
    pub max_vibration_m: Option<f64>,
}

impl Policy {
    /// Whether excitation at this frequency does not count.
    pub fn ignores(&self, excitation_hz: f64) -> bool {
        self.ignore_hz.iter().any(|[low, high]| (*low..=*high).contains(&excitation_hz))
    }

    /// Whether no excitation from `low_hz` to `high_hz` counts.
    pub fn ignores_all(&self, low_hz: f64, high_hz: f64) -> bool {
        let mut bands = self.ignore_hz.clone();
        bands.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let reached =
            bands.iter().fold(
                low_hz,
                |reached, &[from, to]| {
                    if from <= reached { reached.max(to) } else { reached }
                },
            );
        self.ignores(low_hz) && reached >= high_hz
    }
}
