//! A machine file as written: raw, units in the keys, unknown keys refused. Checked by the `resolve` module.

use std::collections::BTreeMap;

use kinetostat_cell::spec::BodySpec;
use kinetostat_input::tables;
use serde::Deserialize;

use super::{accuracy::AccuracyFrame, provenance::Grade, unknown::StiffnessSpec};

tables! {
    /// The whole file.
    pub struct MachineSpec {
        /// Version of the file format; 1.
        #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 1)))]
        pub schema: u32,
        /// Short name, as used in commands and tables.
        pub name: String,
        /// One line: what machine it is.
        pub title: String,
        /// Where the numbers come from; nothing if not given.
        #[serde(default)]
        pub source: String,
        /// What is known of each group of numbers; nothing if not given.
        #[serde(default)]
        pub provenance: Vec<ProvenanceSpec>,
        /// The platform and what it is used for.
        pub platform: PlatformSpec,
        /// Acceleration of gravity in O; (0, 0, −9.81) if not given.
        #[serde(rename = "gravity_m_per_s2")]
        pub gravity: Option<[f64; 3]>,
        /// Where the machine was when its drives were set to zero error; "at_rest" if not given.
        #[serde(default)]
        pub zeroed: ZeroedSpec,
        /// The configuration in which the machine is assembled; P in O, unturned, if not given.
        #[serde(default)]
        pub home: HomeSpec,
        /// The nominal workspace box of P, in O: what is asked about where nothing else is said.
        pub workspace: BoxSpec,
        /// Named locations of P, for `--at` and studies; none if not given.
        #[serde(default)]
        pub point: Vec<PointSpec>,
        /// Materials by name; none if not given.
        #[serde(default)]
        pub material: BTreeMap<String, MaterialSpec>,
        /// Chain designs.
        pub chain: Vec<ChainSpec>,
        /// Where chains are mounted; each mount is one chain of the machine.
        pub mount: Vec<MountSpec>,
        /// How accurate the machine is without load; not known if not given.
        pub accuracy: Option<AccuracySpec>,
        /// What carries the workpiece (turntable, slide) and bends as well; the workpiece stands fast in O if not given.
        pub workpiece_carrier: Option<CarrierSpec>,
        /// Bodies that stand fast in O, such as its pedestal; none if not given.
        #[serde(default)]
        pub body: Vec<BodySpec>,
        /// Pairs of bodies, by name, that may touch or overlap, besides those with one joint between them; none if not given.
        #[serde(default)]
        pub may_touch: Vec<[String; 2]>,
    }

    /// How accurate the machine is without load, as ISO 9283 names it: each number is stated by itself, as none follows from another.
    pub struct AccuracySpec {
        /// Pose accuracy AP: distance of the mean attained pose from the commanded one; not known if not given.
        pub pose: Option<StatedSpec>,
        /// Pose repeatability RP: mean distance of attained poses from their mean, and three standard deviations of it; not known if not given.
        pub repeatability: Option<StatedSpec>,
        /// Path accuracy AT: distance of the mean attained path from the commanded one, at a speed; of both the larger counts; not known if not given.
        pub path: Option<StatedSpec>,
    }

    /// A distance that is stated of a machine.
    pub struct StatedSpec {
        /// The distance.
        pub mm: f64,
        /// How far it may be trusted.
        pub grade: Grade,
        /// Who says so.
        pub source: String,
        /// Speed at which it holds; not said if not given.
        pub speed_mm_per_s: Option<f64>,
        /// Payload with which it holds; not said if not given.
        pub payload_kg: Option<f64>,
        /// Where it is measured from: "base", or a frame taught at the "part"; the base if not given.
        #[serde(default)]
        pub frame: AccuracyFrame,
        /// How many standard deviations along an axis the distance is; 3.62 of a repeatability and 2.80 (95 % of distances) of an accuracy if not given.
        pub coverage_factor: Option<f64>,
    }

    /// Where some of the numbers come from.
    pub struct ProvenanceSpec {
        /// Which numbers.
        pub what: String,
        /// How far they may be trusted.
        pub grade: Grade,
        /// Who says so.
        pub source: String,
        /// Names of parameters that it is about, or the part of several names before a dot (`leg.foot` for all of the foot); none if not given.
        #[serde(default)]
        pub parameters: Vec<String>,
        /// 95 % interval of the number, of which `parameters` then has the full name and nothing else, in its unit; not known if not given.
        pub interval: Option<[f64; 2]>,
    }

    /// The moving platform.
    pub struct PlatformSpec {
        /// Tool tip, from P in platform axes.
        pub tool_tip_mm: [f64; 3],
        /// Direction from the spindle to the tool tip in platform axes, of any length; from P to the tool tip if not given.
        pub tool_axis: Option<[f64; 3]>,
        /// What bends between P and the tool tip (spindle, holder, cutter); rigid if not given.
        pub tool: Option<ToolSpec>,
        /// What moves with P (spindle, holder, tool), its centre in platform axes; without weight if not given.
        pub mass: Option<MassSpec>,
        /// Task coordinates the drives control.
        pub controls: Vec<CoordinateSpec>,
        /// Bodies that move with P, such as the spindle; none if not given.
        #[serde(default)]
        pub body: Vec<BodySpec>,
    }

    /// What lies between P and the tool tip; its parts bend one after the other.
    pub struct ToolSpec {
        /// 6×6 compliance at the tool tip in axes of the tool frame T (z along the tool), translations before rotations; rigid but for the cutter if not given.
        #[serde(rename = "compliance_mm_rad_N")]
        pub compliance: Option<Box<[[f64; 6]; 6]>>,
        /// Cutter as a round cantilever that ends at the tool tip; rigid if not given.
        pub cutter: Option<CutterSpec>,
    }

    /// Another tool than that of the machine file, in a process.
    pub struct OtherToolSpec {
        /// Its tip, from P in platform axes, or in O if it is stationary; where the machine file has it if not given.
        pub tip_mm: Option<[f64; 3]>,
        /// Direction from the spindle to its tip in platform axes, or in O if it is stationary; that of the machine file if not given.
        pub axis: Option<[f64; 3]>,
        /// Whether the tool is stationary (an external TCP) and the machine holds the part, whose frame W is then in its platform; no if not given.
        #[serde(default)]
        pub stationary: bool,
        /// Whether masses and springs of a machine that holds the part are left out; no if not given.
        #[serde(default)]
        pub without_weight: bool,
        /// As in `[platform.tool]`.
        #[serde(rename = "compliance_mm_rad_N")]
        pub compliance: Option<Box<[[f64; 6]; 6]>>,
        /// As in `[platform.tool]`.
        pub cutter: Option<CutterSpec>,
        /// Materials of the cutter besides those of the machine file.
        #[serde(default)]
        pub material: BTreeMap<String, MaterialSpec>,
    }

    /// A cutter: a round cantilever along the tool axis.
    pub struct CutterSpec {
        /// Diameter that bends as the cutter does: of its core, less than that of its edges.
        pub diameter_mm: f64,
        /// Length from the holder to the tool tip.
        pub stick_out_mm: f64,
        /// Name of a material.
        pub material: String,
    }
}

