//! All records of a session → one row of modes for each pose.
//!
//! Records of one pose, taken under the same conditions at the same sampling rate, are merged mode by mode:
//! the mean weighted by variances, its deviation widened by Birge's ratio where the records scatter by more
//! than they state (Birge, Phys. Rev. 40, 1932).

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::notice::{Notice, NoticeKind};
use super::record::{Conditions, Data, Pose, Session, Taken};
use super::record_modes::{Identified, Mode, identify_record};

/// Modes of two records within this share of frequency are the same mode.
const SAME_MODE: f64 = 0.012;

/// Records scatter by more than they state where Birge's ratio is above this.
const SCATTERED: f64 = 3.0;

/// Sampling rates within this share are equal: times are printed with few digits.
const SAME_RATE: f64 = 1e-5;

/// A frequency and its folded image agree within this share.
const SAME_IMAGE: f64 = 0.01;

/// A mode of a pose, from all of the pose's records.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseMode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub frequency_std_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Standard deviation.
    pub damping_std: f64,
    /// The modes that were merged: record of the session, mode of the record.
    pub members: Vec<(usize, usize)>,
    /// What else it may be: then it is not written to the table.
    pub suspicion: Option<NoticeKind>,
}

/// The modes of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseRow {
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
    pub rows: Vec<PoseRow>,
    /// One for each record, in the order of the session.
    pub records: Vec<Identified>,
    /// About several records.
    pub notices: Vec<Notice>,
}

/// Identifies all records and merges those that belong together.
pub fn identify_session(session: &Session) -> IdentifiedSession {
    identify_session_with_progress(session, &|| ())
}

/// As [`identify_session`]; `done` is called after each record, on whatever thread.
pub fn identify_session_with_progress(
    session: &Session,
    done: &(dyn Fn() + Sync),
) -> IdentifiedSession {
    let identified = |taken: &Taken| {
        let found = identify_record(&taken.record, session.band_hz, &session.mains_hz);
        done();
        found
    };
    let records: Vec<Identified> = session.records.par_iter().map(identified).collect();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, taken) in session.records.iter().enumerate() {
        let belongs = |group: &&mut Vec<usize>| is_same(&session.records[group[0]], taken);
        match groups.iter_mut().find(belongs) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    let mut notices = Vec::new();
    let rows: Vec<PoseRow> =
        groups.iter().map(|group| row(session, &records, group, &mut notices)).collect();
    folded_between_rates(&rows, &mut notices);
    modes_differ(&rows, &mut notices);
    IdentifiedSession { rows, records, notices }
}

fn rate(taken: &Taken) -> Option<f64> {
    match &taken.record.data {
        Data::Time { sample_rate_hz, .. } => Some(*sample_rate_hz),
        Data::Responses(_) => None,
    }
}

fn is_same(a: &Taken, b: &Taken) -> bool {
    let is_same_rate = match (rate(a), rate(b)) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() <= SAME_RATE,
        (a, b) => a == b,
    };
    a.pose == b.pose && a.conditions == b.conditions && is_same_rate
}

