//! All records of a session → one row of modes for each pose.
//!
//! Records of one pose, taken under the same conditions at the same sampling rate, are merged mode
//! by mode. Deviations of a record are of its noise alone; where records scatter by more, as where
//! the arm was moved or clamped again between them, that scatter is a variance of its own
//! (DerSimonian & Laird, Controlled Clinical Trials 7, 1986). Their shapes are put together by
//! common responses, and a pose that lacks modes has the others in the columns of their shapes.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

use super::links::LinkRotation;
use super::mode::{Mode, ShapePart};
use super::pairing::{SAME_MODE, clusters, paired};
use super::pose::{JointColumn, Pose};
use super::record::{Conditions, Measurement, Session};
use super::record_modes::{IdentifiedRecord, identify_record};
use super::shapes::{Placed, mac, places, together};
use super::table::{MeasuredRotation, ModeRow, ModeTable, RotationAxis};
use crate::notes::{Code, Note, Part, Place};
use crate::progress::{Done, Progress};

/// Sampling rates within this relative distance are equal: times are printed with few digits.
const SAME_RATE: f64 = 1e-5;

/// A mode of a pose, from all of the pose's records.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "JsonPoseMode")]
pub struct PoseMode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub frequency_std_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Standard deviation.
    #[serde(rename = "damping_ratio_std")]
    pub damping_std: f64,
    /// What else it may be, as the code of a notice: such a mode stays out of the table.
    #[schemars(with = "Option<String>")]
    pub suspicion: Option<Code>,
    /// Its column in the table of modes, from 1; null where it stays out.
    pub number: Option<usize>,
    /// Record and mode of it, counted from 0.
    #[schemars(with = "Vec<[usize; 2]>")]
    pub members: Vec<(usize, usize)>,
    /// Over the responses of all records that have one in common; the largest part is 1.
    pub shape: Vec<ShapePart>,
}

/// The modes of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseModes {
    /// Where the robot stood.
    pub pose: Pose,
    /// Under which conditions.
    pub conditions: Conditions,
    /// Names of the measurements, joined by '+'.
    pub id: Option<String>,
    /// Samples per second; `None` for given frequency responses.
    pub sample_rate_hz: Option<f64>,
    /// By ascending frequency.
    pub modes: Vec<PoseMode>,
}

/// What a session gives.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedSession {
    /// In the order in which poses first appear.
    pub poses: Vec<PoseModes>,
    /// One for each record, in the order of the session.
    pub records: Vec<IdentifiedRecord>,
    /// Columns of the joints in the table of modes, where the session names them.
    pub joint_columns: Option<Vec<JointColumn>>,
    /// About several records.
    pub warnings: Vec<Note>,
}

impl IdentifiedSession {
    /// One row a pose: all modes but those that may be something else.
    pub fn table(&self) -> ModeTable<Pose> {
        let all = self.poses.iter().flat_map(|pose| &pose.modes);
        let most = all.filter_map(|mode| mode.number).max().unwrap_or(0);
        let row = |at: &PoseModes| {
            let numbered = |number: usize| at.modes.iter().find(|mode| mode.number == Some(number));
            let values = |of: fn(&PoseMode) -> f64| -> Vec<Option<f64>> {
                (1..=most).map(|number| numbered(number).map(of)).collect()
            };
            ModeRow {
                pose: at.pose.clone(),
                frequencies_hz: values(|mode| mode.frequency_hz),
                deviations_hz: values(|mode| mode.frequency_std_hz),
                damping_ratios: values(|mode| mode.damping_ratio),
                temperature_c: at.conditions.temperature_c,
                amplitude_nm: at.conditions.amplitude_nm,
                payload_kg: at.conditions.payload_kg,
                added_kg: at.conditions.added_kg.clone(),
                rotations: (1..=most)
                    .map(|number| numbered(number).map_or_else(Vec::new, |m| self.rotations(m)))
                    .collect(),
                sample_rate_hz: at.sample_rate_hz,
                id: at.id.clone(),
            }
        };
        ModeTable { rows: self.poses.iter().map(row).collect(), modes: most, unstated: Vec::new() }
    }

