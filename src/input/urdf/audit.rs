//! The XML of a URDF: structure, missing blocks, numbers, lines.

use roxmltree::{Document, Node};

use super::text::{XACRO_HINT, not_xml, too_many};
use crate::notes::{Code, Notes};
use crate::wording::nearest;

const JOINT_TYPES: [&str; 7] =
    ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];

/// Joints of a robot, at most: what reads them takes time with their square.
const MAX_JOINTS: usize = 1000;

/// Where the parts of a link or joint stand.
#[derive(Debug, Clone, Default)]
pub(in crate::input) struct Lines {
    /// Of the element itself.
    pub(in crate::input) own: usize,
    parts: Vec<(&'static str, usize)>,
}

impl Lines {
    /// The line of a part, or of the element where it has no such part.
    pub(in crate::input) fn of(&self, part: &str) -> usize {
        self.parts.iter().find(|(name, _)| *name == part).map_or(self.own, |&(_, line)| line)
    }
}

/// What the audit knows of a link and urdf-rs does not.
#[derive(Debug)]
pub(super) struct LinkFacts {
    pub(super) name: String,
    pub(super) lines: Lines,
    pub(super) has_inertial: bool,
    pub(super) has_geometry: bool,
}

/// What the audit knows of a joint and urdf-rs does not.
#[derive(Debug)]
pub(super) struct JointFacts {
    pub(super) name: String,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) mimics: Option<String>,
    pub(super) lines: Lines,
    /// Whether the file gives at least one limit of position.
    pub(super) has_position_limit: bool,
}

/// What an audit finds.
#[derive(Debug)]
pub(super) struct Audit {
    pub(super) name: Option<String>,
    pub(super) line: usize,
    pub(super) links: Vec<LinkFacts>,
    pub(super) joints: Vec<JointFacts>,
    /// A link or joint had to be left out, so the tree is not the one that was meant.
    pub(super) damaged: bool,
    /// The same robot as a URDF of links and joints alone, in the same order, free of faults.
    pub(super) plain: String,
}

/// Audits the text of a URDF.
pub(super) fn audit(text: &str, notes: &mut Notes) -> Option<Audit> {
    if let Some((line, what)) = too_many(text) {
        notes.error(Code::TooLong, line, what);
        return None;
    }
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            let (line, what) = not_xml(text, &error);
            notes.error(Code::Syntax, line, what);
            return None;
        }
    };
    let mut auditor = Auditor {
        notes,
        line_starts: std::iter::once(0)
            .chain(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1))
            .collect(),
        plain: String::new(),
        damaged: false,
        knows_quaternions: false,
    };
    let root = document.root_element();
    let xacro = root
        .descendants()
        .find(|node| node.tag_name().namespace().is_some_and(|space| space.ends_with("/xacro")));
    if let Some(node) = xacro {
        auditor.notes.error(Code::Syntax, auditor.line(&node), XACRO_HINT);
        return None;
    }
    if root.tag_name().name() != "robot" {
        let what = format!("root element is <{}>, must be <robot>", root.tag_name().name());
        auditor.notes.error(Code::Syntax, auditor.line(&root), what);
        return None;
    }
    let is_joint = |node: &Node<'_, '_>| node.tag_name().name() == "joint";
    if let Some(joint) = root.children().filter(is_joint).nth(MAX_JOINTS) {
        let what = format!("has more than {MAX_JOINTS} joints; keep those of the arm and its base");
        auditor.notes.error(Code::TooLong, auditor.line(&joint), what);
        return None;
    }
    auditor.plain.push_str("<robot name=\"robot\"");
    if let Some(version) = root.attribute("version") {
        auditor.attribute("version", version);
        auditor.knows_quaternions = !matches!(version.trim(), "1.0" | "1");
    }
    auditor.plain.push('>');
    let (mut links, mut joints) = (Vec::new(), Vec::new());
    for node in root.children().filter(Node::is_element) {
        match node.tag_name().name() {
            "link" => links.extend(auditor.link(&node)),
            "joint" => joints.extend(auditor.joint(&node)),
            "include" => {
                let what = "<include> is not followed; expand the file first";
                auditor.notes.error(Code::UnknownKey, auditor.line(&node), what);
            }
            // Materials, transmissions, simulator settings: no concern of ours.
            _ => {}
        }
    }
    auditor.plain.push_str("</robot>");
    Some(Audit {
        name: root.attribute("name").map(str::to_owned),
        line: auditor.line(&root),
        links,
        joints,
        damaged: auditor.damaged,
        plain: auditor.plain,
    })
}

