//! What a position register holds: the values of a pose or of joints. They are of no frame and no
//! tool: a move counts them in those that are chosen where it runs.

use std::array::from_fn;
use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::text::Group;
use super::why::{Why, both};
use crate::units::{deg_from_rad, m_from_mm, mm_from_m, rad_from_deg};

pub(super) const POSE: [&str; 6] = ["x", "y", "z", "w", "p", "r"];
pub(super) const JOINTS: [&str; 6] = ["j1", "j2", "j3", "j4", "j5", "j6"];

/// The external axes of the arm's own group: elements 7 to 9.
const AXES: [&str; 3] = ["e1", "e2", "e3"];

/// What a bare `Offset` or `Tool_Offset` shifts by.
pub(super) struct OffsetCondition {
    /// n of PR[n], and what that held there.
    pub(super) register: i64,
    pub(super) held: Held,
    /// The frame or tool that is named there.
    pub(super) axes_of: Option<u32>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Held {
    /// J1 to J6 or X to R; `None` where the program sets elements of what only the controller
    /// knows.
    are_joints: Option<bool>,
    /// In mm and degrees, or why they are not known; empty where the program does not set them.
    elements: [Result<f64, Why>; 6],
    /// Elements that are zero by the job's word alone.
    assumed: [bool; 6],
    /// The register of which the job says so, where it is another.
    assumed_of: Option<String>,
    /// External axes by name.
    axes: BTreeMap<String, f64>,
    config: Option<String>,
    /// Whether the program has set it as a whole.
    is_set: bool,
}

impl Held {
    /// What the program has not set.
    pub(super) fn unset() -> Self {
        Self { is_set: false, ..Self::unknown(None, Why::default()) }
    }

    /// What the program has set to what only the run knows.
    pub(super) fn unknown(are_joints: Option<bool>, why: impl Into<Why>) -> Self {
        let why = why.into();
        Self {
            are_joints,
            elements: from_fn(|_| Err(why.clone())),
            assumed: [false; 6],
            assumed_of: None,
            axes: BTreeMap::new(),
            config: None,
            is_set: true,
        }
    }

    /// Zero by the job's word.
    pub(super) fn assumed_zero() -> Self {
        let elements = from_fn(|_| Ok(0.0));
        Self { are_joints: Some(false), elements, assumed: [true; 6], ..Self::unset() }
    }

    /// The values of a position, without its frame and tool.
    pub(super) fn of(group: &Group) -> Self {
        let are_joints = group.parts.contains_key(JOINTS[0]);
        let names = if are_joints { JOINTS } else { POSE };
        let element = |name: &str| {
            let value = group.parts.get(name).copied();
            value.ok_or_else(|| format!("the position has no {}", name.to_uppercase()).into())
        };
        Self {
            elements: names.map(element),
            axes: axes(group).collect(),
            config: group.config.clone(),
            ..Self::unknown(Some(are_joints), Why::default())
        }
    }

    /// Whether the program has set nothing of it, and the job assumes nothing.
    pub(super) fn is_unset(&self) -> bool {
        *self == Self::unset()
    }

    pub(super) fn is_set(&self) -> bool {
        self.is_set
    }

    pub(super) fn is_known(&self) -> bool {
        self.elements.iter().all(Result::is_ok)
    }

    /// Whether the program has set an element of it to what is not known.
    pub(super) fn is_set_to_unknown(&self) -> bool {
        self.elements.iter().any(|own| own.as_ref().is_err_and(|why| !why.is_empty()))
    }

    /// Whether nothing says that the elements are not joints.
    pub(super) fn is_of_unknown_kind(&self) -> bool {
        self.are_joints.is_none()
    }

    /// `PR[1,3]`, by its number from 1.
    pub(super) fn element(&self, name: &str, index: i64) -> Result<f64, Why> {
        let at = usize::try_from(index).ok().and_then(|index| index.checked_sub(1));
        let own = at.and_then(|at| self.elements.get(at));
        if let Some(own) = own {
            return own.clone().map_err(|why| {
                let text = self.reason(name, index, &why);
                // The job can give what the program does not set.
                let is_unset = why.is_empty();
                if is_unset { Why::of(text, &element_of(name, index)) } else { why.told(text) }
            });
        }
        let axis = at.and_then(|at| AXES.get(at.checked_sub(self.elements.len())?));
        let value = axis.and_then(|axis| self.axes.get(*axis)).copied();
        value.ok_or_else(|| format!("{name} is not known in its element {index}").into())
    }

