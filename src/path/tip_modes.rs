//! How each mode moves the tool tip at places of a path, by the batch kernel.

use nalgebra::{Isometry3, Matrix6xX, Unit, Vector3};

use super::batch::located;
use super::surveyor::{no_modes_at, not_reached_at};
use super::timed_path::{Path, PathReader};
use crate::model::{Placement, elastic_jacobian, forward_kinematics};
use crate::modes::batch::{Kernel, ModesOut};
use crate::motion::Work;
use crate::notes::Note;

/// The modes of the arm at one place of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct TipModes {
    /// Where, 0..=1.
    pub s: f64,
    /// Pose of the tool centre point in the base frame.
    pub tcp: Isometry3<f64>,
    /// f_r, Hz, ascending.
    pub natural_frequencies_hz: Vec<f64>,
    /// ζ_r.
    pub damping_ratios: Vec<f64>,
    /// J φ_r, the translational part: how each mode moves the tool centre point, in the base frame,
    /// for a unit of its modal coordinate, m/(√kg m) where all is in SI.
    pub motions: Vec<Vector3<f64>>,
    /// The rotational part: how each mode turns the tool, rad/(√kg m), in the same frame.
    pub turns: Vec<Vector3<f64>>,
    /// Which way the tool tip moves there.
    pub feed: Feed,
}

/// Which way the tool tip moves, as its axis sees it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Feed {
    /// Whether it moves across the axis, so that the feed has a direction.
    pub is_across: bool,
    /// Cosine of the angle between its motion and the axis into the work; zero where it stands.
    pub into_work: f64,
}

/// The feed's direction is read over this share of the path.
const NEARBY: f64 = 1e-5;

/// The modes at each of `s` (0..=1) with their motions and turns in the tool's frame: x along the
/// feed, z along the spindle out of the work, y = z × x.
///
/// # Errors
/// The first place that the arm does not reach, or at which it has no modes.
pub fn tip_modes_of_tool(path: &Path, s: &[f64]) -> Result<Vec<TipModes>, Note> {
    let frames = tool_frames(path, s)?;
    let mut all = tip_modes(path, s)?;
    for (at, (axes, feed)) in all.iter_mut().zip(frames) {
        at.feed = feed;
        for vector in at.motions.iter_mut().chain(&mut at.turns) {
            *vector = Vector3::from(axes.map(|axis| axis.dot(vector)));
        }
    }
    Ok(all)
}

/// x, y and z of the tool's frame in the base frame at each of `s` (0..=1).
///
/// # Errors
/// The first place that the arm does not reach.
pub fn tool_frames(path: &Path, s: &[f64]) -> Result<Vec<ToolFrame>, Note> {
    let mut tips = Tips::of(path);
    let frame = |&s: &f64| {
        let around = [(s - NEARBY).max(0.0), s, (s + NEARBY).min(1.0)];
        let mut read = [Isometry3::identity(); 3];
        for (read, own) in read.iter_mut().zip(around) {
            [*read, _] = tips.at(own)?;
        }
        let Some((work, tcp, share)) = path.led_at(s) else {
            return Ok(tool_axes(&read[1], &Vector3::zeros()));
        };
        let tool = |tip: &Isometry3<f64>| if *work == Work::Held { *tcp } else { tip * tcp };
        // Where the tool is in the work, in directions of the base frame.
        let axes = work.frame(share(s), &read[1]).rotation;
        let in_work = |i: usize| {
            let (frame, at) = (work.frame(share(around[i]), &read[i]), tool(&read[i]));
            axes * frame.inverse_transform_point(&at.translation.vector.into()).coords
        };
        let ([before, at, after], tool) = ([0, 1, 2].map(in_work), tool(&read[1]));
        let (axes, _) = tool_axes(&tool, &(after - before));
        // The feed at a waypoint is that of the move that leads to it.
        let step = if s > 0.0 { at - before } else { after - at };
        Ok((axes, tool_axes(&tool, &step).1))
    };
    s.iter().map(frame).collect()
}

/// Reads where the tip is along a path.
struct Tips<'p, 'a> {
    path: &'p Path<'a>,
    reader: PathReader<'p, 'a>,
    placement: Placement,
    q: Vec<f64>,
}

