//! The renderers of a check on small results that are made by hand: what is expected is worked out from
//! the fixture below, not taken from an earlier run.

use std::path::{Path, PathBuf};

use detune::excitation::{ExcitationLine, Source};
use detune::job::{Carried, Policy};
use detune::notes::{Code, Note, Place};
use detune::report;
use detune::report::check::{github, gitlab, json, junit, plot_text, sarif, text};
use detune::risk::{
    Certainty, Crossing, JobRisk, LeftOut, ModeExchange, Move, OperationRisk, Sample, Verdict,
    closest_approach,
};
use detune::study::check::{CheckedJob, Gate};
use detune::uncertainty::Estimate;

const TOOTH_1: ExcitationLine =
    ExcitationLine { source: Source::ToothPassing, harmonic: 1, order: 2 };
const TOOTH_2: ExcitationLine =
    ExcitationLine { source: Source::ToothPassing, harmonic: 2, order: 4 };
const SPINDLE_1: ExcitationLine = ExcitationLine { source: Source::Spindle, harmonic: 1, order: 1 };

fn policy() -> Policy {
    Policy {
        tooth_passing_harmonics: 2,
        spindle_harmonics: 1,
        separation: 0.10,
        model_uncertainty: Some(0.08),
        confidence: 0.95,
        ignore_hz: Vec::new(),
        min_tip_response_m_per_n: Some(0.0),
        max_deflection_m: None,
        max_vibration_m: None,
    }
}

/// The arm at 0, 10, …, 100 % of the path: mode 1 rises from 20 to 30 Hz, mode 2 falls from 90 to 60 Hz.
fn samples(rpm: f64) -> Vec<Sample> {
    (0..=10)
        .map(|i| {
            let s = f64::from(i) / 10.0;
            Sample {
                s,
                joints: vec![s, -2.0 * s],
                beta1_rad: Some(s),
                beta2_rad: Some(1.0 + s),
                rpm,
                natural_frequencies_hz: vec![20.0 + 10.0 * s, 90.0 - 30.0 * s],
                natural_frequencies_ci95_hz: vec![[18.4 + 9.2 * s, 21.6 + 10.8 * s], [82.8, 97.2]],
                tip_response_m_per_n: vec![2e-6, 0.5e-6],
                families: vec![Some(0), None],
            }
        })
        .collect()
}

/// Shares of the strain energy in joint_2, joint_3 and base, largest first.
fn moves(shares: &[f64]) -> Vec<Move> {
    let names = ["joint_2", "joint_3", "base"];
    let part = |(&share, name): (&f64, &str)| Move { coordinate: name.to_owned(), share };
    let mut moves: Vec<Move> = shares.iter().zip(names).map(part).collect();
    moves.sort_by(|a, b| b.share.total_cmp(&a.share));
    moves
}

/// Mode 2 meets the second tooth-passing harmonic of 1100 rpm, 73.3 Hz.
fn crossing(certainty: Certainty, from_s: f64, to_s: f64) -> Crossing {
    Crossing {
        mode: 2,
        certainty,
        line: TOOTH_2,
        excitation_hz: 1100.0 / 60.0 * 4.0,
        natural_frequency_hz: 74.28,
        from_s,
        to_s,
        closest_s: 0.5,
        separation: 0.0127,
        tip_response_m_per_n: 0.51e-6,
        moves: moves(&[0.24, 0.71, 0.05]),
        leading_turn_together: Some(false),
        natural_frequency_ci95_hz: [68.3, 80.2],
        probability: Some(0.42),
        driver: None,
        accepted: None,
        file: "jobs/pocket.yaml".into(),
        from_line: 41,
        to_line: 58,
    }
}

fn operation(name: &str, crossings: Vec<Crossing>) -> OperationRisk {
    let verdict = crossings
        .iter()
        .map(|crossing| match crossing.certainty {
            Certainty::Certain => Verdict::Resonance,
            Certainty::Uncertain => Verdict::Uncertain,
        })
        .max()
        .unwrap_or(Verdict::Clear);
    let (samples, lines) = (samples(1100.0), vec![SPINDLE_1, TOOTH_1, TOOTH_2]);
    OperationRisk {
        tool_tip: None,
        stability: None,
        name: name.into(),
        program: None,
        verdict,
        tool: None,
        payload: Carried::NOTHING,
        spindle_rpm: 1100.0,
        spindle_min_rpm: 1100.0,
        spindle_max_rpm: 1100.0,
        spindle_schedule: None,
        duration_s: 12.5,
        closest: closest_approach(&samples, &lines, &policy(), 0.0),
        lines,
        left_out: LeftOut::default(),
        probability: 0.42,
        probability_std_error: 0.01,
        model_uncertainty: 0.08,
        uncertainty_by_mode: vec![0.08; 3],
        min_tip_response_m_per_n: 0.0,
        poses_solved: 11,
        samples,
        crossings,
        mode_exchanges: Vec::new(),
    }
}

