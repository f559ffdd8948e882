//! The machine: chains of joints, elastic links and parallelograms, chain errors, rigid kinematics with its Newton steps. Chains lead from base to
//! platform and have limits. Immutable once built; solves nothing elastic.
//!
//! A machine is read from a TOML file ([`Machine::from_file`]) or taken from the [`catalogue`]. Manufacturing and assembly errors make another
//! machine of it ([`Machine::with_errors`]): commands are computed with the nominal one, what happens is computed with the actual one.

mod accuracy;
mod alternative_branches;
mod bodies;
mod branch;
pub mod catalogue;
mod chain;
mod conditioning;
mod errors;
mod external_axes;
mod kinematics;
mod locked;
mod mobility;
mod motion;
mod other_tool;
mod parameters;
mod provenance;
mod redundancy;
mod resolve;
mod rotary_drives;
mod route;
#[cfg(feature = "schema")]
mod schema;
mod section;
mod skeleton;
mod span;
pub mod spec;
mod stationary_tool;
mod task_space;
mod tracked_point;
mod unknown;

use std::{
    ops::{Deref, DerefMut},
    sync::Arc,
};

use nalgebra::{Matrix3, Matrix6, Vector3};

pub use accuracy::{ACCURACY_FACTOR, Accuracy, AccuracyFrame, RP_FACTOR, Stated};
pub use bodies::{MachineBody, O_FRAME, PLATFORM_FRAME, WORKPIECE_FRAME};
pub use branch::{AskedPosture, Branch, Clearance, Elbow, Posture, PostureChange, Shoulder, Wrist};
pub use chain::{Chain, Coupling, Drive, Motion, MoveScrew, PassiveJoint, Spring, SpringLaw};
pub use errors::ChainError;
pub use external_axes::{ExternalAxes, PositionedMachine};
pub use kinematics::{BatchKinematics, Configuration, Unreachable};
pub(crate) use kinematics::{CommandStep, DriveMotions};
pub use mobility::Mobility;
pub use motion::MachineMotion;
pub use parameters::{Parameter, Unit, Variation, is_pattern_of};
pub use provenance::{Grade, Provenance};
pub use rotary_drives::{RotaryDrive, RotaryDrives};
pub use route::{Anchor, HungBody, Loop, Mass, PointSpring, Route, Step};
#[cfg(feature = "schema")]
pub use schema::file_schema;
pub use section::{Material, Section, beam_stiffness, parallelogram_terms};
pub use spec::OtherToolSpec;
pub use task_space::{OutsideWorkspace, UncontrolledDifference};
pub use unknown::{Geometry, UnknownStiffness};

use crate::{
    input::error::{Error, Result},
    spatial::Pose,
};

/// A task coordinate that the drives can control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// Translation along the axis of O with this index.
    Translation(usize),
    /// Rotation about the axis of the commanded platform frame with this index.
    Rotation(usize),
}

/// What defines the direction of the tool axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolAxisSource {
    /// The machine file.
    Given,
    /// The direction from P to the tool tip.
    TowardsTip,
    /// The platform's z axis: the tool tip is P itself.
    PlatformZ,
}

/// A named location of P, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPoint {
    /// Its name.
    pub name: String,
    /// `p_OP`.
    pub position: Vector3<f64>,
}

/// Mass that moves with the platform: spindle, holder and tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlatformMass {
    /// Mass, kg.
    pub kilograms: f64,
    /// Its centre in platform axes, from P, mm.
    pub at: Vector3<f64>,
}

/// Reference from which deflections of a machine with weight or springs are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZeroState {
    /// The unloaded equilibrium under weight and springs: the machine was calibrated there.
    AtRest,
    /// The rigid model, without weight and springs.
    Weightless,
    /// The rigid model, with drives offset so that the machine stands on it at home under its weight and springs.
    AtHome,
}

impl ZeroState {
    /// The word for it in machine files.
    pub fn label(self) -> &'static str {
        match self {
            ZeroState::AtRest => "at_rest",
            ZeroState::Weightless => "weightless",
            ZeroState::AtHome => "at_home",
        }
    }
}

