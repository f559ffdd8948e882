//! A machine file as written: raw, units in the keys, unknown keys refused. Checked by the `resolve` module.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{provenance::Grade, unknown::StiffnessSpec};

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineSpec {
    /// Version of the file format; 1.
    pub schema: u32,
    /// Short name, as used in commands and tables.
    pub name: String,
    /// One line: what machine it is.
    pub title: String,
    /// Where the numbers come from.
    #[serde(default)]
    pub source: String,
    /// What is known of each group of numbers.
    #[serde(default)]
    pub provenance: Vec<ProvenanceSpec>,
    /// The platform and what it is used for.
    pub platform: PlatformSpec,
    /// Acceleration of gravity in O; (0, 0, −9.81) if not given.
    #[serde(rename = "gravity_m_per_s2")]
    pub gravity: Option<[f64; 3]>,
    /// Where the machine was when its drives were set to zero error.
    #[serde(default)]
    pub zeroed: ZeroedSpec,
    /// The configuration in which the machine is assembled.
    #[serde(default)]
    pub home: HomeSpec,
    /// The nominal workspace box of P.
    pub workspace: BoxSpec,
    /// Named locations of P.
    #[serde(default)]
    pub point: Vec<PointSpec>,
    /// Materials by name.
    #[serde(default)]
    pub material: BTreeMap<String, MaterialSpec>,
    /// Chain designs.
    pub chain: Vec<ChainSpec>,
    /// Where chains are mounted; each mount is one chain of the machine.
    pub mount: Vec<MountSpec>,
}

/// Where some of the numbers come from.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProvenanceSpec {
    /// Which numbers.
    pub what: String,
    /// How far they may be trusted.
    pub grade: Grade,
    /// Who says so.
    pub source: String,
}

/// The moving platform.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlatformSpec {
    /// `p_PT` in platform axes.
    pub tool_tip_mm: [f64; 3],
    /// Direction from the spindle to the tool tip in platform axes, of any length; from P to the tool tip if not given.
    pub tool_axis: Option<[f64; 3]>,
    /// What bends between P and the tool tip: spindle, holder, cutter; rigid if not given.
    pub tool: Option<ToolSpec>,
    /// What moves with P: spindle, holder, tool; its centre in platform axes.
    pub mass: Option<MassSpec>,
    /// Task coordinates the drives control.
    pub controls: Vec<CoordinateSpec>,
}

/// What lies between P and the tool tip; its parts bend one after the other.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolSpec {
    /// 6×6 compliance at the tool tip in axes of the tool frame T (z along the tool), translations before rotations.
    #[serde(rename = "compliance_mm_rad_N")]
    pub compliance: Option<Box<[[f64; 6]; 6]>>,
    /// Cutter as a round cantilever that ends at the tool tip.
    pub cutter: Option<CutterSpec>,
}

/// A cutter: a round cantilever along the tool axis.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutterSpec {
    /// Diameter that bends as the cutter does: of its core, less than that of its edges.
    pub diameter_mm: f64,
    /// Length from the holder to the tool tip.
    pub stick_out_mm: f64,
    /// Name of a material.
    pub material: String,
}

/// From where deflections are measured.
#[derive(Debug, Clone, Copy, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ZeroedSpec {
    /// From where the machine stands under its weight.
    #[default]
    AtRest,
    /// From where it would stand without weight.
    Weightless,
    /// From where the rigid model stands, drives offset so that the tool is there at home.
    AtHome,
}

/// A mass: kg, and its centre in the frame reached.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct MassSpec {
    pub kg: f64,
    #[serde(default)]
    pub at_mm: [f64; 3],
}

/// A task coordinate: a translation of P in O axes or a rotation about the platform's own axes.
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum CoordinateSpec {
    X,
    Y,
    Z,
    RotationX,
    RotationY,
    RotationZ,
}

/// Pose of P in O at home.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HomeSpec {
    /// `p_OP`.
    #[serde(default)]
    pub position_mm: [f64; 3],
    /// Roll, pitch, yaw of the platform about the fixed x, y, z axes of O.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
}

/// An axis-aligned box.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Lower corner.
    pub min_mm: [f64; 3],
    /// Upper corner.
    pub max_mm: [f64; 3],
}

/// A named location.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointSpec {
    /// Name, such as Q0.
    pub name: String,
    /// Position of P in O.
    pub position_mm: [f64; 3],
}

/// Elastic constants.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// E.
    #[serde(rename = "youngs_modulus_N_per_mm2")]
    pub youngs_modulus: f64,
    /// G.
    #[serde(rename = "shear_modulus_N_per_mm2")]
    pub shear_modulus: f64,
}

/// A chain design, mounted once or several times.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSpec {
    /// Name used by `mount.chain`.
    pub name: String,
    /// Elements in order from base to platform.
    pub elements: Vec<ElementSpec>,
}

