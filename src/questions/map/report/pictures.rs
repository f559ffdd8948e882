//! Which pictures a map gives.

use crate::{
    answer::{
        grid_slices::{drawn, drawn_nodes, panels, thinned_words},
        point_words,
    },
    figures::{Figure, Mark2, Mark3, Shading, SliceFigure, SlicePanel, VolumeFigure},
    files::{
        table::{kind_word, largest_position},
        words::{counted, millimetres, signed, typographic},
    },
    machine::{Machine, Motion},
    process::MillingForce,
    questions::map::{
        MapPoint, Shown, SourceEffect, WorkspaceMapStudy,
        report::{Summary, summary::Found},
    },
    simulation::Source,
};

/// A quantity of the map that is drawn.
#[derive(Debug, Clone)]
struct Quantity {
    file_stem: &'static str,
    title: String,
    label: String,
    unit: &'static str,
    shading: Shading,
    source: Source,
    value: fn(&Machine, &SourceEffect) -> Option<f64>,
}

/// The quantities drawn. Corrections of slides and of hinges are pictures of their own.
fn quantities(machine: &Machine) -> Vec<Quantity> {
    let quantity = |file_stem, title: &str, label: &str, unit, source, value| Quantity {
        file_stem,
        title: title.into(),
        label: label.into(),
        unit,
        shading: Shading::Ordered,
        source,
        value,
    };
    let mut all = vec![quantity(
        "deflection_cutting",
        "How far the cutting force moves the tool",
        "worst tool deflection",
        "mm",
        Source::Cutting,
        |_, e| Some(e.deflection_mm),
    )];
    let [together, added] = match Source::parts(machine).contains(&Source::Weight) {
        true => {
            ["How far cutting force, weight and chain errors move the tool", "How wrong it is to add the three effects"]
        }
        false => ["How far cutting force and chain errors move the tool", "How wrong it is to add the two effects"],
    };
    all.push(quantity("deflection_all", together, "worst tool deflection", "mm", Source::All, |_, e| {
        Some(e.deflection_mm)
    }));
    if let Some(own) = machine.own_forces() {
        let words = match own {
            "weight" => "How far the machine's own weight moves the tool",
            "springs" => "How far the machine's own springs move the tool",
            _ => "How far the machine's own weight and springs move the tool",
        };
        all.push(quantity("deflection_weight", words, "tool deflection", "mm", Source::Weight, |_, e| {
            Some(e.deflection_mm)
        }));
    }
    all.extend(machine.drive_kinds().map(|kind| correction(machine, kind)));
    all.push(quantity("departure_all", added, "departure at the worst angle", "mm", Source::All, |_, e| {
        e.departure_mm()
    }));
    all.push(quantity(
        "stiffness_min_cutting",
        "How stiff the tool tip is in its softest direction",
        "smallest principal stiffness",
        "N/mm",
        Source::Cutting,
        |_, e| Some(e.principal_stiffness_n_per_mm[0]),
    ));
    let angle = quantity(
        "worst_angle_all",
        "At which tool angle the tool is moved most",
        "tool angle φ",
        "°",
        Source::All,
        |_, e| e.phi_deg,
    );
    all.push(Quantity { shading: Shading::Cyclic, ..angle });
    all
}

/// The largest correction among the drives of one kind.
fn correction(machine: &Machine, kind: Motion) -> Quantity {
    let drives = kind_word(machine, kind);
    Quantity {
        file_stem: match drives {
            "slides" => "delta_rho_slides_all",
            "hinges" => "delta_rho_hinges_all",
            _ => "delta_rho_all",
        },
        title: format!("What the {drives} must be told instead"),
        label: match drives {
            "drives" => "largest drive correction |Δρ|".into(),
            _ => format!("largest correction of {drives} |Δρ|"),
        },
        unit: kind.shown_position_unit(),
        shading: Shading::Ordered,
        source: Source::All,
        value: match kind {
            Motion::Prismatic => |machine, e| correction_of(machine, Motion::Prismatic, e),
            Motion::Revolute => |machine, e| correction_of(machine, Motion::Revolute, e),
        },
    }
}

fn correction_of(machine: &Machine, kind: Motion, effect: &SourceEffect) -> Option<f64> {
    Some(largest_position(machine, kind, effect.delta_rho.as_ref().ok()?))
}