/// From where deflections are measured.
#[derive(Debug, Clone, Copy, Default, Deserialize, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ZeroedSpec {
    /// From where the machine stands under its weight and springs.
    #[default]
    AtRest,
    /// From where the rigid model stands, without weight and springs.
    Weightless,
    /// From where the rigid model stands, drives offset so that the tool is there at home.
    AtHome,
}

tables! {
    /// A mass: kg, and its centre in platform axes.
    #[derive(Default)]
    pub struct MassSpec {
        /// How heavy, 0 or more.
        pub kg: f64,
        /// Its centre in platform axes; P if not given.
        #[serde(default)]
        pub at_mm: [f64; 3],
    }

    /// A mass that moves with a frame of a chain: kg, and its centre in that frame.
    pub struct NamedMassSpec {
        /// Name among parameters; `mass_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// How heavy.
        pub kg: f64,
        /// Its centre in the frame reached; the origin if not given.
        #[serde(default)]
        pub at_mm: [f64; 3],
    }
}

/// A task coordinate: a translation of P in O axes or a rotation about the platform's own axes.
#[derive(Debug, Clone, Copy, Deserialize, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CoordinateSpec {
    /// Of P along x of O.
    X,
    /// Of P along y of O.
    Y,
    /// Of P along z of O.
    Z,
    /// About the platform's x axis.
    RotationX,
    /// About the platform's y axis.
    RotationY,
    /// About the platform's z axis.
    RotationZ,
}