/// One element of a chain: a table with exactly one of these keys.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElementSpec {
    /// A rigid transform.
    Fixed(FixedSpec),
    /// An actuated slide.
    PrismaticDrive(PrismaticDriveSpec),
    /// An actuated hinge.
    RevoluteDrive(RevoluteDriveSpec),
    /// A passive slide.
    PrismaticJoint(PrismaticJointSpec),
    /// A passive hinge.
    RevoluteJoint(RevoluteJointSpec),
    /// An elastic link given as a beam.
    Beam(BeamSpec),
    /// An elastic link given by its 6×6 stiffness or compliance.
    Link(LinkSpec),
    /// Two parallel bars joined by hinges.
    Parallelogram(ParallelogramSpec),
    /// Two crossed passive hinges.
    UniversalJoint(UniversalJointSpec),
    /// Three crossed passive hinges, about x, y, z.
    SphericalJoint(SphericalJointSpec),
    /// A mass that moves with the frame reached.
    Mass(MassSpec),
    /// A name for the frame reached, for springs.
    Frame(String),
    /// A spring between points of two named frames.
    Spring(PointSpringSpec),
    /// Several chains between the frame reached and an inner frame, after which the chain goes on.
    Module(ModuleSpec),
}

/// Two crossed passive hinges.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct UniversalJointSpec {
    pub name: String,
    pub axes: [AxisSpec; 2],
    #[serde(default)]
    pub home_deg: [f64; 2],
    pub limits_deg: Option<[[f64; 2]; 2]>,
}

/// Three crossed passive hinges, about x, y, z.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct SphericalJointSpec {
    pub name: String,
    #[serde(default)]
    pub home_deg: [f64; 3],
    pub limits_deg: Option<[[f64; 2]; 3]>,
}

/// A spring between two points; its force is `preload + stiffness · (length − free length)`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PointSpringSpec {
    pub name: Option<String>,
    pub from: AnchorSpec,
    pub to: AnchorSpec,
    #[serde(rename = "stiffness_N_per_mm")]
    pub stiffness: f64,
    pub free_length_mm: f64,
    #[serde(default, rename = "preload_N")]
    pub preload: f64,
}

/// A point of a named frame of the chain, or of the machine's base, `O`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct AnchorSpec {
    pub frame: String,
    #[serde(default)]
    pub at_mm: [f64; 3],
}

/// A parallel module: chains from the frame reached to an inner frame.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModuleSpec {
    /// Its chains: `base` is the pose of the first frame in the frame reached, `platform` that of the last in the inner frame.
    pub mounts: Vec<MountSpec>,
}

/// Shown coordinate of a drive, as a pendant has it: the sum of joints times factors, and an offset.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShownSpec {
    /// Factor of each joint, by the name of its drive.
    pub of: BTreeMap<String, f64>,
    /// What it shows where these joints are at zero.
    pub offset_deg: Option<f64>,
    /// The same for slides.
    pub offset_mm: Option<f64>,
}

/// A rigid transform: the translation, then the rotation.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedSpec {
    /// Translation in the axes before it.
    #[serde(default)]
    pub translation_mm: [f64; 3],
    /// Roll, pitch, yaw about the fixed x, y, z axes before it.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
}

/// A local axis.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum AxisSpec {
    X,
    Y,
    Z,
}

/// An actuated slide.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PrismaticDriveSpec {
    pub name: String,
    pub axis: AxisSpec,
    #[serde(rename = "stiffness_N_per_mm")]
    pub stiffness: StiffnessSpec,
    /// Of what follows, such as a screw: in series with `stiffness`.
    #[serde(rename = "shaft_stiffness_N_per_mm")]
    pub shaft_stiffness: Option<f64>,
    #[serde(default)]
    pub home_mm: f64,
    pub travel_mm: Option<[f64; 2]>,
    #[serde(rename = "force_limit_N")]
    pub force_limit: Option<f64>,
    /// The slide may stand this far to either side.
    pub backlash_mm: Option<f64>,
    /// Largest force that static friction holds, either way.
    #[serde(rename = "friction_N")]
    pub friction: Option<f64>,
    pub shown: Option<ShownSpec>,
}

/// An actuated hinge.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct RevoluteDriveSpec {
    pub name: String,
    pub axis: AxisSpec,
    #[serde(rename = "stiffness_Nmm_per_rad")]
    pub stiffness: StiffnessSpec,
    /// Of what follows the gear, such as a shaft: in series with `stiffness`.
    #[serde(rename = "shaft_stiffness_Nmm_per_rad")]
    pub shaft_stiffness: Option<f64>,
    #[serde(default)]
    pub home_deg: f64,
    pub travel_deg: Option<[f64; 2]>,
    #[serde(rename = "torque_limit_Nmm")]
    pub torque_limit: Option<f64>,
    /// The hinge may stand this far to either side.
    pub backlash_deg: Option<f64>,
    /// Largest torque that static friction holds, either way.
    #[serde(rename = "friction_Nmm")]
    pub friction: Option<f64>,
    pub shown: Option<ShownSpec>,
}