/// Most nodes along an axis of the picture in 3-D.
const MOST_NODES: usize = 41;

/// The values that pictures show, gathered point by point: a large grid is thinned.
#[derive(Debug, Clone)]
pub struct Pictures {
    /// Heights of the slices, mm.
    slices_z: Vec<f64>,
    /// Grid indices of the nodes shown, ascending.
    nodes: Vec<usize>,
    /// What is drawn.
    quantities: Vec<Quantity>,
    /// At each of the nodes, the values of the quantities.
    values: Vec<Vec<Option<f64>>>,
    /// Indices along each axis of the picture in 3-D.
    volume: [Vec<usize>; 3],
    /// Index of the next point.
    next: usize,
}

impl Pictures {
    /// For a map of `study`, none of its points seen.
    pub fn new(study: &WorkspaceMapStudy, shown: &Shown) -> Self {
        let grid = &study.grid;
        let volume = grid.counts().map(|count| drawn(count, MOST_NODES));
        let slices = drawn_nodes(grid, &shown.slices_z);
        let index = |[x, y, z]: [usize; 3]| grid.index([x, y, z]);
        let mut nodes: Vec<usize> = product(&slices).chain(product(&volume)).map(index).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let (quantities, slices_z) = (quantities(&study.machine), shown.slices_z.clone());
        Self { slices_z, quantities, values: Vec::with_capacity(nodes.len()), nodes, volume, next: 0 }
    }

    /// Takes the next point, in grid order.
    pub fn add(&mut self, machine: &Machine, point: &MapPoint) {
        if self.nodes.get(self.values.len()) == Some(&self.next) {
            let value = |quantity: &Quantity| point.effect(quantity.source).and_then(|e| (quantity.value)(machine, e));
            self.values.push(self.quantities.iter().map(value).collect());
        }
        self.next += 1;
    }

    fn value(&self, study: &WorkspaceMapStudy, node: [usize; 3], quantity: usize) -> Option<f64> {
        let place = self.nodes.binary_search(&study.grid.index(node)).ok()?;
        self.values.get(place)?[quantity]
    }

    /// All pictures with their file stems: the answer, slices of every quantity, and the workspace in 3-D with the deflection under
    /// both sources. `summary` is that of the same points.
    pub fn figures(&self, study: &WorkspaceMapStudy, summary: &Summary) -> Vec<(String, Figure)> {
        let ends = summary.of(Source::All).and_then(|all| all.deflection.get()).map_or_else(Vec::new, Vec::from);
        let slices = |(k, quantity): (usize, &Quantity)| {
            (format!("slices_{}", quantity.file_stem), Figure::Slices(self.slices(study, k)))
        };
        let answer = ("answer".to_string(), Figure::Slices(self.answer(study, &ends)));
        let is_drawn = |(k, _): &(usize, &Quantity)| {
            let is_angle = self.quantities[*k].shading == Shading::Cyclic;
            // Without a cutting force there is no angle.
            !is_angle || ends.is_empty() || self.values.iter().any(|values| values[*k].is_some())
        };
        let all = self.quantities.iter().enumerate().filter(is_drawn).map(slices);
        let mut figures: Vec<(String, Figure)> = std::iter::once(answer).chain(all).collect();
        if study.grid.counts().iter().all(|&n| n > 1) {
            let name = format!("workspace_{}", self.quantities[IN_3D].file_stem);
            figures.push((name, Figure::Volume(self.volume(study, IN_3D))));
        }
        figures
    }

    fn slices(&self, study: &WorkspaceMapStudy, quantity: usize) -> SliceFigure {
        let value = |node| self.value(study, node, quantity);
        SliceFigure {
            title: self.quantities[quantity].title.clone(),
            subtitle: setting(study, self.quantities[quantity].source, &drawn_nodes(&study.grid, &self.slices_z)[..2]),
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: self.label(quantity),
            panels: panels(&study.machine, &study.grid, &self.slices_z, &value),
            range: None,
            contour: None,
            shading: self.quantities[quantity].shading,
            remark: if quantity == 0 { point_words::points(&study.machine) } else { String::new() },
            missing: "no solution".into(),
        }
    }

