//! The placement of the workpiece in the machine, and the platform poses and loads that follow from it.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    machine::Machine,
    spatial::{Axis, Pose, Wrench, frame_about, least_turn, rotation_exp},
    toolpath::{Load, Orientation},
};

/// The point of the machine whose positions a path gives: tool tip or platform point.
///
/// A toolpath is that of the tool tip; a commanded position, everywhere else in this program, is that of P. The paper's
/// "circle centred at Q1" is a path of P.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathReference {
    /// The tool tip T.
    #[default]
    ToolTip,
    /// The platform point P.
    PlatformPoint,
}

/// Pose of the workpiece frame W in the base frame O, or in the frame of the workpiece carrier of a machine that has one, and whose
/// positions a path gives. By default W is that frame.
///
/// The tool keeps the direction it has in W: where W is tilted, the platform tilts with it. Yaw turns the workpiece about
/// the tool's axis, which the platform need not follow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Placement {
    /// `p_OW`, mm.
    pub origin_mm: Vector3<f64>,
    /// Roll, pitch and yaw ψ of W, rad: `R_OW = R_z(yaw) R_y(pitch) R_x(roll)`.
    pub roll_pitch_yaw: Vector3<f64>,
    /// The point whose positions the path gives.
    pub reference: PathReference,
}

impl Placement {
    /// Returns the pose of the workpiece frame, `X_OW`, mm.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose { translation: self.origin_mm, ..Pose::from_roll_pitch_yaw(self.roll_pitch_yaw) }
    }

    /// Returns the platform orientation `R_OP` for a path in W from `home`, that of the platform at home: `R_OP = R_OW R_z(−yaw) R_home`.
    #[must_use]
    pub fn platform_orientation(&self, home: &Matrix3<f64>) -> Matrix3<f64> {
        let tilted = Vector3::new(self.roll_pitch_yaw.x, self.roll_pitch_yaw.y, 0.0);
        if tilted == Vector3::zeros() {
            return *home;
        }
        let mut tilt = self.pose();
        tilt.rotate_about(Axis::Z, -self.roll_pitch_yaw.z);
        tilt.rotation * home
    }

    /// Applies the placement to a machine whose platform has the orientation `home` at home and whose tool frame is `tool`,
    /// `X_PT` in platform axes, mm.
    #[must_use]
    pub fn on_machine(&self, home: &Matrix3<f64>, tool: &Pose) -> PlacedWorkpiece {
        let orientation = self.platform_orientation(home);
        // R_OP = R_OW R_z(−yaw) R_home, so that of R_WP only the yaw is left.
        let unturned = Pose::from_roll_pitch_yaw(Vector3::new(0.0, 0.0, -self.roll_pitch_yaw.z)).rotation;
        let reference = self.reference_in_platform(tool.translation);
        PlacedWorkpiece {
            workpiece: self.pose(),
            home: *home,
            orientation,
            reference,
            tool: *tool,
            tool_axes: frame_about((unturned * (home * tool.rotation.column(2))).normalize()),
        }
    }

    /// Returns the place of workpiece and tool on `machine`, or on its workpiece carrier, with the platform oriented as at home.
    #[must_use]
    pub(crate) fn place(&self, machine: &Machine) -> PlacedWorkpiece {
        let mut placed = self.on_machine(&machine.home.pose.rotation, &machine.tool());
        if machine.is_oriented_by_locked() {
            placed = placed.with_platform_rotation(&machine.home.pose.rotation);
        }
        machine.carrier.as_ref().map_or(placed, |carrier| placed.on_carrier(&carrier.home.pose))
    }

    /// Returns the position `p_PR` of the path's reference point in platform axes, mm.
    fn reference_in_platform(&self, tool_tip: Vector3<f64>) -> Vector3<f64> {
        match self.reference {
            PathReference::ToolTip => tool_tip,
            PathReference::PlatformPoint => Vector3::zeros(),
        }
    }
}

/// A workpiece placed in a machine: the frames that convert path points and loads to poses and wrenches of the platform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedWorkpiece {
    /// `X_OW`.
    workpiece: Pose,
    /// `R_OP` with the machine at home.
    home: Matrix3<f64>,
    /// `R_OP`.
    orientation: Matrix3<f64>,
    /// `p_PR` in platform axes, mm, of the path's reference point R.
    reference: Vector3<f64>,
    /// `X_PT`, the tool frame in platform axes.
    tool: Pose,
    /// See [`PlacedWorkpiece::tool_axes`].
    tool_axes: Matrix3<f64>,
}

impl PlacedWorkpiece {
    /// Returns the pose `X_OP` to command for the path position `position_mm` (W, mm): `p_OP = X_OW · p_W − R_OP p_PR`, where
    /// R is the path's reference point.
    #[must_use]
    pub fn platform_pose(&self, position_mm: Vector3<f64>) -> Pose {
        let arm = self.orientation * self.reference;
        Pose { rotation: self.orientation, translation: self.workpiece.transform(position_mm) - arm }
    }

