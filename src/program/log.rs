//! What a reader writes down on its way through a program.

use std::collections::HashSet;
use std::sync::Arc;

use nalgebra::Isometry3;

use super::{Pace, Program, Settings, Spindle, SpindleCommand};
use crate::motion::{Load, Move, Stated, StatedFeeds, Target};
use crate::notes::{Code, Note, Notes};

/// Moves, spindle commands, errors and warnings so far.
#[derive(Debug)]
pub(super) struct Log {
    /// More than this is a fault.
    max_moves: usize,
    /// At what speed rapid moves are taken to run.
    rapid_m_per_s: f64,
    /// The job's feed.
    feed_m_per_s: Option<f64>,
    is_full: bool,
    moves: Vec<Move>,
    spindle: Vec<SpindleCommand>,
    /// Moves beyond the first whose speed the program leaves open: their number, and the first's
    /// line.
    rapid: Option<(usize, usize)>,
    /// The line that sends the tool to that the program does not give, and how.
    away: Option<(usize, String)>,
    /// What holds for the next move.
    stated: Arc<Stated>,
    feeds: StatedFeeds,
    notes: Notes,
    /// Texts of the warnings.
    warned: HashSet<String>,
}

impl Log {
    pub(super) fn new(max_moves: usize, settings: &Settings) -> Self {
        Self {
            max_moves,
            rapid_m_per_s: settings.rapid_m_per_s,
            feed_m_per_s: settings.feed_m_per_s,
            is_full: false,
            moves: Vec::new(),
            spindle: Vec::new(),
            rapid: None,
            away: None,
            stated: Arc::default(),
            feeds: StatedFeeds::default(),
            notes: Notes::default(),
            warned: HashSet::new(),
        }
    }

    /// Motion is lost, wrong or impossible. The same error of the same line (in a loop) is kept
    /// once.
    pub(super) fn error(&mut self, code: Code, line: usize, what: impl Into<String>) {
        self.notes.error(code, line, what);
    }

    /// Something beside the motion is left out or assumed; kept once, at the first line.
    pub(super) fn warning(&mut self, code: Code, line: usize, what: impl Into<String>) {
        let what = what.into();
        if self.warned.insert(what.clone()) {
            self.notes.warning(code, line, what);
        }
    }

    /// Numbers may be right in the text and overflow on the way to the base frame; one line may ask
    /// for more moves than the memory holds.
    pub(super) fn motion(&mut self, line: usize, to: Target, tcp: Isometry3<f64>, pace: Pace) {
        if self.is_full {
            return;
        }
        if let Some((line, what)) = self.away.take() {
            let what = format!(
                "{what}, and motion follows from there; split the program here into several \
                 operations"
            );
            self.error(Code::Motion, line, what);
        }
        let feed_m_per_s = match pace {
            Pace::Feed(feed_m_per_s) => feed_m_per_s,
            Pace::Rapid => self.count_rapid(line),
            Pace::Unstated => self.feed_of_job(line),
        };
        let stated = Arc::clone(&self.stated);
        let to = Move { to, feed_m_per_s, tcp, line, spindle_turns: true, stated };
        if self.moves.len() >= self.max_moves {
            self.is_full = true;
            let what = format!(
                "the program makes more than {} moves by here; split it into several operations",
                self.max_moves
            );
            self.error(Code::TooLong, to.line, what);
        } else if is_finite(&to) {
            self.moves.push(to);
        } else {
            self.error(Code::Value, to.line, "the target or the feed is too large a number");
        }
    }

    /// The speed that is assumed because the program gives none. The first of all moves does not
    /// count: it goes to where the path starts.
    fn count_rapid(&mut self, line: usize) -> f64 {
        if !self.moves.is_empty() {
            let (count, _) = self.rapid.get_or_insert((0, line));
            *count += 1;
        }
        self.rapid_m_per_s
    }