tables! {
    /// Pose of P in O at home.
    #[derive(Default)]
    pub struct HomeSpec {
        /// Position of P in O; 0 if not given.
        #[serde(default)]
        pub position_mm: [f64; 3],
        /// Roll, pitch, yaw of the platform about the fixed x, y, z axes of O; 0 if not given.
        #[serde(default)]
        pub rotation_deg: [f64; 3],
    }

    /// An axis-aligned box.
    pub struct BoxSpec {
        /// Lower corner, in O.
        pub min_mm: [f64; 3],
        /// Upper corner, in O.
        pub max_mm: [f64; 3],
    }

    /// A named location.
    pub struct PointSpec {
        /// Name, such as Q0.
        pub name: String,
        /// Position of P in O.
        pub position_mm: [f64; 3],
    }

    /// Elastic constants.
    pub struct MaterialSpec {
        /// Young's modulus E.
        #[serde(rename = "youngs_modulus_N_per_mm2")]
        pub youngs_modulus: f64,
        /// Shear modulus G.
        #[serde(rename = "shear_modulus_N_per_mm2")]
        pub shear_modulus: f64,
    }

    /// A chain design, mounted once or several times.
    pub struct ChainSpec {
        /// Name used by `mount.chain`.
        pub name: String,
        /// Elements in order from base to platform.
        pub elements: Vec<ElementSpec>,
    }
}

/// One element of a chain: a table with exactly one of these keys.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ElementSpec {
    /// A rigid transform.
    Fixed(FixedSpec),
    /// An actuated prismatic joint.
    PrismaticDrive(PrismaticDriveSpec),
    /// An actuated revolute joint.
    RevoluteDrive(RevoluteDriveSpec),
    /// A passive prismatic joint.
    PrismaticJoint(PrismaticJointSpec),
    /// A passive revolute joint.
    RevoluteJoint(RevoluteJointSpec),
    /// An elastic link given as a beam.
    Beam(BeamSpec),
    /// An elastic link given by its 6×6 stiffness or compliance.
    Link(LinkSpec),
    /// Two parallel bars joined by revolute joints.
    Parallelogram(ParallelogramSpec),
    /// Two crossed passive revolute joints.
    UniversalJoint(UniversalJointSpec),
    /// Three crossed passive revolute joints, about x, y, z.
    SphericalJoint(SphericalJointSpec),
    /// A mass that moves with the frame reached.
    Mass(NamedMassSpec),
    /// A body that moves with the frame reached.
    Body(BodySpec),
    /// A name for the frame reached, for springs.
    Frame(String),
    /// A spring between points of two named frames.
    Spring(PointSpringSpec),
    /// Several chains between the frame reached and an inner frame, after which the chain goes on.
    Module(ModuleSpec),
}

impl ElementSpec {
    /// The word for the kind of the element, and the name that the file gives it.
    pub(super) fn kind_and_name(&self) -> (&'static str, Option<&str>) {
        match self {
            ElementSpec::Fixed(fixed) => ("fixed", fixed.name.as_deref()),
            ElementSpec::PrismaticDrive(drive) => ("prismatic_drive", Some(&drive.name)),
            ElementSpec::RevoluteDrive(drive) => ("revolute_drive", Some(&drive.name)),
            ElementSpec::PrismaticJoint(joint) => ("prismatic_joint", Some(&joint.name)),
            ElementSpec::RevoluteJoint(joint) => ("revolute_joint", Some(&joint.name)),
            ElementSpec::Beam(beam) => ("beam", beam.name.as_deref()),
            ElementSpec::Link(link) => ("link", link.name.as_deref()),
            ElementSpec::Parallelogram(parallelogram) => ("parallelogram", Some(&parallelogram.name)),
            ElementSpec::UniversalJoint(joint) => ("universal_joint", Some(&joint.name)),
            ElementSpec::SphericalJoint(joint) => ("spherical_joint", Some(&joint.name)),
            ElementSpec::Mass(mass) => ("mass", mass.name.as_deref()),
            ElementSpec::Body(body) => ("body", Some(&body.name)),
            ElementSpec::Frame(name) => ("frame", Some(name)),
            ElementSpec::Spring(spring) => ("spring", spring.name.as_deref()),
            ElementSpec::Module(module) => ("module", module.name.as_deref()),
        }
    }

    /// Name of each element: its own, or its kind and which of this kind it is, from 1.
    pub(super) fn names(elements: &[Self]) -> Vec<String> {
        let name_of = |(i, element): (usize, &Self)| {
            let (kind, name) = element.kind_and_name();
            name.map_or_else(|| Self::default_name(kind, &elements[..i]), String::from)
        };
        elements.iter().enumerate().map(name_of).collect()
    }

