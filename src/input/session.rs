//! session.yaml and the files of raw data that it names.

mod data;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use self::data::Source;
use super::files::{MAX_ROBOT_BYTES, named_file};
use super::kind::{FileKind, document_of};
use super::raw::session as raw;
use super::records::{meaning_of_unit, read_recording};
use super::{Reading, schema};
use crate::formats::records::Recording;
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step};
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::record::{
    Asked, Conditions, Data, Instrument, MarkedLink, Marker, Measurement, Record, Session,
};
use crate::notes::{Code, Note, Notes, Place};
use crate::units::m_from_mm;
use crate::wording::{counted, hint};

/// Fewest marked points that a rotation can be seen from.
const MIN_MARKERS: usize = 2;

/// No picture of an arm is larger, mm.
const MAX_MARKER_MM: f64 = 1e6;

/// Reads a session.yaml and all files that it names.
///
/// # Errors
/// Every fault of the session and of its files, each with its line where it has one.
pub fn read_session(path: &Path, reading: &mut Reading) -> Result<Session, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let text = read_text(path, MAX_ROBOT_BYTES)?;
    let schema = schema::of::<raw::Session>();
    let Some((tree, raw)) =
        document_of::<raw::Session>(FileKind::Session, &text, &schema, &mut notes)
    else {
        return Err(reading.settle(notes));
    };
    let mut reader = Reader {
        path,
        tree: &tree,
        raw: &raw,
        notes,
        file_errors: Vec::new(),
        file_warnings: Vec::new(),
        read: Vec::new(),
        has_force: false,
    };
    let session = reader.session();
    let Reader { notes, file_errors, file_warnings, read, .. } = reader;
    for file in read {
        if !reading.files.contains(&file.path) {
            reading.files.push(file.path);
        }
    }
    reading.warnings.extend(file_warnings);
    let mut errors = reading.settle(notes);
    errors.extend(file_errors);
    if errors.is_empty() { Ok(session) } else { Err(errors) }
}

struct Reader<'s> {
    path: &'s Path,
    tree: &'s Node,
    raw: &'s raw::Session,
    notes: Notes,
    file_errors: Vec<Note>,
    file_warnings: Vec<Note>,
    /// Files that were read already: several records may name one.
    read: Vec<ReadFile>,
    /// Whether a force was measured in any record.
    has_force: bool,
}

/// A file with what the session calls its time.
struct ReadFile {
    path: PathBuf,
    time: Option<String>,
    found: Option<Recording>,
}