    /// How marked links turn in a mode, as the first of its records that shows it has them: as far
    /// as they turn in phase with the one that turns most.
    fn rotations(&self, mode: &PoseMode) -> Vec<MeasuredRotation> {
        let shown = mode.members.iter().filter_map(|&(record, own)| {
            let links = &self.records.get(record)?.modes.get(own)?.links;
            (links.len() > 1).then_some(links)
        });
        let Some(links) = shown.into_iter().next() else { return Vec::new() };
        let most = links.iter().map(|link| link.rotation);
        let most = most.max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        let one = |link: &LinkRotation| MeasuredRotation {
            link: link.link.clone(),
            about: RotationAxis::Joint,
            value: (link.rotation * most.conj()).re / most.norm().max(f64::MIN_POSITIVE),
            std: Some(link.std).filter(|std| *std > 0.0),
        };
        links.iter().map(one).collect()
    }
}

/// Identifies all records and merges those of one pose; `progress` counts records.
pub fn identify_session(session: &Session, progress: Progress<'_>) -> IdentifiedSession {
    let identified = |measurement: &Measurement| {
        let found = identify_record(&measurement.record, &session.asked);
        progress(Done::More(1));
        found
    };
    let mut records: Vec<IdentifiedRecord> = session.records.par_iter().map(identified).collect();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut notes = Vec::new();
    for (index, measurement) in session.records.iter().enumerate() {
        if let Some(first) = session.records[..index].iter().find(|m| is_again(m, measurement)) {
            let what = format!(
                "has the samples of '{}', and counts once with it: a record twice is no second \
                 measurement",
                first.record.name
            );
            let place = Place::part(Part::Record(measurement.record.name.clone()));
            notes.push(Note::warning(Code::Remark, place, what));
            continue;
        }
        let belongs = |group: &&mut Vec<usize>| is_same(&session.records[group[0]], measurement);
        match groups.iter_mut().find(belongs) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    let mut poses: Vec<PoseModes> =
        groups.iter().map(|group| pose_modes(session, &records, group, &mut notes)).collect();
    another_unit_of_time(session, &mut notes);
    aliases_between_rates(&mut poses, &mut records, &mut notes);
    number(&mut poses, &mut notes);
    IdentifiedSession {
        poses,
        records,
        joint_columns: session.joint_columns.clone(),
        warnings: notes,
    }
}

fn rate(measurement: &Measurement) -> Option<f64> {
    measurement.record.data.sample_rate_hz()
}

fn is_same(a: &Measurement, b: &Measurement) -> bool {
    let is_same_rate = match (rate(a), rate(b)) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() <= SAME_RATE,
        (a, b) => a == b,
    };
    a.pose == b.pose && a.conditions == b.conditions && is_same_rate
}

/// Whether a measurement is another one once more.
fn is_again(first: &Measurement, again: &Measurement) -> bool {
    is_same(first, again)
        && first.record.data == again.record.data
        && first.record.links == again.record.links
}

fn pose_modes(
    session: &Session,
    records: &[IdentifiedRecord],
    group: &[usize],
    notes: &mut Vec<Note>,
) -> PoseModes {
    let mut modes: Vec<PoseMode> = clusters(records, group)
        .into_iter()
        .map(|members| merged_mode(records, group, members, notes))
        .collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let first = &session.records[group[0]];
    let mut ids: Vec<&str> =
        group.iter().filter_map(|&i| session.records[i].id.as_deref()).collect();
    ids.dedup();
    PoseModes {
        pose: first.pose.clone(),
        conditions: first.conditions.clone(),
        id: (!ids.is_empty()).then(|| ids.join("+")),
        sample_rate_hz: rate(first),
        modes,
    }
}

