//! Checks the stock and the tools that cut it in a process file.

use std::{collections::BTreeMap, sync::Arc};

use kinetostat_cell::read_stl;
use kinetostat_removal::{RemovalError, Stock};
use serde::Deserialize;

use crate::{
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    process::{
        Process,
        file::{force::teeth, spec::ProcessSpec},
        part::FinishedPart,
        program_inputs,
        stock::{StickOut, StockMesh, StockRemoval, StockShape, StockToolSpec, cutter},
    },
    toolpath::{Sampling, ToolDescription, ToolShape},
};

/// The table `stock`: what is cut, in the frame of the workpiece.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StockSpec {
    /// A box along the axes of the workpiece.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxSpec>,
    /// A cylinder along z of the workpiece.
    pub cylinder: Option<CylinderSpec>,
    /// An STL file, beside the process file, of a closed surface; mm.
    pub mesh: Option<String>,
    /// An STL file, beside the process file, of what is to be left of it; mm.
    pub part: Option<String>,
    /// Programs, beside the process file, that have cut the stock before, in their order.
    #[serde(default)]
    pub after: Vec<String>,
    /// Largest cell of the field; a fortieth of the smallest tool's diameter if not given.
    pub cell_mm: Option<f64>,
    /// Natural frequencies of machine, tool and part.
    #[serde(default, rename = "natural_frequencies_Hz")]
    pub natural_frequencies_hz: Vec<f64>,
}

/// A box between two corners.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Least coordinates.
    pub min_mm: [f64; 3],
    /// Largest coordinates.
    pub max_mm: [f64; 3],
}

/// A cylinder along z.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderSpec {
    /// Centre of the lower end.
    pub base_mm: [f64; 3],
    /// Diameter.
    pub diameter_mm: f64,
    /// Height.
    pub height_mm: f64,
}

/// A cylinder about the axis of a tool that must not come into the stock.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolBodySpec {
    /// D.
    pub diameter_mm: f64,
    /// Height above the tip from which on it is there.
    pub from_mm: f64,
}

/// A tool of a program that cuts stock. What is not given, a comment of the program has to say.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolSpec {
    /// Its shape; flat if no comment says it either.
    pub shape: Option<ToolShape>,
    /// D.
    pub diameter_mm: Option<f64>,
    /// Corner radius of a bull nose.
    pub corner_radius_mm: Option<f64>,
    /// Point angle of a drill; 118 if no comment says it either.
    pub point_angle_deg: Option<f64>,
    /// Number of teeth.
    pub teeth: Option<u32>,
    /// Angle of the helix.
    pub helix_deg: Option<f64>,
    /// Tolerance of the surface that it makes, instead of that of the process.
    pub tolerance_mm: Option<f64>,
    /// Width of the zone of ISO 1101 in which that must be, in place of `tolerance_mm`.
    pub tolerance_zone_mm: Option<f64>,
    /// What is above its flutes.
    pub shank: Option<ToolBodySpec>,
    /// What holds it.
    pub holder: Option<ToolBodySpec>,
    /// Length from the holder to the tip.
    pub stick_out_mm: Option<f64>,
    /// Young's modulus.
    #[serde(rename = "youngs_modulus_N_per_mm2")]
    pub youngs_modulus_n_per_mm2: Option<f64>,
    /// Diameter of the cylinder that bends as the tool does; 0.8 of its own if not given.
    pub equivalent_diameter_mm: Option<f64>,
    /// Stiffness of spindle and holder across the tool; rigid if not given.
    #[serde(rename = "holder_N_per_mm")]
    pub holder_n_per_mm: Option<f64>,
}