    /// Default name of an element behind the elements `before`: its kind, and its number among those of this kind.
    fn default_name(kind: &str, before: &[Self]) -> String {
        format!("{kind}_{}", 1 + before.iter().filter(|element| element.kind_and_name().0 == kind).count())
    }
}

tables! {
    /// Two crossed passive revolute joints.
    pub struct UniversalJointSpec {
        /// Name; its revolute joints are called after it and their axes, such as `u_x`.
        pub name: String,
        /// Local axes of the two revolute joints, in order; two different ones.
        pub axes: [AxisSpec; 2],
        /// Where each revolute joint stands at home, or from where home is sought; 0 if not given.
        #[serde(default)]
        pub home_deg: [f64; 2],
        /// Smallest and largest angle of each revolute joint; none if not given.
        pub limits_deg: Option<[[f64; 2]; 2]>,
    }

    /// Three crossed passive revolute joints, about x, y, z.
    pub struct SphericalJointSpec {
        /// Name; its revolute joints are called after it and their axes, such as `s_z`.
        pub name: String,
        /// Where the revolute joints about x, y, z stand at home, or from where home is sought; 0 if not given.
        #[serde(default)]
        pub home_deg: [f64; 3],
        /// Smallest and largest angle of the revolute joints about x, y, z; none if not given.
        pub limits_deg: Option<[[f64; 2]; 3]>,
    }

    /// A spring between two points; its force is `preload + stiffness · (length − free length)`.
    pub struct PointSpringSpec {
        /// Name in tables and among parameters; `spring_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// One end.
        pub from: AnchorSpec,
        /// The other end, on another frame.
        pub to: AnchorSpec,
        /// Stiffness along the line between its ends.
        #[serde(rename = "stiffness_N_per_mm")]
        pub stiffness: f64,
        /// Length at which the force is the preload; 0 or more.
        pub free_length_mm: f64,
        /// Tension at the free length; 0 if not given.
        #[serde(default, rename = "preload_N")]
        pub preload: f64,
    }

    /// A point of a named frame of the chain, or of the machine's base, `O`.
    pub struct AnchorSpec {
        /// Name of a frame of the same chain, or `O` for the machine's base (not within a module).
        pub frame: String,
        /// The point in this frame; its origin if not given.
        #[serde(default)]
        pub at_mm: [f64; 3],
    }

    /// A parallel module: chains from the frame reached to an inner frame.
    pub struct ModuleSpec {
        /// Name among parameters; `module_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// Its chains: `base` is the pose of the first frame in the frame reached, `platform` that of the last in the inner frame.
        pub mounts: Vec<MountSpec>,
    }

    /// Shown coordinate of a drive, as a pendant has it: the sum of joints times factors, and an offset.
    pub struct ShownSpec {
        /// Factor of each joint, by the name of its drive.
        pub of: BTreeMap<String, f64>,
        /// What it shows where these joints are at zero, of a revolute joint; 0 if not given.
        pub offset_deg: Option<f64>,
        /// What it shows where these joints are at zero, of a prismatic joint; 0 if not given.
        pub offset_mm: Option<f64>,
    }

    /// A rigid transform: the translation, then the rotation.
    pub struct FixedSpec {
        /// Name among parameters; `fixed_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// Translation in the axes before it; 0 if not given.
        #[serde(default)]
        pub translation_mm: [f64; 3],
        /// Roll, pitch, yaw about the fixed x, y, z axes before it; 0 if not given.
        #[serde(default)]
        pub rotation_deg: [f64; 3],
    }
}

/// A local axis.
#[derive(Debug, Clone, Copy, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum AxisSpec {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