fn merged_mode(
    records: &[IdentifiedRecord],
    group: &[usize],
    members: Vec<(usize, usize)>,
    notes: &mut Vec<Note>,
) -> PoseMode {
    // What a clipped record says, or one that is uncertain, bends what others know.
    let is_certain =
        |&(record, mode): &(usize, usize)| records[record].modes[mode].suspicion.is_none();
    let certain: Vec<(usize, usize)> = members.iter().copied().filter(is_certain).collect();
    let used = if certain.is_empty() { &members } else { &certain };
    let values = |of: fn(&Mode) -> (f64, f64)| -> Vec<(f64, f64)> {
        used.iter().map(|&(record, mode)| of(&records[record].modes[mode])).collect()
    };
    let (frequency_hz, frequency_std_hz, ratio) =
        merged(&values(|mode| (mode.frequency_hz, mode.frequency_std_hz)));
    let (damping_ratio, damping_std, _) =
        merged(&values(|mode| (mode.damping_ratio, mode.damping_std)));
    let mut disagreement = |what: String| {
        let names: Vec<&str> = group.iter().map(|&i| records[i].name.as_str()).collect();
        let place = Place::part(Part::Record(names.join(", ")));
        notes.push(Note::warning(Code::Disagreement, place, what));
    };
    if ratio > 3.0 {
        disagreement(format!(
            "the frequencies of the mode at {frequency_hz:.3} Hz scatter {ratio:.1} times as much \
             as the records state, which its standard deviation holds; something changed between \
             the records"
        ));
    }
    let with_modes = group.iter().filter(|&&i| !records[i].modes.is_empty()).count();
    if members.len() < with_modes {
        disagreement(format!(
            "the mode at {frequency_hz:.3} Hz shows in {} of {with_modes} records of its pose",
            members.len()
        ));
    }
    let suspicion = suspicion(members.iter().map(|&(i, mode)| records[i].modes[mode].suspicion));
    let shapes: Vec<&[ShapePart]> =
        used.iter().map(|&(i, mode)| &records[i].modes[mode].shape[..]).collect();
    if let Some(alike) = contradiction(&shapes) {
        disagreement(format!(
            "the records show unlike shapes of the mode at {frequency_hz:.3} Hz (modal assurance \
             criterion {alike:.2}): responses of one name must be sensors in one place; where they \
             were moved, give them other names, or each place a session of its own"
        ));
    }
    PoseMode {
        frequency_hz,
        frequency_std_hz,
        damping_ratio,
        damping_std,
        suspicion,
        number: None,
        shape: together(&shapes),
        members,
    }
}

/// How alike the least alike of some shapes of one mode are, where that is not as noise has it.
fn contradiction(shapes: &[&[ShapePart]]) -> Option<f64> {
    /// Shapes of one mode are more alike.
    const LIKE: f64 = 0.6;
    /// Noise of a shape, as a share of its power, that does not make it unlike.
    const NOISE: f64 = 0.05;
    let is_clear = |shape: &&&[ShapePart]| {
        let sum = |of: fn(&ShapePart) -> f64| shape.iter().map(of).sum::<f64>();
        sum(|part| part.std.powi(2)) < NOISE * sum(|part| part.value.norm_sqr())
    };
    let clear: Vec<&&[ShapePart]> = shapes.iter().filter(is_clear).collect();
    let pairs = clear.iter().enumerate().flat_map(|(i, a)| clear[..i].iter().map(move |b| (a, b)));
    pairs.filter_map(|(a, b)| mac(a, b)).min_by(f64::total_cmp).filter(|alike| *alike < LIKE)
}

/// A tone in one record is a tone in all; a mode that is uncertain in one record may be certain in
/// another.
fn suspicion(members: impl Iterator<Item = Option<Code>> + Clone) -> Option<Code> {
    // What one record cannot say, another may.
    let is_of_record = |code: &Code| matches!(code, Code::Unsettled | Code::Clipping);
    let is_nowhere_certain = members.clone().all(|member| member.is_some());
    let mut found = members.flatten();
    let first = found.next();
    let other = first.into_iter().chain(found).find(|code| !is_of_record(code));
    other.or(first.filter(|_| is_nowhere_certain))
}

/// Weighted mean, its standard deviation, and how many times as much as they state the values
/// scatter (Birge's ratio).
fn merged(values: &[(f64, f64)]) -> (f64, f64, f64) {
    if let [(value, std)] = values {
        return (*value, *std, 0.0);
    }
    // Nothing is known beyond the digits of a number.
    let variance =
        |value: f64, std: f64| std.max(1e-12 * value.abs()).max(f64::MIN_POSITIVE.sqrt()).powi(2);
    let sums = |between: f64| -> [f64; 3] {
        values.iter().fold([0.0; 3], |[w, wx, ww], &(value, std)| {
            let weight = (variance(value, std) + between).recip();
            [w + weight, wx + weight * value, ww + weight * weight]
        })
    };
    let [w, wx, ww] = sums(0.0);
    let chi_squared: f64 =
        values.iter().map(|&(value, std)| (value - wx / w).powi(2) / variance(value, std)).sum();
    let freedom = (values.len() - 1) as f64;
    let between = ((chi_squared - freedom) / (w - ww / w)).max(0.0);
    let [w, wx, _] = sums(between);
    (wx / w, w.recip().sqrt(), (chi_squared / freedom).sqrt())
}