/// Checks the stock with the tools that cut it, by number, and returns it with the file that it is read from; `None` where neither is given.
pub(crate) fn stock(
    process: &ProcessSpec,
    sampling: Sampling,
    folder: &Folder,
    check: &Check,
) -> Result<(Option<StockRemoval>, Inputs)> {
    let Some(spec) = &process.stock else {
        return match process.tools.keys().next() {
            Some(name) => check.key("tools").key(name).fail("has no effect without [stock]: expected that".into()),
            None => Ok((None, Inputs::default())),
        };
    };
    let check_stock = check.key("stock");
    let mut inputs = Inputs::default();
    let mut mesh = |name: &str, check: &Check| {
        let bytes = beside(name, folder, check)?.bytes(name)?;
        inputs = std::mem::take(&mut inputs).and(Inputs::of_bytes(name, &bytes));
        let mesh = read_stl(bytes).and_then(|own| {
            let own = StockMesh::from(own);
            let closed = Stock::mesh(own.vertices.clone(), own.triangles.clone());
            closed.map(|_| Arc::new(own)).map_err(|error| error.to_string())
        });
        mesh.or_else(|fault| check.fail(format!("{name}: {fault}")))
    };
    let shape = match (spec.cuboid, spec.cylinder, &spec.mesh) {
        (Some(BoxSpec { min_mm, max_mm }), None, None) => {
            let check = check_stock.key("box");
            let shape =
                StockShape::Box { min: check.key("min_mm").finite(min_mm)?, max: check.key("max_mm").finite(max_mm)? };
            shape.along_z().or_else(|error| check.fail(error.to_string()))?;
            shape
        }
        (None, Some(CylinderSpec { base_mm, diameter_mm, height_mm }), None) => {
            let check = check_stock.key("cylinder");
            let base = check.key("base_mm").finite(base_mm)?;
            let diameter_mm = check.key("diameter_mm").positive(diameter_mm)?;
            StockShape::Cylinder { base, diameter_mm, height_mm: check.key("height_mm").positive(height_mm)? }
        }
        (None, None, Some(name)) => StockShape::Mesh(mesh(name, &check_stock.key("mesh"))?),
        _ => return check_stock.fail("expected one of box, cylinder and mesh".into()),
    };
    let mut part = None;
    if let Some(name) = &spec.part {
        let check = check_stock.key("part");
        let own = FinishedPart::new(name.clone(), mesh(name, &check)?);
        own.check(&shape).or_else(|fault| check.fail(format!("{}: {fault}", own.name)))?;
        part = Some(own);
    }
    let mut by_number = BTreeMap::new();
    for (name, spec) in &process.tools {
        let check = check.key("tools").key(name);
        let Ok(number) = name.parse::<u32>() else {
            return check.fail("is no tool: expected the number of a tool, as after T in a program".into());
        };
        let stick_out = stick_out(spec, &check)?;
        let tolerance_mm = check.tolerance(spec.tolerance_mm, spec.tolerance_zone_mm)?;
        let body = |(name, body): (&'static str, Option<ToolBodySpec>)| {
            let ToolBodySpec { diameter_mm, from_mm } = body?;
            let check = check.key(name);
            let size = check.key("diameter_mm").length(diameter_mm);
            Some(size.and_then(|diameter_mm| Ok((name, diameter_mm, check.key("from_mm").length(from_mm)?))))
        };
        let bodies = [("shank", spec.shank), ("holder", spec.holder)].into_iter().filter_map(body);
        let bodies: Vec<(&str, f64, f64)> = bodies.collect::<Result<_>>()?;
        if let [(_, _, shank_mm), (_, _, holder_mm)] = bodies[..]
            && holder_mm <= shank_mm
        {
            let problem = format!("is {holder_mm}, and the shank begins at {shank_mm}: expected more");
            return check.key("holder").key("from_mm").fail(problem);
        }
        if let (Some(&(_, _, holder_mm)), Some(own)) = (bodies.iter().find(|own| own.0 == "holder"), stick_out)
            && holder_mm != own.length_mm
        {
            let problem =
                format!("is {holder_mm}, and stick_out_mm, up to the holder, {}: expected the same", own.length_mm);
            return check.key("holder").key("from_mm").fail(problem);
        }
        let own = StockToolSpec { shape: tool(number, spec, &check)?, bodies, stick_out, tolerance_mm };
        if by_number.insert(number, own).is_some() {
            return check.fail(format!("is tool {number} again"));
        }
    }
    let cell_mm = check_stock.key("cell_mm").optional_positive(spec.cell_mm)?;
    let frequencies = spec.natural_frequencies_hz.clone();
    Ok((Some(StockRemoval::new(shape, part, cell_mm, by_number, frequencies, sampling, check_stock)), inputs))
}

/// Returns the natural frequencies that the stock of `process` gives, Hz.
pub(crate) fn natural_frequencies_hz(process: &ProcessSpec) -> &[f64] {
    process.stock.as_ref().map_or(&[], |own| &own.natural_frequencies_hz)
}

/// Reads the programs that have cut the stock of `process` before.
pub(crate) fn with_earlier(
    mut process: Process,
    spec: Option<&StockSpec>,
    folder: &Folder,
    check: &Check,
) -> Result<Process> {
    let (mut earlier, mut inputs) = (Vec::new(), process.inputs.clone());
    for name in spec.iter().flat_map(|spec| &spec.after) {
        let folder = beside(name, folder, &check.key("stock").key("after"))?;
        let program = process.program_in_folder(&folder, name)?;
        let path = program.long_toolpath(process.sampling)?;
        let origin = folder.path(name).display().to_string();
        if path.is_empty() {
            return Err(Error::argument(origin, "moves nowhere: a program with at least one motion is expected"));
        }
        inputs = inputs.and(program_inputs(&program, name));
        earlier.push((origin, path));
    }
    process.inputs = inputs;
    process.stock = process.stock.map(|stock| stock.after(earlier));
    Ok(process)
}

