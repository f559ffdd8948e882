//! The way from base to tip as the elements of a chain: fixed transforms, drives and the masses they carry.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{
    masses::Mass,
    notes::Notes,
    read::{Joint, Kind, Origin, Robot},
    source::{Source, identifier, quoted},
    tree::{Tree, is_movable},
};
use crate::{
    input::error::Result,
    machine::Motion,
    spatial::{Axis, Pose},
};

/// One element, in the units of machine files.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Element {
    /// Words for the reader.
    Comment(String),
    /// Translation, then rotation about fixed axes.
    Fixed {
        translation_mm: [f64; 3],
        rotation_deg: [f64; 3],
    },
    Drive(Drive),
    Mass {
        kg: f64,
        at_mm: [f64; 3],
    },
}

/// A drive, in mm and N or degrees and N·mm.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drive {
    pub name: String,
    pub motion: Motion,
    pub axis: Axis,
    pub travel: Option<[f64; 2]>,
    pub force_limit: Option<f64>,
}

impl Element {
    /// The rigid transform that it is with its drive at zero.
    pub fn pose(&self) -> Pose {
        match self {
            Element::Fixed { translation_mm, rotation_deg } => pose(*translation_mm, rotation_deg.map(f64::to_radians)),
            _ => Pose::identity(),
        }
    }
}

fn pose(translation: [f64; 3], angles: [f64; 3]) -> Pose {
    Pose { translation: translation.into(), ..Pose::from_roll_pitch_yaw(angles.into()) }
}

/// `value`·1000, rounded once: what is written with few decimals stays so.
pub(super) fn thousandfold(value: f64) -> f64 {
    let text = format!("{value:e}");
    let shifted = text.split_once('e').and_then(|(digits, exponent)| {
        let exponent: i32 = exponent.parse().ok()?;
        format!("{digits}e{}", exponent + 3).parse().ok()
    });
    shifted.unwrap_or(value * 1000.0)
}

fn fixed(translation_mm: [f64; 3], rotation_deg: [f64; 3]) -> Element {
    Element::Fixed { translation_mm, rotation_deg }
}

fn in_deg(angle: f64) -> f64 {
    angle.to_degrees() + 0.0
}

fn in_mm(xyz: [f64; 3]) -> [f64; 3] {
    xyz.map(|v| thousandfold(v) + 0.0)
}

/// Length in m of the way along `joints`, slides at the far end of their travel.
pub(super) fn length(robot: &Robot, joints: &[usize]) -> f64 {
    let way = |joint: &Joint| {
        let slide = match (&joint.limit, joint.kind) {
            (Some(limit), Kind::Prismatic) => {
                limit.lower.unwrap_or_default().abs().max(limit.upper.unwrap_or_default().abs())
            }
            _ => 0.0,
        };
        Vector3::from(joint.origin.xyz).norm() + slide
    };
    joints.iter().map(|&joint| way(&robot.joints[joint])).sum()
}

/// Most drives of a chain: many times those of any robot.
const MAX_DRIVES: usize = 100;

/// The elements from the root along `way`.
///
/// # Errors
/// A joint on the way is none that a drive can be.
pub(super) fn elements(
    robot: &Robot,
    tree: &Tree,
    way: &[usize],
    masses: &[Option<Mass>],
    source: &Source<'_>,
    notes: &mut Notes,
) -> Result<Vec<Element>> {
    let count = way.iter().filter(|&&joint| is_movable(&robot.joints[joint])).count();
    if count > MAX_DRIVES {
        return source
            .fail_everywhere(format!("{count} movable joints lead to the tip, expected at most {MAX_DRIVES}"));
    }
    let mut on_way = vec![false; robot.joints.len()];
    way.iter().for_each(|&joint| on_way[joint] = true);
    let mut builder = Builder { robot, tree, on_way, masses, source, notes, elements: Vec::new(), hanging: Vec::new() };
    builder.link(tree.root);
    for &joint in way {
        builder.joint(&robot.joints[joint])?;
        builder.link(tree.moved[joint]);
    }
    let Builder { elements, hanging, notes, .. } = builder;
    notes.names("movable joints beside the chain, held at zero", hanging.iter().map(String::as_str));
    name_limits(robot, way, &elements, notes);
    name_angles(robot, way, notes);
    Ok(elements)
}