fn job(file: &str, operations: Vec<(OperationRisk, Option<&str>)>) -> CheckedJob {
    CheckedJob {
        settings: None,
        overrides: Vec::new(),
        name: "Pocket, roughing".into(),
        file: file.into(),
        policy: policy(),
        risk: JobRisk {
            verdict: operations.iter().map(|o| o.0.verdict).max().unwrap_or(Verdict::Clear),
            calibrated: false,
            payload: Carried::NOTHING,
            model_uncertainty: 0.08,
            uncertainty_by_mode: vec![0.08; 3],
            probability: Estimate { probability: 0.42, std_error: 0.01, is_bound: false },
            separation: 0.10,
            coordinates: vec!["joint_2".into(), "joint_3".into(), "base".into()],
            operations: operations
                .into_iter()
                .map(|(mut risk, program)| {
                    risk.program = program.map(PathBuf::from);
                    for crossing in &mut risk.crossings {
                        crossing.file = program.unwrap_or(file).into();
                    }
                    risk
                })
                .collect(),
            warnings: vec![
                Note::warning(Code::Assumed, Place::line("a.yaml", 3), "something to know").into(),
            ],
        },
    }
}

fn resonant() -> CheckedJob {
    let crossings = vec![
        crossing(Certainty::Uncertain, 0.20, 0.30),
        crossing(Certainty::Certain, 0.30, 0.70),
        crossing(Certainty::Uncertain, 0.70, 0.80),
    ];
    job("jobs/pocket.yaml", vec![(operation("rough", crossings), Some("../nc/pocket.mod"))])
}

fn clear() -> CheckedJob {
    job("jobs/clear.yaml", vec![(operation("finish", Vec::new()), None)])
}

/// Every renderer on the same jobs.
fn rendered(jobs: &[CheckedJob]) -> Vec<String> {
    let root = Path::new("/work piece");
    vec![
        text::check(jobs, false),
        text::check(jobs, true),
        json::check(jobs).unwrap(),
        sarif::check(jobs, root, &Path::to_owned).unwrap(),
        gitlab::check(jobs, &Path::to_owned).unwrap(),
        junit::check(jobs, Gate::From(Verdict::Resonance)).unwrap(),
        junit::check(jobs, Gate::From(Verdict::Uncertain)).unwrap(),
        github::check(jobs, root),
    ]
}

