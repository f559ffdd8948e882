//! Rewrites the text of a pose for a corrected goal: changes its numbers in place and adds missing ones.

use nalgebra::Vector3;

use crate::{
    model::{
        NumberFormat, Orientation, format_fixed, last_place,
        robot::{
            ArmData, ArmPosture, Component, Decimals, INCH_MM, Language, METRE_DECIMALS, METRE_MM, Number, RobotFault,
            Statement, Target, rotation,
        },
    },
    read::robot::{ToolState, target_state},
};
use kinetostat_spatial::MAX_EXTERNAL_AXES;

/// The position, orientation and external axes to which a pose should lead, in the workpiece frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DesiredPose {
    /// Position of the tool tip, mm.
    pub position: Vector3<f64>,
    pub orientation: Option<Orientation>,
    pub external: [Option<f64>; MAX_EXTERNAL_AXES],
    /// How the arm stands there, if it is to be written.
    pub arm: Option<ArmPosture>,
}

/// A pose as it is written: its text, and where it leads.
#[derive(Clone, Debug)]
pub(crate) struct WrittenPose {
    pub text: Vec<u8>,
    pub is_changed: bool,
    /// Where the pose leads, rounding included.
    pub state: ToolState,
}

/// How poses are written: language and decimals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseFormat {
    pub language: Language,
    pub format: NumberFormat,
    pub decimals: Decimals,
}

impl PoseFormat {
    /// Returns the number of decimals of positions in the unit of the program.
    fn position_decimals(self, unit_mm: f64) -> u8 {
        match unit_mm {
            INCH_MM => self.format.inch_decimals(),
            METRE_MM => self.format.mm_decimals() + METRE_DECIMALS,
            _ => self.format.mm_decimals(),
        }
    }

    /// Returns one unit of the last decimal of positions, mm.
    pub fn unit_mm(self, statement: &Statement) -> f64 {
        let unit_mm = statement.frames.unit_mm;
        last_place(self.position_decimals(unit_mm)) * unit_mm
    }

    /// Returns half a unit of the last decimal of rotations, rad.
    fn half_turn_unit(self) -> f64 {
        let half = last_place(self.decimals.rotation) * (0.5 + 1e-6);
        if self.language.has_degrees() { half.to_radians() } else { half }
    }

    /// Rewrites `target` of `statement`, which starts at `from`, so that it leads to `goal`; numbers that are right to half a unit
    /// of the last decimal stay. `None` if it is unknown where the pose leads.
    pub fn write_pose(
        self,
        statement: &Statement,
        target: &Target,
        goal: &DesiredPose,
        from: Option<&ToolState>,
    ) -> Result<Option<WrittenPose>, RobotFault> {
        let full;
        let (target, old, is_whole) = match (target_state(self.language, statement, target, from), &goal.orientation) {
            // Where a motion is split near B = ±90°, a part of A, B and C does not say how the tool stands: all of them do.
            (Err(RobotFault::PartOfOrientation), Some(orientation)) if !statement.is_step => {
                full = self.with_numbers(target, &self.rotation_texts(orientation, statement, target));
                (&full, target_state(self.language, statement, &full, from)?, true)
            }
            (old, _) => (target, old?, false),
        };
        let Some(old) = old else { return Ok(None) };
        let changes = self.changed_numbers(statement, target, &old, goal, from)?;
        if changes.is_empty() {
            return Ok(Some(WrittenPose { text: target.text.clone(), is_changed: is_whole, state: old }));
        }
        let written = self.with_numbers(target, &changes);
        let state = target_state(self.language, statement, &written, from)?.unwrap_or(old);
        Ok(Some(WrittenPose { text: written.text, is_changed: true, state }))
    }

    /// Returns the components in which `current` differs from `goal` by more than half a unit of the last decimal, with their new texts.
    fn changed_numbers(
        self,
        statement: &Statement,
        target: &Target,
        current: &ToolState,
        goal: &DesiredPose,
        from: Option<&ToolState>,
    ) -> Result<Vec<(Component, String)>, RobotFault> {
        let frames = &statement.frames;
        let in_base =
            |position: Vector3<f64>| frames.base.inverse_transform_point(&position.into()).coords / frames.unit_mm;
        let decimals = self.position_decimals(frames.unit_mm);
        let (current_xyz, goal_xyz) = (in_base(current.position), in_base(goal.position));
        let start = from.filter(|_| statement.is_step).map_or_else(Vector3::zeros, |from| in_base(from.position));
        let half = last_place(decimals) * (0.5 + 1e-6);
        let mut changes = Vec::new();
        for axis in 0..3 {
            if (goal_xyz[axis] - current_xyz[axis]).abs() > half {
                changes.push((Component::Position(axis), format_fixed(goal_xyz[axis] - start[axis], decimals)));
            }
        }
        if let (Some(current), Some(corrected)) = (current.orientation, goal.orientation)
            && current.angle_to(&corrected) > self.half_turn_unit()
        {
            if statement.is_step {
                return RobotFault::not_followed("corrected orientations of steps are", "LIN with a pose");
            }
            changes.extend(self.rotation_texts(&corrected, statement, target));
        }
        let half = last_place(self.decimals.external) * (0.5 + 1e-6);
        for (axis, (current, corrected)) in current.external.into_iter().zip(goal.external).enumerate() {
            if let (Some(current), Some(corrected)) = (current, corrected)
                && (current - corrected).abs() > half
            {
                changes.push((Component::External(axis), format_fixed(corrected, self.decimals.external)));
            }
        }
        if let (Some(data), Some(posture)) = (ArmData::of_target(self.language, target), &goal.arm) {
            changes.extend(data.changes(posture));
        }
        Ok(changes)
    }

