//! The channels and frequency responses of one record, in SI.

use super::super::records::{Meaning, is_frequency, meaning_of, meaning_of_unit};
use super::Reader;
use crate::formats::records::{self, Function, Label, Recording};
use crate::formats::yaml::Step;
use crate::identify::record::{Channel, Data, Frf, Quantity, mean_rate_hz};
use crate::input::raw::session as raw;
use crate::notes::Code;
use crate::wording::nearest;

/// Sampling rates that an arm can be recorded at, Hz.
const RATES_HZ: [f64; 2] = [0.1, 1e7];

/// A record and the file that it names.
#[derive(Clone, Copy)]
pub(super) struct Source<'r> {
    pub(super) index: usize,
    pub(super) record: &'r raw::Record,
    pub(super) name: &'r str,
    pub(super) file: &'r Recording,
}

impl Source<'_> {
    fn at<'k>(&self, key: &'k str) -> [Step<'k>; 3] {
        [Step::Key("records"), Step::Index(self.index), Step::Key(key)]
    }

    /// One of the responses that the record names.
    fn response(&self, place: usize) -> [Step<'static>; 4] {
        let [records, index, responses] = self.at("responses");
        [records, index, responses, Step::Index(place)]
    }
}

impl Reader<'_> {
    pub(super) fn data(&mut self, source: &Source<'_>) -> Option<Data> {
        if source.file.channels.is_empty() {
            return self.functions(source);
        }
        if let Some(column) = frequency_column(source.file) {
            let what = format!(
                "file '{}' has a column '{column}', as frequency responses have, and none that is \
                 a part of one: call them tip_re and tip_im, or tip_mag (tip_db) and tip_phase_deg \
                 in a table, or give UFF data sets 58 (.uff, .unv)",
                source.name
            );
            self.error(Code::Value, &source.at("file"), what);
            return None;
        }
        let sample_rate_hz = self.rate(source);
        self.check_time(source);
        let excitation = match &source.record.excitation {
            None => None,
            Some(wanted) => Some(self.channel_named("excitation", wanted, source, None)?),
        };
        let responses = self.responses(source, excitation)?;
        let sample_rate_hz = sample_rate_hz?;
        self.check_band(source.name, sample_rate_hz);
        let excitation = excitation.map(|channel| self.channel(channel));
        let responses: Vec<Channel> =
            responses.iter().map(|channel| self.channel(channel)).collect();
        self.check_forces(source, excitation.as_ref(), &responses);
        Some(match source.file.times_s.clone() {
            Some(times_s) => Data::Uneven { times_s, excitation, responses },
            None => Data::Time { sample_rate_hz, excitation, responses },
        })
    }

    /// The channel that a record names in a role: as its excitation, or as the response at `place`.
    fn channel_named<'f>(
        &mut self,
        role: &str,
        wanted: &str,
        source: &Source<'f>,
        place: Option<usize>,
    ) -> Option<&'f records::Channel> {
        let Source { name, file, .. } = *source;
        let found = find(&file.channels, wanted);
        if found.is_none() {
            let what = unknown(role, wanted, name, &file.channels);
            match place {
                Some(place) => self.error(Code::Reference, &source.response(place), what),
                None => self.error(Code::Reference, &source.at("excitation"), what),
            }
        }
        found
    }

    /// The channels of the responses; `None` where there are none.
    fn responses<'f>(
        &mut self,
        source: &Source<'f>,
        excitation: Option<&records::Channel>,
    ) -> Option<Vec<&'f records::Channel>> {
        let Source { record, name, file, .. } = *source;
        let Some(wanted) = &record.responses else {
            let all: Vec<_> = file.channels.iter().filter(|c| excitation != Some(*c)).collect();
            if all.is_empty() {
                let what = format!("file '{name}' has no channel beside the excitation");
                self.error(Code::TooLittleData, &source.at("file"), what);
            }
            return Some(all).filter(|all| !all.is_empty());
        };
        let mut responses: Vec<&records::Channel> = Vec::new();
        for (place, wanted) in wanted.iter().enumerate() {
            let found = self.channel_named("response", wanted, source, Some(place));
            let Some(channel) = found else { continue };
            let why = if Some(channel) == excitation {
                "is the excitation, too"
            } else if responses.contains(&channel) {
                "is named twice"
            } else {
                responses.push(channel);
                continue;
            };
            let what = format!("response '{wanted}' {why}");
            self.error(Code::Conflict, &source.response(place), what);
        }
        Some(responses).filter(|responses| !responses.is_empty())
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

    /// Warns of a force among the responses, and of an excitation that is no force.
    fn check_forces(
        &mut self,
        source: &Source<'_>,
        excitation: Option<&Channel>,
        responses: &[Channel],
    ) {
        let name = source.name;
        let mut warnings = Vec::new();
        for force in responses.iter().filter(|channel| channel.quantity == Quantity::Force) {
            warnings.push(format!(
                "file '{name}': channel '{}' is a force and is taken for a response: give it as \
                    excitation, or leave it out by responses",
                force.name
            ));
        }
        let is_other =
            |channel: &&Channel| !matches!(channel.quantity, Quantity::Force | Quantity::Unknown);
        if let Some(channel) = excitation.filter(is_other) {
            warnings.push(format!(
                "file '{name}': the excitation '{}' is in {}, not a force: modal constants are \
                    not those of a receptance",
                channel.name,
                channel.quantity.unit()
            ));
        }
        let line = self.tree.line_at(&source.at("file"));
        for what in warnings {
            self.notes.warning(Code::Remark, line, what);
        }
    }

    /// The time that a record names must be in its file.
    fn check_time(&mut self, source: &Source<'_>) {
        let Source { record, name, file, .. } = *source;
        if let Some(wanted) = record.time.as_ref().filter(|time| file.time.as_ref() != Some(time)) {
            let what = unknown("time", wanted, name, &file.channels);
            self.error(Code::Reference, &source.at("time"), what);
        }
    }

    fn rate(&mut self, source: &Source<'_>) -> Option<f64> {
        let Source { record, name, file, .. } = *source;
        let (given, steps): (Option<f64>, Vec<Step<'_>>) = match record.sample_rate_hz {
            Some(rate) => (Some(rate), source.at("sample_rate_hz").to_vec()),
            None => (self.raw.sample_rate_hz, vec![Step::Key("sample_rate_hz")]),
        };
        let own = file.sample_rate_hz.or_else(|| mean_rate_hz(file.times_s.as_deref()?));
        let rate = match (own, given) {
            (Some(own), Some(given)) if (own / given - 1.0).abs() > 0.01 => {
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
                let steps = source.at("file");
                let what = format!("file '{name}' states no sampling rate: give sample_rate_hz");
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
                "file '{name}' states {rate:e} samples/s, must have between {least} and \
                    {most}"
            ),
        };
        self.error(Code::Value, &steps, what);
        None
    }

    /// A channel in SI: the session's unit counts before the file's.
    fn channel(&self, channel: &records::Channel) -> Channel {
        let (meaning, scale) = self.meaning(&channel.label);
        let (quantity, to_si): (Quantity, fn(f64) -> f64) = match meaning {
            Some(meaning) => (meaning.quantity, meaning.to_si),
            None => (Quantity::Unknown, std::convert::identity),
        };
        Channel {
            name: channel.label.name.clone(),
            quantity,
            samples: channel.samples.iter().map(|v| to_si(v * scale)).collect(),
        }
    }

    fn meaning(&self, label: &Label) -> (Option<Meaning>, f64) {
        let given = self
            .raw
            .channels
            .as_ref()
            .and_then(|given| given.get(&label.name).or_else(|| given.get(&label.alias)));
        let unit = given.and_then(|given| given.unit.as_deref()).and_then(meaning_of_unit);
        (unit.or_else(|| meaning_of(label)), given.and_then(|given| given.scale).unwrap_or(1.0))
    }

    fn functions(&mut self, source: &Source<'_>) -> Option<Data> {
        let Source { record, name, file, .. } = *source;
        let mut references: Vec<&str> =
            file.functions.iter().map(|f| f.reference.as_str()).collect();
        references.sort_unstable();
        references.dedup();
        if let Some(wanted) = &record.excitation
            && !references.contains(&wanted.as_str())
        {
            let what = format!(
                "excitation is '{wanted}', must be a reference of file '{name}': {}",
                references.join(", ")
            );
            self.error(Code::Reference, &source.at("excitation"), what);
            return None;
        }
        // Without one, all references are fitted together.
        let is_asked = |f: &&Function| match &record.excitation {
            Some(wanted) => f.reference == *wanted,
            None => true,
        };
        let of_references: Vec<&Function> = file.functions.iter().filter(is_asked).collect();
        if record.driving_point.is_some() && record.excitation.is_none() && references.len() > 1 {
            let what = "driving_point has no effect on responses to several references: there, a \
                        point that is response and reference is one";
            let line = self.tree.line_at(&source.at("driving_point"));
            self.notes.warning(Code::Unused, line, what);
        }
        let mut chosen: Vec<&Function> = Vec::new();
        match &record.responses {
            None => chosen = of_references,
            Some(wanted) => {
                for (place, wanted) in wanted.iter().enumerate() {
                    let matching = of_references
                        .iter()
                        .filter(|f| [&f.label.name, &f.label.alias].contains(&wanted));
                    let before = chosen.len();
                    chosen.extend(matching);
                    if chosen.len() == before {
                        let mut known: Vec<&str> =
                            of_references.iter().map(|f| f.label.name.as_str()).collect();
                        known.dedup();
                        let what = format!(
                            "response '{wanted}' is not in file '{name}'; it has {}",
                            known.join(", ")
                        );
                        self.error(Code::Reference, &source.response(place), what);
                    }
                }
            }
        }
        for (i, function) in chosen.iter().enumerate() {
            let (response, reference) = (&function.label.name, &function.reference);
            let is_same =
                |other: &&Function| other.label.name == *response && other.reference == *reference;
            if chosen[..i].iter().any(is_same) {
                let what = format!(
                    "file '{name}' has response {response} to {reference} twice (again at line {})",
                    function.line
                );
                self.error(Code::Conflict, &source.at("file"), what);
            }
        }
        let functions: Vec<Frf> = chosen
            .iter()
            .map(|function| {
                let (meaning, scale) = self.meaning(&function.label);
                let (quantity, factor) = match meaning {
                    Some(meaning) => (meaning.quantity, (meaning.to_si)(scale)),
                    None => (Quantity::Unknown, scale),
                };
                Frf {
                    name: function.label.name.clone(),
                    reference: function.reference.clone(),
                    quantity,
                    frequencies_hz: function.frequencies_hz.clone(),
                    values: function.values.iter().map(|v| v * factor).collect(),
                }
            })
            .collect();
        (!functions.is_empty()).then_some(Data::Responses(functions))
    }
}

fn find<'c>(channels: &'c [records::Channel], wanted: &str) -> Option<&'c records::Channel> {
    channels
        .iter()
        .find(|channel| channel.label.name == wanted)
        .or_else(|| channels.iter().find(|channel| channel.label.alias == wanted))
}

fn unknown(role: &str, wanted: &str, file: &str, channels: &[records::Channel]) -> String {
    let names = || channels.iter().map(|channel| channel.label.name.as_str());
    let hint = match nearest(wanted, names()) {
        Some(near) => format!("did you mean '{near}'?"),
        None => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
    };
    format!("{role} '{wanted}' is not in file '{file}'; {hint}")
}

/// The first column of a table that is a frequency, by its name and its rising values.
fn frequency_column(file: &Recording) -> Option<&str> {
    let rises = |channel: &records::Channel| channel.samples.windows(2).all(|p| p[1] > p[0]);
    let mut named = file.channels.iter().filter(|channel| is_frequency(&channel.label.name));
    named.find(|channel| rises(channel)).map(|channel| channel.label.name.as_str())
}
