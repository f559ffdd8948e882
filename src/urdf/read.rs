//! From the text of a URDF to links and joints: everything that geometry, limits and masses need, nothing guessed.

use std::collections::{BTreeMap, HashSet};

use roxmltree::{Document, Error as XmlError, Node, ParsingOptions};

use super::source::{Source, quoted};
use crate::input::error::Result;

/// A robot as its URDF writes it: m, rad, kg, N, N·m.
#[derive(Debug)]
pub(super) struct Robot {
    /// Empty if it has none.
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// How many elements there are of each kind that is not read.
    pub unread: BTreeMap<String, usize>,
}

#[derive(Debug)]
pub(super) struct Link {
    pub name: String,
    pub inertial: Option<Inertial>,
    /// Whether something is drawn or collides.
    pub has_shape: bool,
}

#[derive(Debug)]
pub(super) struct Inertial {
    pub mass: Option<f64>,
    /// Centre of mass in the link's frame, if it is given.
    pub centre: Option<[f64; 3]>,
}

#[derive(Debug)]
pub(super) struct Joint {
    pub name: String,
    /// Where it begins in the text.
    pub at: usize,
    pub kind: Kind,
    pub parent: String,
    pub child: String,
    pub origin: Origin,
    /// As written, of any length but zero.
    pub axis: Option<[f64; 3]>,
    pub limit: Option<Limit>,
    pub mimic: Option<Mimic>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
    Spherical,
}

impl Kind {
    const ALL: [(&str, Kind); 7] = [
        ("revolute", Kind::Revolute),
        ("continuous", Kind::Continuous),
        ("prismatic", Kind::Prismatic),
        ("fixed", Kind::Fixed),
        ("floating", Kind::Floating),
        ("planar", Kind::Planar),
        ("spherical", Kind::Spherical),
    ];

    /// Word in URDFs.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(word, _)| word)
    }
}

/// Where a frame stands: the translation, then roll, pitch, yaw about fixed axes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Origin {
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub effort: Option<f64>,
}

#[derive(Debug)]
pub(super) struct Mimic {
    pub joint: String,
    pub multiplier: f64,
    pub offset: f64,
}

/// A file of more XML nodes is no robot.
const MAX_NODES: u32 = 1_000_000;
/// No length or angle is larger, in m or rad.
const LARGEST_PLACE: f64 = 1e6;
/// No limit, mass or effort is larger, in m, rad, kg, N or N·m.
const LARGEST: f64 = 1e12;

/// Reads the robot.
pub(super) fn robot(source: &Source<'_>) -> Result<Robot> {
    if source.text.trim().is_empty() {
        return source.fail_everywhere("is empty, expected a URDF".into());
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = match Document::parse_with_options(source.text, options) {
        Ok(document) => document,
        Err(XmlError::UnknownNamespace(prefix, _)) if prefix == "xacro" => {
            return unexpanded(source, source.text.find(XACRO).unwrap_or(0), XACRO);
        }
        Err(XmlError::NodesLimitReached) => {
            return source.fail_everywhere(format!("has more than {MAX_NODES} XML nodes, expected a URDF"));
        }
        Err(XmlError::DtdDetected) => {
            return source.fail_everywhere("has a <!DOCTYPE …>, expected a URDF without".into());
        }
        Err(error) => return not_xml(source, &error),
    };
    let reader = Reader { source };
    reader.is_expanded(&document)?;
    reader.robot(document.root_element())
}

const XACRO: &str = "<xacro:";

/// The error that the file is a template, as `what` shows.
fn unexpanded<T>(source: &Source<'_>, at: usize, what: &str) -> Result<T> {
    let origin = source.origin;
    let problem = format!(
        "{what} is xacro, from which a URDF has still to be made: xacro {origin} > expanded.urdf (ROS 2: ros2 run \
         xacro xacro {origin} > expanded.urdf), then import expanded.urdf"
    );
    source.fail(at, String::new(), problem)
}

fn not_xml<T>(source: &Source<'_>, error: &XmlError) -> Result<T> {
    let place = error.pos();
    // The place is said in front.
    let text = error.to_string().replace(&format!(" at {place}"), "");
    let start = source.text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
    source.fail(start, String::new(), format!("is no XML: {text}, column {}", place.col))
}

struct Reader<'a> {
    source: &'a Source<'a>,
}

type Element<'a> = Node<'a, 'a>;

fn is(node: Element<'_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

fn elements<'a>(node: Element<'a>) -> impl Iterator<Item = Element<'a>> {
    node.children().filter(Node::is_element)
}