/// An axis-aligned box of positions of P, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkspaceBox {
    /// Lower corner.
    pub min: Vector3<f64>,
    /// Upper corner.
    pub max: Vector3<f64>,
}

/// A machine, checked and assembled at home: a cheap handle that dereferences to its [`Model`]. Clones share the model; changing one copies it.
#[derive(Debug, Clone)]
pub struct Machine(Arc<Model>);

impl Deref for Machine {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.0
    }
}

impl DerefMut for Machine {
    fn deref_mut(&mut self) -> &mut Model {
        Arc::make_mut(&mut self.0)
    }
}

/// All data of a [`Machine`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Short name.
    pub name: String,
    /// One line: what machine it is.
    pub title: String,
    /// Where its numbers come from.
    pub source: String,
    /// Sources of groups of its numbers, with how far each may be trusted.
    pub provenance: Vec<Provenance>,
    /// How accurate it is without load.
    pub accuracy: Accuracy,
    /// Chains between base and platform.
    pub chains: Vec<Chain>,
    /// Tool tip `p_PT` in platform axes, mm.
    pub tool_tip: Vector3<f64>,
    /// `R_PT`, axes of the tool frame T in platform axes: z along the tool from the spindle to its tip, x the projection of the
    /// platform's x axis onto the plane normal to it (of its y axis for a tool along x), y = z × x. Forces of milling live in it.
    pub tool_axes: Matrix3<f64>,
    /// Where the direction of the tool comes from.
    pub tool_axis_source: ToolAxisSource,
    /// Task coordinates the drives control.
    pub controls: Vec<Coordinate>,
    /// Nominal workspace of P.
    pub workspace: WorkspaceBox,
    /// Acceleration of gravity in O, m/s²: the weight of a kilogram in N.
    pub gravity: Vector3<f64>,
    /// Mass that moves with P.
    pub platform_mass: Option<PlatformMass>,
    /// Bodies that stand fast in O.
    pub base_bodies: Vec<MachineBody>,
    /// Bodies that move with P.
    pub platform_bodies: Vec<MachineBody>,
    /// From where deflections are measured.
    pub zeroed: ZeroState,
    /// Compliance between P and T (spindle, holder, cutter): deflection of T per wrench there, axes of T (mm, rad; N, N·mm); `None`: rigid.
    pub tool_compliance: Option<Box<Matrix6<f64>>>,
    /// Named locations of P.
    pub points: Vec<NamedPoint>,
    /// The configuration from which all others are reached.
    pub home: Configuration,
    /// Pose of P that the machine file asks for at home. Coordinates that are not controlled follow from the chains and may differ.
    pub home_target: Pose,
    /// Largest distance in mm from P to a chain's base or joint axis at home: the length by which rotations and moments are made comparable
    /// with displacements and forces in residuals and eigenvalues.
    pub characteristic_length: f64,
    /// Number of independent motions of the drives beyond those that the controlled coordinates take: 0 for most machines.
    ///
    /// The drives of a redundant machine stand as near to home as the task allows: the sum of squares of their distances from home is least, prismatic ones
    /// in mm and revolute joints in mm at the [characteristic length](crate::machine::Model::characteristic_length). So a path has the same commands from
    /// wherever it is begun. A drive that would leave its travel stays at its end, and the others make up for it. Other platform motions follow.
    pub redundancy: usize,
    /// Whether rotations of the platform that the drives do not control change as it moves. A path then asks for the pose in
    /// which the machine stands with the path's point on it, see [`Machine::track`].
    pub has_parasitic_rotation: bool,
    /// Locked drives, which take no part in the task, with their positions, mm or rad: see [`Machine::with_locked_drives`].
    pub locked: Vec<(usize, f64)>,
    /// What carries the workpiece, if it can move or bend: a machine of one chain from O to the workpiece frame W, whose P is the
    /// origin of W and whose home is where its drives stand.
    pub carrier: Option<Machine>,
    /// Geometry of the arm, if it is a six-axis arm with a spherical wrist.
    arm: Option<Box<branch::Arm>>,
    /// The branch chosen for an arm ([`Machine::on_branch`]); `None` where any will do.
    pub branch: Option<Branch>,
    /// The machine file it was made of, and what was changed since: see [`Machine::parameters`].
    definition: parameters::Definition,
}

