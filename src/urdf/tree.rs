//! The tree of links and joints: its root, its tips, and the joints between them.

use std::collections::HashMap;

use super::{
    read::{Joint, JointKind, Robot},
    source::{Source, quoted, quoted_list},
};
use crate::input::error::{Error, Result};

/// Most tips that a message lists.
const LISTED: usize = 30;

/// The tree of a robot: which joint carries each link, and which joints each link carries; links and joints by index.
#[derive(Debug)]
pub(super) struct Tree {
    pub root: usize,
    /// Joint that carries each link; none for the root.
    pub carried_by: Vec<Option<usize>>,
    /// Joints that each link carries.
    pub carries: Vec<Vec<usize>>,
    /// The link that each joint moves.
    pub child_link: Vec<usize>,
    /// The link to which each joint is attached.
    pub parent_link: Vec<usize>,
    /// All links, each after the one that carries it.
    pub order: Vec<usize>,
}

impl Tree {
    /// Builds the tree of `robot`. Fails when links and joints do not form one tree.
    pub fn build(robot: &Robot, source: &Source<'_>) -> Result<Self> {
        let link_index: HashMap<&str, usize> =
            robot.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
        let count = robot.links.len();
        let mut tree = Self {
            root: 0,
            carried_by: vec![None; count],
            carries: vec![Vec::new(); count],
            child_link: Vec::new(),
            parent_link: Vec::new(),
            order: Vec::new(),
        };
        for (j, joint) in robot.joints.iter().enumerate() {
            let place = || format!("joint {}", quoted(&joint.name));
            let link = |which: &str, name: &str| match link_index.get(name) {
                Some(&link) => Ok(link),
                None => source.fail(joint.at, place(), format!("its {which} {} is no link of this file", quoted(name))),
            };
            let (base, moved) = (link("parent", &joint.parent)?, link("child", &joint.child)?);
            if let Some(other) = tree.carried_by[moved].replace(j) {
                let other = quoted(&robot.joints[other].name);
                let problem = format!(
                    "its child {} is also that of joint {other}: expected a tree; write a machine with loops as a machine \
                     file with several chains",
                    quoted(&joint.child)
                );
                return source.fail(joint.at, place(), problem);
            }
            tree.carries[base].push(j);
            tree.parent_link.push(base);
            tree.child_link.push(moved);
        }
        tree.find_root_and_order(robot, source)
    }

    /// Finds the root and orders the links; fails if there are several roots or a loop.
    fn find_root_and_order(mut self, robot: &Robot, source: &Source<'_>) -> Result<Self> {
        let name = |link: &usize| robot.links[*link].name.as_str();
        let roots: Vec<usize> = (0..robot.links.len()).filter(|&link| self.carried_by[link].is_none()).collect();
        match roots[..] {
            [root] => self.root = root,
            [] => return source.fail_whole_file("its joints form a loop, expected a tree".into()),
            _ => {
                let names = quoted_list(roots.iter().map(name));
                return source
                    .fail_whole_file(format!("links {names} are carried by no joint, expected one such link"));
            }
        }
        self.order.push(self.root);
        let mut next = 0;
        while let Some(&link) = self.order.get(next) {
            self.order.extend(self.carries[link].iter().map(|&joint| self.child_link[joint]));
            next += 1;
        }
        if self.order.len() == robot.links.len() {
            return Ok(self);
        }
        let mut is_reachable = vec![false; robot.links.len()];
        self.order.iter().for_each(|&link| is_reachable[link] = true);
        let lost: Vec<usize> = (0..robot.links.len()).filter(|&link| !is_reachable[link]).collect();
        source.fail_whole_file(format!("links {} form a loop, expected a tree", quoted_list(lost.iter().map(name))))
    }

    /// Returns the indices of the joints from the root to `link` (index), in this order.
    pub fn joints_to(&self, mut link: usize) -> Vec<usize> {
        let mut joints = Vec::new();
        while let Some(joint) = self.carried_by[link] {
            joints.push(joint);
            link = self.parent_link[joint];
        }
        joints.reverse();
        joints
    }

    /// Returns the index of the link called `name`; without a name, the only link at the end of movable joints. Fails when there is no such
    /// link, or more than one.
    pub fn tip(&self, name: Option<&str>, robot: &Robot, source: &Source<'_>) -> Result<usize> {
        let fail = |problem: String| Err(Error::Argument { argument: "--tip".into(), problem });
        let mut movable = vec![0; robot.links.len()];
        for &link in &self.order {
            if let Some(joint) = self.carried_by[link] {
                movable[link] = movable[self.parent_link[joint]] + usize::from(is_movable(&robot.joints[joint]));
            }
        }
        if movable.iter().all(|&count| count == 0) {
            return source.fail_whole_file("has no movable joint, expected a robot".into());
        }
        let is_tip = |link: &usize| self.carries[*link].is_empty() && movable[*link] > 0;
        let tips: Vec<usize> = self.order.iter().copied().filter(is_tip).collect();
        let text = |tip: &usize| {
            let (tip_name, count) = (quoted(&robot.links[*tip].name), movable[*tip]);
            format!("{tip_name} ({count} movable {} before it)", if count == 1 { "joint" } else { "joints" })
        };
        let mut tips_in_words = tips.iter().take(LISTED).map(text).collect::<Vec<_>>().join(", ");
        if tips.len() > LISTED {
            tips_in_words += &format!(" and {} more", tips.len() - LISTED);
        }
        match (name, &tips[..]) {
            (None, [tip]) => Ok(*tip),
            (None, _) => fail(format!(
                "{} has several tips: name the link that carries the tool, with --tip: {tips_in_words}",
                source.origin
            )),
            (Some(name), _) => match robot.links.iter().position(|link| link.name == name) {
                Some(link) if movable[link] > 0 => Ok(link),
                Some(_) => fail(format!(
                    "no movable joint leads to {}; tips of {} are: {tips_in_words}",
                    quoted(name),
                    source.origin
                )),
                None => fail(format!("{} has no link {}; its tips are: {tips_in_words}", source.origin, quoted(name))),
            },
        }
    }
}

/// Whether a joint is not fixed.
pub(super) fn is_movable(joint: &Joint) -> bool {
    joint.kind != JointKind::Fixed
}
