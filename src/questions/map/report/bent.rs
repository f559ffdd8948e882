//! The machine bent where a map moves the tool farthest among the named points.

use nalgebra::Vector3;

use crate::{
    answer::deflected_pose::deflected_pose, compensation::Demand, page::DeflectedPose,
    questions::map::WorkspaceMapStudy,
};

/// The named point, or else home, and the tool angle at which cutting force and chain errors of a map move the tool
/// farthest; `None` if the machine settles at none.
pub fn bent(study: &WorkspaceMapStudy) -> Option<DeflectedPose> {
    let machine = &study.machine;
    let mut places: Vec<(&str, Vector3<f64>)> = machine.points.iter().map(|p| (p.name.as_str(), p.position)).collect();
    if places.is_empty() {
        places.push(("home", machine.home.pose.translation));
    }
    let mut worst: Option<DeflectedPose> = None;
    for (name, position) in places {
        let Ok(at) = machine.command(position) else { continue };
        let pose = at.pose;
        for &phi in &study.phis {
            let load = study.force.wrench(phi, &machine.tool_at(&pose.rotation));
            let demand = Demand { pose, load, target: study.target, wanted: None, external: None };
            let place = format!("at {name}, tool angle {:.0}°", phi.to_degrees());
            let Some(bent) = deflected_pose(machine, &study.errors, &demand, place) else { continue };
            let size = |bent: &DeflectedPose| bent.tool_displacement_mm.norm();
            if worst.as_ref().is_none_or(|worst| size(&bent) > size(worst)) {
                worst = Some(bent);
            }
        }
    }
    worst
}