    /// Returns the placement with the workpiece on a carrier at the pose `carrier` (`X_OC`): moving the carrier moves and turns
    /// the workpiece under the tool.
    #[must_use]
    pub fn on_carrier(&self, carrier: &Pose) -> Self {
        let workpiece = carrier.compose(&self.workpiece);
        let axis = workpiece.rotation.tr_mul(&(self.orientation * self.tool.rotation.column(2)));
        Self { workpiece, tool_axes: frame_about(axis.normalize()), ..*self }
    }

    /// Returns the pose of the workpiece frame, `X_OW`, mm.
    #[must_use]
    pub fn workpiece(&self) -> &Pose {
        &self.workpiece
    }

    /// Returns the placement with the platform orientation `rotation` (`R_OP`) in place of its own.
    #[must_use]
    pub fn with_platform_rotation(&self, rotation: &Matrix3<f64>) -> Self {
        if *rotation == self.orientation {
            return *self;
        }
        let axis = self.workpiece.rotation.tr_mul(&(rotation * self.tool.rotation.column(2)));
        Self { orientation: *rotation, tool_axes: frame_about(axis.normalize()), ..*self }
    }

    /// Returns the placement in which a tool axis alone rotates the platform least from `rotation` (`R_OP`), not from its orientation at home.
    #[must_use]
    pub fn turned_from(&self, rotation: &Matrix3<f64>) -> Self {
        Self { home: *rotation, ..*self }
    }

    /// Returns the placement with the tool orientation that the path gives (W axes). For a tool axis alone, the platform is rotated
    /// least from its orientation at home.
    #[must_use]
    pub fn with_tool_orientation(&self, orientation: &Orientation) -> Self {
        let workpiece = &self.workpiece.rotation;
        let rotation = match orientation {
            Orientation::Platform(platform) => workpiece * platform.to_rotation_matrix().matrix(),
            Orientation::ToolAxis(axis) => {
                // The axes of the tool point from the spindle to its tip.
                let home_axis = -(self.home * self.tool.rotation.column(2));
                rotation_exp(least_turn(home_axis.normalize(), (workpiece * axis).normalize())) * self.home
            }
        };
        self.with_platform_rotation(&rotation)
    }

    /// Returns the tool orientation in W for the platform orientation `rotation` (`R_OP`), as a tool axis or platform orientation
    /// as `like` is: the inverse of [`PlacedWorkpiece::with_tool_orientation`].
    #[must_use]
    pub fn tool_orientation_at(&self, rotation: &Matrix3<f64>, like: &Orientation) -> Orientation {
        let in_workpiece = self.workpiece.rotation.tr_mul(rotation);
        match like {
            Orientation::Platform(original) => {
                let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(in_workpiece));
                // Of the two quaternions of a rotation, that which is written alike.
                Orientation::Platform(if q.coords.dot(&original.coords) < 0.0 {
                    UnitQuaternion::new_unchecked(-q.into_inner())
                } else {
                    q
                })
            }
            Orientation::ToolAxis(_) => {
                Orientation::ToolAxis(-(in_workpiece * self.tool.rotation.column(2)).normalize())
            }
        }
    }

    /// Returns the platform orientation `R_OP`.
    #[must_use]
    pub fn orientation(&self) -> &Matrix3<f64> {
        &self.orientation
    }

    /// Returns the position `p_PR` of the path's reference point in platform axes, mm.
    #[must_use]
    pub fn reference(&self) -> Vector3<f64> {
        self.reference
    }

    /// Returns the tool's axes in W: column z points along the tool from the spindle to its tip, x is the projection of the x axis of W
    /// onto the plane normal to z, y = z × x.
    #[must_use]
    pub fn tool_axes(&self) -> &Matrix3<f64> {
        &self.tool_axes
    }

    /// Returns the wrench at P in O axes for a `load` about the tool tip in W axes, at the commanded orientation: `f = R_OW f_W`,
    /// `m = R_OW m_W + p_PT × f`. Without a moment of the load and with W along O this is eq. (16).
    #[must_use]
    pub fn wrench(&self, load: &Load) -> Wrench {
        let rotation = &self.workpiece.rotation;
        Wrench { force: rotation * load.force_N, moment: rotation * load.moment_Nmm }
            .shift(-(self.orientation * self.tool.translation))
    }

    /// Returns the load about the tool tip in W axes for a `wrench` at P in O axes: the inverse of [`PlacedWorkpiece::wrench`].
    #[must_use]
    pub fn load(&self, wrench: &Wrench) -> Load {
        let Wrench { force, moment } = wrench.shift(self.orientation * self.tool.translation);
        let rotation = &self.workpiece.rotation;
        Load { force_N: rotation.tr_mul(&force), moment_Nmm: rotation.tr_mul(&moment) }
    }
}