/// Records that are sampled a thousand times as fast as another: milliseconds for seconds.
fn another_unit_of_time(session: &Session, notes: &mut Vec<Note>) {
    const FAR: f64 = 300.0;
    let rates = || session.records.iter().filter_map(|own| Some((rate(own)?, &own.record.name)));
    let Some((slowest, slow)) = rates().min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    for (fast, name) in rates().filter(|(fast, _)| *fast > FAR * slowest) {
        let what = format!(
            "is sampled at {fast:.0} Hz, '{slow}' at {slowest:.0} Hz: is the time of both in the \
             unit that its header says?"
        );
        notes.push(Note::warning(Code::Units, Place::part(Part::Record(name.clone())), what));
    }
}

/// Poses that were recorded at two rates show which frequencies are aliased: those stay out of the
/// table.
fn aliases_between_rates(
    poses: &mut [PoseModes],
    records: &mut [IdentifiedRecord],
    notes: &mut Vec<Note>,
) {
    let mut aliases: Vec<(usize, f64)> = Vec::new();
    for (slow_at, slow) in poses.iter().enumerate() {
        for (fast_at, fast) in
            poses.iter().enumerate().filter(|(_, fast)| is_same_state(slow, fast))
        {
            if let (Some(rate), Some(fast_rate)) = (slow.sample_rate_hz, fast.sample_rate_hz)
                && rate < fast_rate * (1.0 - SAME_RATE)
            {
                let told = alias_between((slow, rate), (fast, fast_rate), notes);
                let both = folded_twice((slow, rate), (fast, fast_rate), &told, notes);
                aliases.extend(told.into_iter().map(|hz| (slow_at, hz)));
                aliases.extend(both.iter().map(|(hz, _)| (slow_at, *hz)));
                aliases.extend(both.iter().map(|(_, other)| (fast_at, *other)));
            }
        }
    }
    for (at, pose) in poses.iter_mut().enumerate() {
        let is_alias = |mode: &&mut PoseMode| aliases.contains(&(at, mode.frequency_hz));
        for mode in pose.modes.iter_mut().filter(is_alias) {
            mode.suspicion.get_or_insert(Code::MayBeFolded);
            for &(record, own) in &mode.members {
                records[record].modes[own].suspicion.get_or_insert(Code::MayBeFolded);
            }
        }
    }
}

fn is_same_state(a: &PoseModes, b: &PoseModes) -> bool {
    a.pose == b.pose && a.conditions == b.conditions
}

fn has(pose: &PoseModes, hz: f64) -> bool {
    pose.modes.iter().any(|mode| (mode.frequency_hz / hz - 1.0).abs() < 0.01)
}

/// Frequencies that are seen as `hz` at a rate, up to ten times that.
fn unfolded(hz: f64, rate: f64) -> Vec<f64> {
    (1..=10).flat_map(|n| [f64::from(n) * rate - hz, f64::from(n) * rate + hz]).collect()
}

