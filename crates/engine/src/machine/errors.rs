//! Manufacturing and assembly errors: what makes the actual machine differ from the nominal one.

use nalgebra::{Matrix3, Vector3};

use super::{Chain, Drive, Machine, Motion, Route, Step};
use crate::spatial::{Pose, Twist};

/// A chain that is turned farther is a mistake of another kind.
const LARGEST_ROTATION_DEG: f64 = 30.0;

/// Geometric errors of one chain. Zero by default.
///
/// The chain's product becomes `base · E_base · … · T(drive, offset) T(drive, ρ + θ_a) … · E_end · attachment`, where an
/// error frame is `E = T(translation) · exp(rotation)`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChainError {
    /// Displacement (mm) and rotation vector (rad) of the chain's first frame, in its own axes.
    pub base: Twist,
    /// Displacement (mm) and rotation vector (rad) of the chain's last frame, in its own axes.
    pub end: Twist,
    /// Zero-point error of each drive in mm or rad: the joint stands at ρ + offset. Missing entries are zero.
    pub drive_offsets: Vec<f64>,
}

impl ChainError {
    /// Message that refuses an assembly error of `angle` rad as too large; `None` up to 30 degrees.
    pub fn rotation_problem(angle: f64) -> Option<String> {
        let degrees = angle.to_degrees();
        let problem = format!(
            "must be at most {LARGEST_ROTATION_DEG:.0} deg either way, which no error of assembly exceeds, got {degrees:.3} deg"
        );
        (degrees.abs() > LARGEST_ROTATION_DEG).then_some(problem)
    }

    /// An assembly error: the chain is turned by `angle` rad about the axis of its first drive, through the origin of its
    /// base frame. Without a drive the chain stays nominal.
    pub fn turn_about_drive_axis(chain: &Chain, angle: f64) -> Self {
        let mut error = Self::default();
        let axis = chain.drives.first().and_then(|drive| drive_axis(&chain.route, drive, Matrix3::identity()));
        if let Some(axis) = axis {
            error.base.angular = axis * angle;
        }
        error
    }

    /// Whether all errors are zero.
    pub fn is_none(&self) -> bool {
        self.base == Twist::default() && self.end == Twist::default() && self.drive_offsets.iter().all(|o| *o == 0.0)
    }

    /// The error multiplied by `factor`.
    pub fn scale(&self, factor: f64) -> Self {
        let scale = |t: Twist| Twist { linear: t.linear * factor, angular: t.angular * factor };
        Self {
            base: scale(self.base),
            end: scale(self.end),
            drive_offsets: self.drive_offsets.iter().map(|offset| offset * factor).collect(),
        }
    }

    fn apply(&self, chain: &mut Chain) {
        let route = &mut chain.route;
        route.base = route.base.compose(&frame_error(self.base));
        route.attachment = frame_error(self.end).compose(&route.attachment);
        for (drive, &offset) in chain.drives.iter().zip(&self.drive_offsets) {
            route.for_each(&mut |route| shift_joint(route, drive, offset));
        }
    }
}

/// Axis of `drive`, the joints before it at zero; `None` if neither the route nor one of its loops has it. `rotation`: axes of the route's first
/// frame.
fn drive_axis(route: &Route, drive: &Drive, mut rotation: Matrix3<f64>) -> Option<Vector3<f64>> {
    let mut frames = Vec::new();
    for step in &route.steps {
        match *step {
            Step::Fixed(pose) => rotation *= pose.rotation,
            Step::Move { coordinate, axis, .. } if coordinate == drive.coordinate => {
                return Some(rotation.column(axis.index()).into_owned());
            }
            Step::Move { .. } => {}
            Step::Frame => frames.push(rotation),
        }
    }
    let mut loops = route.loops.iter();
    loops.find_map(|inner| drive_axis(&inner.route, drive, frames[inner.from] * inner.route.base.rotation))
}

/// Shifts the zero of the joint of `drive` by `offset` mm or rad, if the route has it.
fn shift_joint(route: &mut Route, drive: &Drive, offset: f64) {
    let joint = route.steps.iter().enumerate().find_map(|(index, step)| match *step {
        Step::Move { coordinate, axis, .. } if coordinate == drive.coordinate => Some((index, axis)),
        _ => None,
    });
    if let Some((index, axis)) = joint {
        let mut shift = Pose::identity();
        match drive.motion {
            Motion::Prismatic => shift.translate_along(axis, offset),
            Motion::Revolute => shift.rotate_about(axis, offset),
        }
        route.steps.insert(index, Step::Fixed(shift));
    }
}

/// Pose of an error frame with this displacement (mm) and rotation vector (rad).
fn frame_error(error: Twist) -> Pose {
    let mut pose = Pose::from_rotation_vector(error.angular);
    pose.translation = error.linear;
    pose
}

impl Machine {
    /// Assembly errors: each chain turned by its entry of `degrees`, see [`ChainError::turn_about_drive_axis`].
    pub fn assembly_errors(&self, degrees: &[f64]) -> Vec<ChainError> {
        let turn = |(chain, angle): (_, &f64)| ChainError::turn_about_drive_axis(chain, angle.to_radians());
        self.chains.iter().zip(degrees).map(turn).collect()
    }

    /// The actual machine: this one with `errors[i]` built into chain `i`; chains without an entry stay nominal.
    ///
    /// Its `home`, limits and names stay those of the nominal machine, by which it is commanded.
    pub fn with_errors(&self, errors: &[ChainError]) -> Machine {
        let mut actual = self.with_errors_unrecorded(errors);
        actual.definition.record_errors(errors);
        actual
    }

    /// Builds `errors` into the chains as [`Machine::with_errors`] does, without recording them for [`Machine::with_parameters`].
    pub(super) fn with_errors_unrecorded(&self, errors: &[ChainError]) -> Machine {
        let mut actual = self.clone();
        for (chain, error) in actual.chains.iter_mut().zip(errors) {
            error.apply(chain);
        }
        actual
    }
}
