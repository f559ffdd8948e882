//! The chain from base to tip as elements of a machine file: fixed transforms, drives and masses; its reach.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{
    bodies::LinkBodies,
    home::drives,
    masses::Mass,
    read::{Joint, JointKind, Origin, Robot},
    source::{Source, identifier, note_names, quoted},
    tree::{Tree, is_movable},
};
use crate::{
    input::error::Result,
    machine::Motion,
    spatial::{Axis, Pose},
};

/// One element of the chain, in the units of machine files.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Element {
    /// A comment for the reader.
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
    /// A body, as an inline table.
    Body(String),
}

/// A drive of the chain: travel in mm or degrees, largest force in N or torque in N·mm.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drive {
    pub name: String,
    pub motion: Motion,
    pub axis: Axis,
    pub travel: Option<[f64; 2]>,
    pub force_limit: Option<f64>,
}

impl Element {
    /// Returns the rigid transform of the element with its drive at zero, mm.
    pub fn pose(&self) -> Pose {
        match self {
            Element::Fixed { translation_mm, rotation_deg } => pose(*translation_mm, rotation_deg.map(f64::to_radians)),
            _ => Pose::identity(),
        }
    }
}

/// Creates a pose from a translation (mm) and roll, pitch, yaw (rad) about fixed axes.
pub(super) fn pose(translation: [f64; 3], angles: [f64; 3]) -> Pose {
    Pose { translation: translation.into(), ..Pose::from_roll_pitch_yaw(angles.into()) }
}

/// Returns `value`·1000, for m to mm: shifts the decimal exponent, so that a number with few decimals keeps few.
pub(super) fn times_thousand(value: f64) -> f64 {
    let text = format!("{value:e}");
    let shifted = text.split_once('e').and_then(|(digits, exponent)| {
        let exponent: i32 = exponent.parse().ok()?;
        format!("{digits}e{}", exponent + 3).parse().ok()
    });
    shifted.unwrap_or(value * 1000.0)
}

/// Converts an angle from rad to degrees, without negative zero.
fn in_deg(angle: f64) -> f64 {
    angle.to_degrees() + 0.0
}

/// Converts a position from m to mm, without negative zero.
pub(super) fn in_mm(xyz: [f64; 3]) -> [f64; 3] {
    xyz.map(|v| times_thousand(v) + 0.0)
}

/// Returns an upper bound of the reach of the chain along `joints`, m: distances between successive joint frames added, each prismatic joint at its
/// larger absolute limit (0 without limits).
pub(super) fn reach_bound(robot: &Robot, joints: &[usize]) -> f64 {
    let joint_reach = |joint: &Joint| {
        let slide = match (&joint.limit, joint.kind) {
            (Some(limit), JointKind::Prismatic) => {
                limit.lower.unwrap_or_default().abs().max(limit.upper.unwrap_or_default().abs())
            }
            _ => 0.0,
        };
        Vector3::from(joint.origin.xyz).norm() + slide
    };
    joints.iter().map(|&joint| joint_reach(&robot.joints[joint])).sum()
}

/// Most drives of a chain: many times those of any robot.
const MAX_DRIVES: usize = 100;

/// Builds the elements of the chain from the root along `joints_to_tip` and the keys of bodies in O and P; fails if a moving joint cannot be a drive.
pub(super) fn chain_elements(
    robot: &Robot,
    tree: &Tree,
    joints_to_tip: &[usize],
    masses: &[Option<Mass>],
    source: &Source<'_>,
    notes: &mut Vec<String>,
) -> Result<(Vec<Element>, [String; 2])> {
    let count = joints_to_tip.iter().filter(|&&joint| is_movable(&robot.joints[joint])).count();
    if count > MAX_DRIVES {
        return source
            .fail_whole_file(format!("{count} movable joints lead to the tip, expected at most {MAX_DRIVES}"));
    }
    let mut on_way = vec![false; robot.joints.len()];
    joints_to_tip.iter().for_each(|&joint| on_way[joint] = true);
    let bodies = LinkBodies { urdf: std::path::absolute(source.origin).unwrap_or_default(), ..LinkBodies::default() };
    let (elements, beside) = (Vec::new(), Vec::new());
    let mut builder = Builder { robot, tree, on_way, masses, source, notes, elements, beside, bodies };
    builder.add_link(tree.root, joints_to_tip);
    for (index, &joint) in joints_to_tip.iter().enumerate() {
        builder.add_joint(&robot.joints[joint])?;
        builder.add_link(tree.child_link[joint], &joints_to_tip[index + 1..]);
    }
    let Builder { elements, beside, bodies, notes, .. } = builder;
    let bodies = bodies.finish(notes);
    note_names(notes, "movable joints beside the chain, held at zero", beside.iter().map(String::as_str));
    note_limits(robot, joints_to_tip, &elements, notes);
    note_angles(robot, joints_to_tip, notes);
    Ok((elements, bodies))
}