fn value(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

mod as_text {
    use super::*;

    #[test]
    fn a_planner_reads_the_worst_crossing_in_words() {
        let text = text::check(&[resonant()], false);
        let (facts, rest) = text.split_once("\n\n      Hz\n").unwrap();
        // 0.3 and 0.7 of 12.5 s are 3.75 and 8.75 s; β2 is 1.5 rad at s = 0.5.
        assert_eq!(
            facts,
            "RESONANCE  jobs/pocket.yaml  Pocket, roughing

  rough  RESONANCE  1100 rpm, 12.5 s
    mode 2 (74.3 Hz) meets tooth passing × 2 of 1100 rpm (73.3 Hz)
      apart    1.3 %, inside the band of ±10 %
      interval 68.3–80.2 Hz with 95 % confidence
      risk     42 % that the line lies in the band on this stretch
      moves    joint_3 71 %, joint_2 24 %, turning against each other
      where    30.0–70.0 % of the path (3.8–8.8 s); uncertain 20.0–80.0 %
      closest  at 50.0 % (6.25 s, β2 85.9°)
      lines    nc/pocket.mod:41–58
      tool tip 0.510 µm/N at resonance"
        );
        assert!(
            rest.ends_with(
                "
  model    not calibrated; assumed uncertainty ±8 %
  explain  detune explain assumed
  next     use another spindle speed or arm pose on these stretches, then check again
"
            ),
            "{rest}"
        );
    }

    #[test]
    fn a_clear_job_tells_its_smallest_margin() {
        let mut job = clear();
        // Tooth passing alone, and mode 2 far above its second harmonic.
        job.risk.operations[0].lines.remove(0);
        for sample in &mut job.risk.operations[0].samples {
            sample.natural_frequencies_hz[1] += 100.0;
        }
        let operation = &mut job.risk.operations[0];
        operation.closest = closest_approach(&operation.samples, &operation.lines, &policy(), 0.0);
        job.risk.calibrated = true;
        let text = text::check(&[job], false);
        // Mode 1 at s = 1 has 30 Hz; 1100 rpm with two teeth strikes at 36.7 Hz.
        assert!(
            text.contains(
                "
  finish  CLEAR  1100 rpm, 12.5 s
      closest  tooth passing × 1 of 1100 rpm (36.7 Hz) stays 22.2 % away from mode 1 (30.0 Hz)
      where    at 100.0 % (12.5 s, β2 114.6°)
      required 18 % (band 10 %, model 8 %)
"
            ),
            "{text}"
        );
        assert!(text.starts_with("CLEAR  jobs/clear.yaml  Pocket, roughing\n"));
        assert!(text.contains("  model    calibrated with measured frequencies; uncertainty"));
        assert!(text.contains("chatter is not checked"));
    }

    #[test]
    fn an_uncertain_crossing_says_why() {
        let crossings = vec![crossing(Certainty::Uncertain, 0.2, 0.3)];
        let text =
            text::check(&[job("a.yaml", vec![(operation("rough", crossings), None)])], false);
        let near =
            "apart    1.3 %, outside the band of ±10 % but within the model uncertainty of ±8 %\n";
        assert!(text.contains(near), "{text}");
        assert!(text.contains("lines    a.yaml:41–58"));
        assert!(text.contains("next     keep more distance from the mode, or calibrate the model"));
    }

    #[test]
    fn further_crossings_are_a_table_that_ends() {
        let crossings = (0..9)
            .map(|i| {
                let s = f64::from(i) / 10.0;
                let mut crossing = crossing(Certainty::Certain, s, s + 0.05);
                crossing.tip_response_m_per_n = 1e-6 * (1.0 + f64::from(i));
                crossing
            })
            .collect();
        let text = text::check(&[job("a.yaml", vec![(operation("o", crossings), None)])], false);
        let table = "      further  8 certain, 0 uncertain; lines of a.yaml
      mode    Hz  meets              Hz  apart        s %  lines  µm/N  certainty
         2  74.3  tooth passing × 2  73.3  1.3 %  70.0–75.0  41–58  8.00  certain
";
        let squeezed =
            |text: &str| text.split(' ').filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ");
        assert!(squeezed(&text).contains(&squeezed(table)), "{text}");
        assert!(text.contains("      … and 3 more; --format json lists all\n"), "{text}");
        assert!(text.contains("tool tip 9.00 µm/N"), "the worst moves the tip most:\n{text}");
    }

    #[test]
    fn exchanges_of_modes_are_noted() {
        let mut job = clear();
        job.risk.operations[0].mode_exchanges =
            (0..5).map(|i| ModeExchange { s: 0.1 * f64::from(i), lower_mode: 1 }).collect();
        let text = text::check(&[job], false);
        assert!(text.contains("note     modes 1 and 2 swap order at 20.0 % of the path\n"));
        assert!(text.contains("note     … and 2 more swaps of modes\n"));
    }

    #[test]
    fn what_moves_is_told_by_share() {
        let told = |shares: &[f64], together: Option<bool>| {
            let mut one = crossing(Certainty::Certain, 0.3, 0.7);
            one.moves = moves(shares);
            one.leading_turn_together = together;
            let job = job("a.yaml", vec![(operation("o", vec![one]), None)]);
            let text = text::check(&[job], false);
            text.lines()
                .find_map(|line| line.strip_prefix("      moves    ").map(str::to_owned))
                .unwrap_or_default()
        };
        assert_eq!(
            told(&[0.6, 0.4, 0.0], Some(true)),
            "joint_2 60 %, joint_3 40 %, turning together"
        );
        assert_eq!(
            told(&[0.3, 0.2, 0.5], Some(false)),
            "base 50 %, joint_2 30 %, joint_3 20 %, the first two turning against each other"
        );
        assert_eq!(told(&[0.6, 0.4], None), "joint_2 60 %, joint_3 40 %");
        assert_eq!(told(&[0.04, 0.95, 0.01], Some(true)), "joint_3 95 %");
        assert_eq!(told(&[], None), "");
    }

    #[test]
    fn several_jobs_are_counted() {
        let text = text::check(&[resonant(), clear(), resonant()], false);
        assert!(
            text.ends_with(
                "\n3 jobs: 2 resonance, 1 clear\n  RESONANCE  jobs/pocket.yaml\n  RESONANCE  jobs/pocket.yaml\n"
            ),
            "{text}"
        );
    }

    #[test]
    fn colour_adds_escape_sequences_and_nothing_else() {
        let jobs = [resonant(), clear()];
        let (plain, colourful) = (text::check(&jobs, false), text::check(&jobs, true));
        assert!(!plain.contains('\x1b'));
        assert!(colourful.starts_with("\x1b[1;31mRESONANCE\x1b[0m  jobs"));
        let mut stripped = String::new();
        let mut inside = false;
        for c in colourful.chars() {
            match c {
                '\x1b' => inside = true,
                'm' if inside => inside = false,
                _ if inside => {}
                _ => stripped.push(c),
            }
        }
        assert_eq!(stripped, plain);
    }
}

mod as_drawing {
    use super::*;

    const COLUMNS: usize = 60;
    const ROWS: usize = 16;

    fn dots(drawing: &str) -> Vec<Vec<char>> {
        drawing
            .lines()
            .filter_map(|line| line.split_once(['┤', '│']))
            .map(|(_, dots)| {
                let mut dots: Vec<char> = dots.chars().take(COLUMNS).collect();
                dots.resize(COLUMNS, ' ');
                dots
            })
            .collect()
    }

    /// Frequencies at the centres of the first and the last row, as the axis says.
    fn ticks(drawing: &str) -> [f64; 2] {
        let ticks: Vec<f64> = drawing
            .lines()
            .filter_map(|line| line.split_once(" ┤"))
            .map(|(tick, _)| tick.trim().parse().unwrap())
            .collect();
        [ticks[0], *ticks.last().unwrap()]
    }

    /// Reads the drawing back: every dot lies within the height of a dot of the law that was drawn, and
    /// every column has one.
    #[test]
    fn the_dots_lie_on_the_curve() {
        let mut operation = operation("o", Vec::new());
        operation.lines.clear();
        for sample in &mut operation.samples {
            sample.natural_frequencies_hz = vec![90.0 - 30.0 * sample.s];
        }
        let drawing = plot_text::frequencies(&operation, &[], false);
        let rows = dots(&drawing);
        assert_eq!(rows.len(), ROWS);
        let [first, last] = ticks(&drawing);
        let dot_hz = (first - last) / (ROWS - 1) as f64 / 4.0;
        let mut columns_hit = [0; 2 * COLUMNS];
        for (row, characters) in rows.iter().enumerate() {
            for (column, &character) in characters.iter().enumerate() {
                let bits = if character == ' ' { 0 } else { character as u32 - 0x2800 };
                for (bit, (x, y)) in
                    [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3)]
                        .iter()
                        .enumerate()
                {
                    if bits >> bit & 1 == 0 {
                        continue;
                    }
                    columns_hit[2 * column + x] += 1;
                    let s =
                        (2.0 * column as f64 + f64::from(*x as u8) + 0.5) / (2 * COLUMNS) as f64;
                    let expected = 90.0 - 30.0 * s;
                    let centre = first + 1.5 * dot_hz - dot_hz * (4 * row + y) as f64;
                    // Half a dot up and down, half a column of slope (0.125 Hz), rounding of the ticks.
                    let tolerance = dot_hz / 2.0 + 0.125 + 0.1;
                    assert!(
                        (centre - expected).abs() < tolerance,
                        "{centre} {expected}\n{drawing}"
                    );
                }
            }
        }
        assert!(columns_hit.iter().all(|&hits| (1..=3).contains(&hits)), "{drawing}");
    }

    #[test]
    fn a_spike_between_columns_is_drawn() {
        let mut operation = operation("o", Vec::new());
        operation.lines.clear();
        let at = |s: f64, hz: f64| Sample {
            s,
            natural_frequencies_hz: vec![hz],
            ..samples(1100.0).remove(0)
        };
        operation.samples = vec![
            at(0.0, 50.0),
            at(0.5001, 50.0),
            at(0.5002, 80.0),
            at(0.5003, 50.0),
            at(1.0, 50.0),
        ];
        let drawing = plot_text::frequencies(&operation, &[], false);
        assert!(dots(&drawing)[..4].iter().any(|row| row[30] != ' '), "{drawing}");
    }

    #[test]
    fn lines_are_dashed_and_curves_are_named_at_their_ends() {
        let drawing = plot_text::frequencies(&operation("o", Vec::new()), &[], false);
        for name in ["f1", "f2", "tooth ×1", "tooth ×2", "spindle ×1"] {
            assert!(
                drawing.lines().any(|line| line.trim_end().ends_with(name)),
                "{name}\n{drawing}"
            );
        }
        let line = drawing.lines().find(|line| line.ends_with("tooth ×1")).unwrap();
        let dashes = &dots(line)[0];
        assert_eq!(dashes.iter().filter(|&&dash| dash == ' ').count(), COLUMNS / 2, "{line}");
    }

    #[test]
    fn marks_stand_below_their_place() {
        let drawing = plot_text::frequencies(&resonant().risk.operations[0], &[], false);
        let marks = drawing.lines().find(|line| line.contains('█')).unwrap();
        let marks: Vec<char> = marks.chars().skip(10).collect();
        let of = |s: f64| marks[(s * COLUMNS as f64) as usize];
        assert_eq!([of(0.15), of(0.25), of(0.5), of(0.65), of(0.75)], [' ', '░', '█', '█', '░']);
        assert_eq!(marks.len(), 49);
    }

    #[test]
    fn far_modes_do_not_squeeze_the_drawing() {
        let mut operation = operation("o", vec![crossing(Certainty::Certain, 0.3, 0.7)]);
        for sample in &mut operation.samples {
            sample.natural_frequencies_hz.push(900.0);
        }
        let focus = [(2, TOOTH_2)];
        let [first, last] = ticks(&plot_text::frequencies(&operation, &focus, false));
        assert!(first < 100.0 && last < 40.0, "{first} {last}");
    }

    #[test]
    fn odd_data_is_drawn_or_left_out() {
        let odd = [f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX, 0.0, 1e-300, 5.0];
        for a in odd {
            for b in odd {
                for s in [[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]] {
                    let mut operation = operation("o", vec![crossing(Certainty::Certain, a, b)]);
                    operation.samples.truncate(2);
                    for (sample, (s, hz)) in
                        operation.samples.iter_mut().zip([(s[0], a), (s[1], b)])
                    {
                        sample.s = s;
                        sample.rpm = b;
                        sample.natural_frequencies_hz = vec![hz, hz];
                    }
                    for focus in [&[][..], &[(1, TOOTH_1)], &[(7, TOOTH_1)]] {
                        let drawing = plot_text::frequencies(&operation, focus, true);
                        assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
                    }
                }
            }
        }
        let mut operation = operation("o", Vec::new());
        operation.samples.truncate(1);
        let one = plot_text::frequencies(&operation, &[], false);
        assert!(one.contains(" f1") && one.contains(" f2"), "{one}");
        operation.samples.clear();
        assert_eq!(plot_text::frequencies(&operation, &[], false), "");
    }
}