    /// The slices through the places where the tool is moved least and most; where nothing is solved, the lowest one.
    fn answer(&self, study: &WorkspaceMapStudy, ends: &[Found]) -> SliceFigure {
        let [columns, rows, planes] = &self.volume;
        let [xs, ys, zs] = &study.grid.axes;
        let plane = |at: &Found| {
            let gap = |&&k: &&usize| (zs[k] - at.position_mm[2]).abs();
            planes.iter().min_by(|a, b| gap(a).total_cmp(&gap(b))).copied()
        };
        let mut heights: Vec<usize> = ends.iter().filter_map(plane).collect();
        heights.dedup();
        if heights.is_empty() {
            heights.extend(planes.first());
        }
        let panel = |&k: &usize| {
            let here = ends.iter().zip(["least", "most"]).filter(|(at, _)| plane(at) == Some(k));
            let nodes = rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y, k]));
            SlicePanel {
                title: typographic(&format!("z = {:.2} mm", zs[k])),
                x: columns.iter().map(|&x| xs[x]).collect(),
                y: rows.iter().map(|&y| ys[y]).collect(),
                values: nodes.map(|node| self.value(study, node, IN_3D)).collect(),
                marks: here
                    .map(|(at, word)| Mark2 {
                        label: format!("{word} {}", millimetres(at.value, 3)),
                        x: at.position_mm[0],
                        y: at.position_mm[1],
                    })
                    .collect(),
            }
        };
        let drawn = &self.volume[..2];
        let line = study.tolerance_mm.map_or_else(String::new, |tolerance| format!("; line: tolerance {tolerance} mm"));
        SliceFigure {
            title: "Where the tool is moved least and most".into(),
            subtitle: setting(study, self.quantities[IN_3D].source, drawn) + &line,
            x_label: "x [mm]".into(),
            y_label: "y [mm]".into(),
            quantity: self.label(IN_3D),
            panels: heights.iter().map(panel).collect(),
            range: None,
            contour: study.tolerance_mm,
            shading: Shading::Ordered,
            remark: String::new(),
            missing: "no solution".into(),
        }
    }

    fn volume(&self, study: &WorkspaceMapStudy, quantity: usize) -> VolumeFigure {
        let points = &study.machine.points;
        let coordinates = |i: usize| self.volume[i].iter().map(|&k| study.grid.axes[i][k]).collect();
        VolumeFigure {
            title: format!("The workspace, coloured by {}", self.quantities[quantity].label),
            subtitle: setting(study, self.quantities[quantity].source, &self.volume),
            axis_labels: ["x [mm]".into(), "y [mm]".into(), "z [mm]".into()],
            quantity: self.label(quantity),
            axes: [0, 1, 2].map(coordinates),
            values: product(&self.volume).map(|node| self.value(study, node, quantity)).collect(),
            marks: points.iter().map(|p| Mark3 { label: p.name.clone(), position: p.position.into() }).collect(),
            range: None,
        }
    }

    fn label(&self, quantity: usize) -> String {
        let Quantity { label, unit, .. } = &self.quantities[quantity];
        format!("{label} [{unit}]")
    }
}

/// The quantity drawn in 3-D: the deflection under both sources.
const IN_3D: usize = 1;

/// All combinations of the indices, x fastest.
fn product([x, y, z]: &[Vec<usize>; 3]) -> impl Iterator<Item = [usize; 3]> {
    z.iter().flat_map(move |&k| y.iter().flat_map(move |&j| x.iter().map(move |&i| [i, j, k])))
}

/// The subtitle of a picture of what `source` does that shows the nodes with the indices `drawn` along the first axes.
fn setting(study: &WorkspaceMapStudy, source: Source, drawn: &[Vec<usize>]) -> String {
    let [nx, ny, nz] = study.grid.counts();
    let thinned = thinned_words(&study.grid, drawn);
    let MillingForce { radial, tangential, axial, .. } = study.force;
    let load = match source {
        Source::Weight => "without cutting force".into(),
        _ => format!(
            "worst of {}, force {radial} / {tangential} / {axial} N (radial / tangential / axial)",
            counted(study.phis.len(), "tool angle"),
        ),
    };
    let setting = format!("{}, {load}, grid {nx} × {ny} × {nz}{thinned}", study.machine.short_title());
    signed(&setting)
}
