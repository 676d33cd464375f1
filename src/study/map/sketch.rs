//! Parts of a reduced map: made on any machines, written to files, and put together again to the
//! map that one run would have made.

use std::fmt::Debug;
use std::hash::Hasher;
use std::path::{Path, PathBuf};

use fnv::FnvHasher;
use serde::{Deserialize, Serialize};

use super::stream::PIECE_POSES;
use super::summary::outside_limits;
use super::{Source, Summary, instructions, wrong};
use crate::input::sketch_text;
use crate::map::{FrequencyMap, Head, Reduction, Statistic};
use crate::notes::{Code, Note, Place};
use crate::study::Read;

/// A part of a reduced map, as its file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sketch {
    schema: SchemaName,
    /// The version that made it.
    detune: String,
    /// The vector instructions of the machine that made it.
    instructions: String,
    /// Of the model, and of the poses that are asked for in all.
    of: Digests,
    /// Which part this is, counted from 1, and of how many.
    part: Part,
    /// Poses of the whole map.
    poses: usize,
    head: Head,
    statistics: Vec<Statistic>,
    /// Poses of this part outside the joint limits, and the first of them in words.
    outside: usize,
    first_outside: Option<String>,
    reduction: Reduction,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum SchemaName {
    #[serde(rename = "sketch/1")]
    Sketch1,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Digests {
    robot: String,
    poses: String,
}

/// One part of several, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Which.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Part {
    /// All.
    pub const WHOLE: Self = Self { number: 1, of: 1 };
}

/// A part that is to be made: its poses, and what its sketch will say of them.
#[derive(Debug)]
pub struct Started {
    /// The poses of the part.
    pub source: Source,
    sketch: Sketch,
}

impl Started {
    /// A part of the map that `source` asks for.
    ///
    /// # Errors
    /// Poses of a table, which are not made.
    pub fn new(
        map: &FrequencyMap,
        source: Source,
        part: Part,
        statistics: &[Statistic],
    ) -> Result<Self, Note> {
        let described = source.described().zip(source.count());
        let no_table = || {
            let what = "a table of poses cannot be divided; divide the table, or ask for --grid, \
                        --random or --joint";
            wrong("part", what)
        };
        let (described, poses) = described.ok_or_else(no_table)?;
        let of = Digests { robot: digest(map.robot()), poses: digest(&described) };
        let source = source.part(part.number, part.of, PIECE_POSES).ok_or_else(no_table)?;
        let reduction = Reduction::from_pose(source.first(), map.joints(), map.modes());
        let sketch = Sketch {
            schema: SchemaName::Sketch1,
            detune: env!("CARGO_PKG_VERSION").to_owned(),
            instructions: instructions().to_owned(),
            of,
            part,
            poses,
            head: Head::of(map),
            statistics: statistics.to_vec(),
            outside: 0,
            first_outside: None,
            reduction,
        };
        Ok(Self { source, sketch })
    }

    /// Where the statistics of the part's poses are gathered.
    pub fn parts(self) -> (Source, Sketch) {
        (self.source, self.sketch)
    }
}

impl Sketch {
    /// Where the statistics are gathered.
    pub fn reduction(&mut self) -> &mut Reduction {
        &mut self.reduction
    }

    /// The sketch of a part whose poses have gone by.
    #[must_use]
    pub fn finished(self, map: &FrequencyMap, summary: &Summary) -> Self {
        let first_outside = summary.first_outside(map.robot());
        Self { outside: summary.outside_limits.poses, first_outside, ..self }
    }

    /// Whether it is what such a file can hold.
    fn is_sound(&self) -> bool {
        let Part { number, of } = self.part;
        let range = self.reduction.range();
        (1..=of).contains(&number)
            && range.end <= self.poses
            && self.outside <= range.len()
            && self.first_outside.is_some() == (self.outside > 0)
            && self.reduction.is_sound(self.head.joints.len(), self.head.coordinates.len())
    }
}

/// A map put together from its parts.
#[derive(Debug)]
pub struct Merged {
    /// What its columns are.
    pub head: Head,
    /// What was asked for; empty where the parts say nothing.
    pub statistics: Vec<Statistic>,
    /// Of all poses.
    pub reduction: Reduction,
    /// What the undivided run would have warned of.
    pub warnings: Vec<Note>,
}

/// Reads the parts of a map and puts them together, in whatever order they are given.
///
/// # Errors
/// Files that are no sketches; parts of other maps, of another version, missing or given twice.
pub fn merge(files: &[PathBuf]) -> Read<Merged> {
    let mut errors = Vec::new();
    let mut parts: Vec<(&Path, Sketch)> = Vec::new();
    for file in files {
        match read(file) {
            Ok(sketch) => parts.push((file, sketch)),
            Err(error) => errors.push(error),
        }
    }
    parts.sort_by_key(|(_, sketch)| sketch.part.number);
    errors.extend(contradictions(&parts));
    if errors.is_empty() {
        errors.extend(gaps(&parts));
    }
    let value = if errors.is_empty() { joined(parts).map_err(Vec::from) } else { Err(errors) };
    Read { value, warnings: Vec::new(), files: files.to_vec() }
}