/// Modes that only one of two rates shows: of one frequency above half of both, where there is one,
/// else they disagree. `told` are those of the lower rate that are explained. The aliases, as the
/// lower and the higher rate show them.
fn folded_twice(
    (slow, rate): (&PoseModes, f64),
    (fast, fast_rate): (&PoseModes, f64),
    told: &[f64],
    notes: &mut Vec<Note>,
) -> Vec<(f64, f64)> {
    /// Clocks of recorders differ, relative.
    const CLOCKS: f64 = 2e-4;
    let only = |of: &PoseModes, other: &PoseModes| -> Vec<(f64, f64)> {
        // Aliases are often unsettled.
        let is_mode = |code: Option<Code>| code.is_none_or(|code| code == Code::Unsettled);
        let own = of.modes.iter().filter(|mode| is_mode(mode.suspicion));
        own.map(|mode| (mode.frequency_hz, mode.frequency_std_hz))
            .filter(|(hz, _)| !has(other, *hz) && !told.contains(hz))
            .collect()
    };
    let mut explained: Vec<(f64, f64)> = Vec::new();
    let mut push = |code: Code, what: String| {
        notes.push(Note::warning(code, Place::default(), what));
    };
    let others = only(fast, slow);
    for (hz, std) in only(slow, fast) {
        let mut both: Vec<(f64, f64)> = Vec::new();
        for (image, (other, other_std)) in
            unfolded(hz, rate).iter().flat_map(|image| others.iter().map(move |o| (*image, *o)))
        {
            let near =
                |other: &f64| (other - image).abs() < 3.0 * std.hypot(other_std) + CLOCKS * image;
            if unfolded(other, fast_rate).iter().any(near) {
                both.push((image, other));
            }
        }
        match both.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((image, other)) => {
                explained.push((hz, *other));
                push(
                    Code::MayBeFolded,
                    format!(
                        "{hz:.3} Hz at {rate} and {other:.3} Hz at {fast_rate} samples/s are \
                         aliases: the lowest frequency that shows as both is {image:.2} Hz; left \
                         out of the table"
                    ),
                );
            }
            None => push(
                Code::Disagreement,
                format!(
                    "the mode at {hz:.3} Hz shows at {rate} and not at {fast_rate} samples/s, in \
                     the same pose: it may be an alias, or was missed"
                ),
            ),
        }
    }
    let is_explained = |hz: &f64| explained.iter().any(|(_, other)| other == hz);
    let hidden = |hz: &f64| *hz < 0.5 * rate && !is_explained(hz);
    for (hz, _) in others.iter().filter(|(hz, _)| hidden(hz)) {
        push(
            Code::Disagreement,
            format!(
                "the mode at {hz:.3} Hz shows at {fast_rate} and not at {rate} samples/s, in the \
                 same pose: it may be an alias, or was missed"
            ),
        );
    }
    explained
}

/// Modes that only the record at the lower rate has, and of whose aliases the other has one: those
/// that are told.
fn alias_between(
    (slow, rate): (&PoseModes, f64),
    (fast, fast_rate): (&PoseModes, f64),
    notes: &mut Vec<Note>,
) -> Vec<f64> {
    let mut told = Vec::new();
    for mode in slow.modes.iter().filter(|mode| !has(fast, mode.frequency_hz)) {
        let images = (1..=4).flat_map(|n| {
            let n = f64::from(n) * rate;
            [n - mode.frequency_hz, n + mode.frequency_hz]
        });
        let within = images.filter(|image| *image < 0.5 * fast_rate);
        for image in within.filter(|image| has(fast, *image) && !has(slow, *image)) {
            let what = format!(
                "{:.3} Hz at {rate} samples/s is an alias of {image:.3} Hz, which {fast_rate} \
                 samples/s show at the same pose: left out of the table",
                mode.frequency_hz
            );
            told.push(mode.frequency_hz);
            notes.push(Note::warning(Code::MayBeFolded, Place::default(), what));
        }
    }
    told
}