    /// Sets an element by its number from 1.
    pub(super) fn set(&mut self, index: i64, value: Result<f64, Why>) -> Result<(), String> {
        let none = || format!("a position has no element {index}");
        let at = usize::try_from(index).ok().and_then(|index| index.checked_sub(1));
        let at = at.ok_or_else(none)?;
        if let (Some(own), Some(assumed)) = (self.elements.get_mut(at), self.assumed.get_mut(at)) {
            (*own, *assumed) = (value, false);
            return Ok(());
        }
        let axis = at.checked_sub(self.elements.len()).and_then(|at| AXES.get(at));
        let axis = axis.ok_or_else(none)?;
        match value {
            Ok(value) => drop(self.axes.insert((*axis).to_owned(), value)),
            Err(_) => drop(self.axes.remove(*axis)),
        }
        Ok(())
    }

    /// Gives an element of a pose, by its number from 1, by the job's word.
    pub(super) fn give(&mut self, index: i64, value: f64) -> Result<(), String> {
        self.are_joints = Some(false);
        self.set(index, Ok(value))
    }

    /// The same with what the job says of the elements that are not known; `hint` is what helps
    /// where it says nothing.
    pub(super) fn completed(mut self, job: &Self, hint: &str) -> Self {
        for (at, own) in self.elements.iter_mut().enumerate() {
            let Err(why) = &*own else { continue };
            let given = job.elements[at].clone().map_err(|_| why.clone().with(hint));
            (*own, self.assumed[at]) = (given, job.assumed[at]);
        }
        self
    }

    /// What is left of it, or of one element, where another may have set it: what is as the job
    /// has it, and else what `given` says of an element, by its number from 1.
    pub(super) fn left(
        &self,
        only: Option<i64>,
        job: &Self,
        given: impl Fn(i64) -> Result<f64, Why>,
    ) -> Self {
        let mut left = self.clone();
        if only.is_none() {
            (left.axes, left.config) = (BTreeMap::new(), None);
            left.are_joints = None;
        }
        for (at, index) in (1..).take(self.elements.len()).enumerate() {
            let is_same = self.elements[at].is_ok() && self.elements[at] == job.elements[at];
            if only.is_none_or(|only| only == index) && !is_same {
                (left.elements[at], left.assumed[at]) = (given(index), false);
            }
        }
        if left.is_known() && only.is_none() {
            left.are_joints = Some(false);
        }
        left
    }

    /// As a place to go to, or a frame: what the job assumes to be zero is none.
    pub(super) fn target(&self, name: &str) -> Result<Group, Why> {
        if self.assumed.contains(&true) {
            let from = self.assumed_of.as_deref().unwrap_or(name);
            let is_own = from == name;
            let set = if is_own { String::new() } else { format!("{name} comes of {from}: ") };
            return Err(format!(
                "{set}assume: {{\"{from}\": 0}} counts for offsets only: for a place the program \
                 sets all elements, or the job gives them: assume: {{\"{}\": …, …, \"{}\": …}}",
                element_of(from, 1),
                element_of(from, 6)
            )
            .into());
        }
        self.group(name)
    }

    /// As what a shift takes, in no frame. All elements that are not known are told at once.
    pub(super) fn group(&self, name: &str) -> Result<Group, Why> {
        let names = if self.are_joints == Some(true) { JOINTS } else { POSE };
        let mut group = Group { config: self.config.clone(), ..Group::default() };
        group.parts.extend(self.axes.iter().map(|(axis, value)| (axis.clone(), *value)));
        let mut unknown = None;
        for (index, own) in (1..).zip(names) {
            match self.element(name, index) {
                Ok(value) => drop(group.parts.insert(own.to_owned(), value)),
                Err(why) => why.add_to(&mut unknown),
            }
        }
        match unknown {
            None => Ok(group),
            Some(why) if self.is_set_to_unknown() => Err(why),
            Some(why) => Err(format!("{}; {}", why.text(), places_by_job(name)).into()),
        }
    }

    /// The same, where what is not known says of which register it comes; `hint` is what helps
    /// where the program sets none of it.
    pub(super) fn named(mut self, name: &str, hint: &str) -> Self {
        let told = self.clone();
        for (index, own) in (1..).zip(&mut self.elements) {
            if let Err(why) = own {
                let text = told.reason(name, index, why);
                *why = match why.is_empty() {
                    // Beside what the program sets to what is not known.
                    true if told.is_set_to_unknown() => Why::of(text, &element_of(name, index)),
                    true => why.clone().told(text).with(hint),
                    false => why.clone().told(text),
                };
            }
        }
        if self.assumed.contains(&true) {
            self.assumed_of.get_or_insert_with(|| name.to_owned());
        }
        self.is_set = true;
        self
    }