struct Builder<'a> {
    robot: &'a Robot,
    tree: &'a Tree,
    /// Of each joint, whether it is on the way to the tip.
    on_way: Vec<bool>,
    masses: &'a [Option<Mass>],
    source: &'a Source<'a>,
    notes: &'a mut Notes,
    elements: Vec<Element>,
    /// Movable joints beside the chain.
    hanging: Vec<String>,
}

impl Builder<'_> {
    fn joint(&mut self, joint: &Joint) -> Result<()> {
        self.elements.push(Element::Comment(format!("joint {}", quoted(&joint.name))));
        let Origin { xyz, rpy } = joint.origin;
        if joint.origin != Origin::default() {
            self.elements.push(fixed(in_mm(xyz), rpy.map(in_deg)));
        }
        if !is_movable(joint) {
            return Ok(());
        }
        let motion = self.motion(joint)?;
        let (axis, before, after) = along(joint.axis.unwrap_or([1.0, 0.0, 0.0]));
        self.elements.extend(before);
        let name = self.drive_name(&joint.name);
        let travel = travel(joint, motion);
        let effort = joint.limit.and_then(|limit| limit.effort).filter(|&effort| effort > 0.0);
        let force_limit = match motion {
            Motion::Prismatic => effort,
            Motion::Revolute => effort.map(thousandfold),
        };
        self.elements.push(Element::Drive(Drive { name, motion, axis, travel, force_limit }));
        self.elements.extend(after);
        Ok(())
    }

    /// How the joint moves, if it can be a drive.
    fn motion(&self, joint: &Joint) -> Result<Motion> {
        let fail = |problem: String| self.source.fail(joint.at, format!("joint {}", quoted(&joint.name)), problem);
        if let Some(mimic) = &joint.mimic {
            return fail(format!(
                "follows joint {} (mimic, {} times and {} on), and is on the way to the tip: a machine file has no joint that \
                 follows another one; choose a tip before it, or make it fixed if it is to stand still",
                quoted(&mimic.joint),
                mimic.multiplier,
                mimic.offset
            ));
        }
        match joint.kind {
            Kind::Revolute | Kind::Continuous => Ok(Motion::Revolute),
            Kind::Prismatic => Ok(Motion::Prismatic),
            kind => fail(format!(
                "is {}, and is on the way to the tip: a drive is revolute, continuous or prismatic; make it fixed if it is to \
                 stand still, or several joints of one motion each",
                kind.word()
            )),
        }
    }

    /// The joint's name as machine files may have it, and no drive before has it.
    fn drive_name(&mut self, joint: &str) -> String {
        let plain = identifier(joint);
        let is_used = |name: &String| {
            let mut drives = self.elements.iter();
            drives.any(|element| matches!(element, Element::Drive(drive) if drive.name == *name))
        };
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let name = std::iter::once(plain.clone()).chain(numbered).find(|name| !is_used(name)).unwrap_or_default();
        if name != joint {
            self.notes.add(format!("joint {}: its drive is called {name}", quoted(joint)));
        }
        name
    }

    /// The masses of `link` and of all that hangs on it beside the chain.
    fn link(&mut self, link: usize) {
        let mut hanging = vec![(link, Pose::identity())];
        while let Some((here, place)) = hanging.pop() {
            if let Some(mass) = self.masses[here] {
                let name = quoted(&self.robot.links[here].name);
                let place_words = if here == link { "" } else { ", beside the chain" };
                self.elements.push(Element::Comment(format!("link {name}{place_words}")));
                let at: Vector3<f64> = place.transform(in_mm(mass.centre).into());
                self.elements.push(Element::Mass { kg: mass.kg, at_mm: at.into() });
            }
            for &joint in self.tree.carries[here].iter().rev().filter(|&&joint| !self.on_way[joint]) {
                let Joint { name, origin, .. } = &self.robot.joints[joint];
                if is_movable(&self.robot.joints[joint]) {
                    self.hanging.push(name.clone());
                }
                hanging.push((self.tree.moved[joint], place.compose(&pose(in_mm(origin.xyz), origin.rpy))));
            }
        }
    }
}

