//! session.yaml and the files of raw data that it names.

use crate::notes::{Code, Note, Notes, Place};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::files::{MAX_ROBOT_BYTES, named_file};
use super::raw::session as raw;
use super::records::{Meaning, RawChannel, RawFile, RawFunction, meaning_of_unit, read_record};
use super::{Reading, schema};
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step, document};
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::record::{
    Channel, Conditions, Data, Frf, MarkedLink, Marker, Measurement, Quantity, Record, Session,
};
use crate::units::m_from_mm;
use crate::wording::nearest;

const DEFAULT_MAINS_HZ: [f64; 2] = [50.0, 60.0];

/// Fewest marked points that a rotation can be seen from.
const MIN_MARKERS: usize = 2;

/// No picture of an arm is larger, mm.
const MAX_MARKER_MM: f64 = 1e6;

/// Sampling rates that an arm can be recorded at, Hz.
const RATES_HZ: [f64; 2] = [0.1, 1e7];

/// A rate in the session and one in the file agree within this share.
const SAME_RATE: f64 = 0.01;

/// Reads a session.yaml and all files that it names.
///
/// # Errors
/// Every fault of the session and of its files, each with its line where it has one.
pub fn read_session(path: &Path, reading: &mut Reading) -> Result<Session, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let text = read_text(path, MAX_ROBOT_BYTES).map_err(|fault| vec![fault])?;
    let schema = schema::session_to_check();
    let Some((tree, raw)) = document::<raw::Session>(&text, &schema, &mut notes) else {
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
    };
    let session = reader.session();
    let Reader { notes, file_errors, file_warnings, read, .. } = reader;
    reading.files.extend(read.into_iter().map(|(file, _)| file));
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
    read: Vec<(PathBuf, Option<RawFile>)>,
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
        self.check_channels();
        self.check_joint_names();
        let links = self.links(raw.markers.as_ref(), &[]);
        let mut records = Vec::new();
        let mut used = Vec::new();
        for (index, record) in raw.records.iter().flatten().enumerate() {
            records.extend(self.taken(index, record, &links, &mut used));
        }
        if self.notes.errors() == 0 && self.file_errors.is_empty() {
            self.check_use(&used);
        }
        Session {
            band_hz: raw.band_hz,
            mains_hz: raw.mains_hz.clone().unwrap_or_else(|| DEFAULT_MAINS_HZ.to_vec()),
            joint_columns: self.joint_columns(),
            records,
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
                    "markers: link '{link}' has {} point(s), must have at least {MIN_MARKERS}",
                    raw_markers.len()
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

    fn taken(
        &mut self,
        index: usize,
        record: &raw::Record,
        links: &[MarkedLink],
        used: &mut Vec<String>,
    ) -> Option<Measurement> {
        let name = record.file.clone()?;
        let of_file = [Step::Key("records"), Step::Index(index), Step::Key("file")];
        let pose = self.pose(index, record.pose.as_ref());
        if let Some(id) = record.id.as_ref().filter(|id| id.contains(['\n', '\r'])) {
            let what = format!("id is '{}', must be one line", id.escape_debug());
            self.error(Code::Value, &[of_file[0], of_file[1], Step::Key("id")], what);
        }
        let line = self.tree.line_at(&of_file);
        let path = named_file(self.path, "file", &name, line, &mut self.notes)?;
        let file = self.file(&path)?;
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
        let data = self.data(index, record, &name, &file)?;
        let responses: Vec<String> = match &data {
            Data::Time { responses, .. } => responses.iter().map(|c| c.name.clone()).collect(),
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
        used.extend(file.names_of(&responses));
        used.extend(record.excitation.iter().map(|name| file.full_name(name).to_owned()));
        Some(Measurement {
            record: Record { name, data, driving_point, links, spindle_rpm: record.spindle_rpm },
            pose: pose?,
            conditions: Conditions {
                temperature_c: record.temperature_c,
                amplitude_nm: record.amplitude_nm,
                payload_kg: record.payload_kg,
            },
            id: record.id.clone(),
        })
    }

    fn pose(&mut self, index: usize, pose: Option<&raw::Pose>) -> Option<Pose> {
        let steps = [Step::Key("records"), Step::Index(index), Step::Key("pose")];
        let pose = pose?;
        let node =
            self.tree.get("records").and_then(|records| records.items().get(index)?.get("pose"));
        let is_spelt = |key| node.is_some_and(|node| node.get(key).is_some());
        for (key, is_missing, expected) in [
            ("beta2_rad", pose.beta2_rad.is_none(), "a number"),
            ("joints_deg", pose.joints_deg.is_none(), "a list of numbers"),
        ] {
            let is_null = node.and_then(|node| node.get(key)).is_some_and(Node::is_null);
            if is_missing && is_null {
                let what = format!("pose: {key} is null, must be {expected}");
                self.error(Code::Value, &[steps[0], steps[1], steps[2], Step::Key(key)], what);
                return None;
            }
        }
        if (pose.beta2_rad.is_none() && is_spelt("beta2_rad"))
            || (pose.joints_deg.is_none() && is_spelt("joints_deg"))
        {
            // Its value is at fault, which was told.
            return None;
        }
        let (found, other) = match (pose.beta2_rad, &pose.joints_deg) {
            (Some(beta2), None) => (Pose::Beta2(beta2), "joints_deg"),
            (None, Some(joints)) => (self.joints(joints), "beta2_rad"),
            (both, _) => {
                let what = match both {
                    Some(_) => "pose has both beta2_rad and joints_deg, must have one",
                    None => "pose has neither beta2_rad nor joints_deg, must have one",
                };
                self.error(Code::Conflict, &steps, what);
                return None;
            }
        };
        let raw = self.raw;
        let first = raw.records.iter().flatten().find_map(|record| record.pose.as_ref());
        let has = |pose: &raw::Pose| match other {
            "joints_deg" => pose.joints_deg.is_some(),
            _ => pose.beta2_rad.is_some(),
        };
        if first.is_some_and(has) {
            let what = format!(
                "pose is given otherwise than that of the first record, by {other}; must be the \
                    same"
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
    fn file(&mut self, path: &Path) -> Option<RawFile> {
        if let Some((_, file)) = self.read.iter().find(|(read, _)| read == path) {
            return file.clone();
        }
        let file = match read_record(path) {
            Ok(file) => {
                self.file_warnings.extend(file.warnings.iter().cloned());
                Some(file)
            }
            Err(errors) => {
                self.file_errors.extend(errors);
                None
            }
        };
        self.read.push((path.to_owned(), file.clone()));
        file
    }

    fn data(
        &mut self,
        index: usize,
        record: &raw::Record,
        name: &str,
        file: &RawFile,
    ) -> Option<Data> {
        if file.channels.is_empty() {
            return self.functions(index, record, name, file);
        }
        let at = |key| [Step::Key("records"), Step::Index(index), Step::Key(key)];
        let sample_rate_hz = self.rate(index, record, name, file);
        let excitation = match &record.excitation {
            None => None,
            Some(wanted) => match find(&file.channels, wanted) {
                Some(channel) => Some(channel),
                None => {
                    let what = unknown("excitation", wanted, name, &file.channels);
                    self.error(Code::Reference, &at("excitation"), what);
                    return None;
                }
            },
        };
        let mut responses: Vec<&RawChannel> = Vec::new();
        match &record.responses {
            None => responses.extend(file.channels.iter().filter(|c| excitation != Some(*c))),
            Some(wanted) => {
                for (place, wanted) in wanted.iter().enumerate() {
                    let steps = [
                        at("responses")[0],
                        at("responses")[1],
                        at("responses")[2],
                        Step::Index(place),
                    ];
                    match find(&file.channels, wanted) {
                        Some(channel) if Some(channel) == excitation => {
                            let what = format!("response '{wanted}' is the excitation, too");
                            self.error(Code::Conflict, &steps, what);
                        }
                        Some(channel) if responses.contains(&channel) => {
                            self.error(
                                Code::Conflict,
                                &steps,
                                format!("response '{wanted}' is named twice"),
                            );
                        }
                        Some(channel) => responses.push(channel),
                        None => self.error(
                            Code::Reference,
                            &steps,
                            unknown("response", wanted, name, &file.channels),
                        ),
                    }
                }
            }
        }
        if responses.is_empty() {
            if record.responses.is_none() {
                self.error(
                    Code::TooLittleData,
                    &at("file"),
                    format!("file '{name}' has no channel beside the excitation"),
                );
            }
            return None;
        }
        let sample_rate_hz = sample_rate_hz?;
        self.check_band(name, sample_rate_hz);
        let excitation = excitation.map(|channel| self.channel(channel));
        let responses: Vec<Channel> =
            responses.iter().map(|channel| self.channel(channel)).collect();
        self.check_forces(index, name, excitation.as_ref(), &responses);
        Some(Data::Time { sample_rate_hz, excitation, responses })
    }

    /// A band must have lines in every record.
    fn check_band(&mut self, name: &str, sample_rate_hz: f64) {
        let nyquist = 0.5 * sample_rate_hz;
        if let Some([low, high]) = self.raw.band_hz.filter(|band| band[0] >= nyquist) {
            let what = format!(
                "band_hz is [{low}, {high}], must begin below half the sampling rate of file \
                    '{name}', {nyquist} Hz"
            );
            self.error(Code::Value, &[Step::Key("band_hz")], what);
        }
    }

    /// Warns of a force among the responses, and of an excitation that is none.
    fn check_forces(
        &mut self,
        index: usize,
        name: &str,
        excitation: Option<&Channel>,
        responses: &[Channel],
    ) {
        let mut told = Vec::new();
        for force in responses.iter().filter(|channel| channel.quantity == Quantity::Force) {
            told.push(format!(
                "file '{name}': channel '{}' is a force and is taken for a response: give it as \
                    excitation, or leave it out by responses",
                force.name
            ));
        }
        let is_other =
            |channel: &&Channel| !matches!(channel.quantity, Quantity::Force | Quantity::Unknown);
        if let Some(channel) = excitation.filter(is_other) {
            told.push(format!(
                "file '{name}': the excitation '{}' is in {}, not a force: modal constants are \
                    none of a receptance",
                channel.name,
                channel.quantity.unit()
            ));
        }
        let steps = [Step::Key("records"), Step::Index(index), Step::Key("file")];
        let line = self.tree.line_at(&steps);
        for what in told {
            self.notes.warning(Code::Remark, line, what);
        }
    }

    fn rate(
        &mut self,
        index: usize,
        record: &raw::Record,
        name: &str,
        file: &RawFile,
    ) -> Option<f64> {
        let (given, steps): (Option<f64>, Vec<Step<'_>>) = match record.sample_rate_hz {
            Some(rate) => (
                Some(rate),
                vec![Step::Key("records"), Step::Index(index), Step::Key("sample_rate_hz")],
            ),
            None => (self.raw.sample_rate_hz, vec![Step::Key("sample_rate_hz")]),
        };
        let rate = match (file.sample_rate_hz, given) {
            (Some(own), Some(given)) if (own / given - 1.0).abs() > SAME_RATE => {
                let what = format!(
                    "sample_rate_hz is {given}, but file '{name}' itself says {own:.4}; must \
                        agree, or be left out"
                );
                self.error(Code::Conflict, &steps, what);
                None
            }
            // Times are printed with few digits: a rate that agrees is the better one.
            (Some(own), given) => Some(given.unwrap_or(own)),
            (None, Some(given)) => Some(given),
            (None, None) => {
                let steps = [Step::Key("records"), Step::Index(index), Step::Key("file")];
                let what =
                    format!("file '{name}' does not tell its sampling rate: give sample_rate_hz");
                self.error(Code::MissingKey, &steps, what);
                None
            }
        }?;
        let [least, most] = RATES_HZ;
        if (least..=most).contains(&rate) {
            return Some(rate);
        }
        let what = match given {
            Some(_) => format!("sample_rate_hz is {rate}, must lie between {least} and {most}"),
            None => format!(
                "file '{name}' has {rate:e} samples/s by itself, must have between {least} and \
                    {most}"
            ),
        };
        self.error(Code::Value, &steps, what);
        None
    }

    /// A channel in SI: the session's unit counts before the file's.
    fn channel(&self, channel: &RawChannel) -> Channel {
        let (meaning, scale) = self.meaning(&channel.name, &channel.alias, channel.meaning);
        let (quantity, to_si): (Quantity, fn(f64) -> f64) = match meaning {
            Some(meaning) => (meaning.quantity, meaning.to_si),
            None => (Quantity::Unknown, std::convert::identity),
        };
        Channel {
            name: channel.name.clone(),
            quantity,
            samples: channel.samples.iter().map(|v| to_si(v * scale)).collect(),
        }
    }

    fn meaning(&self, name: &str, alias: &str, own: Option<Meaning>) -> (Option<Meaning>, f64) {
        let given = self
            .raw
            .channels
            .as_ref()
            .and_then(|given| given.get(name).or_else(|| given.get(alias)));
        let unit = given.and_then(|given| given.unit.as_deref()).and_then(meaning_of_unit);
        (unit.or(own), given.and_then(|given| given.scale).unwrap_or(1.0))
    }

    fn functions(
        &mut self,
        index: usize,
        record: &raw::Record,
        name: &str,
        file: &RawFile,
    ) -> Option<Data> {
        let at = |key| [Step::Key("records"), Step::Index(index), Step::Key(key)];
        let mut references: Vec<&str> =
            file.functions.iter().map(|f| f.reference.as_str()).collect();
        references.sort_unstable();
        references.dedup();
        let reference = match (&record.excitation, references.as_slice()) {
            (Some(wanted), _) if references.contains(&wanted.as_str()) => wanted.as_str(),
            (Some(wanted), _) => {
                let what = format!(
                    "excitation is '{wanted}', must be a reference of file '{name}': {}",
                    references.join(", ")
                );
                self.error(Code::Reference, &at("excitation"), what);
                return None;
            }
            (None, [only]) => only,
            (None, _) => {
                let what = format!(
                    "file '{name}' has responses to several references: give excitation, one of {}",
                    references.join(", ")
                );
                self.error(Code::MissingKey, &at("file"), what);
                return None;
            }
        };
        let of_reference: Vec<&RawFunction> =
            file.functions.iter().filter(|f| f.reference == reference).collect();
        let mut chosen: Vec<&RawFunction> = Vec::new();
        match &record.responses {
            None => chosen = of_reference,
            Some(wanted) => {
                for (place, wanted) in wanted.iter().enumerate() {
                    let matching =
                        of_reference.iter().find(|f| f.name == *wanted || f.alias == *wanted);
                    match matching {
                        Some(function) => chosen.push(function),
                        None => {
                            let known: Vec<&str> =
                                of_reference.iter().map(|f| f.name.as_str()).collect();
                            let what = format!(
                                "response '{wanted}' is not in file '{name}'; it has {}",
                                known.join(", ")
                            );
                            let steps = [
                                at("responses")[0],
                                at("responses")[1],
                                at("responses")[2],
                                Step::Index(place),
                            ];
                            self.error(Code::Reference, &steps, what);
                        }
                    }
                }
            }
        }
        for (i, function) in chosen.iter().enumerate() {
            if chosen[..i].iter().any(|other| other.name == function.name) {
                let what = format!(
                    "file '{name}' has response {} to {reference} twice (again at line {})",
                    function.name, function.line
                );
                self.error(Code::Conflict, &at("file"), what);
            }
        }
        let functions: Vec<Frf> = chosen
            .iter()
            .map(|function| {
                let (meaning, scale) =
                    self.meaning(&function.name, &function.alias, function.meaning);
                let (quantity, factor) = match meaning {
                    Some(meaning) => (meaning.quantity, (meaning.to_si)(scale)),
                    None => (Quantity::Unknown, scale),
                };
                Frf {
                    name: function.name.clone(),
                    quantity,
                    frequencies_hz: function.frequencies_hz.clone(),
                    values: function.values.iter().map(|v| v * factor).collect(),
                }
            })
            .collect();
        (!functions.is_empty()).then_some(Data::Responses(functions))
    }

    /// Settings that no record uses, and marked points that no record has.
    fn check_use(&mut self, used: &[String]) {
        let raw = self.raw;
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
                let near = nearest(name, used.iter().map(String::as_str))
                    .map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
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

fn find<'c>(channels: &'c [RawChannel], wanted: &str) -> Option<&'c RawChannel> {
    channels
        .iter()
        .find(|channel| channel.name == wanted)
        .or_else(|| channels.iter().find(|channel| channel.alias == wanted))
}

fn unknown(role: &str, wanted: &str, file: &str, channels: &[RawChannel]) -> String {
    let names = || channels.iter().map(|channel| channel.name.as_str());
    let hint = match nearest(wanted, names()) {
        Some(near) => format!("did you mean '{near}'?"),
        None => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
    };
    format!("{role} '{wanted}' is not in file '{file}'; {hint}")
}