tables! {
    /// An actuated prismatic joint.
    pub struct PrismaticDriveSpec {
        /// Name, which no other joint or drive of the chain has.
        pub name: String,
        /// Local axis along which it moves.
        pub axis: AxisSpec,
        /// Stiffness about the commanded position: a number, or "unknown", with which only geometry can be asked for.
        #[serde(rename = "stiffness_N_per_mm")]
        pub stiffness: StiffnessSpec,
        /// Stiffness of what follows, such as a screw: in series with `stiffness`; rigid if not given.
        #[serde(rename = "shaft_stiffness_N_per_mm")]
        pub shaft_stiffness: Option<f64>,
        /// Position from which home is sought, as shown; 0 if not given.
        #[serde(default)]
        pub home_mm: f64,
        /// Smallest and largest position, as shown; none if not given.
        pub travel_mm: Option<[f64; 2]>,
        /// Largest force either way; none if not given.
        #[serde(rename = "force_limit_N")]
        pub force_limit: Option<f64>,
        /// Its whole backlash, as a dial gauge reads it when the drive is pushed to and fro; 0 if not given.
        pub backlash_mm: Option<f64>,
        /// Largest force that static friction holds, either way; 0 if not given.
        #[serde(rename = "friction_N")]
        pub friction: Option<f64>,
        /// How the position that a pendant shows follows from the joints; the joint itself if not given.
        pub shown: Option<ShownSpec>,
    }

    /// An actuated revolute joint.
    pub struct RevoluteDriveSpec {
        /// Name, which no other joint or drive of the chain has.
        pub name: String,
        /// Local axis about which it turns.
        pub axis: AxisSpec,
        /// Stiffness about the commanded angle: a number, or "unknown", with which only geometry can be asked for.
        #[serde(rename = "stiffness_Nmm_per_rad")]
        pub stiffness: StiffnessSpec,
        /// Stiffness of what follows the gear, such as a shaft: in series with `stiffness`; rigid if not given.
        #[serde(rename = "shaft_stiffness_Nmm_per_rad")]
        pub shaft_stiffness: Option<f64>,
        /// Angle from which home is sought, as shown; 0 if not given.
        #[serde(default)]
        pub home_deg: f64,
        /// Smallest and largest angle, as shown; none if not given.
        pub travel_deg: Option<[f64; 2]>,
        /// Largest torque either way; none if not given.
        #[serde(rename = "torque_limit_Nmm")]
        pub torque_limit: Option<f64>,
        /// Its whole backlash, as it turns when it is pushed to and fro; 0 if not given.
        pub backlash_deg: Option<f64>,
        /// Largest torque that static friction holds, either way; 0 if not given.
        #[serde(rename = "friction_Nmm")]
        pub friction: Option<f64>,
        /// How the angle that a pendant shows follows from the joints; the joint itself if not given.
        pub shown: Option<ShownSpec>,
    }

    /// A passive prismatic joint; without a stiffness it is free.
    pub struct PrismaticJointSpec {
        /// Name, which no other joint or drive of the chain has.
        pub name: String,
        /// Local axis along which it moves.
        pub axis: AxisSpec,
        /// Position from which home is sought; 0 if not given.
        #[serde(default)]
        pub home_mm: f64,
        /// Smallest and largest position; none if not given.
        pub limits_mm: Option<[f64; 2]>,
        /// Stiffness of a spring in it; free if not given.
        #[serde(rename = "stiffness_N_per_mm")]
        pub stiffness: Option<f64>,
        /// Position in which this spring has no force; 0 if not given.
        #[serde(default)]
        pub neutral_mm: f64,
    }

    /// A passive revolute joint; without a stiffness it is free.
    pub struct RevoluteJointSpec {
        /// Name, which no other joint or drive of the chain has.
        pub name: String,
        /// Local axis about which it turns.
        pub axis: AxisSpec,
        /// Angle from which home is sought; 0 if not given.
        #[serde(default)]
        pub home_deg: f64,
        /// Smallest and largest angle; none if not given.
        pub limits_deg: Option<[f64; 2]>,
        /// Stiffness of a spring in it; free if not given.
        #[serde(rename = "stiffness_Nmm_per_rad")]
        pub stiffness: Option<f64>,
        /// Angle in which this spring has no moment; 0 if not given.
        #[serde(default)]
        pub neutral_deg: f64,
    }

    /// A uniform beam along local x; its end carries a 6-dof spring.
    pub struct BeamSpec {
        /// Name among parameters and in tables; `beam_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// Elastic length, along local x.
        pub length_mm: f64,
        /// How far the frame moves along local x before the spring; the elastic length if not given.
        pub advance_mm: Option<f64>,
        /// Cross-section.
        pub section: SectionSpec,
        /// Name of a material.
        pub material: String,
    }

    /// A link whose stiffness comes from FEA or measurement; exactly one of the two matrices.
    pub struct LinkSpec {
        /// Name among parameters and in tables; `link_1` for the first of a chain if not given.
        pub name: Option<String>,
        /// How far the frame moves along local x before the spring.
        pub advance_mm: f64,
        /// 6×6 stiffness of the link's end in link axes, translations before rotations; the inverse of the compliance if not given.
        #[serde(rename = "stiffness_N_mm_rad")]
        pub stiffness: Option<Box<[[f64; 6]; 6]>>,
        /// 6×6 compliance of the link's end in link axes, translations before rotations; the inverse of the stiffness if not given.
        #[serde(rename = "compliance_mm_rad_N")]
        pub compliance: Option<Box<[[f64; 6]; 6]>>,
    }

    /// A parallelogram in its local x–y plane; x along the bars at q = 0, y along the short link.
    pub struct ParallelogramSpec {
        /// Name, which no other joint or drive of the chain has.
        pub name: String,
        /// Length of its bars.
        pub length_mm: f64,
        /// Distance between its bars.
        pub width_mm: f64,
        /// Cross-section of a bar.
        pub bar_section: SectionSpec,
        /// Name of the bars' material.
        pub material: String,
        /// Angle from which home is sought; 0 if not given.
        #[serde(default)]
        pub home_deg: f64,
        /// Smallest and largest angle; none if not given.
        pub limits_deg: Option<[f64; 2]>,
    }
}

