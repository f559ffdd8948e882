//! Which pictures a map gives.

use crate::{
    machine::Machine,
    process::MillingForce,
    report::{
        figures::{Figure, Mark3, SliceFigure, VolumeFigure},
        grid_slices::{drawn, drawn_nodes, panels, thinned_words},
        table::{largest_position, position_unit},
        words::{counted, typographic},
    },
    study::{
        Source,
        workspace_map::{MapPoint, SourceEffect, WorkspaceMapStudy},
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
        value: |machine, e| Some(largest_position(machine, e.delta_rho.as_ref().ok()?)),
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

/// Most nodes along an axis of the picture in 3-D.
const MOST_NODES: usize = 41;

/// The values that pictures show, gathered point by point: a large grid is thinned.
#[derive(Debug, Clone)]
pub struct Pictures {
    /// Grid indices of the nodes shown, ascending.
    nodes: Vec<usize>,
    /// At each of them, the values of [`QUANTITIES`].
    values: Vec<[Option<f64>; QUANTITIES.len()]>,
    /// Indices along each axis of the picture in 3-D.
    volume: [Vec<usize>; 3],
    /// Index of the next point.
    next: usize,
}

impl Pictures {
    /// For a map of `study`, none of its points seen.
    pub fn new(study: &WorkspaceMapStudy) -> Self {
        let grid = &study.grid;
        let volume = grid.counts().map(|count| drawn(count, MOST_NODES));
        let slices = drawn_nodes(grid, &study.slices_z);
        let index = |[x, y, z]: [usize; 3]| grid.index([x, y, z]);
        let mut nodes: Vec<usize> = product(&slices).chain(product(&volume)).map(index).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { values: Vec::with_capacity(nodes.len()), nodes, volume, next: 0 }
    }

    /// Takes the next point, in grid order.
    pub fn add(&mut self, machine: &Machine, point: &MapPoint) {
        if self.nodes.get(self.values.len()) == Some(&self.next) {
            let value = |quantity: &Quantity| point.effect(quantity.source).and_then(|e| (quantity.value)(machine, e));
            self.values.push(std::array::from_fn(|k| value(&QUANTITIES[k])));
        }
        self.next += 1;
    }

    fn value(&self, study: &WorkspaceMapStudy, node: [usize; 3], quantity: usize) -> Option<f64> {
        let place = self.nodes.binary_search(&study.grid.index(node)).ok()?;
        self.values.get(place)?[quantity]
    }

    /// All pictures with their file stems: slices of every quantity, and the workspace in 3-D with the deflection under
    /// both sources.
    pub fn figures(&self, study: &WorkspaceMapStudy) -> Vec<(String, Figure)> {
        let slices = |(k, quantity): (usize, &Quantity)| {
            (format!("slices_{}", quantity.file_stem), Figure::Slices(self.slices(study, k)))
        };
        let mut figures: Vec<(String, Figure)> = QUANTITIES.iter().enumerate().map(slices).collect();
        if study.grid.counts().iter().all(|&n| n > 1) {
            let name = format!("workspace_{}", QUANTITIES[IN_3D].file_stem);
            figures.push((name, Figure::Volume(self.volume(study, IN_3D))));
        }
        figures
    }

    fn slices(&self, study: &WorkspaceMapStudy, quantity: usize) -> SliceFigure {
        let value = |node| self.value(study, node, quantity);
        SliceFigure {
            title: QUANTITIES[quantity].title.into(),
            subtitle: setting(study, &drawn_nodes(&study.grid, &study.slices_z)[..2]),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: quantity_label(study, quantity),
            panels: panels(&study.machine, &study.grid, &study.slices_z, &value),
            range: None,
            contour: None,
        }
    }

    fn volume(&self, study: &WorkspaceMapStudy, quantity: usize) -> VolumeFigure {
        let points = &study.machine.points;
        let coordinates = |i: usize| self.volume[i].iter().map(|&k| study.grid.axes[i][k]).collect();
        VolumeFigure {
            title: QUANTITIES[quantity].title.into(),
            subtitle: setting(study, &self.volume),
            axis_labels: ["x [mm]".into(), "y [mm]".into(), "z [mm]".into()],
            quantity: quantity_label(study, quantity),
            axes: [0, 1, 2].map(coordinates),
            values: product(&self.volume).map(|node| self.value(study, node, quantity)).collect(),
            marks: points.iter().map(|p| Mark3 { label: p.name.clone(), position: p.position.into() }).collect(),
            range: None,
        }
    }
}

/// The quantity drawn in 3-D: the deflection under both sources.
const IN_3D: usize = 1;

/// All combinations of the indices, x fastest.
fn product([x, y, z]: &[Vec<usize>; 3]) -> impl Iterator<Item = [usize; 3]> {
    z.iter().flat_map(move |&k| y.iter().flat_map(move |&j| x.iter().map(move |&i| [i, j, k])))
}

/// The subtitle of a picture that shows the nodes with the indices `drawn` along the first axes.
fn setting(study: &WorkspaceMapStudy, drawn: &[Vec<usize>]) -> String {
    let [nx, ny, nz] = study.grid.counts();
    let thinned = thinned_words(&study.grid, drawn);
    let MillingForce { radial, tangential, axial, .. } = study.force;
    let setting = format!(
        "{}, worst of {}, force {radial} / {tangential} / {axial} N (radial / tangential / axial), \
         grid {nx} × {ny} × {nz}{thinned}",
        study.machine.name,
        counted(study.phis.len(), "tool angle"),
    );
    typographic(&setting)
}

fn quantity_label(study: &WorkspaceMapStudy, quantity: usize) -> String {
    let Quantity { label, unit, .. } = &QUANTITIES[quantity];
    format!("{label} [{}]", unit(&study.machine))
}