impl Reader<'_> {
    fn error(&mut self, code: Code, steps: &[Step<'_>], what: impl Into<String>) {
        let line = self.tree.line_at(steps);
        self.notes.error(code, line, what);
    }

    fn session(&mut self) -> Session {
        let raw = self.raw;
        if let Some([low, high]) = raw.band_hz
            && !(low >= 0.0 && high > low)
        {
            let what = format!("band_hz is [{low}, {high}], must rise from zero or above");
            self.error(Code::Value, &[Step::Key("band_hz")], what);
        }
        for (index, hz) in raw.mains_hz.iter().flatten().enumerate() {
            if *hz <= 0.0 {
                let what = format!("mains_hz[{index}] is {hz}, must be positive and finite");
                self.error(Code::Value, &[Step::Key("mains_hz")], what);
            }
        }
        self.check_asked();
        self.check_channels();
        self.check_joint_names();
        let links = self.links(raw.markers.as_ref(), &[]);
        let mut records = Vec::new();
        let mut used = Vec::new();
        for (index, record) in raw.records.iter().flatten().enumerate() {
            records.extend(self.measurement(index, record, &links, &mut used));
        }
        if self.notes.errors() == 0 && self.file_errors.is_empty() {
            self.check_use(&used);
        }
        Session {
            asked: Asked {
                band_hz: raw.band_hz,
                mains_hz: raw.mains_hz.clone().unwrap_or_else(|| vec![50.0, 60.0]),
                max_order: raw.max_order.map(|order| order as usize),
                modes: raw.modes.map(|modes| modes as usize),
                near_hz: raw.near_hz.clone().unwrap_or_default(),
            },
            joint_columns: self.joint_columns(),
            records,
        }
    }

    fn check_asked(&mut self) {
        let raw = self.raw;
        for (index, hz) in raw.near_hz.iter().flatten().enumerate() {
            let is_within = raw.band_hz.is_none_or(|[low, high]| *hz >= low && *hz <= high);
            if !(*hz > 0.0 && is_within) {
                let what =
                    format!("near_hz[{index}] is {hz}, must be positive and lie within band_hz");
                self.error(Code::Value, &[Step::Key("near_hz")], what);
            }
        }
    }

    fn check_channels(&mut self) {
        let raw = self.raw;
        for (name, channel) in raw.channels.iter().flatten() {
            let steps = |key| [Step::Key("channels"), Step::Key(name.as_str()), Step::Key(key)];
            if let Some(unit) = &channel.unit
                && meaning_of_unit(unit).is_none()
            {
                let what = format!(
                    "channel '{name}': unit is '{unit}', must be one of m, mm, um, m/s, mm/s, \
                        um/s, m/s2, mm/s2, g, N, kN"
                );
                self.error(Code::Value, &steps("unit"), what);
            }
            if let Some(scale) = channel.scale.filter(|scale| *scale == 0.0) {
                let what = format!("channel '{name}': scale is {scale}, must not be zero");
                self.error(Code::Value, &steps("scale"), what);
            }
        }
    }

    fn joint_columns(&self) -> Option<Vec<JointColumn>> {
        let names = self.raw.joint_names.as_deref()?;
        Some(names.iter().map(|name| JointColumn::of(name)).collect())
    }

    fn check_joint_names(&mut self) {
        let raw = self.raw;
        let names: &[String] = raw.joint_names.as_deref().unwrap_or(&[]);
        for (index, name) in names.iter().enumerate() {
            let steps = [Step::Key("joint_names"), Step::Index(index)];
            if name.is_empty() || name.contains([',', '"', '\n', '\r', '#']) {
                let what = format!(
                    "joint_names[{index}] is '{}', must be the name of a joint",
                    name.escape_debug()
                );
                self.error(Code::Value, &steps, what);
            } else if names[..index].contains(name) {
                self.error(Code::Conflict, &steps, format!("joint_names has '{name}' twice"));
            }
        }
    }

    /// The marked links of the session, or of a record where `before` leads to it.
    fn links(
        &mut self,
        marked: Option<&BTreeMap<String, Vec<raw::Marker>>>,
        before: &[Step<'_>],
    ) -> Vec<MarkedLink> {
        let mut links = Vec::new();
        for (link, raw_markers) in marked.into_iter().flatten() {
            let steps = [before, &[Step::Key("markers"), Step::Key(link.as_str())]].concat();
            if raw_markers.len() < MIN_MARKERS {
                let what = format!(
                    "markers: link '{link}' has {}, must have at least {MIN_MARKERS}",
                    counted(raw_markers.len(), "point")
                );
                self.error(Code::Value, &steps, what);
            }
            let mut markers = Vec::new();
            for (index, marker) in raw_markers.iter().enumerate() {
                let channels = match (&marker.x, &marker.y) {
                    (Some(x), Some(y)) => Some([x.clone(), y.clone()]),
                    (None, None) => None,
                    _ => {
                        let steps = [steps.as_slice(), &[Step::Index(index)]].concat();
                        let what = format!(
                            "markers: link '{link}': point {} has one of x and y, must have both, \
                                or none if it stands still",
                            index + 1
                        );
                        self.error(Code::Conflict, &steps, what);
                        None
                    }
                };
                if let Some(at_mm) = marker.at_mm {
                    if at_mm.iter().any(|at| at.abs() > MAX_MARKER_MM) {
                        let steps = [steps.as_slice(), &[Step::Index(index)]].concat();
                        let what = format!(
                            "markers: link '{link}': point {}: at_mm is [{:e}, {:e}], must lie \
                                within ±{MAX_MARKER_MM}",
                            index + 1,
                            at_mm[0],
                            at_mm[1]
                        );
                        self.error(Code::Value, &steps, what);
                    }
                    markers.push(Marker { at_m: at_mm.map(m_from_mm), channels });
                }
            }
            if markers.len() >= MIN_MARKERS
                && markers.iter().all(|marker| marker.at_m == markers[0].at_m)
            {
                let what = format!("markers: the points of link '{link}' lie on each other");
                self.error(Code::Conflict, &steps, what);
            }
            links.push(MarkedLink { link: link.clone(), markers });
        }
        links
    }

    fn measurement(
        &mut self,
        index: usize,
        record: &raw::Record,
        links: &[MarkedLink],
        used: &mut Vec<String>,
    ) -> Option<Measurement> {
        let (raw, name) = (self.raw, record.file.clone()?);
        let of_file = [Step::Key("records"), Step::Index(index), Step::Key("file")];
        let pose = self.pose(index, record.pose.as_ref());
        if let Some(id) = record.id.as_ref().filter(|id| id.contains(['\n', '\r'])) {
            let what = format!("id is '{}', must be one line", id.escape_debug());
            self.error(Code::Value, &[of_file[0], of_file[1], Step::Key("id")], what);
        }
        let line = self.tree.line_at(&of_file);
        let path = named_file(self.path, "file", &name, line, &mut self.notes)?;
        let time = record.time.as_deref().or(raw.time.as_deref());
        let mut file = self.file(&path, time)?;
        // A table of frequency responses names no force.
        let force = record.excitation.as_deref().unwrap_or("force");
        for function in file.functions.iter_mut().filter(|function| function.reference.is_empty()) {
            force.clone_into(&mut function.reference);
        }
        let own = &[of_file[0], of_file[1]];
        let mut links = match &record.markers {
            Some(markers) => self.links(Some(markers), own),
            None => links.to_vec(),
        };
        for marker in links.iter_mut().flat_map(|link| &mut link.markers) {
            for channel in marker.channels.iter_mut().flatten() {
                *channel = file.full_name(channel).to_owned();
            }
        }
        let data = self.data(&Source { index, record, name: &name, file: &file })?;
        let responses: Vec<String> = match &data {
            Data::Time { responses, .. } | Data::Uneven { responses, .. } => {
                responses.iter().map(|c| c.name.clone()).collect()
            }
            Data::Responses(functions) => functions.iter().map(|f| f.name.clone()).collect(),
        };
        let driving_point =
            record.driving_point.as_ref().map(|point| file.full_name(point).to_owned());
        if let Some(point) = driving_point.as_ref().filter(|point| !responses.contains(point)) {
            let steps = [of_file[0], of_file[1], Step::Key("driving_point")];
            let what = format!(
                "driving_point is '{point}', must be one of the responses: {}",
                responses.join(", ")
            );
            self.error(Code::Reference, &steps, what);
        }
        let instrument = self.instrument(index, record, &data);
        used.extend(file.names_of(&responses));
        used.extend(record.excitation.iter().map(|name| file.full_name(name).to_owned()));
        Some(Measurement {
            record: Record {
                name,
                data,
                driving_point,
                links,
                spindle_rpm: record.spindle_rpm,
                instrument,
            },
            pose: pose?,
            conditions: Conditions {
                temperature_c: record.temperature_c,
                amplitude_nm: record.amplitude_nm,
                payload_kg: record.payload_kg,
                added_kg: record
                    .added_mass_kg
                    .iter()
                    .flatten()
                    .map(|(l, m)| (l.clone(), *m))
                    .collect(),
            },
            id: record.id.clone(),
        })
    }

    /// What the instrument did to a record, by its own keys or those of the session.
    fn instrument(&mut self, index: usize, record: &raw::Record, data: &Data) -> Instrument {
        let delay_s = record.response_delay_s.or(self.raw.response_delay_s);
        let has_force = match data {
            Data::Time { excitation, .. } | Data::Uneven { excitation, .. } => excitation.is_some(),
            Data::Responses(_) => true,
        };
        if record.response_delay_s.is_some() && !has_force {
            let steps = [Step::Key("records"), Step::Index(index), Step::Key("response_delay_s")];
            let line = self.tree.line_at(&steps);
            let what = "response_delay_s has no effect on a record without excitation";
            self.notes.warning(Code::Unused, line, what);
        }
        self.has_force |= has_force;
        Instrument {
            exponential_window_s: record.exponential_window_s.or(self.raw.exponential_window_s),
            response_delay_s: delay_s.filter(|_| has_force).unwrap_or(0.0),
        }
    }

    fn pose(&mut self, index: usize, pose: Option<&raw::Pose>) -> Option<Pose> {
        let steps = [Step::Key("records"), Step::Index(index), Step::Key("pose")];
        let pose = pose?;
        let has_fault = self.tree.at(&steps).is_some_and(|node| {
            node.keys().any(|key| node.get(key).is_some_and(|value| value.faulty))
        });
        if has_fault {
            return None;
        }
        let found = match (pose.beta1_rad, pose.beta2_rad, &pose.joints_deg) {
            (beta1, Some(beta2), None) => Pose::Angles { beta1, beta2 },
            (None, None, Some(joints)) => self.joints(joints),
            (beta1, beta2, joints) => {
                let what = match (beta2, joints) {
                    (Some(_), _) => "pose has both beta2_rad and joints_deg, must have one",
                    (None, Some(_)) => "pose has both beta1_rad and joints_deg, must have one",
                    (None, None) if beta1.is_some() => {
                        "pose has beta1_rad without beta2_rad, must have both"
                    }
                    (None, None) => "pose has neither beta2_rad nor joints_deg, must have one",
                };
                self.error(Code::Conflict, &steps, what);
                return None;
            }
        };
        let raw = self.raw;
        let first = raw.records.iter().flatten().find_map(|record| record.pose.as_ref());
        let keys = |pose: &raw::Pose| match (pose.beta1_rad, pose.beta2_rad) {
            (Some(_), _) => "beta1_rad and beta2_rad",
            (None, Some(_)) => "beta2_rad",
            (None, None) => "joints_deg",
        };
        if let Some(by) = first.map(keys).filter(|by| *by != keys(pose)) {
            let what = format!(
                "pose is given otherwise than that of the first record, by {by}; must be the same"
            );
            self.error(Code::Conflict, &steps, what);
            return None;
        }
        if let Pose::Joints(joints) = &found {
            let expected = raw
                .joint_names
                .as_ref()
                .map(|names| (names.len(), "joint_names"))
                .or_else(|| Some((first?.joints_deg.as_ref()?.len(), "the first record")));
            if let Some((count, by)) = expected.filter(|(count, _)| *count != joints.len()) {
                let what =
                    format!("joints_deg has {} values, must have {count} as {by}", joints.len());
                self.error(Code::Value, &steps, what);
                return None;
            }
        }
        Some(found)
    }

    /// Joint positions in rad or m from degrees or millimetres.
    fn joints(&self, values: &[f64]) -> Pose {
        let columns = JointColumn::list(self.joint_columns().as_deref(), values.len());
        let si = |(column, &value): (&JointColumn, &f64)| column.si_from_degrees_or_mm(value);
        Pose::Joints(columns.iter().zip(values).map(si).collect())
    }

    /// A file of raw data, read once.
    fn file(&mut self, path: &Path, time: Option<&str>) -> Option<Recording> {
        let is_same = |read: &&ReadFile| read.path == path && read.time.as_deref() == time;
        if let Some(read) = self.read.iter().find(is_same) {
            return read.found.clone();
        }
        let file = match read_recording(path, time) {
            Ok(file) => {
                self.file_warnings.extend(file.warnings.iter().cloned());
                Some(file)
            }
            Err(errors) => {
                self.file_errors.extend(errors);
                None
            }
        };
        let time = time.map(str::to_owned);
        self.read.push(ReadFile { path: path.to_owned(), time, found: file.clone() });
        file
    }

    /// Settings that no record uses, and marked points that no record has.
    fn check_use(&mut self, used: &[String]) {
        let raw = self.raw;
        if raw.response_delay_s.is_some() && !self.has_force {
            let line = self.tree.line_at(&[Step::Key("response_delay_s")]);
            let what = "response_delay_s has no effect: no record has an excitation";
            self.notes.warning(Code::Unused, line, what);
        }
        for name in raw.channels.iter().flatten().map(|(name, _)| name) {
            if !used.contains(name) {
                let line = self.tree.line_at(&[Step::Key("channels"), Step::Key(name)]);
                let what = format!("channel '{name}' is in no record: its unit has no effect");
                self.notes.warning(Code::Unused, line, what);
            }
        }
        let own = raw.records.iter().flatten().enumerate().map(|(i, r)| (Some(i), &r.markers));
        let all = [(None, &raw.markers)].into_iter().chain(own);
        let all =
            all.flat_map(|(record, m)| m.iter().flatten().map(move |(link, m)| (record, link, m)));
        for (record, link, markers) in all {
            let names = markers.iter().flat_map(|marker| marker.x.iter().chain(&marker.y));
            for name in names.filter(|name| !used.contains(name)) {
                let near = hint(name, used.iter().map(String::as_str));
                let what =
                    format!("markers: link '{link}': channel '{name}' is in no record{near}");
                let mut steps =
                    record.map_or_else(Vec::new, |i| vec![Step::Key("records"), Step::Index(i)]);
                steps.extend([Step::Key("markers"), Step::Key(link)]);
                self.error(Code::Reference, &steps, what);
            }
        }
    }
}