/// The local axis of a drive along `direction`, and the rotations before and after it.
fn along(direction: [f64; 3]) -> (Axis, Vec<Element>, Vec<Element>) {
    let turn = |angles: [f64; 3]| vec![fixed([0.0; 3], angles.map(in_deg))];
    let half = std::f64::consts::PI;
    let [x, y, z]: [f64; 3] = Vector3::from(direction).normalize().into();
    match (x == 0.0, y == 0.0, z == 0.0) {
        (false, true, true) if x > 0.0 => (Axis::X, Vec::new(), Vec::new()),
        (true, false, true) if y > 0.0 => (Axis::Y, Vec::new(), Vec::new()),
        (true, true, false) if z > 0.0 => (Axis::Z, Vec::new(), Vec::new()),
        (false, true, true) => (Axis::X, turn([0.0, 0.0, half]), turn([0.0, 0.0, -half])),
        (true, false, true) => (Axis::Y, turn([half, 0.0, 0.0]), turn([-half, 0.0, 0.0])),
        (true, true, false) => (Axis::Z, turn([half, 0.0, 0.0]), turn([-half, 0.0, 0.0])),
        _ => {
            let (pitch, yaw) = (x.hypot(y).atan2(z), y.atan2(x));
            let mut back = turn([0.0, -pitch, 0.0]);
            back.extend(turn([0.0, 0.0, -yaw]));
            (Axis::Z, turn([0.0, pitch, yaw]), back)
        }
    }
}

/// Travel in mm or degrees, where both limits are given and differ.
fn travel(joint: &Joint, motion: Motion) -> Option<[f64; 2]> {
    let limit = joint.limit.filter(|_| joint.kind != Kind::Continuous)?;
    // What is not given is zero in a URDF.
    let ends = [limit.lower.unwrap_or_default(), limit.upper.unwrap_or_default()];
    let shown = |end: f64| match motion {
        Motion::Prismatic => thousandfold(end) + 0.0,
        Motion::Revolute => in_deg(end),
    };
    (ends[0] < ends[1]).then(|| ends.map(shown))
}

/// Names what limits and axes do not say.
fn name_limits(robot: &Robot, way: &[usize], elements: &[Element], notes: &mut Notes) {
    let joints: Vec<&Joint> = way.iter().map(|&joint| &robot.joints[joint]).filter(|joint| is_movable(joint)).collect();
    let drives = elements.iter().filter_map(|element| match element {
        Element::Drive(drive) => Some(drive),
        _ => None,
    });
    let pairs: Vec<(&Joint, &Drive)> = joints.into_iter().zip(drives).collect();
    let mut named = |what: &str, is_it: &dyn Fn(&Joint, &Drive) -> bool| {
        notes.names(
            what,
            pairs.iter().filter(|(joint, drive)| is_it(joint, drive)).map(|(joint, _)| joint.name.as_str()),
        );
    };
    named("joints whose lower and upper limits are missing or equal, so without travel", &|joint, drive| {
        drive.travel.is_none() && joint.kind != Kind::Continuous
    });
    named("continuous joints, so without travel", &|joint, _| joint.kind == Kind::Continuous);
    named("joints without effort, so without a largest force or torque", &|_, drive| drive.force_limit.is_none());
    named("joints without axis, taken along x as URDFs have it", &|joint, _| joint.axis.is_none());
}

/// An angle this near to a multiple of a right angle was meant to be one, rad; one nearer than the second is one.
const MEANT: f64 = 2e-3;
const EXACT: f64 = 2e-5;

/// Names angles that were written with few digits.
fn name_angles(robot: &Robot, way: &[usize], notes: &mut Notes) {
    let is_rounded = |angle: f64| {
        let right_angles = (angle / FRAC_PI_2).round();
        right_angles != 0.0 && (EXACT..MEANT).contains(&(angle - right_angles * FRAC_PI_2).abs())
    };
    let joints = way.iter().map(|&joint| &robot.joints[joint]);
    let rounded = joints.filter(|joint| joint.origin.rpy.into_iter().any(is_rounded));
    notes.names(
        "joints whose rpy is almost a right angle, such as 1.57, taken as written",
        rounded.map(|joint| joint.name.as_str()),
    );
}