/// A passive slide; without a stiffness it is free.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PrismaticJointSpec {
    pub name: String,
    pub axis: AxisSpec,
    #[serde(default)]
    pub home_mm: f64,
    pub limits_mm: Option<[f64; 2]>,
    #[serde(rename = "stiffness_N_per_mm")]
    pub stiffness: Option<f64>,
    #[serde(default)]
    pub neutral_mm: f64,
}

/// A passive hinge; without a stiffness it is free.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct RevoluteJointSpec {
    pub name: String,
    pub axis: AxisSpec,
    #[serde(default)]
    pub home_deg: f64,
    pub limits_deg: Option<[f64; 2]>,
    #[serde(rename = "stiffness_Nmm_per_rad")]
    pub stiffness: Option<f64>,
    #[serde(default)]
    pub neutral_deg: f64,
}

/// A uniform beam along local x; its end carries a 6-dof spring.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamSpec {
    /// Elastic length.
    pub length_mm: f64,
    /// How far the frame moves along local x before the spring; the elastic length if not given.
    pub advance_mm: Option<f64>,
    /// Cross-section.
    pub section: SectionSpec,
    /// Name of a material.
    pub material: String,
}

/// A link whose stiffness comes from FEA or measurement; exactly one of the two matrices.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkSpec {
    /// How far the frame moves along local x before the spring.
    pub advance_mm: f64,
    /// 6×6 stiffness of the link's end in link axes, translations before rotations.
    #[serde(rename = "stiffness_N_mm_rad")]
    pub stiffness: Option<Box<[[f64; 6]; 6]>>,
    /// 6×6 compliance of the link's end in link axes, translations before rotations.
    #[serde(rename = "compliance_mm_rad_N")]
    pub compliance: Option<Box<[[f64; 6]; 6]>>,
}

/// A parallelogram in its local x–y plane; x along the bars at q = 0, y along the short link.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ParallelogramSpec {
    pub name: String,
    pub length_mm: f64,
    pub width_mm: f64,
    pub bar_section: SectionSpec,
    pub material: String,
    #[serde(default)]
    pub home_deg: f64,
    pub limits_deg: Option<[f64; 2]>,
}

/// A cross-section: a table with exactly one of these keys.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SectionSpec {
    /// Solid rectangle.
    Rectangle(RectangleSpec),
    /// Solid circle.
    Round(RoundSpec),
    /// Circular tube.
    Tube(TubeSpec),
    /// Doubly symmetric I, its web in the local x–z plane.
    IBeam(IBeamSpec),
    /// Rectangular hollow section.
    Box(BoxSectionSpec),
    /// Circular tube whose diameter changes evenly from the clamped end to the free one.
    TaperedTube(TaperedTubeSpec),
}

/// Flanges along local y, height over both of them along local z.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct IBeamSpec {
    pub width_mm: f64,
    pub height_mm: f64,
    pub flange_mm: f64,
    pub web_mm: f64,
}

/// Outer width along local y, outer height along local z.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct BoxSectionSpec {
    pub width_mm: f64,
    pub height_mm: f64,
    pub wall_mm: f64,
}

/// Outer diameters at the clamped and at the free end.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct TaperedTubeSpec {
    pub start_diameter_mm: f64,
    pub end_diameter_mm: f64,
    pub wall_mm: f64,
}

/// Width along local y, height along local z.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct RectangleSpec {
    pub width_mm: f64,
    pub height_mm: f64,
}

/// Solid circle.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct RoundSpec {
    pub diameter_mm: f64,
}

/// Circular tube.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct TubeSpec {
    pub outer_diameter_mm: f64,
    pub inner_diameter_mm: f64,
}

/// One chain of the machine: a design, where it starts and where it holds the platform.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountSpec {
    /// Name of this chain in tables.
    pub name: String,
    /// Name of the design.
    pub chain: String,
    /// Pose of the chain's first frame in O.
    #[serde(default)]
    pub base: FrameSpec,
    /// Pose of the chain's last frame in P.
    #[serde(default)]
    pub platform: FrameSpec,
}

/// A frame: position, and either two axes or roll, pitch, yaw.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameSpec {
    /// Origin.
    #[serde(default)]
    pub position_mm: [f64; 3],
    /// Direction of the frame's x axis; needs `y_axis`.
    pub x_axis: Option<[f64; 3]>,
    /// Direction of the frame's y axis; needs `x_axis`.
    pub y_axis: Option<[f64; 3]>,
    /// Roll, pitch, yaw about the fixed x, y, z axes.
    pub rotation_deg: Option<[f64; 3]>,
}