fn read(file: &Path) -> Result<Sketch, Note> {
    let text = sketch_text(file)?;
    let sketch: Sketch = serde_json::from_str(&text).map_err(|error| {
        let what = format!("is no sketch of a map: {error}");
        Note::error(Code::Syntax, Place::line(file, error.line()), what)
    })?;
    let damaged = || {
        let what = "is damaged: its numbers contradict each other; make the part again";
        Note::error(Code::Conflict, Place::file(file), what)
    };
    if sketch.is_sound() { Ok(sketch) } else { Err(damaged()) }
}

/// Parts that do not belong to the map of the first one.
fn contradictions(parts: &[(&Path, Sketch)]) -> Vec<Note> {
    let Some(((first_file, first), others)) = parts.split_first() else { return Vec::new() };
    let differs = |sketch: &Sketch| {
        if sketch.detune != first.detune {
            Some("was made by another version of detune")
        } else if sketch.of.robot != first.of.robot || sketch.head != first.head {
            Some("is about another robot")
        } else if sketch.of.poses != first.of.poses || sketch.poses != first.poses {
            Some("is about other poses")
        } else if sketch.part.of != first.part.of {
            Some("is of a map in another number of parts")
        } else if sketch.statistics != first.statistics {
            Some("was made for other statistics")
        } else {
            None
        }
    };
    let notes = others.iter().filter_map(|(file, sketch)| {
        let what = format!("{} than {}", differs(sketch)?, first_file.display());
        Some(Note::error(Code::Conflict, Place::file(file), what))
    });
    notes.collect()
}

/// Parts that are missing or given twice.
fn gaps(parts: &[(&Path, Sketch)]) -> Vec<Note> {
    let mut notes = Vec::new();
    for pair in parts.windows(2) {
        let ((one, a), (two, b)) = (&pair[0], &pair[1]);
        if a.part == b.part {
            let what = format!("is part {}, and so is {}", b.part.number, one.display());
            notes.push(Note::error(Code::Conflict, Place::file(two), what));
        }
    }
    let Some((_, first)) = parts.first() else {
        return vec![wrong("", "no sketch is given")];
    };
    let mut missing = Vec::new();
    let mut given = parts.iter().map(|(_, sketch)| sketch.part.number).peekable();
    for number in 1..=first.part.of {
        while given.next_if(|&part| part < number).is_some() {}
        if given.peek() != Some(&number) {
            missing.push(number.to_string());
        }
        if missing.len() > MAX_NAMED {
            missing.push("…".to_owned());
            break;
        }
    }
    if !missing.is_empty() {
        let what = format!("of {} parts these are missing: {}", first.part.of, missing.join(", "));
        notes.push(wrong("", what));
    }
    let is_whole = parts.iter().try_fold(0, |end, (_, sketch)| {
        let range = sketch.reduction.range();
        (range.start == end).then_some(range.end)
    }) == Some(first.poses);
    if notes.is_empty() && !is_whole {
        notes.push(wrong("", "the parts do not hold every pose once; make them again"));
    }
    notes
}

/// At most so many missing parts are named.
const MAX_NAMED: usize = 20;

fn joined(parts: Vec<(&Path, Sketch)>) -> Result<Merged, Note> {
    let mut parts = parts.into_iter().map(|(_, sketch)| sketch);
    let Some(mut first) = parts.next() else { return Err(wrong("", "no sketch is given")) };
    let mut mixed = false;
    for later in parts {
        mixed |= later.instructions != first.instructions;
        first.outside += later.outside;
        first.first_outside = first.first_outside.or(later.first_outside);
        first.reduction.append(later.reduction);
    }
    let of_machines = mixed.then(|| {
        let what = "the parts were made with different vector instructions; the last digits may \
                    differ from those of one run";
        Note::warning(Code::Remark, Place::default(), what)
    });
    let warning = first.first_outside.map(|place| {
        let what = outside_limits(first.outside, first.poses, &place);
        Note::warning(Code::OutsideLimits, Place::default(), what)
    });
    Ok(Merged {
        head: first.head,
        statistics: first.statistics,
        reduction: first.reduction,
        warnings: warning.into_iter().chain(of_machines).collect(),
    })
}

/// The same for the same value, on every machine.
fn digest(value: &impl Debug) -> String {
    let mut hasher = FnvHasher::default();
    hasher.write(format!("{value:?}").as_bytes());
    format!("fnv1a-{:016x}", hasher.finish())
}
