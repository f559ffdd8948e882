//! What a page draws of a scene before anything is asked.

use serde::Serialize;

use super::{Explorer, Workpiece, place::columns};
use crate::{
    input::check::Check,
    machine::{Machine, Skeleton},
    process::{Extent, PathReference, tilt::Turned},
    questions::placement::{PlacementStudy, Site},
};

/// A scene in words and lines.
#[derive(Debug, Clone, Serialize)]
pub struct View {
    /// The machine.
    pub machine: MachineView,
    /// Numbers of the machine that can be set.
    pub parameters: Vec<ParameterView>,
    /// The workpiece, if there is one.
    pub workpiece: Option<WorkpieceView>,
}

/// A machine.
#[derive(Debug, Clone, Serialize)]
pub struct MachineView {
    /// Short name.
    pub name: String,
    /// In words.
    pub title: String,
    /// Its lines at home.
    pub home: Skeleton,
    /// Lines of what carries the workpiece, at home.
    pub carrier: Option<Skeleton>,
    /// Position of P at home, mm, and its roll, pitch and yaw, degrees.
    pub home_pose: [f64; 6],
    /// Columns of the tool's axes at home, and the tool tip, seen from P.
    pub tool: [[f64; 3]; 4],
    /// Corners of the workspace box of P, mm.
    pub workspace: [[f64; 3]; 2],
    /// Named places of P, mm.
    pub points: Vec<(String, [f64; 3])>,
    /// Label and units of position and force of each drive.
    pub drives: Vec<DriveView>,
    /// What the drives do not control, in words.
    pub uncontrolled: Option<String>,
    /// Whether orientations may be asked for.
    pub turns: bool,
    /// Words that the command line needs to stand on the same branch with the same drives locked.
    pub options: Vec<String>,
}

/// A drive.
#[derive(Debug, Clone, Serialize)]
pub struct DriveView {
    /// Label.
    pub label: String,
    /// mm or °.
    pub unit: &'static str,
    /// N or N·mm.
    pub force_unit: &'static str,
    /// Most force, where there is a limit.
    pub force_limit: Option<f64>,
}

/// A number of the machine.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterView {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit, as shown.
    pub unit: String,
}

/// A workpiece.
#[derive(Debug, Clone, Serialize)]
pub struct WorkpieceView {
    /// Its paths.
    pub features: Vec<FeatureView>,
    /// Corners of its box in W.
    pub extent: [[f64; 3]; 2],
    /// Boxes that it must stay out of, in O: name and corners.
    pub forbidden: Vec<(String, [[f64; 3]; 2])>,
    /// How far it must stay from them, mm.
    pub clearance_mm: f64,
    /// Smallest and largest coordinates of the study.
    pub bounds: [[f64; 6]; 2],
    /// Named places of the study.
    pub candidates: Vec<(String, [f64; 6])>,
    /// Columns of the axes in which places are given, seen from O, and their origin.
    pub base: [[f64; 3]; 4],
    /// Whether roll and pitch may be other than zero.
    pub tilts: [bool; 2],
    /// What is made small.
    pub objective: String,
    /// Whether paths give positions of P, not of the tool tip.
    pub is_of_platform: bool,
}

/// A path of a workpiece.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureView {
    /// Its name.
    pub name: String,
    /// How far the tool may be from it, mm.
    pub tolerance_mm: f64,
    /// Its points in W, mm.
    pub points: Vec<[f64; 3]>,
    /// Whether the tool cuts on the way to each.
    pub cutting: Vec<bool>,
    /// Length up to each, mm.
    pub arc_length: Vec<f64>,
}

impl Explorer {
    /// What is drawn before anything is asked.
    pub fn view(&self) -> View {
        let parameters = self.machine.parameters().into_iter().filter(|parameter| parameter.key.is_some());
        let parameter = |p: crate::machine::Parameter| {
            Some(ParameterView { value: p.value?, unit: p.unit.to_string(), name: p.name })
        };
        View {
            machine: self.machine_view(),
            parameters: parameters.filter_map(parameter).collect(),
            workpiece: self.workpiece.as_ref().map(Workpiece::view),
        }
    }