    /// Rewrites the record of a circle of `statement` for another centre (mm in W) and radius (mm); numbers that are right to half a unit of
    /// the last decimal stay.
    pub fn circle_record(self, statement: &Statement, record: &Target, centre: Vector3<f64>, radius_mm: f64) -> Target {
        let frames = &statement.frames;
        let decimals = self.position_decimals(frames.unit_mm);
        let goal = frames.base.inverse_transform_point(&centre.into()).coords / frames.unit_mm;
        let goals = (0..3).map(|axis| (Component::Position(axis), goal[axis]));
        let goals = goals.chain([(Component::Radius, radius_mm / frames.unit_mm)]);
        let half = last_place(decimals) * (0.5 + 1e-6);
        let differs = |(component, goal): &(Component, f64)| {
            record.number(*component).is_some_and(|number| (number - goal).abs() > half)
        };
        let changes = goals.filter(differs).map(|(component, goal)| (component, format_fixed(goal, decimals)));
        self.with_numbers(record, &changes.collect::<Vec<_>>())
    }

    /// Returns the rotation components that command the orientation `goal` in `statement`, with their texts.
    fn rotation_texts(self, goal: &Orientation, statement: &Statement, target: &Target) -> Vec<(Component, String)> {
        let numbers = rotation::rotation_parts(self.language, goal, &statement.frames, target);
        let with_text = |(entry, value)| (Component::Rotation(entry), format_fixed(value, self.decimals.rotation));
        numbers.into_iter().enumerate().map(with_text).collect()
    }

    /// Returns `target` with the numbers of `changes` replaced in its text, or added behind the last one.
    fn with_numbers(self, target: &Target, changes: &[(Component, String)]) -> Target {
        let (mut text, mut numbers) = (Vec::with_capacity(target.text.len() + 16), Vec::new());
        let mut put = |text: &mut Vec<u8>, component: Component, digits: &str| {
            // X-5 may become X 5, but not X5, which is another name.
            if text.last().is_some_and(u8::is_ascii_alphanumeric) && !digits.starts_with(['-', '+', '.']) {
                text.push(b' ');
            }
            let at = text.len()..text.len() + digits.len();
            text.extend_from_slice(digits.as_bytes());
            // What was written by us is a number.
            numbers.push(Number { component, at, value: digits.parse().unwrap_or_default() });
        };
        let mut in_order: Vec<&Number> = target.numbers.iter().collect();
        in_order.sort_by_key(|number| number.at.start);
        let mut copied = 0;
        for number in in_order {
            text.extend_from_slice(&target.text[copied..number.at.start]);
            let changed = changes.iter().find(|(component, _)| *component == number.component);
            match changed {
                Some((component, digits)) => put(&mut text, *component, digits),
                None => put(&mut text, number.component, &String::from_utf8_lossy(&target.text[number.at.clone()])),
            }
            copied = number.at.end;
        }
        // Behind the last value, before the brace that closes.
        let rest = &target.text[copied..];
        let end = if self.language == Language::Krl { rest.iter().rposition(|byte| *byte == b'}') } else { None };
        let end = copied + rest[..end.unwrap_or(rest.len())].trim_ascii_end().len();
        text.extend_from_slice(&target.text[copied..end]);
        let separator = if target.text.windows(2).any(|pair| pair == b", ") { ", " } else { "," };
        for (component, digits) in changes.iter().filter(|(component, _)| target.number(*component).is_none()) {
            // `{E6POS:` names a type and nothing yet.
            if !text.ends_with(b"{") && !text.ends_with(b":") {
                text.extend_from_slice(separator.as_bytes());
            }
            if self.language == Language::Krl {
                text.extend_from_slice(krl_name(*component).as_bytes());
                text.push(b' ');
            }
            put(&mut text, *component, digits);
        }
        text.extend_from_slice(&target.text[end..]);
        Target { at: target.at.clone(), text, numbers }
    }
}

/// Returns the name of a component in a KRL pose.
fn krl_name(component: Component) -> String {
    match component {
        Component::Position(axis) => ["X", "Y", "Z"][axis].into(),
        Component::Rotation(angle) => ["A", "B", "C", ""][angle].into(),
        Component::External(axis) => format!("E{}", axis + 1),
        Component::Radius | Component::Arm(_) => String::new(),
    }
}