/// A collision or visual element as a collision of the plain copy, if it is of a simple shape.
fn solid(node: &Node<'_, '_>) -> Option<String> {
    let child = |tag: &str| node.children().find(|child| child.tag_name().name() == tag);
    let copied = |of: &Node<'_, '_>, name: &str, count: usize, least: f64| {
        let value = of.attribute(name)?;
        let fits = |word: &str| word.parse::<f64>().is_ok_and(|x| x.is_finite() && x > least);
        let fits = value.split_whitespace().count() == count && value.split_whitespace().all(fits);
        fits.then(|| format!(" {name}=\"{value}\""))
    };
    let mut plain = "<collision>".to_owned();
    if let Some(origin) = child("origin") {
        plain.push_str("<origin");
        for name in origin.attributes().map(|attribute| attribute.name()) {
            let known = matches!(name, "xyz" | "rpy");
            plain.push_str(&known.then(|| copied(&origin, name, 3, f64::NEG_INFINITY)).flatten()?);
        }
        plain.push_str("/>");
    }
    let shape = child("geometry")?.children().find(Node::is_element)?;
    let sizes: &[(&str, usize)] = match shape.tag_name().name() {
        "box" => &[("size", 3)],
        "cylinder" => &[("radius", 1), ("length", 1)],
        "sphere" => &[("radius", 1)],
        _ => return None,
    };
    plain.push_str(&format!("<geometry><{}", shape.tag_name().name()));
    for &(name, count) in sizes {
        plain.push_str(&copied(&shape, name, count, 0.0)?);
    }
    plain.push_str("/></geometry></collision>");
    Some(plain)
}

/// A visual element as one of the plain copy, if it is a mesh whose numbers can be read.
fn mesh(node: &Node<'_, '_>) -> Option<String> {
    let child = |tag: &str| node.children().find(|child| child.tag_name().name() == tag);
    let shape = child("geometry")?.children().find(Node::is_element)?;
    let file = shape.attribute("filename").filter(|_| shape.tag_name().name() == "mesh")?;
    let mut plain = "<visual>".to_owned();
    if let Some(origin) = child("origin") {
        plain.push_str("<origin");
        for name in ["xyz", "rpy"] {
            if let Some(value) = origin.attribute(name) {
                plain.push_str(&format!(" {name}=\"{}\"", three_numbers(value)?));
            }
        }
        plain.push_str("/>");
    }
    plain.push_str("<geometry><mesh");
    attribute(&mut plain, "filename", file);
    if let Some(value) = shape.attribute("scale") {
        plain.push_str(&format!(" scale=\"{}\"", three_numbers(value)?));
    }
    plain.push_str("/></geometry></visual>");
    Some(plain)
}

/// The text of three finite numbers.
fn three_numbers(text: &str) -> Option<&str> {
    let mut words = text.split_whitespace();
    let are_finite = words.all(|word| word.parse::<f64>().is_ok_and(f64::is_finite));
    (are_finite && text.split_whitespace().count() == 3).then_some(text)
}

/// Writes an attribute of the plain copy.
fn attribute(plain: &mut String, name: &str, value: &str) {
    plain.push(' ');
    plain.push_str(name);
    plain.push_str("=\"");
    for c in value.chars() {
        match c {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            c if c.is_control() => plain.push(' '),
            c => plain.push(c),
        }
    }
    plain.push('"');
}

struct Auditor<'f> {
    notes: &'f mut Notes,
    line_starts: Vec<usize>,
    plain: String,
    damaged: bool,
    /// Whether readers of this version of URDF know quat_xyzw.
    knows_quaternions: bool,
}

