//! One box, 2 × 4 × 6, in all formats; files that are none; surfaces with many triangles.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// Corners of the box by the bits of their number.
fn corner(k: usize) -> [f64; 3] {
    [2.0 * (k & 1) as f64, 4.0 * (k >> 1 & 1) as f64, 6.0 * (k >> 2 & 1) as f64]
}

const FACES: [[usize; 4]; 6] =
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

fn triangles() -> impl Iterator<Item = [[f64; 3]; 3]> {
    FACES.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner))
}

fn binary_stl(head: &[u8]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12_u32.to_le_bytes());
    for triangle in triangles() {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|v| (*v as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> Vec<u8> {
    let mut text = "solid box\n".to_owned();
    for triangle in triangles() {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid box\n").into_bytes()
}

/// Faces with four corners, normals, a line, a point and a material that is nowhere.
fn obj() -> Vec<u8> {
    let mut text = "mtllib nowhere.mtl\no box\nvn 0 0 1\n".to_owned();
    for [x, y, z] in (0..8).map(corner) {
        text += &format!("v {x} {y} {z}\n");
    }
    text += "usemtl red\nl 1 2\np 1\n";
    for face in FACES {
        let words: Vec<String> = face.iter().map(|k| format!("{}//1", k + 1)).collect();
        text += &format!("f {}\n", words.join(" "));
    }
    text.into_bytes()
}

/// In mm, half as wide in x, and put right by a node in a node: turned about z and scaled.
fn dae(faces: &str) -> Vec<u8> {
    // Turned by 90° about z, (y, −x/2, z) becomes (x/2, y, z); the scale doubles x.
    let points: Vec<String> = (0..8)
        .map(corner)
        .map(|[x, y, z]| format!("{} {} {}", 1e3 * y, -1e3 * x / 2.0, 1e3 * z))
        .collect();
    format!(
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" \
         version=\"1.4.1\"><asset><unit meter=\"0.001\" \
         name=\"mm\"/><up_axis>Y_UP</up_axis></asset>\
         <library_geometries><geometry id=\"g\"><mesh><source id=\"s\"><float_array id=\"a\" \
         count=\"24\">{}</float_array><technique_common><accessor source=\"#a\" count=\"8\" \
         stride=\"3\"/></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" \
         source=\"#s\"/></vertices>{faces}</mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id=\"w\"><node><scale>2 1 1</scale><node>\
         <rotate>0 0 1 90</rotate><instance_geometry url=\"#g\"/></node></node></visual_scene>\
         </library_visual_scenes><scene><instance_visual_scene url=\"#w\"/></scene></COLLADA>",
        points.join(" ")
    )
    .into_bytes()
}

const INPUTS: &str = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"1\"/>\
                      <input semantic=\"NORMAL\" source=\"#n\" offset=\"0\"/>";

fn polylist() -> String {
    let p: Vec<String> = FACES.iter().flatten().map(|k| format!("0 {k}")).collect();
    format!(
        "<polylist count=\"6\">{INPUTS}<vcount>4 4 4 4 4 4</vcount><p>{}</p></polylist>",
        p.join(" ")
    )
}

fn read_as(ending: &str, bytes: &[u8], most: usize) -> Result<Reduced, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("mesh.{ending}"));
    std::fs::write(&path, bytes).unwrap();
    read(&path, most)
}

fn point(of: &Reduced, k: u16) -> [f64; 3] {
    let shares = of.points[usize::from(k)];
    [0, 1, 2].map(|k| of.low[k] + of.size[k] * f64::from(shares[k]) / 65535.0)
}

/// Twice the area of all triangles: 2 · 2 (2·4 + 4·6 + 6·2) = 176.
fn doubled_area(of: &Reduced) -> f64 {
    let of_one = |[a, b, c]: &[u16; 3]| {
        let [a, b, c] = [*a, *b, *c].map(|k| nalgebra::Vector3::from(point(of, k)));
        (b - a).cross(&(c - a)).norm()
    };
    of.triangles.iter().map(of_one).sum()
}

#[test]
fn a_box_is_the_same_in_all_formats() {
    let triangles_of = |p: &str| format!("<triangles count=\"2\">{INPUTS}<p>{p}</p></triangles>");
    let halves: String = FACES
        .iter()
        .map(|[a, b, c, d]| triangles_of(&format!("0 {a} 0 {b} 0 {c} 0 {a} 0 {c} 0 {d}")))
        .collect();
    for (ending, bytes) in [
        ("stl", binary_stl(b"made by a test")),
        ("STL", binary_stl(b"solid of an exporter that knows no better")),
        ("stl", text_stl()),
        ("obj", obj()),
        ("dae", dae(&polylist())),
        ("dae", dae(&halves)),
    ] {
        let found = read_as(ending, &bytes, 100).unwrap();
        for k in 0..3 {
            assert!(found.low[k].abs() < 1e-9, "{ending}: {found:?}");
            assert!((found.size[k] - [2.0, 4.0, 6.0][k]).abs() < 1e-9, "{ending}: {found:?}");
        }
        assert_eq!((found.points.len(), found.triangles.len()), (8, 12), "{ending}");
        assert!((doubled_area(&found) - 176.0).abs() < 1e-9, "{ending}: {}", doubled_area(&found));
    }
}

#[test]
fn what_is_no_surface_is_refused_in_words() {
    let self_referring = String::from_utf8(dae(&polylist()))
        .unwrap()
        .replace("<instance_geometry url=\"#g\"/>", "<instance_node url=\"#me\"/>");
    let self_referring = self_referring.replacen("<node>", "<node id=\"me\">", 1);
    let mut cut = binary_stl(b"");
    cut.truncate(400);
    let mut huge = binary_stl(b"");
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut not_finite = binary_stl(b"");
    not_finite[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    let count = polylist().replace("<vcount>4", "<vcount>18446744073709551615");
    let far = polylist().replacen("0 0 0 1", "0 0 0 99", 1);
    for (ending, bytes, expected) in [
        ("stl", cut, "cannot be read as STL"),
        ("stl", huge, "cannot be read as STL"),
        ("stl", not_finite, "not finite"),
        ("stl", b"solid a\nendsolid a\n".to_vec(), "holds no surface"),
        ("stl", Vec::new(), "cannot be read as STL"),
        ("obj", b"v 0 0 0\nf 1 2 3\n".to_vec(), "cannot be read as OBJ"),
        ("obj", b"v 1 2 3\n".to_vec(), "holds no surface"),
        ("dae", b"<COLLADA>".to_vec(), "not valid XML"),
        ("dae", b"<COLLADA/>".to_vec(), "no visual_scene"),
        ("dae", dae(&count), "vcount asks for more"),
        ("dae", dae(&far), "a point that is not there"),
        ("dae", dae("<tristrips/>"), "<tristrips>, which is not read"),
        ("dae", self_referring.into_bytes(), "shows more than"),
        ("step", b"x".to_vec(), "neither STL, OBJ nor DAE"),
    ] {
        let why = read_as(ending, &bytes, 100).unwrap_err();
        assert!(why.contains(expected), "{ending}: {why}, not {expected}");
    }
}

/// Whatever the bytes: a surface or a reason, and no panic.
#[test]
fn spoilt_files_are_read_or_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (ending, bytes) in
        [("stl", binary_stl(b"")), ("stl", text_stl()), ("obj", obj()), ("dae", dae(&polylist()))]
    {
        for _ in 0..400 {
            let mut spoilt = bytes.clone();
            for _ in 0..rng.random_range(1..6) {
                let at = rng.random_range(0..spoilt.len());
                match rng.random_range(0..3) {
                    0 => spoilt[at] = rng.random(),
                    1 => spoilt[at] = b"0123456789-.e/ <>"[rng.random_range(0..17)],
                    _ => spoilt.truncate(at + 1),
                }
            }
            if let Ok(found) = read_as(ending, &spoilt, 100) {
                assert!(
                    found
                        .triangles
                        .iter()
                        .flatten()
                        .all(|k| { usize::from(*k) < found.points.len() })
                );
            }
        }
    }
}

/// A sphere of radius 1 in 180 000 triangles: few are left, and all near it.
#[test]
fn a_fine_surface_is_thinned_out() {
    let (rings, sides) = (300, 300);
    let at = |i: usize, j: usize| {
        let (theta, phi) = (
            std::f64::consts::PI * i as f64 / rings as f64,
            std::f64::consts::TAU * j as f64 / sides as f64,
        );
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
    };
    let mut surface = Triangles::default();
    for (i, j) in (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
        surface.push([at(i, j), at(i + 1, j), at(i, j + 1)]).unwrap();
        surface.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).unwrap();
    }
    let found = Reduced::of(&surface, 3000).unwrap();
    assert!((1000..=3000).contains(&found.triangles.len()), "{}", found.triangles.len());
    for k in 0..found.points.len() as u16 {
        let [x, y, z] = point(&found, k);
        let radius = (x * x + y * y + z * z).sqrt();
        assert!((0.95..1.001).contains(&radius), "{radius}");
    }
    // 4 π r², of flat triangles a little less.
    let area = 0.5 * doubled_area(&found);
    assert!((11.5..12.6).contains(&area), "{area}");
}
