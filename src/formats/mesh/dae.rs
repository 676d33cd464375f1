//! COLLADA 1.4: triangles and polygons of the geometries that its scene shows, in m. The axis that
//! it calls up is passed over, as the viewers of robots do.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Rotation3, Scale3, Translation3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::Triangles;
use crate::formats::text::decode;
use crate::units::rad_from_deg;

/// A scene that shows more nodes than this refers to itself.
const MAX_NODES: usize = 20_000;

/// Polygons with more corners are refused.
const MAX_CORNERS: usize = 10_000;

type Element<'a> = Node<'a, 'a>;

pub(super) fn triangles(bytes: Vec<u8>) -> Result<Triangles, String> {
    let text = decode(bytes).map_err(|(line, what)| format!("line {line}: {what}"))?;
    let document = Document::parse(&text).map_err(|error| format!("not valid XML: {error}"))?;
    let root = document.root_element();
    let with_id = |node: Element<'_>| node.attribute("id").is_some();
    let by_id: HashMap<&str, Element<'_>> = root
        .descendants()
        .filter(|node| with_id(*node))
        .filter_map(|node| Some((node.attribute("id")?, node)))
        .collect();
    let scenes = root.descendants().filter(|node| node.has_tag_name_of("visual_scene"));
    let shown = root.descendants().find(|node| node.has_tag_name_of("instance_visual_scene"));
    let scene = match shown {
        Some(shown) => referred(&by_id, shown, "url")?,
        None => scenes.into_iter().next().ok_or("holds no visual_scene")?,
    };
    let scale = Scale3::from(Vector3::repeat(metres(root)?)).to_homogeneous();
    let mut out = Triangles::default();
    let mut open = vec![(scene, scale)];
    let mut seen = 0;
    while let Some((node, outer)) = open.pop() {
        seen += 1;
        if seen > MAX_NODES {
            return Err(format!("its scene shows more than {MAX_NODES} nodes, the limit"));
        }
        let own = outer * transform(node)?;
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "node" => open.push((child, own)),
                "instance_node" => open.push((referred(&by_id, child, "url")?, own)),
                "instance_geometry" => {
                    geometry(&by_id, referred(&by_id, child, "url")?, &own, &mut out)?;
                }
                "instance_controller" => return Err("has a skin, which is not read".to_owned()),
                _ => {}
            }
        }
    }
    Ok(out)
}

/// Names of elements in COLLADA's name space and in none.
trait Tagged {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl Tagged for Element<'_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

fn children<'a>(node: Element<'a>, name: &'static str) -> impl Iterator<Item = Element<'a>> {
    node.children().filter(move |child| child.has_tag_name_of(name))
}

fn referred<'a>(
    by_id: &HashMap<&str, Element<'a>>,
    node: Element<'_>,
    attribute: &str,
) -> Result<Element<'a>, String> {
    let url = node.attribute(attribute).unwrap_or_default();
    let found = url.strip_prefix('#').and_then(|id| by_id.get(id)).copied();
    found.ok_or_else(|| format!("'{url}' is not in the file"))
}

/// How long a unit of the file is.
fn metres(root: Element<'_>) -> Result<f64, String> {
    let unit = children(root, "asset").flat_map(|asset| children(asset, "unit")).next();
    let Some(meter) = unit.and_then(|unit| unit.attribute("meter")) else { return Ok(1.0) };
    let value = meter.trim().parse::<f64>().ok().filter(|m| *m > 1e-9 && *m < 1e9);
    value.ok_or_else(|| format!("its unit is '{meter}' m, must be positive"))
}

/// What a node does to all it holds: its transformations from first to last, the last acts first.
fn transform(node: Element<'_>) -> Result<Matrix4<f64>, String> {
    let mut all = Matrix4::identity();
    for child in node.children().filter(Node::is_element) {
        let name = child.tag_name().name();
        let count = match name {
            "matrix" => 16,
            "rotate" => 4,
            "translate" | "scale" => 3,
            "lookat" | "skew" => return Err(format!("a node has <{name}>, which is not read")),
            _ => continue,
        };
        let values = numbers(child)?;
        if values.len() != count {
            return Err(format!("<{name}> has {} numbers, must have {count}", values.len()));
        }
        all *= match name {
            "matrix" => Matrix4::from_row_slice(&values),
            "translate" => Translation3::new(values[0], values[1], values[2]).to_homogeneous(),
            "scale" => Scale3::new(values[0], values[1], values[2]).to_homogeneous(),
            _ => {
                let axis = Vector3::new(values[0], values[1], values[2]);
                let angle = rad_from_deg(values[3]);
                Unit::try_new(axis, 1e-12).map_or_else(Matrix4::identity, |axis| {
                    Rotation3::from_axis_angle(&axis, angle).to_homogeneous()
                })
            }
        };
    }
    Ok(all)
}

