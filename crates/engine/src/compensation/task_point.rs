//! Task point: what is wanted at one point of a path, and the error of a pose against it.

use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::{
    machine::{AskedPosture, Coordinate, ExternalAxes, Machine},
    spatial::{Pose, Twist, Wrench, matrix_product, matrix_vector, rotation_exp, rotation_log, skew},
    statics::TaskError,
};

/// Coordinates that are compensated. Others, and those that the drives do not control, are left over and reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Position of the tool tip T, as far as the drives control translations.
    #[default]
    ToolTip,
    /// Position of the platform point P.
    PlatformPoint,
    /// Position of the tool tip and the orientation of the platform, as far as the drives control rotations.
    FullPose,
}

impl Target {
    /// Describes in words what is compensated.
    pub fn text(self) -> &'static str {
        match self {
            Target::ToolTip => "position of the tool tip T",
            Target::PlatformPoint => "position of the platform point P",
            Target::FullPose => "position of the tool tip T and orientation of the platform",
        }
    }
}

/// A task point: the pose that is wanted at one point of a path, the load there, and what is compensated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskPoint {
    /// The pose of P commanded without compensation, t₀, in O.
    pub pose: Pose,
    /// Dead wrench at P in O axes.
    pub load: Wrench,
    /// What is compensated.
    pub target: Target,
    /// Pose that P should have; `None`: `pose`, or where the machine is calibrated for it, see [`ZeroState`](crate::machine::ZeroState).
    pub wanted: Option<Pose>,
    /// Where the compensated point should be beside that, O axes, mm: against what the tool bends in itself, which the machine does not know.
    pub aside: Vector3<f64>,
    /// Positions of the external axes; `None`: those of the machine.
    pub external: Option<ExternalAxes>,
    /// External axes of [`Machine::with_commanded_head`] where the program leads the revolute joints of a head that serves the task: the configurations
    /// of the task are those near them. `None`: those that are reached from home and from point to point.
    pub led: Option<ExternalAxes>,
    /// What a program says of the posture of the arm.
    pub asked: Option<AskedPosture>,
}

impl TaskPoint {
    /// Pose that P should have, as far as it is known.
    pub fn wanted(&self) -> &Pose {
        self.wanted.as_ref().unwrap_or(&self.pose)
    }

    /// Creates the task to hold `pose` under `load`, as the machine is calibrated for it.
    #[must_use]
    pub fn new(pose: Pose, load: Wrench, target: Target) -> Self {
        Self { pose, load, target, wanted: None, aside: Vector3::zeros(), external: None, led: None, asked: None }
    }

    /// The task without the cutting force and what it does to the tool.
    #[must_use]
    pub fn without_force(&self) -> Self {
        Self { load: Wrench::zero(), aside: Vector3::zeros(), ..*self }
    }

    /// Position of the compensated point from P in platform axes, mm.
    pub fn offset(&self, machine: &Machine) -> Vector3<f64> {
        match self.target {
            Target::ToolTip | Target::FullPose => machine.tool_tip,
            Target::PlatformPoint => Vector3::zeros(),
        }
    }

    /// Compensated coordinates, with their indices among the controlled ones.
    pub fn coordinates(&self, machine: &Machine) -> impl Iterator<Item = (usize, Coordinate)> {
        machine.controls.iter().copied().enumerate().filter(|&(_, coordinate)| self.is_compensated(coordinate))
    }

    /// Whether a controlled coordinate is compensated.
    fn is_compensated(&self, coordinate: Coordinate) -> bool {
        self.target == Target::FullPose || matches!(coordinate, Coordinate::Translation(_))
    }

    /// Error of the compensated coordinates (mm, rad) when P is at `pose`.
    pub fn task_error(&self, machine: &Machine, pose: &Pose) -> TaskError {
        let offset = self.offset(machine);
        let wanted_pose = self.wanted();
        let shift = pose.transform(offset) - wanted_pose.transform(offset);
        let turn = rotation_log(&matrix_product(&wanted_pose.rotation.transpose(), &pose.rotation));
        let lever = skew(matrix_vector(&pose.rotation, offset));
        let (mut error, mut slope) = (Vector6::zeros(), Matrix6::zeros());
        let (mut lever_arms, mut count) = (Vector6::zeros(), 0);
        for (row, (_, coordinate)) in self.coordinates(machine).enumerate() {
            count = row + 1;
            match coordinate {
                Coordinate::Translation(axis) => {
                    lever_arms[row] = 1.0;
                    error[row] = shift[axis];
                    slope[(row, axis)] = 1.0;
                    for i in 0..3 {
                        slope[(row, 3 + i)] = -lever[(axis, i)];
                    }
                }
                Coordinate::Rotation(axis) => {
                    lever_arms[row] = machine.characteristic_length;
                    error[row] = turn[axis];
                    for i in 0..3 {
                        slope[(row, 3 + i)] = wanted_pose.rotation[(i, axis)];
                    }
                }
            }
        }
        TaskError { count, error, slope, lever: lever_arms }
    }

    /// Modified target `t₀^(F)`: the commanded pose t₀, its compensated point shifted and the platform turned about it by `shift` (mm, rad).
    pub fn shifted_pose(&self, machine: &Machine, shift: &Vector6<f64>) -> Pose {
        let Twist { linear, angular } = self.shift_twist(machine, shift);
        let rotation = self.pose.rotation * rotation_exp(angular);
        let offset = self.offset(machine);
        let turned_about_point = (self.pose.rotation - rotation) * offset;
        Pose { rotation, translation: self.pose.translation + linear + turned_about_point }
    }

    /// Change of each controlled coordinate of the commanded frame (rows) per unit of each compensated coordinate (columns), mm and rad.
    pub fn control_changes(&self, machine: &Machine) -> DMatrix<f64> {
        let twists = self.shift_twists(machine);
        let change = |row: usize, column: usize| match machine.controls[row] {
            Coordinate::Translation(axis) => twists[(axis, column)],
            Coordinate::Rotation(axis) => self.pose.rotation.column(axis).dot(&twists.fixed_view::<3, 1>(3, column)),
        };
        DMatrix::from_fn(machine.controls.len(), self.coordinates(machine).count(), change)
    }

    /// Twist of the commanded frame at P in O axes per unit of each compensated coordinate, one column each; zero columns beyond them.
    pub fn shift_twists(&self, machine: &Machine) -> Matrix6<f64> {
        let offset = self.offset(machine);
        let mut twists = Matrix6::zeros();
        for (column, (_, coordinate)) in self.coordinates(machine).enumerate() {
            match coordinate {
                Coordinate::Translation(axis) => twists[(axis, column)] = 1.0,
                Coordinate::Rotation(axis) => {
                    let turn = self.pose.rotation.column(axis).into_owned();
                    twists.fixed_view_mut::<3, 1>(0, column).copy_from(&(self.pose.rotation * offset).cross(&turn));
                    twists.fixed_view_mut::<3, 1>(3, column).copy_from(&turn);
                }
            }
        }
        twists
    }

    /// Translation of the compensated point (O axes, mm) and rotation (commanded frame's axes, rad) by a shift of the compensated coordinates.
    fn shift_twist(&self, machine: &Machine, shift: &Vector6<f64>) -> Twist {
        let mut twist = Twist::default();
        for ((_, coordinate), &value) in self.coordinates(machine).zip(shift.iter()) {
            match coordinate {
                Coordinate::Translation(axis) => twist.linear[axis] = value,
                Coordinate::Rotation(axis) => twist.angular[axis] = value,
            }
        }
        twist
    }
}