mod as_json {
    use super::*;

    #[test]
    fn the_fields_of_the_contract_are_there() {
        let output = value(&json::check(&[resonant(), clear()]).unwrap());
        assert_eq!(output["schema"], "check/1");
        assert_eq!(output["verdict"], "resonance");
        let job = &output["jobs"][0];
        assert_eq!(job["job"], "jobs/pocket.yaml");
        assert_eq!(job["verdict"], "resonance");
        assert_eq!(job["model"]["calibrated"], false);
        assert_eq!(job["model"]["uncertainty_percent"], 8.0);
        let operation = &job["operations"][0];
        assert_eq!(operation["name"], "rough");
        assert_eq!(operation["spindle_rpm"], 1100.0);
        assert_eq!(operation["duration_s"], 12.5);
        let sample = &operation["samples"][3];
        assert_eq!(sample["s"], 0.3);
        assert_eq!(sample["joints_rad"], serde_json::json!([0.3, -0.6]));
        assert_eq!(sample["beta2_rad"], 1.3);
        assert_eq!(sample["natural_frequencies_hz"], serde_json::json!([23.0, 81.0]));
        assert_eq!(sample["families"], serde_json::json!([0, null]));
        assert_eq!(operation["samples"].as_array().unwrap().len(), 11);
        let crossings = operation["crossings"].as_array().unwrap();
        assert_eq!(crossings.len(), 3, "flanks are listed here");
        let crossing = &crossings[1];
        assert_eq!(crossing["mode"], 2);
        assert_eq!(crossing["certainty"], "certain");
        assert_eq!(crossing["source"], "tooth_passing");
        assert_eq!(crossing["harmonic"], 2);
        // All digits: the same double comes back.
        assert_eq!(crossing["excitation_hz"].as_f64(), Some(1100.0 / 60.0 * 4.0));
        assert_eq!([&crossing["from_s"], &crossing["to_s"]], [0.3, 0.7]);
        assert_eq!(crossing["closest_s"], 0.5);
        assert_eq!(crossing["separation_percent"], 1.27);
        assert_eq!(crossing["tip_response_um_per_n"], 0.51);
        assert_eq!(crossing["file"], "../nc/pocket.mod");
        assert_eq!([&crossing["from_line"], &crossing["to_line"]], [41, 58]);
        assert_eq!(
            crossing["moves"][0],
            serde_json::json!({"coordinate": "joint_3", "share": 0.71})
        );
        assert_eq!(crossings[0]["certainty"], "uncertain");
        let second = &output["jobs"][1];
        assert_eq!(second["verdict"], "clear");
        assert_eq!(second["operations"][0]["crossings"], serde_json::json!([]));
    }