/// Error that refuses the argument called `argument` because of `problem`.
fn refusal(argument: &str, problem: String) -> Error {
    Error::Argument { argument: argument.into(), problem }
}

/// Error with `problem` and the names of the built-in machines.
fn unknown_machine(problem: &str) -> Error {
    let names = catalogue::names().collect::<Vec<_>>().join(", ");
    refusal("machine", format!("{problem}; built in: {names}"))
}

impl Machine {
    /// Title of the machine up to the first comma or bracket; its name if that is empty.
    pub fn short_title(&self) -> &str {
        let text = self.title.split([',', '(']).next().unwrap_or_default().trim();
        if text.is_empty() { &self.name } else { text }
    }

    /// The handle of a new model.
    fn from_model(model: Model) -> Self {
        Self(Arc::new(model))
    }

    /// Reads and checks the machine file `file`.
    pub fn from_file(file: &std::path::Path) -> Result<Self> {
        let text = crate::input::toml_file::read(file)?;
        Self::from_toml(&text, &file.display().to_string())
    }

    /// Reads and checks a machine given as TOML text; `origin` names it in error messages.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self> {
        Geometry::from_toml(text, origin)?.machine()
    }

    /// The built-in machine called `name`.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn named(name: &str) -> Result<Self> {
        match catalogue::find(name) {
            Some(entry) => Self::from_toml(entry.toml, entry.name),
            None => Err(unknown_machine(&format!("no built-in machine \"{name}\""))),
        }
    }

    /// The built-in machine called `name`, or else the machine of the file at this path.
    pub fn named_or_file(name: &str) -> Result<Self> {
        Geometry::named_or_file(name)?.machine()
    }

    /// This machine and its workpiece carrier without gravity.
    pub fn weightless(&self) -> Self {
        let mut machine = self.clone();
        if machine.has_weight() {
            machine.gravity = Vector3::zeros();
            machine.definition.clear_gravity();
            machine.carrier = machine.carrier.as_ref().map(Machine::weightless);
        }
        machine
    }

    /// Stiffness at T of spindle, holder and cutter (N, mm, rad), the inverse of their compliance; `None` where they are rigid.
    pub fn tool_stiffness(&self) -> Option<Matrix6<f64>> {
        self.tool_compliance.as_ref()?.try_inverse()
    }

    /// Whether the machine or its workpiece carrier has a mass, and gravity acts on it.
    pub fn has_weight(&self) -> bool {
        let chains = self.chains.iter().chain(self.carrier.iter().flat_map(|carrier| &carrier.chains));
        let has_mass = self.platform_mass.is_some() || chains.into_iter().any(|chain| chain.route.has_mass());
        has_mass && self.gravity != Vector3::zeros()
    }

    /// Whether the machine or its workpiece carrier has springs between points or in passive joints.
    pub fn has_springs(&self) -> bool {
        let mut chains = self.chains.iter().chain(self.carrier.iter().flat_map(|carrier| &carrier.chains));
        let is_sprung = |route: &Route| !route.point_springs.is_empty();
        chains.any(|chain| {
            chain.passive.iter().any(|joint| joint.stiffness > 0.0)
                || chain.route.with_loops().into_iter().any(is_sprung)
        })
    }

    /// Names what deflects the machine without a load: its weight, its springs or both; `None` if nothing does.
    pub fn own_load_text(&self) -> Option<&'static str> {
        match (self.has_weight(), self.has_springs()) {
            (true, true) => Some("weight and springs"),
            (true, false) => Some("weight"),
            (false, true) => Some("springs"),
            (false, false) => None,
        }
    }

    /// All drives in machine order, each with the index of its chain.
    pub fn drives(&self) -> impl Iterator<Item = (usize, &Drive)> {
        self.chains.iter().enumerate().flat_map(|(c, chain)| chain.drives.iter().map(move |drive| (c, drive)))
    }

    /// Full turn of each drive, rad, see `Chain::full_turn`; `None` for prismatic joints and locked drives.
    pub fn full_turns(&self) -> impl Iterator<Item = Option<f64>> {
        let turns = self.chains.iter().flat_map(|chain| (0..chain.drives.len()).map(|drive| chain.full_turn(drive)));
        turns.enumerate().map(|(index, turn)| turn.filter(|_| self.locked.iter().all(|&(locked, _)| locked != index)))
    }

    /// Number of drives.
    pub fn drive_count(&self) -> usize {
        self.chains.iter().map(|chain| chain.drives.len()).sum()
    }

    /// Name of each drive in tables: the chain's name, followed by the drive's where a chain has several.
    pub fn drive_labels(&self) -> Vec<String> {
        let label = |chain: &Chain, drive: &Drive| match chain.drives.len() {
            1 => chain.name.clone(),
            _ => format!("{}_{}", chain.name, drive.name),
        };
        self.drives().map(|(c, drive)| label(&self.chains[c], drive)).collect()
    }

    /// The kinds of drives that the machine has, prismatic joints first. Values of prismatic and revolute joints have no common unit.
    pub fn drive_kinds(&self) -> impl Iterator<Item = Motion> {
        let has = |kind: &Motion| self.drives().any(|(_, drive)| drive.motion == *kind);
        [Motion::Prismatic, Motion::Revolute].into_iter().filter(has)
    }

    /// Whether the machine has both prismatic and revolute joints as drives.
    pub fn has_mixed_drives(&self) -> bool {
        self.drive_kinds().count() > 1
    }

    /// Index of the chain called `name`; `None` if there is none.
    pub fn chain_index(&self, name: &str) -> Option<usize> {
        self.chains.iter().position(|chain| chain.name == name)
    }

    /// The named location called `name`; `None` if the machine has none.
    pub fn point(&self, name: &str) -> Option<&NamedPoint> {
        self.points.iter().find(|point| point.name == name)
    }

    /// This machine with each drive standing its entry of `offsets` (mm or rad, one per drive) beyond its command.
    pub fn with_drive_offsets(&self, offsets: &[f64]) -> Self {
        let mut first = 0;
        let errors: Vec<ChainError> = self
            .chains
            .iter()
            .map(|chain| {
                let shown = &offsets[first..first + chain.drives.len()];
                first += shown.len();
                let joint = |joint: usize| (0..shown.len()).map(|d| chain.joint_per_drive(joint, d) * shown[d]).sum();
                ChainError { drive_offsets: (0..shown.len()).map(joint).collect(), ..ChainError::default() }
            })
            .collect();
        self.with_errors(&errors)
    }

    /// `X_PT`: the tool frame T, with its origin at the tool tip, in platform axes.
    pub fn tool(&self) -> Pose {
        Pose { rotation: self.tool_axes, translation: self.tool_tip }
    }

    /// The tool frame T as seen from P in O axes, where the platform has the orientation `rotation` (`R_OP`): the columns of its
    /// rotation are the tool's axes in O, its translation is `p_PT` in O axes, mm.
    pub fn tool_at(&self, rotation: &Matrix3<f64>) -> Pose {
        Pose { rotation: rotation * self.tool_axes, translation: rotation * self.tool_tip }
    }

    /// Displacement of the tool tip when P moves from pose `from` to pose `to`, O axes, mm.
    pub fn tool_displacement(&self, from: &Pose, to: &Pose) -> Vector3<f64> {
        to.transform(self.tool_tip) - from.transform(self.tool_tip)
    }

    /// Pose of P that commands position `position` mm with the platform oriented as at home.
    pub fn pose_at(&self, position: Vector3<f64>) -> Pose {
        Pose { rotation: self.home.pose.rotation, translation: position }
    }
}
