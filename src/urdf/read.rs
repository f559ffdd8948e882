//! Reads links and joints from the text of a URDF: everything that geometry, limits and masses need, nothing guessed.

use std::collections::{BTreeMap, HashSet};

use kinetostat_cell::spec::{BoxShapeSpec, MeshSpec, MeshUnit, RoundShapeSpec, ShapeSpec};
use roxmltree::{Document, Error as XmlError, Node, ParsingOptions};

use super::{
    chain::{in_mm, times_thousand},
    source::{Source, quoted},
};
use crate::input::error::Result;

/// A robot as its URDF writes it: m, rad, kg, N, N·m.
#[derive(Debug)]
pub(super) struct Robot {
    /// The robot's name; empty if it has none.
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// How many elements there are of each kind that is not read.
    pub unread: BTreeMap<String, usize>,
}

/// A link of a URDF.
#[derive(Debug)]
pub(super) struct Link {
    pub name: String,
    pub inertial: Option<Inertial>,
    /// Shapes of its collision elements, or of the visual ones if it has no other, and the frames about whose origin they are; `Err` has the text of one
    /// that is not known.
    pub shapes: Vec<std::result::Result<(Origin, ShapeSpec), String>>,
}

/// The inertial element of a link.
#[derive(Debug)]
pub(super) struct Inertial {
    pub mass: Option<f64>,
    /// Centre of mass in the link's frame, m, if it is given.
    pub centre: Option<[f64; 3]>,
}

/// A joint of a URDF, as written.
#[derive(Debug)]
pub(super) struct Joint {
    pub name: String,
    /// The byte of the text at which the joint begins.
    pub at: usize,
    pub kind: JointKind,
    pub parent: String,
    pub child: String,
    pub origin: Origin,
    /// The axis as written, of any length but zero.
    pub axis: Option<[f64; 3]>,
    pub limit: Option<Limit>,
    pub mimic: Option<Mimic>,
}

/// The type of a joint in a URDF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointKind {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
    Spherical,
}

impl JointKind {
    const ALL: [(&str, JointKind); 7] = [
        ("revolute", JointKind::Revolute),
        ("continuous", JointKind::Continuous),
        ("prismatic", JointKind::Prismatic),
        ("fixed", JointKind::Fixed),
        ("floating", JointKind::Floating),
        ("planar", JointKind::Planar),
        ("spherical", JointKind::Spherical),
    ];

    /// Returns the type's word in URDFs.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(word, _)| word)
    }

    /// Whether an `<axis>` means anything.
    fn has_axis(self) -> bool {
        !matches!(self, Self::Fixed | Self::Floating | Self::Spherical)
    }
}

/// Pose of a joint's frame: translation, m, then roll, pitch, yaw about fixed axes, rad.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Origin {
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
}

/// The limits of a joint: position in m or rad, effort in N or N·m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub effort: Option<f64>,
}

/// A joint that follows another one: its position is `multiplier` times that of `joint` plus `offset`.
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

/// Reads the robot of a URDF. Fails where the text is no XML, no URDF, or still a xacro template.
pub(super) fn robot(source: &Source<'_>) -> Result<Robot> {
    if source.text.trim().is_empty() {
        return source.fail_whole_file("is empty, expected a URDF".into());
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = match Document::parse_with_options(source.text, options) {
        Ok(document) => document,
        Err(XmlError::UnknownNamespace(prefix, _)) if prefix == "xacro" => {
            return xacro_error(source, source.text.find(XACRO).unwrap_or(0), XACRO);
        }
        Err(XmlError::NodesLimitReached) => {
            return source.fail_whole_file(format!("has more than {MAX_NODES} XML nodes, expected a URDF"));
        }
        Err(XmlError::DtdDetected) => {
            return source.fail_whole_file("has a <!DOCTYPE …>, expected a URDF without".into());
        }
        Err(error) => return xml_error(source, &error),
    };
    source.check_expanded(&document)?;
    source.read_robot(document.root_element())
}

const XACRO: &str = "<xacro:";

/// Returns the error that the file is a xacro template, as the text `what` shows.
fn xacro_error<T>(source: &Source<'_>, at: usize, what: &str) -> Result<T> {
    let origin = source.origin;
    let problem = format!(
        "{what} is xacro, from which a URDF has still to be made: xacro {origin} > expanded.urdf (ROS 2: ros2 run \
         xacro xacro {origin} > expanded.urdf), then import expanded.urdf"
    );
    source.fail(at, String::new(), problem)
}

/// Returns the error that the file is no XML, with line and column.
fn xml_error<T>(source: &Source<'_>, error: &XmlError) -> Result<T> {
    let place = error.pos();
    // The place is said in front.
    let text = error.to_string().replace(&format!(" at {place}"), "");
    let start = source.text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
    source.fail(start, String::new(), format!("is no XML: {text}, column {}", place.col))
}

type Element<'a> = Node<'a, 'a>;

/// Whether `node` is an element called `name`.
fn is_element(node: Element<'_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// Returns the child elements of a node.
fn children_of<'a>(node: Element<'a>) -> impl Iterator<Item = Element<'a>> {
    node.children().filter(Node::is_element)
}