/// The state while the elements of a chain are built.
struct Builder<'a> {
    robot: &'a Robot,
    tree: &'a Tree,
    /// For each joint, whether it is part of the chain to the tip.
    on_way: Vec<bool>,
    masses: &'a [Option<Mass>],
    source: &'a Source<'a>,
    notes: &'a mut Vec<String>,
    elements: Vec<Element>,
    /// Names of movable joints beside the chain.
    beside: Vec<String>,
    bodies: LinkBodies,
}

impl Builder<'_> {
    /// Appends the elements of a joint: its fixed transform and, if it moves, its drive.
    fn add_joint(&mut self, joint: &Joint) -> Result<()> {
        self.elements.push(Element::Comment(format!("joint {}", quoted(&joint.name))));
        let Origin { xyz, rpy } = joint.origin;
        if joint.origin != Origin::default() {
            self.elements.push(Element::Fixed { translation_mm: in_mm(xyz), rotation_deg: rpy.map(in_deg) });
        }
        if !is_movable(joint) {
            return Ok(());
        }
        let motion = self.drive_motion(joint)?;
        let (axis, before, after) = local_drive_axis(joint.axis.unwrap_or([1.0, 0.0, 0.0]));
        self.elements.extend(before);
        let name = self.drive_name(&joint.name);
        let travel = travel(joint, motion);
        let effort = joint.limit.and_then(|limit| limit.effort).filter(|&effort| effort > 0.0);
        let force_limit = match motion {
            Motion::Prismatic => effort,
            Motion::Revolute => effort.map(times_thousand),
        };
        self.elements.push(Element::Drive(Drive { name, motion, axis, travel, force_limit }));
        self.elements.extend(after);
        Ok(())
    }

    /// Returns how the joint moves; fails if it cannot be a drive.
    fn drive_motion(&self, joint: &Joint) -> Result<Motion> {
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
            JointKind::Revolute | JointKind::Continuous => Ok(Motion::Revolute),
            JointKind::Prismatic => Ok(Motion::Prismatic),
            kind => fail(format!(
                "is {}, and is on the way to the tip: a drive is revolute, continuous or prismatic; make it fixed if it is to \
                 stand still, or several joints of one motion each",
                kind.word()
            )),
        }
    }

    /// Returns the drive's name: the joint's name in permitted characters, numbered if an earlier drive has it.
    fn drive_name(&mut self, joint: &str) -> String {
        let plain = identifier(joint);
        let is_used = |name: &String| {
            let mut drives = self.elements.iter();
            drives.any(|element| matches!(element, Element::Drive(drive) if drive.name == *name))
        };
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let name = std::iter::once(plain.clone()).chain(numbered).find(|name| !is_used(name)).unwrap_or_default();
        if name != joint {
            self.notes.push(format!("joint {}: its drive is called {name}", quoted(joint)));
        }
        name
    }

    /// Appends masses and bodies of `link` (index), from which `rest` leads to the tip, and of all links that it carries beside the chain, movable joints at zero.
    fn add_link(&mut self, link: usize, rest: &[usize]) {
        let joints = &self.robot.joints;
        let origin = |joint: &usize| pose(in_mm(joints[*joint].origin.xyz), joints[*joint].origin.rpy);
        // Before the first drive it stands in O, behind the last one it moves with P.
        let (end, frame) = if !self.elements.iter().any(|own| matches!(own, Element::Drive(_))) {
            (Some(0), self.elements.iter().fold(Pose::identity(), |all, own| all.compose(&own.pose())))
        } else if rest.iter().all(|&joint| !is_movable(&joints[joint])) {
            (Some(1), rest.iter().fold(Pose::identity(), |all, joint| all.compose(&origin(joint))).inverse())
        } else {
            (None, Pose::identity())
        };
        let mut pending = vec![(link, Pose::identity())];
        while let Some((here, pose_here)) = pending.pop() {
            if let Some(mass) = self.masses[here] {
                let name = quoted(&self.robot.links[here].name);
                let place_text = if here == link { "" } else { ", beside the chain" };
                self.elements.push(Element::Comment(format!("link {name}{place_text}")));
                let at: Vector3<f64> = pose_here.transform(in_mm(mass.centre).into());
                self.elements.push(Element::Mass { kg: mass.kg, at_mm: at.into() });
            }
            self.elements.extend(self.bodies.add(&self.robot.links[here], &frame.compose(&pose_here), end));
            for &joint in self.tree.carries[here].iter().rev().filter(|&&joint| !self.on_way[joint]) {
                let Joint { name, .. } = &self.robot.joints[joint];
                if is_movable(&self.robot.joints[joint]) {
                    self.beside.push(name.clone());
                }
                pending.push((self.tree.child_link[joint], pose_here.compose(&origin(&joint))));
            }
        }
    }
}

