//! Figures of a workspace map: slices of its quantities, the workspace in 3-D, and the deflected machine.

use nalgebra::Vector3;

use super::{
    Summary,
    quantities::{ANGLE, DEFLECTION, P95_DEFLECTION, STIFFNESS, SUPERPOSITION_ERROR, drives},
};
use crate::{
    answer::{GridMap, MapLayer, Quantity, Tolerance, deflected_pose::deflected_pose, drive_columns::kind_word},
    figures::{Figure, Shading},
    machine::Motion,
    page::DeflectedPose,
    questions::map::{MapPoint, SourceEffect, WorkspaceMapStudy},
    simulation::Source,
};

/// Index of the quantity drawn in 3-D: the deflection by all sources.
const IN_3D: usize = 1;
/// Index of its 95 % quantile, where inputs are uncertain.
const P95: usize = 2;

/// Makes the figures of a map of `study`, to which points are then added one by one.
pub(super) fn pictures<'a>(study: &'a WorkspaceMapStudy, slices_z: &[f64]) -> GridMap<'a, MapPoint> {
    GridMap::new(&study.load_case, &study.grid, slices_z, drawn_quantities(study))
}

/// Lists the quantities drawn. Corrections of prismatic and of revolute joints are separate figures.
fn drawn_quantities(study: &WorkspaceMapStudy) -> Vec<MapLayer<MapPoint>> {
    let machine = &study.load_case.machine;
    let layer = |stem, title: &str, source, quantity: Quantity<SourceEffect>| MapLayer {
        stem,
        title: title.into(),
        label: quantity.axis_label(),
        setting: match source {
            Source::Weight => "without cutting force".into(),
            _ => study.load_case.worst_text(),
        },
        limit: None,
        of_limit: String::new(),
        shading: Shading::Ordered,
        value: Box::new(move |point: &MapPoint| quantity.value(point.effect(source)?)),
    };
    let [together, added] = match Source::parts(machine).contains(&Source::Weight) {
        true => {
            ["How far cutting force, weight and chain errors move the tool", "Superposition error of the three effects"]
        }
        false => ["How far cutting force and chain errors move the tool", "Superposition error of the two effects"],
    };
    let mut layers = vec![
        layer("deflection_cutting", "How far the cutting force moves the tool", Source::Cutting, DEFLECTION),
        layer("deflection_all", together, Source::All, DEFLECTION),
    ];
    if study.uncertainty.is_some() {
        let title = "How far the tool moves at most with 95 % probability";
        layers.push(layer("deflection_p95_all", title, Source::All, P95_DEFLECTION));
    }
    if let Some(load) = machine.own_load_text() {
        let text = match load {
            "weight" => "How far the machine's own weight moves the tool",
            "springs" => "How far the machine's own springs move the tool",
            _ => "How far the machine's own weight and springs move the tool",
        };
        let weight = layer("deflection_weight", text, Source::Weight, DEFLECTION);
        layers.push(MapLayer { label: "tool deflection [mm]".into(), ..weight });
    }
    for (kind, correction) in drives(machine).corrections {
        let stem = match (machine.has_mixed_drives(), kind) {
            (false, _) => "delta_rho_all",
            (true, Motion::Prismatic) => "delta_rho_prismatic_all",
            (true, Motion::Revolute) => "delta_rho_revolute_all",
        };
        let title = format!("Corrections of the {}", kind_word(machine, kind));
        layers.push(layer(stem, &title, Source::All, correction));
    }
    let superposition_error = layer("superposition_all", added, Source::All, SUPERPOSITION_ERROR);
    layers.push(MapLayer { label: "superposition error at the worst angle [mm]".into(), ..superposition_error });
    let [smallest, ..] = STIFFNESS;
    let title = "How stiff the tool tip is in its softest direction";
    layers.push(layer("stiffness_min_cutting", title, Source::Cutting, smallest));
    let angle = layer("worst_angle_all", "At which tool angle the tool is moved most", Source::All, ANGLE);
    layers.push(MapLayer { label: "tool angle φ [°]".into(), shading: Shading::Cyclic, ..angle });
    layers
}

/// Returns all figures with their file stems: the result, slices of every quantity, and the workspace in 3-D.
pub(super) fn figures(map: &GridMap<'_, MapPoint>, summary: &Summary<'_>) -> Vec<(String, Figure)> {
    let tolerance = summary.study.load_case.tolerance_mm.map(Tolerance);
    let (layer, quantity, title) = match summary.study.uncertainty {
        None => (IN_3D, &DEFLECTION, "Where the tool is moved least and most"),
        Some(_) => (P95, &P95_DEFLECTION, "Where the tool is moved least and most with 95 % probability"),
    };
    let extremes = summary.of(Source::All).of(quantity).into_iter().flatten();
    let ends: Vec<_> = extremes.zip(["least", "most"]).map(|(at, word)| (at.value, at.position_mm, word)).collect();
    let answer = map.slices_at(layer, title, &ends, tolerance);
    let mut figures = vec![("answer".to_string(), answer)];
    figures.extend(map.slices());
    // Without a cutting force there is no angle.
    if !ends.is_empty() && !map.has_values(figures.len() - 2) {
        figures.pop();
    }
    let title = format!("The workspace, coloured by {}", DEFLECTION.label);
    figures.extend(map.in_3d(IN_3D, title).map(|figure| ("workspace_deflection_all".into(), figure)));
    figures
}

/// Returns the deflected machine at that named point (or home) and φ where all sources move the tool farthest; `None` without equilibrium.
pub(super) fn worst_deflected_pose(WorkspaceMapStudy { load_case, .. }: &WorkspaceMapStudy) -> Option<DeflectedPose> {
    let machine = &load_case.machine;
    let mut places: Vec<(&str, Vector3<f64>)> = machine.points.iter().map(|p| (p.name.as_str(), p.position)).collect();
    if places.is_empty() {
        places.push(("home", machine.home.pose.translation));
    }
    let mut worst: Option<DeflectedPose> = None;
    for (name, position) in places {
        let Ok(at) = machine.inverse_kinematics_at(position) else { continue };
        for &phi in &load_case.phis {
            let place = format!("at {name}, tool angle {:.0}°", phi.to_degrees());
            let task = load_case.task_point(at.pose, Some(phi));
            let Some(deflected) = deflected_pose(machine, &load_case.errors, &task, place) else { continue };
            let size = |deflected: &DeflectedPose| deflected.tool_displacement_mm.norm();
            if worst.as_ref().is_none_or(|worst| size(&deflected) > size(worst)) {
                worst = Some(deflected);
            }
        }
    }
    worst
}