impl Source<'_> {
    /// Returns an error at `node`, about the link or joint `place`.
    fn fail_at<T>(&self, node: Element<'_>, place: &str, problem: String) -> Result<T> {
        self.fail(node.range().start, place.into(), problem)
    }

    /// Checks that nothing is left for xacro to replace; a leftover `xmlns:xacro` alone is nothing to replace.
    fn check_expanded(&self, document: &Document<'_>) -> Result<()> {
        for node in document.descendants().filter(Node::is_element) {
            if self.text[node.range().start..].starts_with(XACRO) {
                return xacro_error(self, node.range().start, XACRO);
            }
            let is_template = |value: &str| value.contains("${") || value.contains("$(");
            if let Some(attribute) = node.attributes().find(|attribute| is_template(attribute.value())) {
                return xacro_error(self, node.range().start, &quoted(attribute.value()));
            }
        }
        Ok(())
    }

    /// Reads all links and joints below the root element.
    fn read_robot(&self, root: Element<'_>) -> Result<Robot> {
        if !is_element(root, "robot") {
            let hint = if is_element(root, "sdf") { "; this is SDF, the format of Gazebo" } else { "" };
            let problem = format!("begins with <{}>, expected <robot>, a URDF{hint}", root.tag_name().name());
            return self.fail_at(root, "", problem);
        }
        let name = root.attribute("name").unwrap_or_default().to_string();
        let mut robot = Robot { name, links: Vec::new(), joints: Vec::new(), unread: BTreeMap::new() };
        let (mut link_names, mut joint_names) = (HashSet::new(), HashSet::new());
        for node in children_of(root) {
            match node.tag_name().name() {
                "link" => robot.links.push(self.read_link(node, &mut link_names, &mut robot.unread)?),
                "joint" => robot.joints.push(self.read_joint(node, &mut joint_names, &mut robot.unread)?),
                other => *robot.unread.entry(other.into()).or_default() += 1,
            }
        }
        if robot.links.is_empty() {
            return self.fail_at(root, "", "has no <link>, expected a URDF".into());
        }
        Ok(robot)
    }

    /// Returns the name of a link or joint and its description, such as `joint "a"`; fails if the name is missing or among `names`.
    fn read_name<'a>(&self, node: Element<'a>, names: &mut HashSet<&'a str>) -> Result<(&'a str, String)> {
        let kind = if is_element(node, "link") { "link" } else { "joint" };
        let name = node.attribute("name").unwrap_or_default();
        if name.is_empty() {
            return self.fail_at(node, kind, "has no name".into());
        }
        let place = format!("{kind} {}", quoted(name));
        if !names.insert(name) {
            return self.fail_at(node, &place, format!("is there twice, expected each {kind} once"));
        }
        Ok((name, place))
    }

    /// Reads a link, whose name must not be in `names`, and counts in `unread` its elements of each kind that is not read.
    fn read_link<'a>(
        &self,
        node: Element<'a>,
        names: &mut HashSet<&'a str>,
        unread: &mut BTreeMap<String, usize>,
    ) -> Result<Link> {
        let (name, place) = self.read_name(node, names)?;
        let inertial = match self.only_child(node, "inertial", &place)? {
            None => None,
            Some(inertial) => {
                let mass = match self.only_child(inertial, "mass", &place)? {
                    Some(mass) => self.read_number(mass, "value", &place)?,
                    None => None,
                };
                let origin = self.only_child(inertial, "origin", &place)?;
                let centre =
                    origin.map(|origin| self.read_vector(origin, "xyz", &place).map(Option::unwrap_or_default));
                Some(Inertial { mass, centre: centre.transpose()? })
            }
        };
        let kinds = children_of(node).map(|child| child.tag_name().name());
        for other in kinds.filter(|own| !["inertial", "visual", "collision"].contains(own)) {
            *unread.entry(other.into()).or_default() += 1;
        }
        let of = |kind| children_of(node).filter(move |child| is_element(*child, kind)).collect::<Vec<_>>();
        let shapes = [of("collision"), of("visual")].into_iter().find(|own| !own.is_empty()).unwrap_or_default();
        let read = |own| self.read_shape(own).ok_or_else(|| quoted(&self.text[own.range()]));
        let shapes = shapes.into_iter().map(read).collect();
        Ok(Link { name: name.into(), inertial, shapes })
    }

    /// Reads a collision or visual element; `None` if it is no known shape.
    fn read_shape(&self, node: Element<'_>) -> Option<(Origin, ShapeSpec)> {
        let mut all = children_of(self.only_child(node, "geometry", "").ok()??);
        let own = all.next().filter(|_| all.next().is_none())?;
        let number = |name| self.read_number(own, name, "").ok()?;
        let vector = |name| self.read_vector(own, name, "").ok()?;
        let (at_mm, rotation_deg) = ([0.0; 3], [0.0; 3]);
        let round = |length: f64| {
            let [from_mm, to_mm] = [-0.5, 0.5].map(|share| [0.0, 0.0, share * times_thousand(length)]);
            Some(RoundShapeSpec { from_mm, to_mm, radius_mm: times_thousand(number("radius")?) })
        };
        let shape = match own.tag_name().name() {
            "box" => ShapeSpec::Box(BoxShapeSpec { size_mm: in_mm(vector("size")?), at_mm, rotation_deg }),
            "cylinder" => ShapeSpec::Cylinder(round(number("length").filter(|own| *own > 0.0)?)?),
            "sphere" => ShapeSpec::Capsule(round(0.0)?),
            "mesh" => {
                let scale = if own.has_attribute("scale") { vector("scale")? } else { [1.0; 3] };
                let is_of = |unit: &(f64, MeshUnit)| scale.iter().all(|own| (own - unit.0).abs() < 1e-9);
                let unit = [(1.0, MeshUnit::M), (0.001, MeshUnit::Mm)].into_iter().find(is_of)?.1;
                let file = own.attribute("filename")?.into();
                ShapeSpec::Mesh(MeshSpec { file, unit: Some(unit), at_mm, rotation_deg, pieces: None })
            }
            _ => return None,
        };
        Some((self.read_origin(node, "").ok()?, shape))
    }

    /// Reads a joint, whose name must not be in `names`, and counts in `unread` its elements of each kind that is not read.
    fn read_joint<'a>(
        &self,
        node: Element<'a>,
        names: &mut HashSet<&'a str>,
        unread: &mut BTreeMap<String, usize>,
    ) -> Result<Joint> {
        let (name, place) = self.read_name(node, names)?;
        let word = node.attribute("type").unwrap_or_default();
        let Some((_, kind)) = JointKind::ALL.iter().find(|(known, _)| *known == word) else {
            let known = JointKind::ALL.map(|(known, _)| known).join(", ");
            return self.fail_at(node, &place, format!("type={}, expected one of {known}", quoted(word)));
        };
        let end = |which: &str| match self.only_child(node, which, &place)?.and_then(|end| end.attribute("link")) {
            Some(link) => Ok(link.to_string()),
            None => self.fail_at(node, &place, format!("has no <{which} link=…>")),
        };
        for child in children_of(node).map(|child| child.tag_name().name()) {
            if !["origin", "parent", "child", "axis", "limit", "mimic"].contains(&child) {
                *unread.entry(child.into()).or_default() += 1;
            }
        }
        let has_velocity = |child: &Element<'_>| is_element(*child, "limit") && child.has_attribute("velocity");
        children_of(node).filter(has_velocity).for_each(|_| *unread.entry("limit velocity".into()).or_default() += 1);
        Ok(Joint {
            name: name.into(),
            at: node.range().start,
            kind: *kind,
            parent: end("parent")?,
            child: end("child")?,
            origin: self.read_origin(node, &place)?,
            // A joint that does not move has no axis, whatever stands there.
            axis: if kind.has_axis() { self.read_axis(node, &place)? } else { None },
            limit: self.read_limit(node, &place)?,
            mimic: self.read_mimic(node, &place)?,
        })
    }

    /// Reads the pose of a joint's frame; the identity if it is not given.
    fn read_origin(&self, joint: Element<'_>, place: &str) -> Result<Origin> {
        let Some(node) = self.only_child(joint, "origin", place)? else { return Ok(Origin::default()) };
        if node.attribute("quat_xyzw").is_some() {
            let problem = "quat_xyzw of <origin> is not read: expected rpy, roll, pitch and yaw in rad".into();
            return self.fail_at(node, place, problem);
        }
        let vector = |name| self.read_vector(node, name, place).map(Option::unwrap_or_default);
        Ok(Origin { xyz: vector("xyz")?, rpy: vector("rpy")? })
    }

    /// Reads the axis of a joint, a vector of any length; `None` if it is not given. Fails if it is zero.
    fn read_axis(&self, joint: Element<'_>, place: &str) -> Result<Option<[f64; 3]>> {
        let Some(node) = self.only_child(joint, "axis", place)? else { return Ok(None) };
        let axis = self.read_vector(node, "xyz", place)?;
        if axis.is_some_and(|axis| axis.iter().all(|component| component.abs() < SHORTEST_AXIS)) {
            return self.fail_at(node, place, "the <axis> is zero, expected a direction".into());
        }
        Ok(axis)
    }

    /// Reads the limits of a joint, those beyond any machine left out; fails if the lower one is above the upper.
    fn read_limit(&self, joint: Element<'_>, place: &str) -> Result<Option<Limit>> {
        let Some(node) = self.only_child(joint, "limit", place)? else { return Ok(None) };
        let number =
            |name| self.read_numbers(node, name, place, f64::INFINITY).map(|found| found.map(|[number]| number));
        let (mut lower, mut upper, effort) = (number("lower")?, number("upper")?, number("effort")?);
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            let problem = format!("lower={lower:?} of <limit> is above upper={upper:?}");
            return self.fail_at(node, place, problem);
        }
        // Writers that know no limit give one of 1e16 or so.
        if lower.into_iter().chain(upper).any(|end| end.abs() > LARGEST_PLACE) {
            (lower, upper) = (None, None);
        }
        Ok(Some(Limit { lower, upper, effort: effort.filter(|effort| *effort <= LARGEST) }))
    }

    /// Reads the mimic element: which joint this one follows; `None` if it moves by itself.
    fn read_mimic(&self, joint: Element<'_>, place: &str) -> Result<Option<Mimic>> {
        let Some(node) = self.only_child(joint, "mimic", place)? else { return Ok(None) };
        let Some(other) = node.attribute("joint") else {
            return self.fail_at(node, place, "has no <mimic joint=…>".into());
        };
        Ok(Some(Mimic {
            joint: other.into(),
            multiplier: self.read_number(node, "multiplier", place)?.unwrap_or(1.0),
            offset: self.read_number(node, "offset", place)?.unwrap_or(0.0),
        }))
    }

    /// Returns the child element called `name`, if there is one; fails if there are two.
    fn only_child<'a>(&self, node: Element<'a>, name: &str, place: &str) -> Result<Option<Element<'a>>> {
        let mut found = children_of(node).filter(|child| is_element(*child, name));
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => self.fail_at(second, place, format!("has <{name}> twice, expected it once")),
        }
    }

    /// Reads the attribute `name` as a number; `None` if it is missing. Fails if it is anything else.
    fn read_number(&self, node: Element<'_>, name: &str, place: &str) -> Result<Option<f64>> {
        Ok(self.read_numbers(node, name, place, LARGEST)?.map(|[number]| number))
    }

    /// Reads the attribute `name` as three numbers; `None` if it is missing. Fails if it is anything else.
    fn read_vector(&self, node: Element<'_>, name: &str, place: &str) -> Result<Option<[f64; 3]>> {
        self.read_numbers(node, name, place, LARGEST_PLACE)
    }

    /// Reads the attribute `name` as `COUNT` numbers of at most `largest` in magnitude; `None` if it is missing. Fails for anything else.
    fn read_numbers<const COUNT: usize>(
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
        let range =
            if largest.is_finite() { format!(" between {:e} and {largest:e}", -largest) } else { String::new() };
        let problem = format!("{name}={} of <{tag}>, expected {expected}{range}", quoted(text));
        self.fail_at(node, place, problem)
    }
}

/// A shorter axis has no direction.
const SHORTEST_AXIS: f64 = 1e-9;