    /// Element by element, as the controller adds and subtracts; the configuration stays.
    /// `is_same`: both are one register, so that what it holds does not matter.
    pub(super) fn plus(&self, sign: f64, other: &Self, is_same: bool) -> Self {
        let are_joints = match (self.are_joints, other.are_joints) {
            (Some(own), Some(other)) if own != other => {
                return Self::unknown(None, "it adds a pose and joints");
            }
            (Some(own), Some(_)) => Some(own),
            (Some(true), None) | (None, Some(true)) => {
                return Self::unknown(None, "it adds joints to what may be a pose");
            }
            _ => None,
        };
        let is_zero = is_same && sign < 0.0;
        let added = |at: usize| match both(self.elements[at].clone(), other.elements[at].clone()) {
            Ok((own, other)) => Ok(own + sign * other),
            Err(_) if is_zero => Ok(0.0),
            Err(why) => Err(why),
        };
        let both = self.axes.iter().filter_map(|(axis, own)| {
            let other = other.axes.get(axis)?;
            Some((axis.clone(), own + sign * other))
        });
        Self {
            are_joints,
            elements: from_fn(added),
            assumed: from_fn(|at| self.assumed[at] && other.assumed[at]),
            assumed_of: self.assumed_of.clone().or_else(|| other.assumed_of.clone()),
            axes: both.collect(),
            config: self.config.clone(),
            is_set: true,
        }
    }

    /// Why an element of a register is not known.
    fn reason(&self, name: &str, index: i64, why: &Why) -> String {
        let head = format!("{name} is known only at run time");
        let why = why.text();
        // Of registers that are set to each other the last is told.
        let inner = " is known only at run time: PR[";
        let last = why.rfind(inner).and_then(|at| why.get(at + inner.len() - "PR[".len()..));
        let why = last.unwrap_or(why);
        if why.starts_with(&head) {
            return why.to_owned();
        }
        match (why, self.elements.iter().any(Result::is_ok)) {
            ("", true) => format!("{head}: the program does not set its element {index}"),
            ("", false) => head,
            _ => format!("{head}: {why}"),
        }
    }
}

/// `PR[5,1]` of `PR[5]`.
pub(super) fn element_of(name: &str, index: i64) -> String {
    format!("{},{index}]", name.trim_end_matches(']'))
}

/// What the job can say of a register that the program does not set.
pub(super) fn places_by_job(name: &str) -> String {
    format!("{}: X, Y, Z in mm, W, P, R in degrees", six_by_job(name))
}

/// The same of a register that the program sets to joints.
pub(super) fn joints_by_job(name: &str) -> String {
    format!("{}: J1 to J6 in degrees", six_by_job(name))
}

fn six_by_job(name: &str) -> String {
    let [first, last] = [1, 6].map(|index| element_of(name, index));
    format!("assume: {{\"{first}\": …, …, \"{last}\": …}} in the job gives the place")
}

/// The external axes that a position places.
pub(super) fn axes(group: &Group) -> impl Iterator<Item = (String, f64)> {
    let is_axis = |name: &str| AXES.contains(&name) || name.starts_with("gp");
    let own = group.parts.iter().filter(move |(name, _)| is_axis(name));
    own.map(|(name, value)| (name.clone(), *value))
}

/// Six components, if the first is there.
pub(super) fn six(group: &Group, names: [&str; 6]) -> Result<Option<[f64; 6]>, String> {
    if !group.parts.contains_key(names[0]) {
        return Ok(None);
    }
    let mut found = [0.0; 6];
    for (value, name) in found.iter_mut().zip(names) {
        let part = group.parts.get(name);
        *value = *part.ok_or_else(|| format!("the position has no {}", name.to_uppercase()))?;
    }
    Ok(Some(found))
}

/// A pose as what is taught has it, in no frame.
pub(super) fn group_of(six: [f64; 6]) -> Group {
    Group { parts: POSE.map(str::to_owned).into_iter().zip(six).collect(), ..Group::default() }
}

/// X, Y, Z in mm and W, P, R in degrees of a pose.
pub(super) fn elements(pose: &Isometry3<f64>) -> [f64; 6] {
    let at = pose.translation.vector.map(mm_from_m);
    let (w, p, r) = pose.rotation.euler_angles();
    let [w, p, r] = [w, p, r].map(deg_from_rad);
    [at.x, at.y, at.z, w, p, r]
}

/// X, Y, Z in mm; W, P, R about the fixed x, y and z axes in degrees.
pub(super) fn pose([x, y, z, w, p, r]: [f64; 6]) -> Isometry3<f64> {
    let at = Translation3::new(m_from_mm(x), m_from_mm(y), m_from_mm(z));
    let [w, p, r] = [w, p, r].map(rad_from_deg);
    Isometry3::from_parts(at, UnitQuaternion::from_euler_angles(w, p, r))
}
