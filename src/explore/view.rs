//! What a page draws of a scene when it opens.

use serde::Serialize;

use super::{Explorer, Workpiece, cloud::Uncertain, place::columns};
use crate::{
    input::check::Check,
    machine::Machine,
    process::{Extent, PathReference, tilt::TiltAngles},
    questions::placement::{PlacementStudy, Site},
    spatial::Skeleton,
};

/// Machine and workpiece of a scene, as a page shows them.
#[derive(Debug, Clone, Serialize)]
pub struct View {
    /// The machine.
    pub machine: MachineView,
    /// Parameters of the machine that can be set.
    pub parameters: Vec<ParameterView>,
    /// The workpiece, if there is one.
    pub workpiece: Option<WorkpieceView>,
    /// Where it stands what is not known exactly; `None` where everything is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertain_by: Option<&'static str>,
}

/// A machine as a page draws it.
#[derive(Debug, Clone, Serialize)]
pub struct MachineView {
    /// Short name.
    pub name: String,
    /// Title in words.
    pub title: String,
    /// Its skeleton lines at home.
    pub home: Skeleton,
    /// Skeleton lines of the workpiece carrier at home.
    pub carrier: Option<Skeleton>,
    /// Position of P at home, mm, and its roll, pitch and yaw, degrees.
    pub home_pose: [f64; 6],
    /// Columns of the tool's axes at home, and the tool tip, seen from P in O axes.
    pub tool: [[f64; 3]; 4],
    /// Corners of the workspace box, P in O, mm.
    pub workspace: [[f64; 3]; 2],
    /// Named positions of P, O, mm.
    pub points: Vec<(String, [f64; 3])>,
    /// Label and units of position and force of each drive.
    pub drives: Vec<DriveView>,
    /// Coordinates that the drives do not control, in words.
    pub uncontrolled: Option<String>,
    /// Whether the machine can be commanded to orientations.
    pub turns: bool,
    /// Options of the command line for the same branch and locked drives.
    pub options: Vec<String>,
}

/// A drive as a page shows it.
#[derive(Debug, Clone, Serialize)]
pub struct DriveView {
    /// Label.
    pub label: String,
    /// Unit of its position: mm or °.
    pub unit: &'static str,
    /// Unit of its force: N or N·mm.
    pub force_unit: &'static str,
    /// Largest force, if limited.
    pub force_limit: Option<f64>,
}

/// A parameter of the machine.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterView {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit, as shown.
    pub unit: String,
}

/// A workpiece as a page draws it.
#[derive(Debug, Clone, Serialize)]
pub struct WorkpieceView {
    /// Its paths.
    pub features: Vec<FeatureView>,
    /// Corners of its bounding box in W, mm.
    pub extent: [[f64; 3]; 2],
    /// Boxes that it must avoid: name and corners in O, mm.
    pub forbidden: Vec<(String, [[f64; 3]; 2])>,
    /// Smallest distance from them, mm.
    pub clearance_mm: f64,
    /// Smallest and largest place of the study: x, y, z in mm, yaw, pitch, roll in degrees.
    pub bounds: [[f64; 6]; 2],
    /// Named candidate places of the study.
    pub candidates: Vec<(String, [f64; 6])>,
    /// Columns of the axes in which places are given, seen from O, and their origin, mm.
    pub base: [[f64; 3]; 4],
    /// Whether roll and pitch may be nonzero.
    pub tilts: [bool; 2],
    /// The objective that is minimised, in words.
    pub objective: String,
    /// Whether the paths are of P, not of the tool tip.
    pub is_of_platform: bool,
}

/// A path of a workpiece.
#[derive(Debug, Clone, Serialize)]
pub struct FeatureView {
    /// Its name.
    pub name: String,
    /// Tolerance of the path, mm.
    pub tolerance_mm: f64,
    /// Its points in W, mm.
    pub points: Vec<[f64; 3]>,
    /// Whether the tool cuts on the way to each point.
    pub cutting: Vec<bool>,
    /// Arc length up to each point, mm.
    pub arc_length: Vec<f64>,
}

impl Explorer {
    /// Returns what to draw of the scene.
    pub fn view(&self) -> View {
        let parameters = self.machine.parameters().into_iter().filter(|parameter| parameter.key.is_some());
        let parameter = |p: crate::machine::Parameter| {
            Some(ParameterView { value: p.value?, unit: p.unit.to_string(), name: p.name })
        };
        View {
            machine: self.machine_view(),
            parameters: parameters.filter_map(parameter).collect(),
            workpiece: self.workpiece.as_ref().map(Workpiece::view),
            uncertain_by: self.uncertain.as_ref().map(Uncertain::by),
        }
    }

    /// Returns the machine as a page draws it.
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
            home_pose: [at.translation.x, at.translation.y, at.translation.z, to_deg(roll), to_deg(pitch), to_deg(yaw)],
            tool: columns(&machine.tool_at(&at.rotation)),
            workspace: [machine.workspace.min.into(), machine.workspace.max.into()],
            points: machine.points.iter().map(|point| (point.name.clone(), point.position.into())).collect(),
            drives: drives.collect(),
            uncontrolled: machine.uncontrolled_text(),
            turns: can_rotate(machine, TiltAngles { roll: true, pitch: true, yaw: true }),
            options: branch.chain(locked).collect(),
        }
    }
}

impl Workpiece {
    /// Returns the workpiece as a page draws it.
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
            extent: extent_corners(extent),
            forbidden: forbidden.iter().map(|each| (each.name.clone(), extent_corners(&each.extent))).collect(),
            clearance_mm: self.study.clearance_mm,
            bounds: [Site(bounds.low).shown(), Site(bounds.high).shown()],
            candidates: self.study.candidates.iter().map(|each| (each.name.clone(), each.site.shown())).collect(),
            base: columns(&self.study.workpiece_pose(&Site([0.0; 6]))),
            tilts: [
                can_rotate(machine, TiltAngles { roll: true, pitch: false, yaw: true }),
                can_rotate(machine, TiltAngles { roll: false, pitch: true, yaw: true }),
            ],
            objective: self.study.objective.text(machine),
            is_of_platform: features.iter().any(|job| job.feature.reference == PathReference::PlatformPoint),
        }
    }
}

/// Returns whether the machine can be commanded to the rotations of `angles`.
fn can_rotate(machine: &Machine, angles: TiltAngles) -> bool {
    angles.check(machine, |key| Check::new(super::STUDY).key(key)).is_ok()
}

/// Returns the two corners of a bounding box, mm.
fn extent_corners(extent: &Extent) -> [[f64; 3]; 2] {
    [extent.min.into(), extent.max.into()]
}

/// Returns an angle (rad) in degrees, rounded to 1e-9.
fn to_deg(angle: f64) -> f64 {
    (angle.to_degrees() * 1e9).round() / 1e9 + 0.0
}