    #[test]
    fn a_path_in_the_job_itself_names_the_job() {
        let crossings = vec![crossing(Certainty::Certain, 0.0, 1.0)];
        let job = job("jobs/a.yaml", vec![(operation("o", crossings), None)]);
        let output = value(&json::check(&[job]).unwrap());
        assert_eq!(output["jobs"][0]["operations"][0]["crossings"][0]["file"], "jobs/a.yaml");
    }

    #[test]
    fn each_sample_and_crossing_stands_on_one_line() {
        let text = json::check(&[resonant()]).unwrap();
        assert_eq!(text.lines().filter(|line| line.contains("joints_rad")).count(), 11);
        assert!(
            text.lines()
                .filter(|line| line.contains("\"closest_s\""))
                .all(|line| value(line.trim().trim_end_matches(',')).is_object())
        );
        assert!(text.ends_with("}\n"));
    }

    #[test]
    fn a_number_that_is_not_finite_is_refused() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut job = resonant();
            job.risk.operations[0].crossings[1].tip_response_m_per_n = bad;
            let told = json::check(&[job]).unwrap_err().to_string();
            assert!(told.contains("must be finite"), "{told}");
        }
    }

    /// What the schema asks for is what is written: key by key, on every object.
    #[test]
    fn the_schema_and_the_output_have_the_same_keys() {
        let schema = report::schema::check();
        let mut job = resonant();
        job.risk.operations[0].mode_exchanges.push(ModeExchange { s: 0.4, lower_mode: 1 });
        let output = value(&json::check(&[job]).unwrap());
        let mut seen = 0;
        compare(&schema, &schema, &output, &mut seen);
        assert!(seen > 20, "only {seen} objects were compared");
    }

    /// Sections that stand only where the job says what is cut, and how.
    const LEFT_AWAY: [&str; 2] = ["stability", "tool_tip"];

    fn compare(
        root: &serde_json::Value,
        schema: &serde_json::Value,
        value: &serde_json::Value,
        seen: &mut usize,
    ) {
        let schema = match schema["$ref"].as_str() {
            Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
            None => schema,
        };
        let schema = match schema["anyOf"].as_array() {
            Some(choices) if !value.is_null() => return compare(root, &choices[0], value, seen),
            _ => schema,
        };
        if let Some(object) = value.as_object() {
            *seen += 1;
            let properties = schema["properties"].as_object().unwrap();
            let keys = |keys: Vec<&String>| {
                let mut keys: Vec<String> = keys.into_iter().cloned().collect();
                keys.sort();
                keys
            };
            let is_told =
                |key: &&String| !LEFT_AWAY.contains(&key.as_str()) || object.contains_key(*key);
            let known = keys(properties.keys().filter(is_told).collect());
            assert_eq!(known, keys(object.keys().collect()));
            for (key, inner) in object {
                compare(root, &properties[key], inner, seen);
            }
        }
        for inner in value.as_array().into_iter().flatten() {
            compare(root, &schema["items"], inner, seen);
        }
    }
}