/// A cross-section: a table with exactly one of these keys.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

tables! {
    /// Flanges along local y, height over both of them along local z.
    pub struct IBeamSpec {
        /// Width of the flanges, along local y.
        pub width_mm: f64,
        /// Height over both flanges, along local z.
        pub height_mm: f64,
        /// Thickness of a flange, less than half the height.
        pub flange_mm: f64,
        /// Thickness of the web, not more than the width.
        pub web_mm: f64,
    }

    /// Outer width along local y, outer height along local z.
    pub struct BoxSectionSpec {
        /// Outer width, along local y.
        pub width_mm: f64,
        /// Outer height, along local z.
        pub height_mm: f64,
        /// Thickness of the wall, less than half the smaller side.
        pub wall_mm: f64,
    }

    /// Outer diameters at the clamped and at the free end.
    pub struct TaperedTubeSpec {
        /// Outer diameter at the clamped end.
        pub start_diameter_mm: f64,
        /// Outer diameter at the free end.
        pub end_diameter_mm: f64,
        /// Thickness of the wall, less than half the smaller diameter.
        pub wall_mm: f64,
    }

    /// Width along local y, height along local z.
    pub struct RectangleSpec {
        /// Along local y.
        pub width_mm: f64,
        /// Along local z.
        pub height_mm: f64,
    }

    /// Solid circle.
    pub struct RoundSpec {
        /// Diameter.
        pub diameter_mm: f64,
    }

    /// Circular tube.
    pub struct TubeSpec {
        /// Outer diameter.
        pub outer_diameter_mm: f64,
        /// Inner diameter, smaller than the outer one.
        pub inner_diameter_mm: f64,
    }

    /// One chain of the machine: a design, where it starts and where it holds the platform.
    pub struct MountSpec {
        /// Name of this chain in tables.
        pub name: String,
        /// Name of the design.
        pub chain: String,
        /// Pose of the chain's first frame in O (in a module: in the frame reached); in place if not given.
        #[serde(default)]
        pub base: FrameSpec,
        /// Pose of the chain's last frame in P (in a module: in the inner frame); in place if not given.
        #[serde(default)]
        pub platform: FrameSpec,
    }

    /// The chain from O to the frame on which the workpiece lies: a design without passive joints and modules.
    pub struct CarrierSpec {
        /// Name of this chain in tables.
        pub name: String,
        /// Name of the design.
        pub chain: String,
        /// Pose of the chain's first frame in O; in place if not given.
        #[serde(default)]
        pub base: FrameSpec,
    }

    /// A frame: position, and either two axes or roll, pitch, yaw.
    #[derive(Default)]
    pub struct FrameSpec {
        /// Origin; 0 if not given.
        #[serde(default)]
        pub position_mm: [f64; 3],
        /// Direction of the frame's x axis, of any length, with `y_axis`; as `rotation_deg` has it if not given.
        pub x_axis: Option<[f64; 3]>,
        /// Direction of the frame's y axis, of any length and perpendicular to x, with `x_axis`; as `rotation_deg` has it if not given.
        pub y_axis: Option<[f64; 3]>,
        /// Roll, pitch, yaw about the fixed x, y, z axes, instead of two axes; 0 if not given.
        pub rotation_deg: Option<[f64; 3]>,
    }
}
