//! Groove milling, eqs. (16) and (17): the cutting force as a function of the tool's angle of engagement φ.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::spatial::{Pose, Wrench};

/// The two readings of eq. (17), which resolves radial and tangential force in the plane normal to the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceLaw {
    /// Eq. (17) as the paper prints it: `F_x = F_r cos φ + F_t sin φ`, `F_y = F_r sin φ + F_t cos φ`.
    /// Not a rotation: with 215 N and −10 N
    /// the in-plane force varies between 205 N and 225 N.
    PaperEq17,
    /// A rotation: `F_x = F_r cos φ − F_t sin φ`, `F_y = F_r sin φ + F_t cos φ`. Used where no law is named.
    #[default]
    Rotated,
}

impl ForceLaw {
    /// Both.
    pub const ALL: [ForceLaw; 2] = [ForceLaw::PaperEq17, ForceLaw::Rotated];

    /// Returns the law's name in files and on the command line.
    pub fn label(self) -> &'static str {
        match self {
            ForceLaw::PaperEq17 => "paper_eq17",
            ForceLaw::Rotated => "rotated",
        }
    }
}

/// Cutting force of groove milling on the tool, in the tool frame T: z along the tool from the spindle to its tip
/// ([`Machine::tool_axes`](crate::machine::Model::tool_axes)), φ from x towards y.
///
/// ```text
/// F = F_x x_T + F_y y_T + F_z z_T          F_x, F_y: eq. (17)
/// F_r > 0   pushes the tool along the direction φ
/// F_t > 0   pushes it along φ + 90° (rotated law): with growing φ, counter-clockwise seen from the workpiece
/// F_z < 0   pushes it back into the spindle
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MillingForce {
    /// Radial force F_r, N.
    pub radial: f64,
    /// Tangential force F_t, N.
    pub tangential: f64,
    /// Force along the tool axis F_z, N: positive away from the spindle.
    pub axial: f64,
    /// How the forces are turned by φ.
    pub law: ForceLaw,
}

impl MillingForce {
    /// The paper's groove: F_r = 215 N, F_t = −10 N, F_z = −25 N, eq. (17) as printed.
    pub const KLIMCHIK_GROOVE: Self = Self { radial: 215.0, tangential: -10.0, axial: -25.0, law: ForceLaw::PaperEq17 };

    /// Whether all force components are zero.
    pub fn is_zero(&self) -> bool {
        [self.radial, self.tangential, self.axial] == [0.0; 3]
    }

    /// Returns the size of the force, N, the same at each angle of engagement.
    pub fn size(&self) -> f64 {
        Vector3::new(self.radial, self.tangential, self.axial).norm()
    }

    /// Returns the force on the tool tip at the angle of engagement `phi` (rad), axes of the tool frame T, N; eq. (17).
    pub fn force(&self, phi: f64) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(phi);
        let sign = match self.law {
            ForceLaw::PaperEq17 => 1.0,
            ForceLaw::Rotated => -1.0,
        };
        Vector3::new(
            self.radial * cos + sign * self.tangential * sin,
            self.radial * sin + self.tangential * cos,
            self.axial,
        )
    }

    /// Returns the wrench at P in O axes (N, N·mm) of the force on a tool whose frame, seen from P in O axes, is `tool`
    /// ([`Machine::tool_at`](crate::machine::Machine::tool_at)), eq. (16): a dead load.
    pub fn wrench(&self, phi: f64, tool: &Pose) -> Wrench {
        let force = tool.rotation * self.force(phi);
        Wrench { force, moment: tool.translation.cross(&force) }
    }
}