impl Auditor<'_> {
    fn line(&self, node: &Node<'_, '_>) -> usize {
        self.line_starts.partition_point(|&start| start <= node.range().start)
    }

    fn missing(&mut self, line: usize, what: String) {
        self.notes.error(Code::MissingKey, line, what);
    }

    fn conflict(&mut self, line: usize, what: String) {
        self.notes.error(Code::Conflict, line, what);
    }

    /// Writes an attribute of the plain copy.
    fn attribute(&mut self, name: &str, value: &str) {
        attribute(&mut self.plain, name, value);
    }

    /// The child element of that name; a second one is a fault.
    fn child<'a, 'i>(
        &mut self,
        owner: &str,
        node: &Node<'a, 'i>,
        tag: &str,
    ) -> Option<Node<'a, 'i>> {
        let mut found =
            node.children().filter(|child| child.is_element() && child.tag_name().name() == tag);
        let first = found.next();
        if let Some(second) = found.next() {
            let line = self.line(&second);
            self.conflict(line, format!("{owner}: <{tag}> is given twice, must be given once"));
        }
        first
    }

    /// Refuses attributes that an element of numbers does not have: misspelt, they would leave the
    /// default in place.
    fn attributes(&mut self, owner: &str, node: &Node<'_, '_>, known: &[&str]) {
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            let name = attribute.name();
            if !known.contains(&name) {
                let tag = node.tag_name().name();
                let known = known.join(", ");
                let what = format!("{owner}: <{tag}> has no attribute '{name}', only {known}");
                let line = self.line(node);
                self.notes.error(Code::UnknownKey, line, what);
            }
        }
    }

    /// Refuses children whose names are misspelt; others are of simulators and tools.
    fn children(&mut self, owner: &str, node: &Node<'_, '_>, known: &[&str]) {
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if known.contains(&name) || child.tag_name().namespace().is_some() {
                continue;
            }
            if let Some(near) = nearest(name, known.iter().copied()) {
                let what = format!("{owner}: <{name}> is not known; did you mean <{near}>?");
                let line = self.line(&child);
                self.notes.error(Code::UnknownKey, line, what);
            }
        }
    }

    /// The name of a link or joint.
    fn name(&mut self, node: &Node<'_, '_>) -> Option<String> {
        match node.attribute("name") {
            Some(name) if !name.is_empty() => {
                if name.contains(char::is_control) {
                    // It would stand in the titles of tables, raw.
                    let what = format!("the name '{name}' holds a control character");
                    let line = self.line(node);
                    self.notes.error(Code::Value, line, what);
                }
                Some(name.to_owned())
            }
            _ => {
                let what = format!("<{}> has no name", node.tag_name().name());
                let line = self.line(node);
                self.notes.error(Code::MissingKey, line, what);
                self.damaged = true;
                None
            }
        }
    }

    /// Copies an attribute that holds `count` finite numbers; a faulty one is reported and
    /// replaced.
    fn numbers(
        &mut self,
        owner: &str,
        node: &Node<'_, '_>,
        name: &str,
        count: usize,
        stand_in: &str,
    ) -> bool {
        let Some(value) = node.attribute(name) else { return false };
        let finite = |word: &str| word.parse::<f64>().is_ok_and(f64::is_finite);
        if value.split_whitespace().count() == count && value.split_whitespace().all(finite) {
            self.attribute(name, value);
            return true;
        }
        let must = if count == 1 {
            "a finite number".to_owned()
        } else {
            format!("{count} finite numbers")
        };
        let hint = if value.contains("${") { format!("; it {XACRO_HINT}") } else { String::new() };
        let tag = node.tag_name().name();
        let shown: String = value.chars().take(60).collect();
        let line = self.line(node);
        self.notes.error(
            Code::Value,
            line,
            format!("{owner}: <{tag}> {name} is \"{shown}\", must be {must}{hint}"),
        );
        self.attribute(name, stand_in);
        true
    }

    /// Like [`Self::numbers`], where absence is a fault, too.
    fn required_number(&mut self, owner: &str, node: &Node<'_, '_>, name: &str, stand_in: &str) {
        if !self.numbers(owner, node, name, 1, stand_in) {
            let line = self.line(node);
            let tag = node.tag_name().name();
            self.missing(line, format!("{owner}: <{tag}> has no {name}"));
            self.attribute(name, stand_in);
        }
    }

    fn origin(&mut self, owner: &str, node: &Node<'_, '_>) -> Option<usize> {
        let origin = self.child(owner, node, "origin")?;
        let line = self.line(&origin);
        self.attributes(owner, &origin, &["xyz", "rpy", "quat_xyzw"]);
        self.plain.push_str("<origin");
        self.numbers(owner, &origin, "xyz", 3, "0 0 0");
        if origin.has_attribute("quat_xyzw") && !self.knows_quaternions {
            let what = format!(
                "{owner}: <origin> has quat_xyzw, which readers of URDF ignore unless <robot> has \
                 version=\"1.1\""
            );
            self.notes.error(Code::Value, line, what);
        }
        if origin.has_attribute("rpy") && origin.has_attribute("quat_xyzw") {
            self.conflict(
                line,
                format!("{owner}: <origin> has both rpy and quat_xyzw, must have one"),
            );
        } else {
            self.numbers(owner, &origin, "rpy", 3, "0 0 0");
            self.doubt_degrees(owner, &origin, line);
            self.numbers(owner, &origin, "quat_xyzw", 4, "0 0 0 1");
        }
        self.plain.push_str("/>");
        Some(line)
    }

    /// Angles beyond a whole turn, with what rounding adds to it.
    fn doubt_degrees(&mut self, owner: &str, origin: &Node<'_, '_>, line: usize) {
        const TURN_RAD: f64 = std::f64::consts::TAU + 0.01;
        let rpy = origin.attribute("rpy").unwrap_or_default();
        let is_beyond = |word: &str| word.parse::<f64>().is_ok_and(|angle| angle.abs() > TURN_RAD);
        if rpy.split_whitespace().any(is_beyond) {
            let what = format!(
                "{owner}: <origin> rpy is \"{}\", more than a whole turn; is it in degrees? A URDF \
                 has radians",
                rpy.split_whitespace().collect::<Vec<_>>().join(" ")
            );
            self.notes.warning(Code::CadUnits, line, what);
        }
    }

    fn link(&mut self, node: &Node<'_, '_>) -> Option<LinkFacts> {
        let name = self.name(node)?;
        let owner = format!("link '{name}'");
        let mut lines = Lines { own: self.line(node), parts: Vec::new() };
        self.plain.push_str("<link");
        self.attribute("name", &name);
        self.plain.push('>');
        self.children(&owner, node, &["inertial", "visual", "collision"]);
        let inertial = self.child(&owner, node, "inertial");
        if let Some(inertial) = inertial {
            lines.parts.push(("inertial", self.line(&inertial)));
            self.inertial(&owner, &inertial, &mut lines);
        }
        self.solids(node);
        self.plain.push_str("</link>");
        let has_geometry = node.children().any(|child| {
            matches!(child.tag_name().name(), "visual" | "collision")
                && child.children().any(|inner| inner.tag_name().name() == "geometry")
        });
        Some(LinkFacts { name, lines, has_inertial: inertial.is_some(), has_geometry })
    }

    /// Stand-ins make a ball: a body that has no fault of its own.
    fn inertial(&mut self, owner: &str, node: &Node<'_, '_>, lines: &mut Lines) {
        const MOMENTS: [(&str, &str); 6] =
            [("ixx", "1"), ("ixy", "0"), ("ixz", "0"), ("iyy", "1"), ("iyz", "0"), ("izz", "1")];
        self.children(owner, node, &["origin", "mass", "inertia"]);
        for com in node.children().filter(|child| child.tag_name().name() == "com") {
            let what = format!(
                "{owner}: <inertial> has <com>; the centre of mass stands in <origin xyz=\"…\">"
            );
            let line = self.line(&com);
            self.notes.error(Code::UnknownKey, line, what);
        }
        self.plain.push_str("<inertial>");
        if let Some(line) = self.origin(owner, node) {
            lines.parts.push(("com", line));
        }
        match self.child(owner, node, "mass") {
            Some(mass) => {
                lines.parts.push(("mass", self.line(&mass)));
                self.attributes(owner, &mass, &["value"]);
                self.plain.push_str("<mass");
                self.required_number(owner, &mass, "value", "1");
                self.plain.push_str("/>");
            }
            None => {
                self.missing(lines.of("inertial"), format!("{owner}: <inertial> has no <mass>"));
                self.plain.push_str("<mass value=\"1\"/>");
            }
        }
        let start = self.plain.len();
        let before = self.notes.errors();
        self.plain.push_str("<inertia");
        match self.child(owner, node, "inertia") {
            Some(inertia) => {
                lines.parts.push(("inertia", self.line(&inertia)));
                self.attributes(owner, &inertia, &MOMENTS.map(|(name, _)| name));
                for (name, stand_in) in MOMENTS {
                    self.required_number(owner, &inertia, name, stand_in);
                }
            }
            None => {
                self.missing(lines.of("inertial"), format!("{owner}: <inertial> has no <inertia>"))
            }
        }
        // One faulty moment would make the others look impossible.
        if self.notes.errors() > before {
            self.plain.truncate(start);
            self.plain.push_str("<inertia");
            for (name, stand_in) in MOMENTS {
                self.attribute(name, stand_in);
            }
        }
        self.plain.push_str("/></inertial>");
    }

    /// Copies what gives a link its shape, where that is boxes, cylinders and spheres alone.
    /// Nothing here is a fault: most links have meshes.
    fn solids(&mut self, node: &Node<'_, '_>) {
        let shown = node.children().filter(|child| child.tag_name().name() == "visual");
        self.plain.extend(shown.filter_map(|part| mesh(&part)));
        for tag in ["collision", "visual"] {
            let parts = node.children().filter(|child| child.tag_name().name() == tag);
            let solids: Option<Vec<String>> = parts.map(|part| solid(&part)).collect();
            if let Some(solids) = solids.filter(|solids| !solids.is_empty()) {
                self.plain.extend(solids);
                return;
            }
        }
    }

    fn joint(&mut self, node: &Node<'_, '_>) -> Option<JointFacts> {
        let name = self.name(node)?;
        let owner = format!("joint '{name}'");
        let mut lines = Lines { own: self.line(node), parts: Vec::new() };
        let start = self.plain.len();
        self.plain.push_str("<joint");
        self.attribute("name", &name);
        match node.attribute("type") {
            Some(kind) if JOINT_TYPES.contains(&kind) => self.attribute("type", kind),
            Some(kind) => {
                let what =
                    format!("{owner}: type is '{kind}', must be one of {}", JOINT_TYPES.join(", "));
                self.notes.error(Code::Value, lines.own, what);
                self.attribute("type", "continuous");
            }
            None => {
                self.missing(lines.own, format!("{owner}: has no type"));
                self.attribute("type", "continuous");
            }
        }
        self.plain.push('>');
        let known = [
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        ];
        self.children(&owner, node, &known);
        if let Some(line) = self.origin(&owner, node) {
            lines.parts.push(("origin", line));
        }
        let parent = self.link_of(&owner, node, "parent", &mut lines);
        let child = self.link_of(&owner, node, "child", &mut lines);
        if let Some(axis) = self.child(&owner, node, "axis") {
            lines.parts.push(("axis", self.line(&axis)));
            self.attributes(&owner, &axis, &["xyz"]);
            self.plain.push_str("<axis");
            if !self.numbers(&owner, &axis, "xyz", 3, "1 0 0") {
                self.missing(lines.of("axis"), format!("{owner}: <axis> has no xyz"));
                self.attribute("xyz", "1 0 0");
            }
            self.plain.push_str("/>");
        }
        let has_position_limit = self.limit(&owner, node, &mut lines);
        let mimics = self.child(&owner, node, "mimic").map(|mimic| {
            lines.parts.push(("mimic", self.line(&mimic)));
            mimic.attribute("joint").unwrap_or_default().to_owned()
        });
        self.plain.push_str("</joint>");
        let (Some(parent), Some(child)) = (parent, child) else {
            self.damaged = true;
            self.plain.truncate(start);
            return None;
        };
        Some(JointFacts { name, parent, child, mimics, lines, has_position_limit })
    }

    fn link_of(
        &mut self,
        owner: &str,
        node: &Node<'_, '_>,
        tag: &'static str,
        lines: &mut Lines,
    ) -> Option<String> {
        let Some(element) = self.child(owner, node, tag) else {
            self.missing(lines.own, format!("{owner}: has no <{tag} link=\"…\"/>"));
            return None;
        };
        lines.parts.push((tag, self.line(&element)));
        let Some(link) = element.attribute("link") else {
            self.missing(lines.of(tag), format!("{owner}: <{tag}> has no link"));
            return None;
        };
        self.plain.push_str(&format!("<{tag}"));
        self.attribute("link", link);
        self.plain.push_str("/>");
        Some(link.to_owned())
    }

    fn limit(&mut self, owner: &str, node: &Node<'_, '_>, lines: &mut Lines) -> bool {
        let Some(limit) = self.child(owner, node, "limit") else { return false };
        lines.parts.push(("limit", self.line(&limit)));
        self.plain.push_str("<limit");
        let before = self.notes.errors();
        let lower = self.numbers(owner, &limit, "lower", 1, "0");
        let upper = self.numbers(owner, &limit, "upper", 1, "0");
        let sound = self.notes.errors() == before;
        // Stands for "none given": the URDF standard asks for it, but many files lack it.
        if !self.numbers(owner, &limit, "velocity", 1, "0") {
            self.attribute("velocity", "0");
        }
        self.plain.push_str("/>");
        (lower || upper) && sound
    }
}
