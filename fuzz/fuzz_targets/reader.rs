//! A text is read or refused, never more; what is read is rewritten or refused, and what is rewritten
//! reads as it should.

use std::sync::Arc;

use detune::motion::{MechanicalUnit, Move, Target, UnitAxis};
use detune::program::{
    Companion, Dialect, NewSpeed, Rewrite, SetBy, Setter, Settings, Spindle, read, rewrite,
};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

fn settings() -> Settings {
    let mut settings = Settings {
        feed_m_per_s: Some(0.01),
        joint_count: 6,
        tcp: Some(Default::default()),
        work_object: Some(Default::default()),
        ..Settings::default()
    };
    let axes = [("eax_b", false), ("eax_c", true)].map(|(name, slides)| UnitAxis {
        name: name.to_owned(),
        axis: Unit::new_normalize(Vector3::z()),
        origin_m: Point3::origin(),
        slides,
    });
    let frame = Isometry3::translation(1.0, 0.0, 0.5);
    let unit = MechanicalUnit { name: "STN1".to_owned(), axes: axes.into(), frame };
    settings.mechanical_units.insert("stn1".to_owned(), Arc::new(unit));
    settings.spindle_from =
        Some(SetBy { what: Setter::Procedure("SPINDLE".to_owned(), 1), per_unit: 1.0 });
    settings
}

fn is_sound(each: &Move) -> bool {
    let finite = match &each.to {
        Target::Joints(q) => q.iter().all(|q| q.is_finite()),
        Target::JointsTo(end) | Target::Line(end) => {
            end.translation.vector.iter().all(|x| x.is_finite())
        }
        Target::Arc { via, end, .. } => {
            let points = [via, end].map(|pose| pose.translation.vector);
            points.iter().all(|point| point.iter().all(|x| x.is_finite()))
        }
    };
    finite && each.feed_m_per_s.is_finite() && each.feed_m_per_s > 0.0
}

/// The program rewritten, where it is read and can be.
pub(crate) fn run(dialect: Dialect, data: &[u8]) -> Option<Vec<u8>> {
    let mut settings = settings();
    // Behind a mark stands another file of the program.
    let (main, other) = match data.windows(2).position(|two| two == b"\x01\x01") {
        Some(at) => (&data[..at], Some(&data[at + 2..])),
        None => (data, None),
    };
    if let Some(Ok(other)) = other.map(|other| Companion::new("other".to_owned(), other)) {
        settings.companions.push(other);
    }
    let program = match read(main, dialect, &settings) {
        Ok(program) => program,
        Err(notes) => {
            assert!(!notes.is_empty());
            return None;
        }
    };
    assert!(program.moves.iter().all(is_sound));
    let speed = NewSpeed { end: usize::MAX, rpm: 1234.5, job_rpm: None };
    let to = Rewrite { speeds: vec![speed], keeps_chip_load: true };
    let new = rewrite(main, dialect, &settings, &to).ok()?;
    let again = read(&new.bytes, dialect, &settings).expect("what was written is read");
    assert_eq!(again.moves.len(), program.moves.len());
    for (old, new) in program.moves.iter().zip(&again.moves).skip(1) {
        assert_eq!((&old.to, &old.work), (&new.to, &new.work));
        if let Some(Spindle::Turns(Some(rpm))) = new.stated.spindle {
            assert!((rpm - 1234.5).abs() < 1e-3);
        }
    }
    Some(new.bytes)
}