/// Gives the modes their columns in the table: the lowest, but for a pose that lacks modes, where
/// those that were left out or shapes say which.
fn number(poses: &mut [PoseModes], notes: &mut Vec<Note>) {
    let count = |pose: &PoseModes| pose.modes.iter().filter(|m| m.suspicion.is_none()).count();
    let counts: Vec<usize> = poses.iter().map(count).collect();
    let (Some(&least), Some(&most)) = (counts.iter().min(), counts.iter().max()) else { return };
    let mut are_placed = true;
    let of = |pose: &PoseModes| -> Option<Vec<usize>> {
        let full = poses.iter().zip(&counts).filter(|(_, count)| **count == most);
        // Shapes change with the pose: those of some pose with all modes must do.
        full.filter_map(|(full, _)| places(&listed(pose), &listed(full))).next()
    };
    let found: Vec<Option<(Vec<usize>, &str)>> = poses
        .iter()
        .map(|pose| {
            let by_rank = beside_left_out(pose, most).map(|at| (at, "with those left out"));
            let by_rate = || at_other_rate(pose, poses, most).map(|at| (at, "by another rate"));
            let by_shape = || of(pose).map(|at| (at, "by their shapes"));
            by_rank.or_else(by_rate).or_else(by_shape)
        })
        .collect();
    for ((pose, count), found) in poses.iter_mut().zip(&counts).zip(found) {
        are_placed &= *count == most || found.is_some();
        if let Some((found, by)) = &found {
            let words = |at: &usize| (at + 1).to_string();
            let held: Vec<String> = found.iter().map(words).collect();
            let what = format!(
                "a pose has {count} of {most} modes, {by} f{}; the others are blank in its row",
                held.join(", f")
            );
            let place =
                pose.id.clone().map_or_else(Place::default, |id| Place::part(Part::Record(id)));
            notes.push(Note::warning(Code::ModesDiffer, place, what));
        }
        let found = found.map_or_else(|| (0..*count).collect(), |(found, _)| found);
        let own = pose.modes.iter_mut().filter(|mode| mode.suspicion.is_none());
        own.zip(found).for_each(|(mode, at)| mode.number = Some(at + 1));
    }
    crossings(poses, most, notes);
    if !are_placed {
        let what = format!(
            "poses have {least} to {most} modes: where one was missed, and shapes do not say \
             which, the next takes its column f1, f2, … in the table; compare the rows before \
             you use them"
        );
        notes.push(Note::warning(Code::ModesDiffer, Place::default(), what));
    }
}

/// Places of a pose's modes among all of its modes, if there are `most` with those that were left
/// out and whose frequency is known.
fn beside_left_out(pose: &PoseModes, most: usize) -> Option<Vec<usize>> {
    /// Relative deviation.
    const KNOWN: f64 = 3e-3;
    let is_left_out = |mode: &&PoseMode| {
        matches!(mode.suspicion, Some(Code::Unsettled | Code::AmplitudeDependent))
            && mode.frequency_std_hz < KNOWN * mode.frequency_hz
    };
    let is_listed = |mode: &&PoseMode| mode.suspicion.is_none();
    let all = || pose.modes.iter().filter(|mode| is_listed(mode) || is_left_out(mode));
    let are_all = all().count() == most && all().any(|mode| is_left_out(&mode));
    let own = all().enumerate().filter(|(_, mode)| is_listed(mode)).map(|(at, _)| at);
    are_all.then(|| own.collect())
}

/// Places of a pose's modes, where it lacks some, among those that the same pose has at another
/// sampling rate.
fn at_other_rate(pose: &PoseModes, poses: &[PoseModes], most: usize) -> Option<Vec<usize>> {
    let own = listed(pose);
    let is_other = |other: &&PoseModes| {
        is_same_state(pose, other) && pose.sample_rate_hz != other.sample_rate_hz
    };
    let full = poses.iter().filter(is_other).map(listed);
    let full = full.into_iter().find(|other| other.len() == most && own.len() < most)?;
    let cost = |at: usize, other: usize| {
        let apart = (own[at].hz / full[other].hz - 1.0).abs();
        (apart < SAME_MODE).then_some(apart)
    };
    paired(own.len(), full.len(), 1.0, cost).into_iter().collect()
}