impl<'p, 'a> Tips<'p, 'a> {
    fn of(path: &'p Path<'a>) -> Self {
        let robot = path.robot();
        Self {
            path,
            reader: path.reader(),
            placement: Placement::new(robot),
            q: vec![0.0; robot.joints().len()],
        }
    }

    /// The pose of the tip in the base frame, and of the tool in the tip frame.
    fn at(&mut self, s: f64) -> Result<[Isometry3<f64>; 2], Note> {
        let robot = self.path.robot();
        let tcp = self.reader.at(s, &mut self.q);
        let tcp = tcp.map_err(|fault| not_reached_at(self.path, s, &fault))?;
        self.placement.place(robot, &self.q);
        Ok([forward_kinematics(robot, &self.placement), tcp])
    }
}

/// x, y and z of the tool's frame in the base frame, and which way the tool tip moves.
pub type ToolFrame = ([Vector3<f64>; 3], Feed);

/// The frame for a step of the tool centre point.
fn tool_axes(tcp: &Isometry3<f64>, step: &Vector3<f64>) -> ToolFrame {
    // The TCP's z axis points from the spindle into the work.
    let z = -(tcp.rotation * Vector3::z());
    // Where the tool stands or plunges there is no feed direction: any will do.
    let across = Unit::try_new(step - z * z.dot(step), 1e-6 * step.norm());
    let any = || Unit::new_normalize(tcp.rotation * Vector3::x());
    let x = across.unwrap_or_else(any).into_inner();
    let into_work = match step.norm() {
        0.0 => 0.0,
        length => -z.dot(step) / length,
    };
    ([x, z.cross(&x), z], Feed { is_across: across.is_some(), into_work })
}

/// The pose of the tool centre point in the base frame at each of `s` (0..=1).
///
/// # Errors
/// The first place that the arm does not reach.
pub fn tcp_poses(path: &Path, s: &[f64]) -> Result<Vec<Isometry3<f64>>, Note> {
    let mut tips = Tips::of(path);
    s.iter().map(|&s| tips.at(s).map(|[tip, tcp]| tip * tcp)).collect()
}

/// The modes at each of `s` (0..=1).
///
/// # Errors
/// The first place at which the arm has no modes.
pub fn tip_modes(path: &Path, s: &[f64]) -> Result<Vec<TipModes>, Note> {
    let robot = path.robot();
    let (n, joints) = (robot.coordinates().len(), robot.joints().len());
    let mut reader = path.reader();
    let mut poses = vec![0.0; s.len() * joints];
    let mut tcps = Vec::with_capacity(s.len());
    for (&s, q) in s.iter().zip(poses.chunks_mut(joints)) {
        let tcp = reader.at(s, q);
        tcps.push(tcp.map_err(|fault| not_reached_at(path, s, &fault))?);
    }
    let mut frequencies_hz = vec![0.0; s.len() * n];
    let mut shapes = vec![0.0; s.len() * n * n];
    let mut damping_ratios = vec![0.0; s.len() * n];
    let out = ModesOut {
        natural_frequencies_hz: &mut frequencies_hz,
        shapes: &mut shapes,
        damping_ratios: &mut damping_ratios,
    };
    Kernel::new(robot).par_modes(&poses, out).map_err(|fault| {
        let (i, fault) = located(fault, 0);
        no_modes_at(path, s[i], &fault)
    })?;
    let mut placement = Placement::new(robot);
    let mut jacobian = Matrix6xX::zeros(n);
    let places = s.iter().zip(tcps).enumerate().map(|(i, (&s, tcp))| {
        placement.place(robot, &poses[i * joints..][..joints]);
        let at = tcp.translation.vector.into();
        elastic_jacobian(robot, &placement, &at, &mut jacobian);
        let rows = |from: usize| {
            let column = |k: usize| jacobian.fixed_view::<3, 1>(from, k).into_owned();
            let of = |shape: &[f64]| (0..n).map(|k| column(k) * shape[k]).sum();
            shapes[i * n * n..][..n * n].chunks(n).map(of).collect()
        };
        TipModes {
            s,
            tcp: forward_kinematics(robot, &placement) * tcp,
            natural_frequencies_hz: frequencies_hz[i * n..][..n].to_vec(),
            damping_ratios: damping_ratios[i * n..][..n].to_vec(),
            motions: rows(0),
            turns: rows(3),
            feed: Feed::default(),
        }
    });
    Ok(places.collect())
}