mod as_sarif {
    use super::*;

    fn log(jobs: &[CheckedJob]) -> serde_json::Value {
        value(&sarif::check(jobs, Path::new("/work piece"), &Path::to_owned).unwrap())
    }

    #[test]
    fn the_frame_is_that_of_the_standard() {
        let log = log(&[clear()]);
        assert_eq!(log["version"], "2.1.0");
        let run = &log["runs"][0];
        let driver = &run["tool"]["driver"];
        assert_eq!(driver["name"], "detune");
        assert_eq!(driver["rules"][0]["id"], "resonance");
        assert_eq!(driver["rules"][1]["id"], "uncertain");
        assert_eq!(run["invocations"][0]["executionSuccessful"], true);
        assert_eq!(run["results"], serde_json::json!([]));
        assert_eq!(run["artifacts"][0]["location"]["uri"], "jobs/clear.yaml");
    }

    #[test]
    fn a_result_points_at_lines_of_the_program() {
        let log = log(&[resonant()]);
        let results = log["runs"][0]["results"].as_array().unwrap();
        assert_eq!(results.len(), 1, "flanks are part of the result");
        let result = &results[0];
        assert_eq!(result["ruleId"], "resonance");
        assert_eq!(result["level"], "error");
        let physical = &result["locations"][0]["physicalLocation"];
        assert_eq!(physical["artifactLocation"]["uri"], "nc/pocket.mod");
        assert_eq!(physical["artifactLocation"]["index"], 1);
        assert_eq!(log["runs"][0]["artifacts"][1]["location"]["uri"], "nc/pocket.mod");
        assert_eq!(physical["region"], serde_json::json!({"startLine": 41, "endLine": 58}));
        assert_eq!(
            result["message"]["text"],
            "operation 'rough': mode 2 (74.3 Hz) meets tooth passing × 2 of 1100 rpm (73.3 Hz): 1.3 % \
             apart, inside the band of ±10 %, at 30.0–70.0 % of the path (3.8–8.8 s) (uncertain \
             20.0–80.0 %), closest at 50.0 % (6.25 s, β2 85.9°); it moves joint_3 71 %, joint_2 24 %, \
             turning against each other; 0.510 µm/N at the tool tip at resonance"
        );
    }

    #[test]
    fn stretches_of_one_mode_and_line_are_one_result() {
        let mut crossings: Vec<Crossing> = (0..4)
            .map(|i| {
                let s = 0.2 * f64::from(i);
                crossing(Certainty::Certain, s, s + 0.1)
            })
            .collect();
        crossings[2].separation = 0.001;
        crossings[2].from_line = 70;
        crossings[2].to_line = 90;
        crossings.push(crossing(Certainty::Uncertain, 0.95, 1.0));
        let log = log(&[job("a.yaml", vec![(operation("o", crossings), None)])]);
        let results = log["runs"][0]["results"].as_array().unwrap();
        assert_eq!(results.len(), 2);
        let region = &results[0]["locations"][0]["physicalLocation"]["region"];
        assert_eq!(*region, serde_json::json!({"startLine": 70, "endLine": 90}));
        let related = results[0]["relatedLocations"].as_array().unwrap();
        assert_eq!(
            related.iter().map(|l| l["id"].as_u64().unwrap()).collect::<Vec<_>>(),
            [1, 2, 3]
        );
        assert_eq!(related[0]["message"]["text"], "0.0–10.0 % of the path (0.0–1.2 s)");
        assert!(
            results[0]["message"]["text"].as_str().unwrap().ends_with("also on 3 more stretches")
        );
        assert_eq!(results[1]["ruleId"], "uncertain");
        assert_eq!(results[1]["level"], "warning");
    }

    fn fingerprint(job: &CheckedJob) -> serde_json::Value {
        log(std::slice::from_ref(job))["runs"][0]["results"][0]["partialFingerprints"].clone()
    }