fn row(
    session: &Session,
    records: &[Identified],
    group: &[usize],
    notices: &mut Vec<Notice>,
) -> PoseRow {
    let mut clusters: Vec<Vec<(usize, usize)>> = Vec::new();
    let of = |(record, mode): (usize, usize)| -> &Mode { &records[record].modes[mode] };
    for &record in group {
        for mode in 0..records[record].modes.len() {
            let frequency = of((record, mode)).frequency_hz;
            let distance =
                |cluster: &[(usize, usize)]| (of(cluster[0]).frequency_hz / frequency - 1.0).abs();
            let nearest = clusters
                .iter_mut()
                .filter(|cluster| cluster.iter().all(|(other, _)| *other != record))
                .filter(|cluster| distance(cluster) < SAME_MODE)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            match nearest {
                Some(cluster) => cluster.push((record, mode)),
                None => clusters.push(vec![(record, mode)]),
            }
        }
    }
    let mut tell = |kind, what: String| {
        let names: Vec<&str> = group.iter().map(|&i| records[i].record.as_str()).collect();
        notices.push(Notice { kind, record: Some(names.join(", ")), channel: None, what });
    };
    let found = group.iter().filter(|&&i| !records[i].modes.is_empty()).count();
    let mut modes = Vec::new();
    for members in clusters {
        let members: Vec<(usize, usize)> = members;
        let values = |of_mode: &dyn Fn(&Mode) -> (f64, f64)| -> Vec<(f64, f64)> {
            members.iter().map(|&member| of_mode(of(member))).collect()
        };
        let (frequency_hz, frequency_std_hz, ratio) =
            merged(&values(&|mode| (mode.frequency_hz, mode.frequency_std_hz)));
        let (damping_ratio, damping_std, _) =
            merged(&values(&|mode| (mode.damping_ratio, mode.damping_std)));
        if ratio > SCATTERED {
            let what = format!(
                "the frequencies of the mode at {frequency_hz:.3} Hz scatter {ratio:.1} times as much as the records \
                 state; its deviation was widened; something changed between the records"
            );
            tell(NoticeKind::Disagreement, what);
        }
        if members.len() < found {
            let what = format!(
                "the mode at {frequency_hz:.3} Hz shows in {} of {found} records of its pose",
                members.len()
            );
            tell(NoticeKind::Disagreement, what);
        }
        let suspicion = suspicion(members.iter().map(|&member| of(member).suspicion));
        modes.push(PoseMode {
            frequency_hz,
            frequency_std_hz,
            damping_ratio,
            damping_std,
            members,
            suspicion,
        });
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let first = &session.records[group[0]];
    let mut ids: Vec<&str> =
        group.iter().filter_map(|&i| session.records[i].id.as_deref()).collect();
    ids.dedup();
    PoseRow {
        pose: first.pose.clone(),
        conditions: first.conditions,
        id: (!ids.is_empty()).then(|| ids.join("+")),
        sample_rate_hz: rate(first),
        modes,
    }
}

/// A tone in one record is one in all; what one record cannot settle another may.
fn suspicion(members: impl Iterator<Item = Option<NoticeKind>> + Clone) -> Option<NoticeKind> {
    let unsettled = Some(NoticeKind::Unsettled);
    let is_unsettled = members.clone().all(|member| member == unsettled);
    let other = members.flatten().find(|kind| *kind != NoticeKind::Unsettled);
    other.or(unsettled.filter(|_| is_unsettled))
}

/// Weighted mean, its deviation and Birge's ratio.
fn merged(values: &[(f64, f64)]) -> (f64, f64, f64) {
    if let [(value, std)] = values {
        return (*value, *std, 0.0);
    }
    // Nothing is known beyond the digits of a number.
    let weight =
        |value: f64, std: f64| std.max(1e-12 * value.abs()).max(f64::MIN_POSITIVE.sqrt()).powi(-2);
    let sum: f64 = values.iter().map(|&(value, std)| weight(value, std)).sum();
    let mean = values.iter().map(|&(value, std)| value * weight(value, std)).sum::<f64>() / sum;
    let chi_squared: f64 =
        values.iter().map(|&(value, std)| (value - mean).powi(2) * weight(value, std)).sum();
    let ratio = (chi_squared / (values.len() - 1) as f64).sqrt();
    (mean, sum.recip().sqrt() * ratio.max(1.0), ratio)
}

/// Poses that were recorded at two rates tell folded frequencies from true ones.
fn folded_between_rates(rows: &[PoseRow], notices: &mut Vec<Notice>) {
    for row in rows {
        for other in rows.iter().filter(|o| o.pose == row.pose && o.conditions == row.conditions) {
            let (Some(rate), Some(other_rate)) = (row.sample_rate_hz, other.sample_rate_hz) else {
                continue;
            };
            if rate >= other_rate * (1.0 - SAME_RATE) {
                continue;
            }
            let has = |row: &PoseRow, f: f64| {
                row.modes.iter().any(|mode| (mode.frequency_hz / f - 1.0).abs() < SAME_IMAGE)
            };
            for mode in row.modes.iter().filter(|mode| !has(other, mode.frequency_hz)) {
                let images = (1..=4).flat_map(|n| {
                    let n = f64::from(n) * rate;
                    [n - mode.frequency_hz, n + mode.frequency_hz]
                });
                let within = images.filter(|image| *image < 0.5 * other_rate);
                for image in within.filter(|image| has(other, *image) && !has(row, *image)) {
                    notices.push(Notice {
                        kind: NoticeKind::MayBeFolded,
                        record: None,
                        channel: None,
                        what: format!(
                            "{:.3} Hz at {rate} samples/s is {image:.3} Hz folded: that is what {other_rate} samples/s \
                             show at the same pose",
                            mode.frequency_hz
                        ),
                    });
                }
            }
        }
    }
}

fn modes_differ(rows: &[PoseRow], notices: &mut Vec<Notice>) {
    let counts: Vec<usize> = rows
        .iter()
        .map(|row| row.modes.iter().filter(|mode| mode.suspicion.is_none()).count())
        .collect();
    let (least, most) = (counts.iter().min(), counts.iter().max());
    if let (Some(least), Some(most)) = (least, most)
        && least < most
    {
        notices.push(Notice {
            kind: NoticeKind::ModesDiffer,
            record: None,
            channel: None,
            what: format!(
                "poses have {least} to {most} modes: where one was missed, the next takes its column f1, f2, … in \
                 the table; compare the rows before you use them"
            ),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: weights 1 and 1/4, so 0.8 and 0.2; variances add to 0.8; a distance of 3 against 1 and 2 is
    /// χ² = 9/5.
    #[test]
    fn merging_weighs_by_variance_and_widens_where_records_scatter() {
        let (mean, std, ratio) = merged(&[(10.0, 1.0), (13.0, 2.0)]);
        assert!((mean - 10.6).abs() < 1e-12);
        assert!((ratio - 1.8_f64.sqrt()).abs() < 1e-12);
        assert!((std - (0.8_f64 * 1.8).sqrt()).abs() < 1e-12);
        assert_eq!(merged(&[(10.0, 1.0)]), (10.0, 1.0, 0.0));
        let (_, std, _) = merged(&[(10.0, 1.0), (10.1, 1.0)]);
        assert!((std - 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