    /// The tool goes to a place that the program does not give. Before the first move and behind
    /// the last the path is whole without that way; in between it would be wrong.
    pub(super) fn leaves(&mut self, line: usize, how: &str) {
        let what = format!("{how}: the place is not in the program");
        if self.moves.is_empty() {
            self.warning(Code::LeftOut, line, left_out(&what));
        } else {
            self.away.get_or_insert((line, what));
        }
    }

    /// The feed of the job where the program states none. The first of all moves does not count.
    fn feed_of_job(&mut self, line: usize) -> f64 {
        /// Stands in where there is none, which is an error.
        const ANY: f64 = 1.0;
        if !self.moves.is_empty() {
            self.feeds.incomplete = true;
            if self.feed_m_per_s.is_none() {
                let what = "moves at a feed that the program does not state: write \
                            feed_mm_per_min in the job's operation";
                if self.warned.insert(what.to_owned()) {
                    self.error(Code::MissingKey, line, what);
                }
            }
        }
        self.feed_m_per_s.unwrap_or(ANY)
    }

    /// Another tool is loaded, by its number.
    pub(super) fn tool(&mut self, number: u32) {
        if self.stated.tool != Some(number) {
            Arc::make_mut(&mut self.stated).tool = Some(number);
        }
    }

    /// What the tip carries from here on.
    pub(super) fn load(&mut self, load: Option<&Arc<Load>>) {
        if self.stated.load.as_ref() != load {
            Arc::make_mut(&mut self.stated).load = load.cloned();
        }
    }

    /// The program states a feed of its own.
    pub(super) fn feed(&mut self, is_per_revolution: bool) {
        if is_per_revolution {
            self.feeds.per_revolution = true;
        } else {
            self.feeds.per_time = true;
        }
    }

    /// Whether there are more moves than are accepted: reading on is in vain.
    pub(super) fn is_full(&self) -> bool {
        self.is_full
    }

    pub(super) fn spindle(&mut self, line: usize, spindle: Spindle) {
        Arc::make_mut(&mut self.stated).spindle = Some(spindle);
        self.spindle.push(SpindleCommand { line, spindle, from_move: self.moves.len() });
    }

    pub(super) fn finish(mut self) -> Result<Program, Vec<Note>> {
        if self.notes.errors() == 0 && self.moves.is_empty() {
            self.error(Code::Motion, 1, "the program contains no motion");
        }
        if let Some((line, what)) = self.away.take() {
            self.warning(Code::LeftOut, line, left_out(&what));
        }
        if let Some((count, first_line)) = self.rapid {
            let moves = if count == 1 {
                "a rapid move runs".to_owned()
            } else {
                format!("{count} rapid moves, of which this is the first, run")
            };
            let what = format!("{moves} at the assumed {} m/s", self.rapid_m_per_s);
            self.warning(Code::Assumed, first_line, what);
        }
        let Self { mut moves, spindle, feeds, notes, .. } = self;
        let (errors, warnings) = notes.finish();
        if !errors.is_empty() {
            return Err(errors);
        }
        let ends = spindle.iter().skip(1).map(|next| next.from_move).chain([moves.len()]);
        let stops = spindle.iter().zip(ends).filter(|(at, _)| at.spindle == Spindle::Stands);
        for (stop, end) in stops {
            moves[stop.from_move..end].iter_mut().for_each(|each| each.spindle_turns = false);
        }
        Ok(Program { moves, spindle, feeds, warnings })
    }
}

fn left_out(what: &str) -> String {
    format!("{what}; the move there is skipped")
}

fn is_finite(each: &Move) -> bool {
    let pose = |pose: &Isometry3<f64>| {
        pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
    };
    each.feed_m_per_s.is_finite()
        && pose(&each.tcp)
        && match &each.to {
            Target::Joints(joints) => joints.iter().all(|joint| joint.is_finite()),
            Target::JointsTo(end) | Target::Line(end) => pose(end),
            Target::Arc { via, end } => pose(via) && pose(end),
        }
}