/// Tells modes that change places between two poses that show all of them, by shape.
fn crossings(poses: &[PoseModes], most: usize, notes: &mut Vec<Note>) {
    /// Least likeness of the modes that are one, and most of those in one column.
    const ALIKE: f64 = 0.9;
    const UNLIKE: f64 = 0.5;
    /// Fewer responses make modes alike by chance.
    const RESPONSES: usize = 3;
    let full: Vec<&PoseModes> = poses.iter().filter(|pose| listed(pose).len() == most).collect();
    for pair in full.windows(2) {
        let [before, own] = [pair[0], pair[1]].map(listed);
        let are_shapes = before.iter().chain(&own).all(|mode| mode.shape.len() >= RESPONSES);
        let alike = |at: usize, other: usize| mac(own[at].shape, before[other].shape);
        let cost = |at: usize, other: usize| alike(at, other).map(|alike| 1.0 - alike);
        let pairs = paired(own.len(), before.len(), 1.0, cost);
        let moved: Vec<(usize, usize)> = pairs
            .iter()
            .enumerate()
            .filter_map(|(at, other)| Some((at, (*other).filter(|other| *other != at)?)))
            .filter(|&(at, other)| {
                alike(at, other) > Some(ALIKE) && alike(at, at).is_some_and(|own| own < UNLIKE)
            })
            .collect();
        if moved.is_empty() || !are_shapes {
            continue;
        }
        let words = |(at, other): &(usize, usize)| {
            format!("{:.3} Hz has the shape of {:.3} Hz", own[*at].hz, before[*other].hz)
        };
        let what = format!(
            "modes change places against the pose before: {}; columns f1, f2, … are by frequency, \
             so each of these changes its column; the shapes are in the JSON",
            moved.iter().map(words).collect::<Vec<_>>().join(", ")
        );
        let id = pair[1].id.clone();
        let place = id.map_or_else(Place::default, |id| Place::part(Part::Record(id)));
        notes.push(Note::warning(Code::ModesDiffer, place, what));
    }
}

fn listed(pose: &PoseModes) -> Vec<Placed<'_>> {
    let own = pose.modes.iter().filter(|mode| mode.suspicion.is_none());
    own.map(|mode| Placed { hz: mode.frequency_hz, shape: &mode.shape }).collect()
}

impl PoseModes {
    /// How alike the shapes of its modes are to those of another pose, by the modal assurance
    /// criterion over common responses: own modes down, the other's across.
    pub fn mac(&self, other: &PoseModes) -> Vec<Vec<Option<f64>>> {
        let row = |own: &PoseMode| other.modes.iter().map(|m| mac(&own.shape, &m.shape)).collect();
        self.modes.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three modes at most in a row: of two rows that list two, one knows of a third between them,
    /// the other of none.
    #[test]
    fn what_was_left_out_keeps_its_column() {
        let mode = |frequency_hz: f64, suspicion| PoseMode {
            frequency_hz,
            frequency_std_hz: 1e-3,
            damping_ratio: 0.02,
            damping_std: 1e-3,
            suspicion,
            number: None,
            members: Vec::new(),
            shape: Vec::new(),
        };
        let pose = |modes: &[(f64, Option<Code>)]| PoseModes {
            pose: Pose::Joints(Vec::new()),
            conditions: Conditions::default(),
            id: None,
            sample_rate_hz: None,
            modes: modes.iter().map(|&(hz, code)| mode(hz, code)).collect(),
        };
        let unsettled = Some(Code::Unsettled);
        let mut poses = [
            pose(&[(8.0, None), (9.0, None), (14.0, None)]),
            pose(&[(8.0, None), (9.0, unsettled), (14.0, None)]),
            pose(&[(8.0, unsettled), (9.0, None), (14.0, None)]),
            pose(&[(9.0, None), (14.0, None)]),
            // A tone is none of the arm's modes.
            pose(&[(8.0, Some(Code::Mains)), (9.0, None), (14.0, None)]),
        ];
        number(&mut poses, &mut Vec::new());
        let columns =
            |pose: &PoseModes| pose.modes.iter().filter_map(|m| m.number).collect::<Vec<_>>();
        let expected: [&[usize]; 5] = [&[1, 2, 3], &[1, 3], &[2, 3], &[1, 2], &[1, 2]];
        assert_eq!(poses.each_ref().map(columns), expected.map(<[usize]>::to_vec));
    }

    /// By hand: weights 1 and 1/4, a distance of 3, so χ² = 9/5; between the records lies
    /// (9/5 − 1)/(5/4 − 17/20) = 2, weights become 1/3 and 1/6.
    #[test]
    fn merging_weighs_by_variance_and_adds_that_between_records() {
        let (mean, std, ratio) = merged(&[(10.0, 1.0), (13.0, 2.0)]);
        assert!((mean - 11.0).abs() < 1e-12);
        assert!((ratio - 1.8_f64.sqrt()).abs() < 1e-12);
        assert!((std - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(merged(&[(10.0, 1.0)]), (10.0, 1.0, 0.0));
        let (_, std, _) = merged(&[(10.0, 1.0), (10.1, 1.0)]);
        assert!((std - 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