/// Returns the coordinate axis for a drive along `direction` (joint frame), and the rotations before and after it that align the axis.
fn local_drive_axis(direction: [f64; 3]) -> (Axis, Vec<Element>, Vec<Element>) {
    let turn = |angles: [f64; 3]| vec![Element::Fixed { translation_mm: [0.0; 3], rotation_deg: angles.map(in_deg) }];
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
            let (pitch, yaw) = (libm::atan2(libm::hypot(x, y), z), libm::atan2(y, x));
            let mut back = turn([0.0, -pitch, 0.0]);
            back.extend(turn([0.0, 0.0, -yaw]));
            (Axis::Z, turn([0.0, pitch, yaw]), back)
        }
    }
}

/// Returns the travel of a drive, mm or degrees; `None` for continuous joints and where the limits are missing, equal or endless.
fn travel(joint: &Joint, motion: Motion) -> Option<[f64; 2]> {
    let limit = joint.limit.filter(|_| joint.kind != JointKind::Continuous)?;
    // What is not given is zero in a URDF.
    let ends = [limit.lower.unwrap_or_default(), limit.upper.unwrap_or_default()];
    let shown = |end: f64| match motion {
        Motion::Prismatic => times_thousand(end) + 0.0,
        Motion::Revolute => in_deg(end),
    };
    (ends[0] < ends[1]).then(|| ends.map(shown))
}

/// Adds notes that name the joints whose travel, effort or axis is missing.
fn note_limits(robot: &Robot, joints_to_tip: &[usize], elements: &[Element], notes: &mut Vec<String>) {
    let joints: Vec<&Joint> =
        joints_to_tip.iter().map(|&joint| &robot.joints[joint]).filter(|joint| is_movable(joint)).collect();
    let pairs: Vec<(&Joint, &Drive)> = joints.into_iter().zip(drives(elements)).collect();
    let mut named = |what: &str, is_it: &dyn Fn(&Joint, &Drive) -> bool| {
        note_names(
            notes,
            what,
            pairs.iter().filter(|(joint, drive)| is_it(joint, drive)).map(|(joint, _)| joint.name.as_str()),
        );
    };
    named("joints whose lower and upper limits are missing, equal or endless, so without travel", &|joint, drive| {
        drive.travel.is_none() && joint.kind != JointKind::Continuous
    });
    named("continuous joints, so without travel", &|joint, _| joint.kind == JointKind::Continuous);
    named("joints without effort, so without a largest force or torque", &|_, drive| drive.force_limit.is_none());
    named("joints without axis, taken along x as URDFs have it", &|joint, _| joint.axis.is_none());
}

/// An angle this near to a multiple of a right angle was meant to be one, rad; one nearer than the second is one.
const MEANT: f64 = 2e-3;
const EXACT: f64 = 2e-5;

/// Adds a note that names joints whose angles are almost right angles, as if written with few digits.
fn note_angles(robot: &Robot, joints_to_tip: &[usize], notes: &mut Vec<String>) {
    let is_rounded = |angle: f64| {
        let right_angles = (angle / FRAC_PI_2).round();
        right_angles != 0.0 && (EXACT..MEANT).contains(&(angle - right_angles * FRAC_PI_2).abs())
    };
    let joints = joints_to_tip.iter().map(|&joint| &robot.joints[joint]);
    let rounded = joints.filter(|joint| joint.origin.rpy.into_iter().any(is_rounded));
    note_names(
        notes,
        "joints whose rpy is almost a right angle, such as 1.57, taken as written",
        rounded.map(|joint| joint.name.as_str()),
    );
}