    #[test]
    fn fingerprints_follow_the_finding_and_no_number() {
        let job = resonant();
        let same = fingerprint(&job);
        assert_eq!(
            same["detuneFinding/v1"],
            "resonance|jobs/pocket.yaml|rough|mode 2|tooth_passing 2"
        );
        let mut moved = job.clone();
        let crossing = &mut moved.risk.operations[0].crossings[1];
        crossing.from_line += 7;
        crossing.natural_frequency_hz += 1.0;
        crossing.separation *= 1.1;
        crossing.tip_response_m_per_n *= 2.0;
        assert_eq!(fingerprint(&moved), same);
        type Change = fn(&mut CheckedJob);
        let changes: [Change; 4] = [
            |job| job.file = "jobs/other.yaml".into(),
            |job| job.risk.operations[0].name = "other".into(),
            |job| job.risk.operations[0].crossings[1].mode = 1,
            |job| job.risk.operations[0].crossings[1].line = TOOTH_1,
        ];
        for change in changes {
            let mut other = job.clone();
            other.risk.operations[0].crossings.retain(|c| c.certainty == Certainty::Certain);
            other.risk.operations[0]
                .crossings
                .insert(0, job.risk.operations[0].crossings[0].clone());
            change(&mut other);
            let other = fingerprint(&other);
            assert_ne!(other["primaryLocationLineHash"], same["primaryLocationLineHash"]);
            assert_ne!(other["detuneFinding/v1"], same["detuneFinding/v1"]);
        }
    }

    #[test]
    fn uris_are_relative_to_the_root_where_they_can_be() {
        let crossings = || vec![crossing(Certainty::Certain, 0.0, 1.0)];
        let uri = |file: &str| {
            let log = log(&[job(file, vec![(operation("o", crossings()), None)])]);
            let place = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"].clone();
            let place = &place["artifactLocation"];
            (
                place["uri"].as_str().unwrap().to_owned(),
                place["uriBaseId"].as_str().map(str::to_owned),
            )
        };
        let root = Some("%SRCROOT%".to_owned());
        assert_eq!(uri("/work piece/jobs/a b.yaml"), ("jobs/a%20b.yaml".into(), root.clone()));
        assert_eq!(uri("./jobs/../a.yaml"), ("a.yaml".into(), root));
        assert_eq!(uri("/else where/a.yaml"), ("file:///else%20where/a.yaml".into(), None));
    }

    #[test]
    fn a_run_holds_what_github_takes() {
        let mut all = Vec::new();
        for mode in 1..=26_000 {
            let mut one = crossing(Certainty::Uncertain, 0.0, 1.0);
            one.mode = mode;
            all.push(one);
        }
        let last = all.last_mut().unwrap();
        last.certainty = Certainty::Certain;
        let jobs: Vec<CheckedJob> = all
            .chunks(100)
            .map(|some| job("a.yaml", vec![(operation("o", some.to_vec()), None)]))
            .collect();
        let log = log(&jobs);
        let run = &log["runs"][0];
        assert_eq!(run["results"].as_array().unwrap().len(), 25_000);
        assert_eq!(run["results"][0]["level"], "error", "what is certain is kept");
        let note = &run["invocations"][0]["toolExecutionNotifications"][0]["message"]["text"];
        assert!(note.as_str().unwrap().starts_with("1000 findings omitted"));
    }
}

mod as_junit {
    use super::*;

