//! Which pictures a map gives.

use crate::{
    machine::Machine,
    process::MillingForce,
    report::{
        figures::{Figure, Mark3, SliceFigure, VolumeFigure},
        grid_slices::{panels, typographic},
        table::{largest_position, position_unit},
        words::counted,
    },
    study::{
        Source,
        workspace_map::{SourceEffect, WorkspaceMap, WorkspaceMapStudy},
    },
};

/// A quantity of the map that is drawn.
struct Quantity {
    file_stem: &'static str,
    title: &'static str,
    label: &'static str,
    unit: fn(&Machine) -> &'static str,
    source: Source,
    value: fn(&Machine, &SourceEffect) -> Option<f64>,
}

const QUANTITIES: [Quantity; 5] = [
    Quantity {
        file_stem: "deflection_cutting",
        title: "How far the cutting force moves the tool",
        label: "worst tool deflection",
        unit: |_| "mm",
        source: Source::Cutting,
        value: |_, e| Some(e.deflection_mm),
    },
    Quantity {
        file_stem: "deflection_both",
        title: "How far cutting force and chain errors move the tool",
        label: "worst tool deflection",
        unit: |_| "mm",
        source: Source::Both,
        value: |_, e| Some(e.deflection_mm),
    },
    Quantity {
        file_stem: "delta_rho_both",
        title: "What the drives must be told instead",
        label: "largest drive correction |Δρ|",
        unit: position_unit,
        source: Source::Both,
        value: |machine, e| Some(largest_position(machine, &e.delta_rho)),
    },
    Quantity {
        file_stem: "departure_both",
        title: "How wrong it is to add the two effects",
        label: "departure at the worst angle",
        unit: |_| "mm",
        source: Source::Both,
        value: |_, e| e.departure_mm(),
    },
    Quantity {
        file_stem: "stiffness_min_cutting",
        title: "How stiff the tool tip is in its softest direction",
        label: "smallest principal stiffness",
        unit: |_| "N/mm",
        source: Source::Cutting,
        value: |_, e| Some(e.principal_stiffness_n_per_mm[0]),
    },
];

/// All pictures with their file stems: slices of every quantity, and the workspace in 3-D with the deflection under both
/// sources.
pub fn figures(map: &WorkspaceMap) -> Vec<(String, Figure)> {
    let mut figures: Vec<(String, Figure)> = QUANTITIES
        .iter()
        .map(|quantity| (format!("slices_{}", quantity.file_stem), Figure::Slices(slices(map, quantity))))
        .collect();
    let deflection = &QUANTITIES[1];
    if map.study.grid.counts().iter().all(|&n| n > 1) {
        figures.push((format!("workspace_{}", deflection.file_stem), Figure::Volume(volume(map, deflection))));
    }
    figures
}

fn setting(map: &WorkspaceMap) -> String {
    let study = &map.study;
    let [nx, ny, nz] = study.grid.counts();
    let MillingForce { radial, tangential, axial, .. } = study.force;
    let setting = format!(
        "{}, worst of {}, force {radial} / {tangential} / {axial} N (radial / tangential / axial), \
         grid {nx} × {ny} × {nz}",
        study.machine.name,
        counted(study.phis.len(), "tool angle"),
    );
    typographic(&setting)
}

fn quantity_label(map: &WorkspaceMap, quantity: &Quantity) -> String {
    format!("{} [{}]", quantity.label, (quantity.unit)(&map.study.machine))
}

fn values(map: &WorkspaceMap, quantity: &Quantity) -> Vec<Option<f64>> {
    let machine = &map.study.machine;
    map.points.iter().map(|point| point.effect(quantity.source).and_then(|e| (quantity.value)(machine, e))).collect()
}

fn slices(map: &WorkspaceMap, quantity: &Quantity) -> SliceFigure {
    let WorkspaceMapStudy { machine, grid, slices_z, .. } = &map.study;
    SliceFigure {
        title: quantity.title.into(),
        subtitle: setting(map),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: quantity_label(map, quantity),
        panels: panels(machine, grid, slices_z, &values(map, quantity)),
        range: None,
        contour: None,
    }
}

fn volume(map: &WorkspaceMap, quantity: &Quantity) -> VolumeFigure {
    let points = &map.study.machine.points;
    VolumeFigure {
        title: quantity.title.into(),
        subtitle: setting(map),
        axis_labels: ["x [mm]".into(), "y [mm]".into(), "z [mm]".into()],
        quantity: quantity_label(map, quantity),
        axes: map.study.grid.axes.clone(),
        values: values(map, quantity),
        marks: points.iter().map(|p| Mark3 { label: p.name.clone(), position: p.position.into() }).collect(),
        range: None,
    }
}