impl Reader<'_> {
    fn fail<T>(&self, node: Element<'_>, place: &str, problem: String) -> Result<T> {
        self.source.fail(node.range().start, place.into(), problem)
    }

    /// Refuses what xacro has still to replace. A leftover `xmlns:xacro` alone is nothing to replace.
    fn is_expanded(&self, document: &Document<'_>) -> Result<()> {
        for node in document.descendants().filter(Node::is_element) {
            if self.source.text[node.range().start..].starts_with(XACRO) {
                return unexpanded(self.source, node.range().start, XACRO);
            }
            let is_template = |value: &str| value.contains("${") || value.contains("$(");
            if let Some(attribute) = node.attributes().find(|attribute| is_template(attribute.value())) {
                return unexpanded(self.source, node.range().start, &quoted(attribute.value()));
            }
        }
        Ok(())
    }

    fn robot(&self, root: Element<'_>) -> Result<Robot> {
        if !is(root, "robot") {
            let hint = if is(root, "sdf") { "; this is SDF, the format of Gazebo" } else { "" };
            let problem = format!("begins with <{}>, expected <robot>, a URDF{hint}", root.tag_name().name());
            return self.fail(root, "", problem);
        }
        let name = root.attribute("name").unwrap_or_default().to_string();
        let mut robot = Robot { name, links: Vec::new(), joints: Vec::new(), unread: BTreeMap::new() };
        let (mut link_names, mut joint_names) = (HashSet::new(), HashSet::new());
        for node in elements(root) {
            match node.tag_name().name() {
                "link" => robot.links.push(self.link(node, &mut link_names, &mut robot.unread)?),
                "joint" => robot.joints.push(self.joint(node, &mut joint_names, &mut robot.unread)?),
                other => *robot.unread.entry(other.into()).or_default() += 1,
            }
        }
        if robot.links.is_empty() {
            return self.fail(root, "", "has no <link>, expected a URDF".into());
        }
        Ok(robot)
    }

    /// The name of a link or joint, and the words by which messages call it.
    fn name<'a>(&self, node: Element<'a>, names: &mut HashSet<&'a str>) -> Result<(&'a str, String)> {
        let kind = if is(node, "link") { "link" } else { "joint" };
        let name = node.attribute("name").unwrap_or_default();
        if name.is_empty() {
            return self.fail(node, kind, "has no name".into());
        }
        let place = format!("{kind} {}", quoted(name));
        if !names.insert(name) {
            return self.fail(node, &place, format!("is there twice, expected each {kind} once"));
        }
        Ok((name, place))
    }

    fn link<'a>(
        &self,
        node: Element<'a>,
        names: &mut HashSet<&'a str>,
        unread: &mut BTreeMap<String, usize>,
    ) -> Result<Link> {
        let (name, place) = self.name(node, names)?;
        let inertial = match self.only(node, "inertial", &place)? {
            None => None,
            Some(inertial) => {
                let mass = match self.only(inertial, "mass", &place)? {
                    Some(mass) => self.number(mass, "value", &place)?,
                    None => None,
                };
                let origin = self.only(inertial, "origin", &place)?;
                let centre = origin.map(|origin| self.vector(origin, "xyz", &place).map(Option::unwrap_or_default));
                Some(Inertial { mass, centre: centre.transpose()? })
            }
        };
        for other in elements(node).filter(|child| !is(*child, "inertial")) {
            *unread.entry(other.tag_name().name().into()).or_default() += 1;
            let meshes = other.descendants().filter(|child| is(*child, "mesh"));
            meshes.for_each(|_| *unread.entry("mesh".into()).or_default() += 1);
        }
        let has_shape = elements(node).any(|child| is(child, "visual") || is(child, "collision"));
        Ok(Link { name: name.into(), inertial, has_shape })
    }

    fn joint<'a>(
        &self,
        node: Element<'a>,
        names: &mut HashSet<&'a str>,
        unread: &mut BTreeMap<String, usize>,
    ) -> Result<Joint> {
        let (name, place) = self.name(node, names)?;
        let word = node.attribute("type").unwrap_or_default();
        let Some((_, kind)) = Kind::ALL.iter().find(|(known, _)| *known == word) else {
            let known = Kind::ALL.map(|(known, _)| known).join(", ");
            return self.fail(node, &place, format!("type={}, expected one of {known}", quoted(word)));
        };
        let end = |which: &str| match self.only(node, which, &place)?.and_then(|end| end.attribute("link")) {
            Some(link) => Ok(link.to_string()),
            None => self.fail(node, &place, format!("has no <{which} link=…>")),
        };
        for child in elements(node).map(|child| child.tag_name().name()) {
            if !["origin", "parent", "child", "axis", "limit", "mimic"].contains(&child) {
                *unread.entry(child.into()).or_default() += 1;
            }
        }
        let has_velocity = |child: &Element<'_>| is(*child, "limit") && child.has_attribute("velocity");
        elements(node).filter(has_velocity).for_each(|_| *unread.entry("limit velocity".into()).or_default() += 1);
        Ok(Joint {
            name: name.into(),
            at: node.range().start,
            kind: *kind,
            parent: end("parent")?,
            child: end("child")?,
            origin: self.origin(node, &place)?,
            axis: self.axis(node, &place)?,
            limit: self.limit(node, &place)?,
            mimic: self.mimic(node, &place)?,
        })
    }

    fn origin(&self, joint: Element<'_>, place: &str) -> Result<Origin> {
        let Some(node) = self.only(joint, "origin", place)? else { return Ok(Origin::default()) };
        if node.attribute("quat_xyzw").is_some() {
            let problem = "quat_xyzw of <origin> is not read: expected rpy, roll, pitch and yaw in rad".into();
            return self.fail(node, place, problem);
        }
        let vector = |name| self.vector(node, name, place).map(Option::unwrap_or_default);
        Ok(Origin { xyz: vector("xyz")?, rpy: vector("rpy")? })
    }

    fn axis(&self, joint: Element<'_>, place: &str) -> Result<Option<[f64; 3]>> {
        let Some(node) = self.only(joint, "axis", place)? else { return Ok(None) };
        let axis = self.vector(node, "xyz", place)?;
        if axis.is_some_and(|axis| axis.iter().all(|component| component.abs() < SHORTEST_AXIS)) {
            return self.fail(node, place, "the <axis> is zero, expected a direction".into());
        }
        Ok(axis)
    }

    fn limit(&self, joint: Element<'_>, place: &str) -> Result<Option<Limit>> {
        let Some(node) = self.only(joint, "limit", place)? else { return Ok(None) };
        let number = |name| self.number(node, name, place);
        let limit = Limit { lower: number("lower")?, upper: number("upper")?, effort: number("effort")? };
        if let (Some(lower), Some(upper)) = (limit.lower, limit.upper)
            && lower > upper
        {
            let problem = format!("lower={lower:?} of <limit> is above upper={upper:?}");
            return self.fail(node, place, problem);
        }
        Ok(Some(limit))
    }

    fn mimic(&self, joint: Element<'_>, place: &str) -> Result<Option<Mimic>> {
        let Some(node) = self.only(joint, "mimic", place)? else { return Ok(None) };
        Ok(Some(Mimic {
            joint: node.attribute("joint").unwrap_or_default().into(),
            multiplier: self.number(node, "multiplier", place)?.unwrap_or(1.0),
            offset: self.number(node, "offset", place)?.unwrap_or(0.0),
        }))
    }

    /// The one child called `name`, if there is any.
    fn only<'a>(&self, node: Element<'a>, name: &str, place: &str) -> Result<Option<Element<'a>>> {
        let mut found = elements(node).filter(|child| is(*child, name));
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => self.fail(second, place, format!("has <{name}> twice, expected it once")),
        }
    }

    fn number(&self, node: Element<'_>, name: &str, place: &str) -> Result<Option<f64>> {
        Ok(self.numbers(node, name, place, LARGEST)?.map(|[number]| number))
    }

    fn vector(&self, node: Element<'_>, name: &str, place: &str) -> Result<Option<[f64; 3]>> {
        self.numbers(node, name, place, LARGEST_PLACE)
    }

    /// The numbers of an attribute, as many as expected and each of sensible size.
    fn numbers<const COUNT: usize>(
        &self,
        node: Element<'_>,
        name: &str,
        place: &str,
        largest: f64,
    ) -> Result<Option<[f64; COUNT]>> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        let number = |word: &str| word.parse().ok().filter(|value: &f64| value.abs() <= largest);
        let found: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        if let Some(values) = found.and_then(|found| found.try_into().ok()) {
            return Ok(Some(values));
        }
        let expected = if COUNT == 1 { "a number".into() } else { format!("{COUNT} numbers") };
        let tag = node.tag_name().name();
        let problem =
            format!("{name}={} of <{tag}>, expected {expected} between {:e} and {largest:e}", quoted(text), -largest);
        self.fail(node, place, problem)
    }
}

/// A shorter axis has no direction.
const SHORTEST_AXIS: f64 = 1e-9;