    fn machine_view(&self) -> MachineView {
        let machine = &self.machine;
        let at = &machine.home.pose;
        let (roll, pitch, yaw) = nalgebra::Rotation3::from_matrix_unchecked(at.rotation).euler_angles();
        let drives = machine.drive_labels().into_iter().zip(machine.drives()).map(|(label, (_, drive))| DriveView {
            label,
            unit: drive.motion.shown_position_unit(),
            force_unit: drive.motion.shown_force_unit(),
            force_limit: drive.force_limit,
        });
        let branch = machine.branch.iter().flat_map(|branch| ["--branch".to_string(), branch.label().into()]);
        let locked = machine
            .locked_drives()
            .into_iter()
            .flat_map(|(label, value, _)| ["--lock".into(), format!("{label}={value}")]);
        MachineView {
            name: self.scene.machine.clone(),
            title: machine.title.clone(),
            home: machine.rigid_skeleton(&machine.home),
            carrier: machine.carrier.as_ref().map(|carrier| carrier.rigid_skeleton(&carrier.home)),
            home_pose: [at.translation.x, at.translation.y, at.translation.z, tidy(roll), tidy(pitch), tidy(yaw)],
            tool: columns(&machine.tool_at(&at.rotation)),
            workspace: [machine.workspace.min.into(), machine.workspace.max.into()],
            points: machine.points.iter().map(|point| (point.name.clone(), point.position.into())).collect(),
            drives: drives.collect(),
            uncontrolled: machine.uncontrolled_words(),
            turns: may_turn(machine, Turned { roll: true, pitch: true, yaw: true }),
            options: branch.chain(locked).collect(),
        }
    }
}

impl Workpiece {
    fn view(&self) -> WorkpieceView {
        let PlacementStudy { machine, features, extent, forbidden, bounds, .. } = &self.study;
        let feature = |job: &crate::questions::placement::FeatureJob| {
            let points = job.feature.path.points();
            FeatureView {
                name: job.feature.name.clone(),
                tolerance_mm: job.feature.tolerance_mm,
                points: points.iter().map(|point| point.position_mm.into()).collect(),
                cutting: points.iter().map(|point| point.cutting).collect(),
                arc_length: points.iter().map(|point| point.arc_length_mm).collect(),
            }
        };
        WorkpieceView {
            features: features.iter().map(feature).collect(),
            extent: ends(extent),
            forbidden: forbidden.iter().map(|own| (own.name.clone(), ends(&own.extent))).collect(),
            clearance_mm: self.study.clearance_mm,
            bounds: [Site(bounds.low).shown(), Site(bounds.high).shown()],
            candidates: self.study.candidates.iter().map(|own| (own.name.clone(), own.site.shown())).collect(),
            base: columns(&self.study.workpiece(&Site([0.0; 6]))),
            tilts: [
                may_turn(machine, Turned { roll: true, pitch: false, yaw: true }),
                may_turn(machine, Turned { roll: false, pitch: true, yaw: true }),
            ],
            objective: self.study.objective.words(machine),
            is_of_platform: features.iter().any(|job| job.feature.reference == PathReference::PlatformPoint),
        }
    }
}

fn may_turn(machine: &Machine, turned: Turned) -> bool {
    turned.check(machine, |key| Check::new(super::STUDY).key(key)).is_ok()
}

fn ends(extent: &Extent) -> [[f64; 3]; 2] {
    [extent.min.into(), extent.max.into()]
}

/// Degrees, without the rounding of the way through radians.
fn tidy(angle: f64) -> f64 {
    (angle.to_degrees() * 1e9).round() / 1e9 + 0.0
}
