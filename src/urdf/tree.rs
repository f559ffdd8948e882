//! Links and joints as the tree they must be: its root, its tips, and the way from one to the other.

use std::collections::HashMap;

use super::{
    read::{Joint, Kind, Robot},
    source::{Source, list, quoted},
};
use crate::input::error::{Error, Result};

/// Most tips that a message lists.
const LISTED: usize = 30;

/// Which joint leads to each link and which lead on from it; links and joints by their place in the robot.
#[derive(Debug)]
pub(super) struct Tree {
    pub root: usize,
    /// Joint that carries each link; none for the root.
    pub carried_by: Vec<Option<usize>>,
    /// Joints that each link carries.
    pub carries: Vec<Vec<usize>>,
    /// Link that each joint moves.
    pub moved: Vec<usize>,
    /// Link that each joint stands on.
    pub base: Vec<usize>,
    /// All links, each after that which carries it.
    pub order: Vec<usize>,
}

impl Tree {
    /// Joins `robot`.
    ///
    /// # Errors
    /// It is not one tree.
    pub fn of(robot: &Robot, source: &Source<'_>) -> Result<Self> {
        let number: HashMap<&str, usize> =
            robot.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
        let count = robot.links.len();
        let mut tree = Self {
            root: 0,
            carried_by: vec![None; count],
            carries: vec![Vec::new(); count],
            moved: Vec::new(),
            base: Vec::new(),
            order: Vec::new(),
        };
        for (j, joint) in robot.joints.iter().enumerate() {
            let place = || format!("joint {}", quoted(&joint.name));
            let link = |which: &str, name: &str| match number.get(name) {
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
            tree.base.push(base);
            tree.moved.push(moved);
        }
        tree.rooted(robot, source)
    }

    fn rooted(mut self, robot: &Robot, source: &Source<'_>) -> Result<Self> {
        let name = |link: &usize| robot.links[*link].name.as_str();
        let roots: Vec<usize> = (0..robot.links.len()).filter(|&link| self.carried_by[link].is_none()).collect();
        match roots[..] {
            [root] => self.root = root,
            [] => return source.fail_everywhere("its joints form a loop, expected a tree".into()),
            _ => {
                let names = list(roots.iter().map(name));
                return source
                    .fail_everywhere(format!("links {names} are carried by no joint, expected one such link"));
            }
        }
        self.order.push(self.root);
        let mut next = 0;
        while let Some(&link) = self.order.get(next) {
            self.order.extend(self.carries[link].iter().map(|&joint| self.moved[joint]));
            next += 1;
        }
        if self.order.len() == robot.links.len() {
            return Ok(self);
        }
        let mut is_reached = vec![false; robot.links.len()];
        self.order.iter().for_each(|&link| is_reached[link] = true);
        let lost: Vec<usize> = (0..robot.links.len()).filter(|&link| !is_reached[link]).collect();
        source.fail_everywhere(format!("links {} form a loop, expected a tree", list(lost.iter().map(name))))
    }

    /// Joints from the root to `link`, in this order.
    pub fn way_to(&self, mut link: usize) -> Vec<usize> {
        let mut way = Vec::new();
        while let Some(joint) = self.carried_by[link] {
            way.push(joint);
            link = self.base[joint];
        }
        way.reverse();
        way
    }

    /// The link called `wanted`; without a name, the only one that movable joints lead to and nothing leads on from.
    ///
    /// # Errors
    /// There is none, or more than one.
    pub fn tip(&self, wanted: Option<&str>, robot: &Robot, source: &Source<'_>) -> Result<usize> {
        let fail = |problem: String| Err(Error::Argument { argument: "--tip".into(), problem });
        let mut movable = vec![0; robot.links.len()];
        for &link in &self.order {
            if let Some(joint) = self.carried_by[link] {
                movable[link] = movable[self.base[joint]] + usize::from(is_movable(&robot.joints[joint]));
            }
        }
        if movable.iter().all(|&count| count == 0) {
            return source.fail_everywhere("has no movable joint, expected a robot".into());
        }
        let is_tip = |link: &usize| self.carries[*link].is_empty() && movable[*link] > 0;
        let tips: Vec<usize> = self.order.iter().copied().filter(is_tip).collect();
        let words = |tip: &usize| {
            let (name, count) = (quoted(&robot.links[*tip].name), movable[*tip]);
            format!("{name} ({count} movable {} before it)", if count == 1 { "joint" } else { "joints" })
        };
        let mut tips_in_words = tips.iter().take(LISTED).map(words).collect::<Vec<_>>().join(", ");
        if tips.len() > LISTED {
            tips_in_words += &format!(" and {} more", tips.len() - LISTED);
        }
        match (wanted, &tips[..]) {
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

/// Whether a joint moves at all.
pub(super) fn is_movable(joint: &Joint) -> bool {
    joint.kind != Kind::Fixed
}