    fn parsed(text: &str) -> roxmltree::Document<'_> {
        roxmltree::Document::parse(text).unwrap()
    }

    #[test]
    fn an_operation_is_a_case_and_passes_when_nothing_is_found() {
        let text = junit::check(&[resonant(), clear()], Gate::From(Verdict::Resonance)).unwrap();
        let document = parsed(&text);
        let root = document.root_element();
        assert_eq!(root.attribute("tests"), Some("2"));
        assert_eq!(root.attribute("failures"), Some("1"));
        let cases: Vec<_> = document.descendants().filter(|n| n.has_tag_name("testcase")).collect();
        assert_eq!(cases[0].attribute("name"), Some("rough"));
        let failure = cases[0].children().find(|n| n.has_tag_name("failure")).unwrap();
        assert_eq!(failure.attribute("type"), Some("resonance"));
        assert_eq!(failure.attribute("message"), Some("operation 'rough': resonance (1 finding)"));
        assert!(
            failure.text().unwrap().starts_with("nc/pocket.mod:41–58: operation 'rough': mode 2")
        );
        assert_eq!(cases[1].children().count(), 0);
        for forbidden in ["timestamp", "uuid", "time="] {
            assert!(!text.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn an_uncertain_operation_fails_only_if_asked() {
        let crossings = vec![crossing(Certainty::Uncertain, 0.2, 0.3)];
        let jobs = [job("a.yaml", vec![(operation("o", crossings), None)])];
        let passing = junit::check(&jobs, Gate::From(Verdict::Resonance)).unwrap();
        assert_eq!(parsed(&passing).root_element().attribute("failures"), Some("0"));
        let document = parsed(&passing);
        let out = document.descendants().find(|n| n.has_tag_name("system-out")).unwrap();
        assert!(out.text().unwrap().starts_with("uncertain: a.yaml:41–58: operation 'o'"));
        let failing = junit::check(&jobs, Gate::From(Verdict::Uncertain)).unwrap();
        assert_eq!(parsed(&failing).root_element().attribute("failures"), Some("1"));
    }

    #[test]
    fn names_cannot_break_the_document() {
        let crossings = vec![crossing(Certainty::Certain, 0.2, 0.3)];
        let name = "a <b> & \"c\" ]]> \u{1} \u{1b}[31m";
        let text = junit::check(
            &[job("a&b.yaml", vec![(operation(name, crossings), None)])],
            Gate::From(Verdict::Resonance),
        )
        .unwrap();
        let document = parsed(&text);
        let case = document.descendants().find(|n| n.has_tag_name("testcase")).unwrap();
        assert_eq!(case.attribute("name"), Some(r#"a <b> & "c" ]]> \u{1} \u{1b}[31m"#));
    }
}

mod as_annotations {
    use super::*;

    #[test]
    fn a_finding_is_a_command_at_its_lines() {
        let text = github::check(&[resonant()], Path::new("/"));
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        let head = "::error file=nc/pocket.mod,line=41,endLine=58,title=detune%3A resonance in \
                    'rough'::operation 'rough': mode 2 (74.3 Hz) meets tooth passing × 2 of 1100 rpm \
                    (73.3 Hz): 1.3 %25 apart";
        assert!(lines[0].starts_with(head), "{}", lines[0]);
        assert_eq!(lines[1], "detune check: jobs/pocket.yaml resonance");
    }

    #[test]
    fn names_are_escaped() {
        let crossings = vec![crossing(Certainty::Certain, 0.2, 0.3)];
        let jobs =
            [job("a,b:c%\n::x::.yaml", vec![(operation("o\r\n::error::", crossings), None)])];
        let text = github::check(&jobs, Path::new("/"));
        assert_eq!(text.lines().count(), 2, "{text}");
        assert!(
            text.starts_with(r"::error file=a%2Cb%3Ac%25\n%3A%3Ax%3A%3A.yaml,line=41,"),
            "{text}"
        );
        assert!(text.contains(r"title=detune%3A resonance in 'o\r\n%3A%3Aerror%3A%3A'::operation"));
    }

    #[test]
    fn ten_a_level_and_the_last_counts_the_rest() {
        let of = |certainty, count| {
            (1..=count).map(move |mode| {
                let mut one = crossing(certainty, 0.0, 1.0);
                one.mode = mode;
                one.line = if certainty == Certainty::Certain { TOOTH_1 } else { TOOTH_2 };
                one
            })
        };
        let all = of(Certainty::Certain, 12).chain(of(Certainty::Uncertain, 10)).collect();
        let text =
            github::check(&[job("a.yaml", vec![(operation("o", all), None)])], Path::new("/"));
        let commands = |level: &str| {
            text.lines()
                .filter(|line| line.starts_with(level))
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        let (errors, warnings) = (commands("::error "), commands("::warning "));
        assert_eq!([errors.len(), warnings.len()], [10, 10]);
        assert!(errors[9].ends_with("%0A… and 2 more like this; --format json or sarif lists all"));
        assert!(!errors[8].contains("more like this") && !warnings[9].contains("more like this"));
    }
}

#[test]
fn every_renderer_takes_every_result() {
    let many = (0..300)
        .map(|i| {
            let mut one = crossing(
                if i % 3 == 0 { Certainty::Certain } else { Certainty::Uncertain },
                f64::from(i) / 300.0,
                f64::from(i + 1) / 300.0,
            );
            one.mode = 1 + (i as usize % 7);
            one.moves.truncate(i as usize % 4);
            one.leading_turn_together = [None, Some(true), Some(false)][i as usize % 3];
            one
        })
        .collect();
    let mut bare = operation("", Vec::new());
    bare.samples.clear();
    bare.closest = None;
    bare.lines.clear();
    let cases = [
        Vec::new(),
        vec![clear()],
        vec![resonant()],
        vec![job("ü 漢.yaml", vec![(operation("viele", many), Some("n.mod")), (bare, None)])],
        vec![resonant(), clear(), resonant()],
        vec![job("none.yaml", Vec::new())],
    ];
    for jobs in &cases {
        let texts = rendered(jobs);
        assert_eq!(texts, rendered(jobs), "the same bytes");
        for text in &texts {
            assert!(text.ends_with('\n') || (jobs.is_empty() && text.is_empty()), "{text}");
            assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
        }
    }
}

#[test]
fn the_closest_approach_is_that_of_a_plain_search() {
    let operation = operation("o", Vec::new());
    let closest = closest_approach(&operation.samples, &operation.lines, &policy(), 0.0).unwrap();
    let mut best = f64::INFINITY;
    for s in (0..=10).map(|i| f64::from(i) / 10.0) {
        for mode in [20.0 + 10.0 * s, 90.0 - 30.0 * s] {
            for line in [1100.0 / 60.0, 1100.0 / 30.0, 1100.0 / 15.0] {
                best = best.min(((line - mode) / mode).abs());
            }
        }
    }
    assert!((closest.separation - best).abs() < 1e-15);
    assert_eq!((closest.mode, closest.line, closest.s), (2, TOOTH_2, 0.6));

    let mut policy = policy();
    policy.ignore_hz = vec![[73.0, 74.0]];
    let without = closest_approach(&operation.samples, &operation.lines, &policy, 0.0).unwrap();
    assert_eq!((without.mode, without.line, without.s), (1, SPINDLE_1, 0.0));
    assert_eq!(closest_approach(&operation.samples, &operation.lines, &policy, 1e-5), None);
}
