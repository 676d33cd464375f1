//! `detune map` with Apache Arrow: the tables in `tests/data/arrow` were written by PyArrow (`make.py` beside
//! them). `cargo test --test commands map_arrow`; without the feature `arrow`, that it is told.

use crate::map_command::{bytes, fed};

const ARM: &str = "robots/two-link --poses";

#[cfg(feature = "arrow")]
mod with_arrow {
    use std::fs;

    use super::*;

    const POSES: &str = "joint_1_rad,joint_2_rad\n0.125,-0.25\n0.5,1.25\n-1.5,2\n";

    fn data(name: &str) -> Vec<u8> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/arrow/");
        fs::read(format!("{folder}{name}")).unwrap()
    }

    #[test]
    fn streams_and_files_are_the_same_map_as_csv() {
        let expected = fed(&format!("{ARM} -"), POSES.as_bytes()).unwrap();
        for name in ["stream.arrows", "single.arrows", "packed.feather", "plain.feather"] {
            let out = bytes(&format!("{ARM} tests/data/arrow/{name}")).unwrap();
            assert_eq!(out, expected, "{name}");
        }
        assert_eq!(fed(&format!("{ARM} -"), &data("stream.arrows")).unwrap(), expected);
    }

    #[test]
    fn what_is_written_can_be_read_again() {
        let sweep = "robots/two-link --random 5000 --seed 3";
        let csv = bytes(sweep).unwrap();
        let arrow = bytes(&format!("{sweep} --format arrow")).unwrap();
        assert_eq!(fed(&format!("{ARM} -"), &arrow).unwrap(), csv);
        // Frequencies too: as poses of joints that are called so.
        let reduced = fed(&format!("{ARM} - --reduce min,max --format csv"), &arrow).unwrap();
        assert_eq!(reduced, bytes(&format!("{sweep} --reduce min,max")).unwrap());
        // Poses that come as a table whose length nobody knows.
        let again = fed(&format!("{ARM} - --format arrow"), &csv).unwrap();
        assert_eq!(fed(&format!("{ARM} -"), &again).unwrap(), csv);
    }

    #[test]
    fn faults_are_told_with_their_row_or_column() {
        let mut cut = data("stream.arrows");
        cut.truncate(500);
        for (input, told) in [
            (
                data("holes.arrows"),
                vec!["-: row 2: joint_1_rad is empty, must be", "-: row 3: joint_2_rad is NaN"],
            ),
            (
                data("whole_numbers.arrows"),
                vec!["-: joint_1_rad is Int64, must be", "-: joint_2_rad is Int64"],
            ),
            (
                data("misspelt.arrows"),
                vec!["-: no column 'joint_2_rad' or 'joint_2_deg'; did you mean 'joint2_rad'"],
            ),
            (data("plain.feather"), vec!["-: is an Arrow file, which cannot be read from a pipe"]),
            (cut, vec!["-: cannot be read as Arrow: "]),
        ] {
            let faults = fed(&format!("{ARM} -"), &input).unwrap_err();
            let faults: Vec<_> =
                faults.iter().filter_map(|line| line.strip_prefix("error: ")).collect();
            assert_eq!(faults.len(), told.len(), "{faults:?}");
            for (fault, told) in faults.iter().zip(told) {
                assert!(fault.starts_with(told), "{fault}, not {told}");
            }
        }
    }
}

#[cfg(not(feature = "arrow"))]
#[test]
fn without_the_feature_it_is_told() {
    let reads = bytes(&format!("{ARM} tests/data/arrow/stream.arrows")).unwrap_err();
    assert!(reads[0].contains("is Apache Arrow, which this detune was built without"), "{reads:?}");
    let file = bytes(&format!("{ARM} tests/data/arrow/plain.feather")).unwrap_err();
    assert!(file[0].contains("is Apache Arrow"), "{file:?}");
    let piped = fed("robots/two-link --random 3 --format arrow", b"").unwrap_err();
    assert!(piped[0].contains("the feature arrow"), "{piped:?}");
}