/// Returns the folder, without recording for pages, which have no stock, if there is a file with this name.
fn beside(name: &str, folder: &Folder, check: &Check) -> Result<Folder> {
    match folder.has_file(name) {
        true => Ok(folder.unrecorded()),
        false => check.fail(format!("\"{name}\" is not a file in the folder of the process file")),
    }
}

impl StockShape {
    /// The stock where the tool points down along z, so that what makes none is found when it is read.
    fn along_z(&self) -> std::result::Result<Stock, RemovalError> {
        match self {
            StockShape::Box { min, max } => Stock::cuboid(*min, *max),
            StockShape::Cylinder { base, diameter_mm, height_mm } => Stock::cylinder(*base, *diameter_mm, *height_mm),
            StockShape::Mesh(mesh) => Stock::mesh(mesh.vertices.clone(), mesh.triangles.clone()),
        }
    }
}

fn tool(number: u32, spec: &ToolSpec, check: &Check) -> Result<ToolDescription> {
    let only = |key: &str, given: Option<f64>, shape: ToolShape, name: &str| match given {
        Some(_) if spec.shape != Some(shape) => {
            check.key(key).fail(format!("is of shape = \"{name}\": expected no such key"))
        }
        _ => Ok(()),
    };
    only("corner_radius_mm", spec.corner_radius_mm, ToolShape::BullNose, "bull_nose")?;
    only("point_angle_deg", spec.point_angle_deg, ToolShape::Drill, "drill")?;
    let tool = ToolDescription {
        number,
        line: None,
        shape: spec.shape.map(Ok),
        diameter_mm: check.key("diameter_mm").optional_positive(spec.diameter_mm)?,
        corner_radius_mm: spec
            .corner_radius_mm
            .map(|own| check.key("corner_radius_mm").not_negative(own))
            .transpose()?,
        point_angle_deg: check.key("point_angle_deg").optional_positive(spec.point_angle_deg)?,
        teeth: spec.teeth.map(|own| teeth(own, check)).transpose()?,
    };
    if let (Some(shape), Some(diameter_mm)) = (spec.shape, tool.diameter_mm)
        && (shape != ToolShape::BullNose || tool.corner_radius_mm.is_some())
    {
        cutter(shape, diameter_mm, &tool).or_else(|error| check.fail(error.to_string()))?;
    }
    Ok(tool)
}

/// Checks how a tool sticks out: all that its bend needs is given, or nothing.
fn stick_out(spec: &ToolSpec, check: &Check) -> Result<Option<StickOut>> {
    let others = [
        ("helix_deg", spec.helix_deg),
        ("youngs_modulus_N_per_mm2", spec.youngs_modulus_n_per_mm2),
        ("equivalent_diameter_mm", spec.equivalent_diameter_mm),
        ("holder_N_per_mm", spec.holder_n_per_mm),
    ];
    let Some(length_mm) = spec.stick_out_mm else {
        return match others.iter().find(|own| own.1.is_some()) {
            Some((key, _)) => check.key(key).fail("has no effect without stick_out_mm: expected that".into()),
            None => Ok(None),
        };
    };
    let [helix_deg, modulus] = [0, 1].map(|own| {
        let (key, given) = others[own];
        given.map_or_else(|| check.key(key).fail("missing: a tool with stick_out_mm bends by it".into()), Ok)
    });
    let helix_deg = check.key("helix_deg").not_negative(helix_deg?)?;
    if helix_deg >= 80.0 {
        return check.key("helix_deg").fail(format!("is {helix_deg}: expected from 0 to below 80"));
    }
    let holder = check.key("holder_N_per_mm").optional_positive(spec.holder_n_per_mm)?;
    Ok(Some(StickOut {
        length_mm: check.key("stick_out_mm").positive(length_mm)?,
        helix: helix_deg.to_radians(),
        modulus_N_per_mm2: check.key("youngs_modulus_N_per_mm2").positive(modulus?)?,
        equivalent_mm: check.key("equivalent_diameter_mm").optional_positive(spec.equivalent_diameter_mm)?,
        holder_mm_per_N: holder.map_or(0.0, |own| 1.0 / own),
    }))
}
