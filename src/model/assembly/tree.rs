//! Who carries whom, by index into a description.

use std::collections::BTreeSet;

use super::Builder;
use crate::notes::{Code, Part};

/// Who is whose parent, by index into the description.
pub(super) struct Tree {
    /// Joint above each link.
    pub(super) parent_joint: Vec<Option<usize>>,
    /// Joints below each link.
    pub(super) child_joints: Vec<Vec<usize>>,
    pub(super) parent_link: Vec<usize>,
    pub(super) child_link: Vec<usize>,
    pub(super) root: usize,
}

/// Names with their places in a list, in order of the names.
struct Names<'d>(Vec<(&'d str, usize)>);

impl<'d> Names<'d> {
    fn of(names: impl Iterator<Item = &'d str>) -> Self {
        let mut names: Vec<_> = names.enumerate().map(|(place, name)| (name, place)).collect();
        names.sort_unstable();
        Self(names)
    }

    /// Where a name is first.
    fn place(&self, name: &str) -> Option<usize> {
        let at = self.0.partition_point(|(other, _)| *other < name);
        self.0.get(at).filter(|(found, _)| *found == name).map(|(_, place)| *place)
    }

    /// Where names are that stand before, as well.
    fn repeated(&self) -> BTreeSet<usize> {
        self.0.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).collect()
    }
}

impl Builder<'_> {
    /// The parent-child relations, if they form one tree.
    pub(super) fn tree(&mut self) -> Option<Tree> {
        let description = self.description;
        let mut tree = self.relations()?;
        tree.root = self.only_root(&tree.parent_joint)?;
        let before = self.errors.len();
        let mut reached = vec![false; description.links.len()];
        for link in tree.from(tree.root) {
            reached[link] = true;
        }
        for (link, _) in reached.iter().enumerate().filter(|(_, reached)| !**reached) {
            let name = description.links[link].name.clone();
            self.error(Code::Tree, Part::Link(name), "", "is part of a loop of joints");
        }
        (self.errors.len() == before).then_some(tree)
    }

    /// Parents and children, if all names are known and no link has two parents.
    fn relations(&mut self) -> Option<Tree> {
        let description = self.description;
        let before = self.errors.len();
        let links = Names::of(description.links.iter().map(|link| link.name.as_str()));
        for i in links.repeated() {
            let link = Part::Link(description.links[i].name.clone());
            self.error(Code::Conflict, link, "name", "name is taken by another link");
        }
        let joints = Names::of(description.joints.iter().map(|joint| joint.name.as_str()));
        let repeated = joints.repeated();
        let mut parent_joint = vec![None; description.links.len()];
        let mut child_joints = vec![Vec::new(); description.links.len()];
        let (mut parent_link, mut child_link) = (Vec::new(), Vec::new());
        for (j, joint) in description.joints.iter().enumerate() {
            let part = || Part::Joint(joint.name.clone());
            if repeated.contains(&j) {
                self.error(Code::Conflict, part(), "name", "name is taken by another joint");
            }
            let parent = links.place(&joint.parent);
            let child = links.place(&joint.child);
            for (key, name, found) in
                [("parent", &joint.parent, parent), ("child", &joint.child, child)]
            {
                if found.is_none() {
                    let what = format!("{key} link '{name}' does not exist");
                    self.error(Code::Reference, part(), key, what);
                }
            }
            parent_link.push(parent.unwrap_or(usize::MAX));
            child_link.push(child.unwrap_or(usize::MAX));
            if let (Some(parent), Some(child)) = (parent, child) {
                child_joints[parent].push(j);
                if let Some(other) = parent_joint[child].replace(j) {
                    let what = format!(
                        "link '{}' is already the child of joint '{}'; a link has one parent",
                        joint.child, description.joints[other].name
                    );
                    self.error(Code::Tree, part(), "child", what);
                }
            }
        }
        // A joint without links leaves further roots, which are no errors of their own.
        (self.errors.len() == before).then_some(Tree {
            parent_joint,
            child_joints,
            parent_link,
            child_link,
            root: 0,
        })
    }

    /// The link without a parent, if there is one alone.
    fn only_root(&mut self, parent_joint: &[Option<usize>]) -> Option<usize> {
        let description = self.description;
        let roots: Vec<usize> =
            (0..description.links.len()).filter(|&l| parent_joint[l].is_none()).collect();
        match roots.as_slice() {
            [] if description.links.is_empty() => {
                self.error(Code::Tree, Part::Robot, "", "the URDF has no link");
            }
            [] => self.error(
                Code::Tree,
                Part::Robot,
                "",
                "the joints form a loop: no link is without a parent",
            ),
            [root] => return Some(*root),
            [first, others @ ..] => {
                for &other in others {
                    let what = format!(
                        "a second root beside '{}'; every link but one must be the child of a \
                         joint",
                        description.links[*first].name
                    );
                    self.error(
                        Code::Tree,
                        Part::Link(description.links[other].name.clone()),
                        "",
                        what,
                    );
                }
            }
        }
        None
    }
}

impl Tree {
    /// Links carried by `link`, itself first, parents before children, in file order.
    pub(super) fn from(&self, link: usize) -> Vec<usize> {
        let mut links = vec![link];
        let mut next = 0;
        while next < links.len() {
            links.extend(self.child_joints[links[next]].iter().map(|&j| self.child_link[j]));
            next += 1;
        }
        links
    }

    /// Links from the root to `link`, both included.
    pub(super) fn path_to(&self, link: usize) -> Vec<usize> {
        let mut path = vec![link];
        let mut at = link;
        while let Some(joint) = self.parent_joint[at] {
            at = self.parent_link[joint];
            path.push(at);
        }
        path.reverse();
        path
    }
}