fn numbers(node: Element<'_>) -> Result<Vec<f64>, String> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let one = |word: &str| word.parse::<f64>().map_err(|_| format!("'{word}' is not a number"));
    words.map(one).collect()
}

fn indices(node: Element<'_>) -> Result<Vec<usize>, String> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let one = |word: &str| word.parse::<usize>().map_err(|_| format!("'{word}' is no index"));
    words.map(one).collect()
}

fn geometry(
    by_id: &HashMap<&str, Element<'_>>,
    geometry: Element<'_>,
    pose: &Matrix4<f64>,
    out: &mut Triangles,
) -> Result<(), String> {
    for mesh in children(geometry, "mesh") {
        for primitive in mesh.children().filter(Node::is_element) {
            match primitive.tag_name().name() {
                "triangles" | "polylist" | "polygons" => {
                    faces(by_id, primitive, pose, out)?;
                }
                name @ ("tristrips" | "trifans") => {
                    return Err(format!("has <{name}>, which is not read"));
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// Points of a primitive, and where its index stands among those of a corner.
fn points_of(
    by_id: &HashMap<&str, Element<'_>>,
    primitive: Element<'_>,
) -> Result<(Vec<[f64; 3]>, usize), String> {
    let is_vertex = |input: &Element<'_>| input.attribute("semantic") == Some("VERTEX");
    let Some(vertex) = children(primitive, "input").find(is_vertex) else {
        return Err("a primitive has no input VERTEX".to_owned());
    };
    let vertices = referred(by_id, vertex, "source")?;
    let is_position = |input: &Element<'_>| input.attribute("semantic") == Some("POSITION");
    let Some(position) = children(vertices, "input").find(is_position) else {
        return Err("vertices have no input POSITION".to_owned());
    };
    let source = referred(by_id, position, "source")?;
    let Some(values) = children(source, "float_array").next() else {
        return Err("a source of points has no float_array".to_owned());
    };
    let accessor = source.descendants().find(|node| node.has_tag_name_of("accessor"));
    let stride = accessor.map_or(Ok(3), |of| whole(of, "stride", 3))?;
    if stride < 3 {
        return Err(format!("a source of points has stride {stride}, must be 3 or more"));
    }
    let values = numbers(values)?;
    let points = values.chunks_exact(stride).map(|point| [point[0], point[1], point[2]]);
    Ok((points.collect(), whole(vertex, "offset", 0)?))
}

fn whole(node: Element<'_>, attribute: &str, default: usize) -> Result<usize, String> {
    let Some(text) = node.attribute(attribute) else { return Ok(default) };
    // Offsets and strides of more than some dozens are faults, and would overflow.
    let value = text.trim().parse::<usize>().ok().filter(|value| *value <= 1000);
    value.ok_or_else(|| format!("{attribute} is '{text}', must be a small whole number"))
}

fn faces(
    by_id: &HashMap<&str, Element<'_>>,
    primitive: Element<'_>,
    pose: &Matrix4<f64>,
    out: &mut Triangles,
) -> Result<(), String> {
    let (points, offset) = points_of(by_id, primitive)?;
    let offsets = children(primitive, "input").map(|input| whole(input, "offset", 0));
    let stride = 1 + offsets.collect::<Result<Vec<_>, _>>()?.into_iter().max().unwrap_or(0);
    let placed = |index: usize| -> Result<[f64; 3], String> {
        let point = points.get(index).ok_or("a face names a point that is not there")?;
        Ok(pose.transform_point(&Point3::from(*point)).coords.into())
    };
    let mut face = |corners: &[usize]| -> Result<(), String> {
        let corners: Vec<usize> = corners.iter().skip(offset).step_by(stride).copied().collect();
        for pair in corners.windows(2).skip(1) {
            out.push([placed(corners[0])?, placed(pair[0])?, placed(pair[1])?])?;
        }
        Ok(())
    };
    let sizes: Option<Vec<usize>> = match primitive.tag_name().name() {
        "polylist" => children(primitive, "vcount").next().map(indices).transpose()?,
        _ => None,
    };
    for p in children(primitive, "p") {
        let all = indices(p)?;
        match (primitive.tag_name().name(), &sizes) {
            ("triangles", _) => all.chunks_exact(3 * stride).try_for_each(&mut face)?,
            ("polygons", _) => face(&all)?,
            (_, Some(sizes)) => {
                let mut rest = all.as_slice();
                for &size in sizes {
                    let own = (size <= MAX_CORNERS).then(|| rest.split_at_checked(size * stride));
                    let (own, after) = own.flatten().ok_or("vcount asks for more than p holds")?;
                    face(own)?;
                    rest = after;
                }
            }
            _ => return Err("a polylist has no vcount".to_owned()),
        }
    }
    Ok(())
}
