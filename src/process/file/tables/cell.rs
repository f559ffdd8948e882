//! Checks the table `cell` of a process file: what stands around the workpiece or moves with it or with the tool.

use std::{cell::RefCell, sync::Arc};

use kinetostat_cell::{
    Body, BodyGrade, Mesh, Shape, pieces_of_mesh,
    spec::{BodySpec, ShapeSpec, check_pairs},
};
use nalgebra::{Isometry3, Point3, Vector3};
use serde::Deserialize;

use crate::{
    input::{Folder, Inputs, check::Check, error::Result},
    machine::Machine,
    process::{Process, file::spec::ProcessSpec, stock::StockRemoval, stock::StockShape, stock::is_tool},
    toolpath::Toolpath,
};

/// The table `cell`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellSpec {
    /// How far apart bodies are to be at least; 0 if not given.
    pub clearance_mm: Option<f64>,
    /// How the control moves where a program moves rapidly; not known if not given.
    pub rapid: Option<RapidMove>,
    /// Bodies besides those of the machine.
    #[serde(default)]
    pub body: Vec<CellBodySpec>,
    /// Pairs of bodies, by name, that may touch or overlap.
    #[serde(default)]
    pub may_touch: Vec<[String; 2]>,
}

/// A body of the cell.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellBodySpec {
    /// Its name in answers.
    pub name: String,
    /// What it moves with.
    pub on: CellFrame,
    /// How well it is known; assumed if not given.
    #[serde(default)]
    pub grade: BodyGrade,
    /// Its shapes, in that frame.
    pub shapes: Vec<ShapeSpec>,
}

/// How a control moves where a program moves rapidly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RapidMove {
    /// The tool tip on a straight line.
    Linear,
    /// All drives from where they stand to where they are to be at constant rates, at rest and in motion together.
    Joint,
    /// Each drive or axis at a rate of its own, so that some are there before others.
    PerAxis,
}

/// What a body of the cell moves with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellFrame {
    /// Nothing: it is given in the base frame O.
    Base,
    /// The workpiece carrier, or nothing without one: it is given in the frame in which the workpiece is placed.
    Table,
    /// The workpiece: it is given in W.
    Part,
    /// The platform or flange: it is given in platform axes, from P.
    Platform,
    /// The tool: it is given in the tool frame, from its tip, z along the tool towards the tip.
    Tool,
}

/// The table `cell`, checked, with the stock as a body.
#[derive(Debug, Clone)]
pub struct ProcessCell {
    /// How far apart bodies are to be at least, mm.
    pub clearance_mm: f64,
    /// How the control moves where a program moves rapidly; `None` where it is not known.
    pub rapid: Option<RapidMove>,
    /// Bodies besides those of the machine; their frames are not set.
    pub bodies: Vec<(CellFrame, Body)>,
    /// Number of them before those of the first tool of a path, which the cut holds against the stock.
    pub before_tool: usize,
    /// Index of the stock among them.
    pub stock: Option<usize>,
    /// Pairs of bodies that may touch or overlap.
    pub may_touch: Vec<[String; 2]>,
    /// The place of the table.
    pub check: Check,
}

/// Name of the stock as a body.
pub const PART: &str = "part";
/// Bodies at most: each is held against each of those that move otherwise.
const MAX_BODIES: usize = 500;
/// Convex pieces of a stock at most.
const PIECES: usize = 24;

