//! `detune map` with NumPy arrays: those in `tests/data/npy` were written by NumPy (`make.py` beside them).

use std::fs;

use crate::map_command::{bytes, data, fed, map};

/// The same three poses as CSV.
const POSES: &str = "joint_1_rad,joint_2_rad\n0.125,-0.25\n0.5,1.25\n-1.5,2\n";

const ARM: &str = "robots/two-link --poses";

/// The numbers of an array that `detune` wrote.
fn numbers(npy: &[u8]) -> Vec<f64> {
    let start = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    npy[start..].as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
}

fn header(npy: &[u8]) -> String {
    let length = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    String::from_utf8(npy[10..10 + length].to_vec()).unwrap()
}

#[test]
fn every_kind_of_array_is_the_same_map_as_csv() {
    let expected = fed(&format!("{ARM} -"), POSES.as_bytes()).unwrap();
    let names = ["poses", "by_column", "big_endian", "single", "single_big_by_column", "version_2"];
    for name in names {
        let out = bytes(&format!("{ARM} tests/data/npy/{name}.npy")).unwrap();
        assert_eq!(out, expected, "{name}");
    }
    // The bytes tell the format, not the name.
    let piped = fed(&format!("{ARM} -"), &data("poses.npy")).unwrap();
    assert_eq!(piped, expected);
}

#[test]
fn an_array_of_frequencies_holds_the_numbers_of_the_csv() {
    let csv = String::from_utf8(fed(&format!("{ARM} -"), POSES.as_bytes()).unwrap()).unwrap();
    let expected: Vec<f64> = csv
        .lines()
        .skip(1)
        .flat_map(|line| line.split(',').skip(3).map(|v| v.parse().unwrap()).collect::<Vec<_>>())
        .collect();
    // The number of poses is known beforehand, or is not.
    let known = bytes(&format!("{ARM} tests/data/npy/poses.npy --format npy")).unwrap();
    let counted = fed(&format!("{ARM} - --format npy"), POSES.as_bytes()).unwrap();
    assert_eq!(numbers(&known), expected);
    assert_eq!(counted, known);
    let head = header(&known);
    assert_eq!(head.trim_end(), "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }");
    assert_eq!((head.len() + 10) % 64, 0);
}

/// More rows than two batches hold, stored by columns: pieces are put together from all over the file.
#[test]
fn a_long_array_by_columns_keeps_its_order() {
    let count = 70_001;
    let pose = |i: usize| [0.001 * i as f64 - 30.0, 2.0 - 5e-5 * i as f64];
    let folder = tempfile::tempdir().unwrap();
    let array = |is_by_column: &str, values: Vec<f64>| {
        let header = format!(
            "{{'descr': '<f8', 'fortran_order': {is_by_column}, 'shape': ({count}, 2), }}\n"
        );
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let file = folder.path().join(format!("{is_by_column}.npy"));
        fs::write(&file, bytes).unwrap();
        map(&format!("{ARM} {}", file.display())).unwrap()
    };
    let by_row = array("False", (0..count).flat_map(pose).collect());
    let by_column =
        array("True", (0..2).flat_map(|j| (0..count).map(move |i| pose(i)[j])).collect());
    assert!(by_row == by_column);
    assert_eq!(by_row.lines().count(), count + 1);
    let last: Vec<f64> =
        by_row.lines().last().unwrap().split(',').take(2).map(|v| v.parse().unwrap()).collect();
    assert_eq!(last, pose(count - 1));
}

#[test]
fn faults_of_arrays_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let told = |name: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, bytes).unwrap();
        let faults = map(&format!("{ARM} {}", file.display())).unwrap_err();
        let of_file = faults.iter().filter_map(|f| f.split_once(&format!("{name}: ")));
        of_file.map(|(_, what)| what.to_owned()).collect::<Vec<_>>().join(" | ")
    };
    let good = data("poses.npy");
    let with = |from: &str, to: &str| {
        let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        let mut bytes = good.clone();
        bytes.splice(at..at + from.len(), to.bytes());
        bytes
    };
    for (bytes, expected) in [
        (b"NUMPY".to_vec(), "does not begin as .npy does (\\x93NUMPY)"),
        (data("archive.npz"), "is an archive (.npz); save one array with numpy.save"),
        (data("whole_numbers.npy"), "has dtype '<i8', must be float64 or float32; save it with"),
        (data("structure.npy"), "has dtype 'a structure', must be float64 or float32"),
        (
            data("three_columns.npy"),
            "has shape (2, 3), must be (poses, 2), one column per moving joint in this order: \
             joint_1, joint_2",
        ),
        (with("(3, 2)", "(6,)  "), "has shape (6,), must be (poses, 2)"),
        (with("(3, 2)", "(-3, 2"), "has a header without a valid 'shape'"),
        (with("'descr'", "'dtype'"), "has a header without a valid 'descr'"),
        (with("False", "Falsy"), "has a header without a valid 'fortran_order'"),
        (
            data("not_finite.npy"),
            "row 2: joint_2 is NaN, must be a finite number | row 3: joint_1 is -inf, must be a \
             finite number",
        ),
        (
            good[..good.len() - 17].to_vec(),
            "is cut off: its header states 3 rows, but it ends within row 2",
        ),
        (good[..40].to_vec(), "ends within its header"),
        (good[..6].to_vec(), "ends within its header"),
        ([&b"\x93NUMPY\x09\x00"[..], &good[8..]].concat(), "is .npy of version 9, must be 1, 2"),
        ([&b"\x93NUMPY\x02\x00\xff\xff\xff\xff"[..], &good[10..]].concat(), "has a header of 4294"),
    ] {
        let what = told("p.npy", &bytes);
        assert!(what.starts_with(expected), "{what}\nexpected: {expected}");
    }
    let piped = fed(&format!("{ARM} -"), &data("by_column.npy")).unwrap_err().concat();
    assert!(piped.contains("numpy.ascontiguousarray"), "{piped}");
}

#[test]
fn an_array_holds_no_spectra_and_no_figures() {
    for (options, expected) in [
        (
            "--format npy --method nonlinear",
            "--format npy and arrow: hold the frequencies of linear",
        ),
        (
            "--format npy --reduce min",
            "--format npy and arrow: cannot hold the statistics of --reduce",
        ),
        ("--method nonlinear --reduce min", "--reduce: takes linear maps only"),
    ] {
        let faults = map(&format!("{ARM} tests/data/npy/poses.npy {options}")).unwrap_err();
        assert!(faults.concat().contains(expected), "{faults:?}");
    }
    // Nonlinear maps take arrays.
    let line = format!("{ARM} tests/data/npy/poses.npy --method nonlinear --amplitude-deg 0.1");
    assert_eq!(map(&line).unwrap().lines().count(), 4);
}