/// Checks the table, and returns it with the files that it names; `None` where it is not given. Meshes are in `folder`.
pub(crate) fn cell(
    process: &ProcessSpec,
    stock: Option<&StockRemoval>,
    machine: &Machine,
    folder: &Folder,
    check: &Check,
) -> Result<(Option<Arc<ProcessCell>>, Inputs)> {
    let Some(spec) = &process.cell else { return Ok((None, Inputs::default())) };
    let check = check.key("cell");
    let inputs = RefCell::new(Inputs::default());
    let read = |name: &str| {
        let bytes = folder.bytes(name)?;
        let others = inputs.take();
        *inputs.borrow_mut() = others.and(Inputs::of_bytes(name, &bytes));
        Ok(bytes)
    };
    let mut names: Vec<String> = machine.listed_bodies().map(|(_, body)| body.name.clone()).collect();
    let mut bodies = Vec::new();
    for (name, bytes) in machine.body_files()? {
        let others = inputs.take();
        *inputs.borrow_mut() = others.and(Inputs::of_bytes(&name, &bytes));
    }
    if let Some(stock) = stock {
        let is_taken = |name: &&String| **name == PART || is_tool(name);
        if let Some(name) = names.iter().find(is_taken) {
            let problem = format!(
                "machine {} has a body \"{name}\", the name of the stock or its tool: expected another name there",
                machine.name
            );
            return check.fail(problem);
        }
        names.push(PART.into());
        let body = part(stock.shape()).or_else(|problem| check.root().key("stock").fail(problem))?;
        bodies.push((CellFrame::Part, body));
    }
    if spec.body.len() > MAX_BODIES {
        return check.key("body").fail(format!("expected at most {MAX_BODIES} bodies, got {}", spec.body.len()));
    }
    for (index, own) in spec.body.iter().enumerate() {
        let check = check.key("body").item(index);
        check.key("name").readable(&own.name)?;
        if stock.is_some() && (own.name == PART || is_tool(&own.name)) {
            let problem = format!("\"{}\" is the name of the stock or of a tool: expected another name", own.name);
            return check.key("name").fail(problem);
        }
        check.key("name").unique(&own.name, names.iter().map(String::as_str))?;
        names.push(own.name.clone());
        let spec = BodySpec { name: own.name.clone(), grade: own.grade, shapes: own.shapes.clone() };
        bodies.extend(spec.resolve(&own.name, 0, Some(&read), &check)?.map(|body| (own.on, body)));
    }
    let of_tools = if stock.is_some() { ", tool N, shank of tool N, holder of tool N" } else { "" };
    let is_name = |name: &String| names.contains(name) || stock.is_some() && is_tool(name);
    check_pairs(&spec.may_touch, &(names.join(", ") + of_tools), is_name, &check)?;
    let cell = ProcessCell {
        clearance_mm: check.key("clearance_mm").not_negative(spec.clearance_mm.unwrap_or(0.0))?,
        rapid: spec.rapid,
        stock: bodies.iter().position(|(_, body)| body.name == PART).filter(|_| stock.is_some()),
        before_tool: bodies.len(),
        bodies,
        may_touch: spec.may_touch.clone(),
        check,
    };
    Ok((Some(Arc::new(cell)), inputs.into_inner()))
}

impl ProcessCell {
    /// Returns the cell of `process` with the first tool of `path` among its bodies; `None` without a cell.
    pub(crate) fn along(process: &Process, path: &Toolpath) -> Option<Arc<Self>> {
        let mut cell = Self::clone(process.cell.as_ref()?);
        cell.bodies.truncate(cell.before_tool);
        // How high P is above the tip.
        let height_mm = process.machine.tool_tip.dot(&process.machine.tool_axes.column(2));
        let bodies = process.stock.iter().flat_map(|stock| stock.tool_bodies(path, height_mm));
        cell.bodies.extend(bodies.map(|body| (CellFrame::Tool, body)));
        Some(Arc::new(cell))
    }
}

/// Makes a body of the stock, which encloses the part at any time.
fn part(shape: &StockShape) -> std::result::Result<Body, String> {
    let shapes = match shape {
        StockShape::Box { min, max } => {
            let pose = Isometry3::translation(0.5 * (min.x + max.x), 0.5 * (min.y + max.y), 0.5 * (min.z + max.z));
            vec![Shape::Cuboid { pose, size_mm: max - min }]
        }
        StockShape::Cylinder { base, diameter_mm, height_mm } => {
            let ends_mm = [Point3::from(*base), Point3::from(base + Vector3::new(0.0, 0.0, *height_mm))];
            vec![Shape::Cylinder { ends_mm, radius_mm: 0.5 * diameter_mm }]
        }
        StockShape::Mesh(mesh) => {
            let corner = |index: u32| Point3::from(mesh.vertices[index as usize]);
            let triangles: Vec<[Point3<f64>; 3]> = mesh.triangles.iter().map(|own| own.map(corner)).collect();
            pieces_of_mesh(&triangles, PIECES).map_err(|fault| fault.to_string())?
        }
    };
    Body::new(PART, 0, BodyGrade::Enclosing, &shapes).map_err(|fault| fault.to_string())
}

impl From<Mesh> for crate::process::stock::StockMesh {
    fn from(Mesh { vertices, triangles }: Mesh) -> Self {
        Self { vertices: vertices.into_iter().map(|own| own.coords).collect(), triangles }
    }
}
