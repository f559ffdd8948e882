//! The stock as a path cuts it: where its tools are in material, and the force that this makes.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    sync::Arc,
};

use kinetostat_cell::{Body, BodyGrade, Shape};
use kinetostat_removal::{Cutter, Engagement, Field, Milling, RemovalError, Slicing, Spindle, Stock};
use nalgebra::{Matrix3, Point3, Vector3};

use super::part::FinishedPart;
use crate::{
    input::{
        check::Check,
        error::{Error, Result},
    },
    machine::Machine,
    process::{
        Bend, CutPath, Engaged, Extent, PathReference, PlacedWorkpiece, Placement, UnknownForce,
        cutting::{
            BY_END, CuttingLaw, Drilling, DrillingLaw, EngagedMilling, LEAST_HEADING, LoadError, PathLoad, Stub,
            is_drilling, lateral_share,
        },
    },
    toolpath::{Load, PathPoint, Sampling, ToolDescription, ToolShape, Toolpath, TurnDirection},
};

/// What is cut, in the frame of the workpiece, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum StockShape {
    /// A box along the axes of the workpiece.
    Box {
        /// Least coordinates.
        min: Vector3<f64>,
        /// Largest coordinates.
        max: Vector3<f64>,
    },
    /// A cylinder along z of the workpiece.
    Cylinder {
        /// Centre of the lower end.
        base: Vector3<f64>,
        /// Diameter.
        diameter_mm: f64,
        /// Height.
        height_mm: f64,
    },
    /// The inside of a closed surface.
    Mesh(Arc<StockMesh>),
}

/// A surface of triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StockMesh {
    /// Corners of triangles.
    pub vertices: Vec<Vector3<f64>>,
    /// Numbers of the corners of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A tool that cuts stock.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StockTool {
    /// Its shape; of a tool that is refused, the cylinder that it is in.
    pub cutter: Cutter,
    /// Number of its teeth, or what is said where it is needed.
    teeth: std::result::Result<u32, String>,
    /// Why it cannot cut.
    refused: Option<String>,
    /// How it bends in itself; `None`: not at all.
    stub: Option<Stub>,
    /// Its shank and holder as cutters, by name, and how high their ends are above its tip, mm.
    bodies: Vec<(&'static str, Cutter, f64)>,
}

/// What the process file says of a tool.
#[derive(Debug, Clone)]
pub(super) struct StockToolSpec {
    pub shape: ToolDescription,
    /// What must not come into the stock: name, diameter and height above the tip from which on it is there, mm.
    pub bodies: Vec<(&'static str, f64, f64)>,
    pub stick_out: Option<StickOut>,
    /// Tolerance of the surface that it makes, mm; `None`: that of the process.
    pub tolerance_mm: Option<f64>,
}

/// How a tool sticks out of its holder.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct StickOut {
    /// Length from the holder to the tip, mm.
    pub length_mm: f64,
    /// Angle of the helix, rad.
    pub helix: f64,
    /// Young's modulus, N/mm².
    pub modulus_N_per_mm2: f64,
    /// Diameter of the cylinder that bends as the tool does, mm; `None`: 0.8 of its own.
    pub equivalent_mm: Option<f64>,
    /// Displacement of the holder for each N across it, mm/N.
    pub holder_mm_per_N: f64,
}

/// Diameter of the cylinder that bends as the flutes of an end mill do, as a share of theirs; see [`Stub`].
const EQUIVALENT: f64 = 0.8;

impl StickOut {
    fn stub(&self, diameter_mm: f64) -> Stub {
        let equivalent_mm = self.equivalent_mm.unwrap_or(EQUIVALENT * diameter_mm);
        Stub {
            stick_out_mm: self.length_mm,
            rigidity_Nmm2: self.modulus_N_per_mm2 * std::f64::consts::PI * equivalent_mm.powi(4) / 64.0,
            holder_mm_per_N: self.holder_mm_per_N,
            lag_per_mm: 2.0 * libm::tan(self.helix) / diameter_mm,
        }
    }
}

/// The stock, the tools that cut it, and the programs that have cut it before.
#[derive(Debug, Clone)]
#[allow(non_snake_case, reason = "the unit is Hz, not hz")]
pub struct StockRemoval {
    shape: StockShape,
    cell_mm: Option<f64>,
    tools: BTreeMap<u32, StockToolSpec>,
    natural_frequencies_Hz: Vec<f64>,
    /// Of the paths that cut it.
    sampling: Sampling,
    check: Check,
    /// What is to be left of it, if that is known.
    pub(super) part: Option<FinishedPart>,
    /// Names and paths of the programs that have cut it.
    pub(super) earlier: Arc<[(String, Toolpath)]>,
}

/// Cells over the diameter of the smallest tool, if no cell is given.
const CELLS: f64 = 40.0;
/// Slices of a corner, a ball or a point: with them the volume of a pass of a ball is within half a per cent.
const NOSE_SLICES: u32 = 16;
/// Most slices of the side of a tool in a high stock.
const MAX_SLICES: f64 = 400.0;
/// Ways shorter than this are none: what is met by them is within what counts as touched, mm.
pub(crate) const LEAST_WAY: f64 = 1e-5;
/// A way that rises or falls by less is level, mm: it does so by rounding.
const LEVEL_MM: f64 = 1e-9;
/// A rapid move may come so near into material: programs round, mm.
const FREE_MM: f64 = 0.02;
/// Most memory for a field, bytes.
const MAX_BYTES: usize = 4 << 30;
/// Largest bend of a tool, as a share of its radius: one that bends more is given wrongly, or breaks.
const MAX_BEND: f64 = 0.1;
/// A tooth passing frequency is near a natural one within this ratio.
const NEAR: f64 = 1.2;
/// The direction in a point belongs to the way there if it is within 45° of it, as the cosine: an arc turns by less in a step.
const ALONG: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// A tool that leans by less is parallel to the one before, as the sine of the angle: programs give angles with so many digits.
const PARALLEL: f64 = 1e-5;

/// Point angle of a drill if none is given, degrees.
const POINT_ANGLE_DEG: f64 = 118.0;
/// The peak of a force is looked for where its mean is so many times larger than before.
const LARGER: f64 = 1.02;
/// Point angles that differ by less are one, degrees.
const SAME_ANGLE_DEG: f64 = 0.5;
const LIPS: u32 = 2;
/// A drill that removes this share of its area is in solid material: a hole of a thirtieth of its diameter takes as much of the rest.
const SOLID: f64 = 1.0 - 1e-3;
/// A mesh so small is in metres where a path is so long, mm.
const METRES_MM: [f64; 2] = [1.0, 50.0];
/// Length of what of a tool is there for certain where its end is not known, mm.
const END_MM: f64 = 1.0;

/// Returns the name of a body of a tool: `part` is "", "shank of " or "holder of ".
fn tool_name(part: &str, number: u32) -> String {
    format!("{part}tool {number}")
}

/// Whether a body of that name is a tool's.
pub(super) fn is_tool(name: &str) -> bool {
    let number = name.rsplit(' ').next().and_then(|own| own.parse().ok());
    number.is_some_and(|number| ["", "shank of ", "holder of "].iter().any(|part| tool_name(part, number) == name))
}

/// Axes of a field of removal in W, its rows: z to the spindle.
type Axes = Matrix3<f64>;
/// The tools of a path, by number, or what is wrong with one, which is said where it is needed.
pub(super) type Tools = BTreeMap<Option<u32>, std::result::Result<StockTool, String>>;

impl StockRemoval {
    /// Returns what is cut, in the frame of the workpiece.
    pub(super) fn shape(&self) -> &StockShape {
        &self.shape
    }

    /// Creates the stock of a `shape` with its largest cell, for paths sampled so.
    pub(super) fn new(
        shape: StockShape,
        part: Option<FinishedPart>,
        cell_mm: Option<f64>,
        tools: BTreeMap<u32, StockToolSpec>,
        frequencies: Vec<f64>,
        sampling: Sampling,
        check: Check,
    ) -> Self {
        let earlier = Arc::new([]);
        Self { shape, cell_mm, tools, natural_frequencies_Hz: frequencies, sampling, check, part, earlier }
    }

    /// Returns the same stock, which the paths of these programs, by name, have cut before, in their order.
    pub(super) fn after(self, earlier: Vec<(String, Toolpath)>) -> Self {
        Self { earlier: earlier.into(), ..self }
    }

    /// Returns cutter, shank and holder of the first tool of `path` as bodies in its frame, each up to where the next begins, the last up to `height_mm`, where P is.
    /// One whose end is not known, as of a cutter alone, what begins beyond P or a holder that is not given, is its lower end, assumed: such a holder from
    /// where the tool sticks out to, or at P.
    pub(super) fn tool_bodies(&self, path: &Toolpath, height_mm: f64) -> Vec<Body> {
        let number = path.points().iter().find_map(|point| point.tool).or_else(|| self.only_tool());
        let found = number.and_then(|number| Some((number, self.tool(Some(number), path.tools()).ok()?)));
        let Some((number, tool)) = found else { return Vec::new() };
        let is_alone = tool.bodies.is_empty();
        let mut parts = vec![(tool_name("", number), tool.cutter, 0.0)];
        parts.extend(
            tool.bodies.iter().map(|(name, own, from)| (tool_name(&format!("{name} of "), number), *own, *from)),
        );
        let is_held = tool.bodies.iter().any(|own| own.0 == "holder");
        let stick_out_mm = tool.stub.map(|own| own.stick_out_mm);
        if !is_held && (stick_out_mm.is_some() || !is_alone) {
            let (_, within, above_mm) = parts[parts.len() - 1];
            let from_mm = stick_out_mm.unwrap_or(height_mm - END_MM).max(above_mm);
            parts.push((tool_name("holder of ", number), within, from_mm));
        }
        let body = |k: usize| {
            let (name, cutter, from) = &parts[k];
            let next = parts.get(k + 1).map(|next| next.2);
            let is_known = !is_alone && (is_held || next.is_some()) && next.unwrap_or(height_mm) > *from;
            let (radius_mm, nose) = (cutter.radius_mm(), if k == 0 { cutter.nose_height_mm() } else { 0.0 });
            let is_ball = k == 0 && Cutter::ball(2.0 * radius_mm).is_ok_and(|ball| ball == *cutter);
            // Only above its nose a cutter is certain to be as wide as it is.
            let from = if is_known { *from } else { from + nose };
            let end = if is_known { next.unwrap_or(height_mm) } else { next.unwrap_or(0.0).max(from + END_MM) };
            let ends_mm = if is_ball { [nose, end.max(nose)] } else { [from, end] };
            let ends_mm = ends_mm.map(|height| Point3::new(0.0, 0.0, -height));
            let round =
                if is_ball { Shape::Capsule { ends_mm, radius_mm } } else { Shape::Cylinder { ends_mm, radius_mm } };
            let grade = match nose {
                _ if !is_known => BodyGrade::Assumed,
                _ if is_ball || nose == 0.0 => BodyGrade::Given,
                // A cylinder encloses other noses.
                _ => BodyGrade::Enclosing,
            };
            Body::new(name.clone(), 0, grade, &[round]).ok()
        };
        (0..parts.len()).filter_map(body).collect()
    }

    /// Returns the tolerance of the surface that the tool with this number makes, the only one where no number is given, mm; `None` if it has none of its own.
    pub fn tolerance_mm(&self, number: Option<u32>) -> Option<f64> {
        self.tools.get(&number.or_else(|| self.only_tool())?)?.tolerance_mm
    }

    /// Returns the number of its tool, if it has one alone.
    fn only_tool(&self) -> Option<u32> {
        self.tools.keys().next().copied().filter(|_| self.tools.len() == 1)
    }

    /// Returns the least and largest frequency at which teeth pass on `path`, which cuts the stock, Hz; `None` where the spindle speed is not known.
    pub(super) fn teeth_hz(&self, path: &CutPath) -> Option<[f64; 2]> {
        let tools = self.tools_of(path);
        let at = |(point, engaged): (&PathPoint, &Engaged)| {
            let speed = point.spindle_rev_per_min.filter(|_| engaged.removed_mm2 > 0.0)?;
            let teeth = tools[&point.tool].as_ref().ok()?.teeth.as_ref().ok()?;
            Some(speed / 60.0 * f64::from(*teeth))
        };
        let all = path.points().iter().zip(path.engagements()).filter_map(at);
        all.fold(None, |ends, own| Some(ends.map_or([own; 2], |[low, high]: [f64; 2]| [low.min(own), high.max(own)])))
    }

    /// Returns in words how often teeth pass on `path`, which cuts the stock, and what is near; `None` where the spindle speed is not known. The second is a caution.
    pub fn tooth_passing(&self, path: &CutPath) -> Option<(String, Option<String>)> {
        let [low, high] = self.teeth_hz(path)?;
        let range = if low == high { format!("{low:.0} Hz") } else { format!("{low:.0} to {high:.0} Hz") };
        let own = &self.natural_frequencies_Hz;
        let near = own.iter().find(|own| low < NEAR * **own && **own < NEAR * high).map(|own| {
            format!("Teeth pass at {range}, near the natural frequency of {own} Hz: vibration may be far larger than the deflection told here.\n")
        });
        let given = if own.is_empty() {
            "dynamics not considered: no natural frequency is given"
        } else {
            "static: dynamics not considered"
        };
        Some((format!("{range}; {given}"), near))
    }

    /// Fails where the tool is not along z of the workpiece, so that another place of the part may be another cut.
    ///
    /// # Errors
    /// Such a placement, by the key of the stock.
    pub fn check_movable(&self, machine: &Machine, placement: &Placement) -> Result<()> {
        let axis = placement.place(machine).tool_axes().column(2).into_owned();
        if axis.xy().norm() <= PARALLEL {
            return Ok(());
        }
        let problem = "is cut along one direction of the tool, which another place of the workpiece would change: expected a tool along z of the workpiece, or no [stock]";
        self.check.fail(problem.into())
    }

    /// Returns `path` as it cuts the stock, with the load of an [`EngagedMilling`] law at points on whose way material is touched, and how it is touched
    /// ([`CutPath::engagements`]). `law` gives the law of a point; `origin` names the path in errors; `done` is called for each point.
    ///
    /// # Errors
    /// A tool that is not known, or leans, or is a drill of another diameter than its law; a rapid move through material, a start in it, a path that touches none; loads that come with the path; a feed or a
    /// spindle speed that the law needs and is not there; a field too large. The same of programs that cut before, but for loads.
    pub(super) fn cut<'a>(
        &self,
        path: Toolpath,
        machine: &Machine,
        placement: &Placement,
        law: impl Fn(&PathPoint) -> &'a CuttingLaw,
        origin: &str,
        done: &mut dyn FnMut(),
    ) -> Result<CutPath> {
        if placement.reference != PathReference::ToolTip {
            let problem = "is cut by the tool tip, and the path is of the platform point: expected placement.reference = \"tool_tip\"";
            return self.check.fail(problem.into());
        }
        if let Some((number, _)) =
            self.tools.iter().find(|own| own.1.stick_out.is_some() && machine.tool_compliance.is_some())
        {
            let problem =
                format!("is given in tools.{number}, and the tool of the machine bends, too: expected one of both");
            return self.check.key("stick_out_mm").fail(problem);
        }
        let placed = placement.place(machine);
        if path.is_empty() {
            return Ok(path.into());
        }
        let axes = self.axes_along(&path, &placed);
        let mut cutting = self.cutting_before(&path, axes, &placed)?;
        self.follow(&mut cutting, &path, origin, &placed, law, done)
    }

    /// Returns `path` as it cuts the stock with its tool at `shifts` (W, mm) from its points, which stay where they are: otherwise as [`StockRemoval::cut`], but that rapid moves and
    /// bodies of tools may come into material, as they do where the tool has left some.
    ///
    /// # Errors
    /// As there.
    pub(super) fn cut_shifted<'a>(
        &self,
        path: &Toolpath,
        placed: &PlacedWorkpiece,
        shifts: &[Vector3<f64>],
        law: impl Fn(&PathPoint) -> &'a CuttingLaw,
        origin: &str,
    ) -> Result<CutPath> {
        let mut cutting = self.cutting_before(path, self.axes_along(path, placed), placed)?;
        cutting.is_checked = false;
        let shifted = path.points().iter().zip(shifts);
        let shifted =
            shifted.map(|(point, shift)| PathPoint { position_mm: point.position_mm + shift, load: None, ..*point });
        let shifted = Toolpath::assemble(shifted.collect()).with_tools(path.tools().to_vec());
        let cut = self.follow(&mut cutting, &shifted, origin, placed, law, &mut || ())?;
        let points = path.points().iter().zip(cut.points());
        let points = points.map(|(point, cut)| PathPoint { load: cut.load, ..*point }).collect();
        let own = Toolpath::assemble(points).with_tools(path.tools().to_vec());
        Ok(CutPath::new(own, cut.engagements().to_vec()))
    }

    /// Returns the stock for `path` as the programs before have left it.
    fn cutting_before(&self, path: &Toolpath, axes: Axes, placed: &PlacedWorkpiece) -> Result<Cutting> {
        let mut cutting = Cutting::new(self.field(&axes, path)?, axes, FREE_MM + self.sampling.chordal_tolerance_mm());
        for (origin, path) in self.earlier.iter() {
            self.follow(&mut cutting, path, origin, placed, |_| &CuttingLaw::None, &mut || ())?;
        }
        Ok(cutting)
    }

    /// Returns `path` as it cuts what there is; see [`StockRemoval::cut`].
    fn follow<'a>(
        &self,
        cutting: &mut Cutting,
        path: &Toolpath,
        origin: &str,
        placed: &PlacedWorkpiece,
        law: impl Fn(&PathPoint) -> &'a CuttingLaw,
        done: &mut dyn FnMut(),
    ) -> Result<CutPath> {
        if let [first, ..] = path.external_axes() {
            let problem = format!("is cut along one direction of the tool, and {origin} commands {first}");
            return self.check.fail(problem);
        }
        if path.points().iter().any(|point| point.load.is_some()) {
            return Err(Error::argument(origin, LoadError::UnusedLoads { other_law: true }.to_string()));
        }
        let tools = self.tools_of(path);
        let mut points = path.points().to_vec();
        let mut engagements = vec![Engaged::default(); points.len()];
        for k in 0..points.len() {
            done();
            let to = points[k];
            if cutting.leans(&axes_of(placed, &to)) {
                let problem = "tilts the tool, and stock is cut along one direction of it: expected one orientation, or no [stock]";
                return Err(fault(origin, &to, problem));
            }
            let tool = tools[&to.tool].as_ref().map_err(String::clone);
            if k == 0 {
                cutting.begin(tool, &to.position_mm).map_err(|problem| fault(origin, &to, &problem))?;
                continue;
            }
            let mut way = cutting.axes * to.position_mm - cutting.at;
            if way.z.abs() < LEVEL_MM {
                way.z = 0.0;
            }
            if way.norm() < LEAST_WAY {
                // It stays in what it met.
                if to.cutting {
                    (points[k].load, engagements[k]) = (points[k - 1].load, engagements[k - 1]);
                }
                continue;
            }
            if is_unknown_way(&points[k - 1], &to) {
                cutting.begin(tool, &to.position_mm).map_err(|problem| fault(origin, &to, &problem))?;
                continue;
            }
            let found = match is_rapid(&to) {
                true => cutting.pass(tool, &way).map(|()| None),
                false => tool.and_then(|tool| cutting.feed(tool, &way, &to, law(&to))),
            };
            let (load, engaged) = found.map_err(|problem| fault(origin, &to, &problem))?.unwrap_or_default();
            points[k].load = load.filter(|_| to.cutting);
            engagements[k] = engaged;
        }
        if cutting.is_checked && engagements.iter().all(|own| own.removed_mm2 == 0.0) {
            let problem = "nothing touches the stock: expected it where the tool goes, in the frame of the program";
            return Err(Error::argument(origin, problem));
        }
        let cut = Toolpath::assemble(points).with_tools(path.tools().to_vec());
        Ok(CutPath::new(cut, engagements))
    }

    /// Returns the axes of a field that `path` cuts, in W.
    pub(super) fn axes_along(&self, path: &Toolpath, placed: &PlacedWorkpiece) -> Axes {
        path.points().first().map_or_else(Axes::identity, |first| axes_of(placed, first))
    }

    /// Returns the tools with which `path` moves.
    pub(super) fn tools_of(&self, path: &Toolpath) -> Tools {
        let mut tools = Tools::new();
        for point in path.points() {
            if let Entry::Vacant(place) = tools.entry(point.tool) {
                place.insert(self.tool(point.tool, path.tools()));
            }
        }
        tools
    }

    /// Returns the tool with this number, the only one where no number is given, of which `comments` say more. `Err` says what is wrong.
    fn tool(&self, number: Option<u32>, comments: &[ToolDescription]) -> std::result::Result<StockTool, String> {
        let mut numbers: Vec<u32> = self.tools.keys().copied().chain(comments.iter().map(|own| own.number)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let number = match (number, numbers.as_slice()) {
            (Some(number), _) | (None, &[number]) => number,
            (None, []) => return Err("cuts with a tool that is not known: expected it, such as [tools.1]".into()),
            _ => return Err("does not say which tool cuts: expected T before it, or a single tool in [tools]".into()),
        };
        let own = self.tools.get(&number);
        let sources = own.map(|own| &own.shape).into_iter().chain(comments.iter().filter(|own| own.number == number));
        let sources: Vec<&ToolDescription> = sources.collect();
        let mut tool = match sources.first() {
            Some(first) => (*first).clone(),
            None => return Err(format!("is of tool {number}, whose geometry is not known: expected [tools.{number}]")),
        };
        for (k, source) in sources.iter().enumerate() {
            if let Err(what) = tool.merge(source) {
                let other = sources[..k].iter().find(|own| ToolDescription::clone(own).merge(source).is_err());
                let (a, b) = (other.map_or_else(|| tool.text(), |own| own.text()), source.text());
                return Err(format!("is of tool {number}, {a}, and {b}: expected the same {what}"));
            }
        }
        let said: Vec<String> = sources.iter().map(|own| own.text()).collect();
        let missing = |what: &str, key: &str| {
            format!(
                "is of tool {number}, {}, whose {what} is not known: expected tools.{number}.{key}",
                said.join(", ")
            )
        };
        let diameter_mm = tool.diameter_mm.ok_or_else(|| missing("diameter", "diameter_mm"))?;
        let teeth = tool.teeth.ok_or_else(|| missing("number of teeth", "teeth"));
        let is_commented = sources.iter().any(|own| own.line.is_some());
        let shape = match tool.shape {
            Some(Ok(shape)) => shape,
            None if is_commented => return Err(missing("shape", "shape")),
            None => ToolShape::Flat,
            Some(Err(_)) => {
                let refused = format!("is of tool {number}, {}, which stock cannot be cut with", said.join(", "));
                let cutter = cutter(ToolShape::Flat, diameter_mm, &tool).map_err(|error| error.to_string())?;
                return Ok(StockTool { cutter, teeth, refused: Some(refused), stub: None, bodies: Vec::new() });
            }
        };
        if shape == ToolShape::BullNose && tool.corner_radius_mm.is_none() {
            return Err(missing("corner radius", "corner_radius_mm"));
        }
        let described = || format!("is of tool {number}, {}", said.join(", and "));
        if tool.is_of_other_shape_than(shape, diameter_mm) {
            return Err(format!("{}: expected the same shape", described()));
        }
        let cutter = cutter(shape, diameter_mm, &tool).map_err(|error| format!("{}: {error}", described()))?;
        let stub = own.and_then(|own| own.stick_out).map(|own| own.stub(diameter_mm));
        if stub.is_some() && shape == ToolShape::Drill {
            return Err(format!(
                "{}: expected no tools.{number}.stick_out_mm, which is of tools that make walls",
                described()
            ));
        }
        let body = |&(name, diameter_mm, from_mm): &(&'static str, f64, f64)| {
            Cutter::flat(diameter_mm)
                .map(|own| (name, own, from_mm))
                .map_err(|error| format!("{}: {error}", described()))
        };
        let bodies = own.iter().flat_map(|own| &own.bodies).map(body).collect::<std::result::Result<_, _>>()?;
        Ok(StockTool { cutter, teeth, refused: None, stub, bodies })
    }

    /// Fails for a mesh or a part that seems to be in metres, from the length of the path that cuts it.
    fn check_unit(&self, path: &Toolpath) -> Result<()> {
        let mesh = if let StockShape::Mesh(mesh) = &self.shape { Some(("mesh", mesh)) } else { None };
        let meshes = mesh.into_iter().chain(self.part.iter().map(|part| ("part", &part.mesh)));
        let size = |places: &mut dyn Iterator<Item = Vector3<f64>>| {
            Extent::around(places).map_or(0.0, |extent| (extent.max - extent.min).amax())
        };
        let along = size(&mut path.positions_mm().into_iter());
        for (key, mesh) in meshes {
            let large = size(&mut mesh.vertices.iter().copied());
            if large <= METRES_MM[0] && along > METRES_MM[1] {
                let problem = format!("is {large:.3} mm large, and the path {along:.0} mm: expected mm, not metres");
                return self.check.key(key).fail(problem);
            }
        }
        Ok(())
    }

    /// Returns the uncut stock in axes of the field, for `path` and the programs before.
    ///
    /// # Errors
    /// A mesh or part in metres, a path sampled too coarsely, a stock that lies askew, a field too large.
    pub(super) fn field(&self, axes: &Axes, path: &Toolpath) -> Result<Field> {
        let (stock, cell_mm, _) = self.uncut(axes, path)?;
        Field::new(stock, cell_mm).or_else(|error| self.check.fail(error.to_string()))
    }

    /// Returns the size of the cells, mm, and the memory that the field of the stock takes at most for `path` of `machine`, bytes.
    ///
    /// # Errors
    /// Those of the stock for this path.
    pub fn field_size(&self, path: &Toolpath, machine: &Machine, placement: &Placement) -> Result<(f64, u64)> {
        let (_, cell_mm, bytes) = self.uncut(&self.axes_along(path, &placement.place(machine)), path)?;
        Ok((cell_mm, bytes as u64))
    }

    /// Returns the uncut stock, the size of its cells, mm, and the memory that its field takes at most, bytes.
    fn uncut(&self, axes: &Axes, path: &Toolpath) -> Result<(Stock, f64, usize)> {
        self.check_unit(path)?;
        let paths = || self.earlier.iter().map(|own| &own.1).chain([path]);
        let moves = paths().map(Toolpath::len).sum();
        let feeds = paths().flat_map(|path| {
            let tools = self.tools_of(path);
            let feeds = path.points().iter().filter(|point| !is_rapid(point));
            feeds.filter_map(|point| Some(tools[&point.tool].as_ref().ok()?.cutter.radius_mm())).collect::<Vec<_>>()
        });
        let smallest_mm = feeds.fold(f64::INFINITY, f64::min);
        let longest_mm = smallest_mm.max(Sampling::default().max_segment_mm());
        if self.sampling.max_segment_mm() > longest_mm {
            let problem = format!(
                "is {}: expected at most {longest_mm}, half the diameter of the smallest tool, as [stock] is cut from point to point",
                self.sampling.max_segment_mm()
            );
            return Err(Error::argument("sampling.max_segment_mm", problem));
        }
        let stock = match &self.shape {
            StockShape::Box { min, max } => {
                if axes.iter().any(|own| own.abs() > PARALLEL && (own.abs() - 1.0).abs() > PARALLEL) {
                    let problem = "stands along axes of the workpiece, and the tool is along none of them";
                    return self.check.key("box").fail(problem.into());
                }
                let [a, b] = [axes * min, axes * max];
                Stock::cuboid(a.inf(&b), a.sup(&b))
            }
            &StockShape::Cylinder { base, diameter_mm, height_mm } => {
                if libm::hypot(axes[(2, 0)], axes[(2, 1)]) > PARALLEL {
                    let problem = "stands along z of the workpiece, and the tool is not along it";
                    return self.check.key("cylinder").fail(problem.into());
                }
                let end = base + Vector3::z() * if axes[(2, 2)] < 0.0 { height_mm } else { 0.0 };
                Stock::cylinder(axes * end, diameter_mm, height_mm)
            }
            StockShape::Mesh(mesh) => {
                Stock::mesh(mesh.vertices.iter().map(|own| axes * own).collect(), mesh.triangles.clone())
            }
        };
        let wrong = |error: RemovalError| self.check.fail(error.to_string());
        let stock = stock.or_else(wrong)?;
        let (low, high) = stock.bounds();
        let cell_mm = self.cell_mm.unwrap_or(2.0 * smallest_mm.min((high - low).norm()) / CELLS);
        let bytes = Field::memory_bytes(&stock, cell_mm, moves);
        let bytes = bytes.or_else(|error| self.check.key("cell_mm").fail(error.to_string()))?;
        if bytes > MAX_BYTES {
            let problem = format!(
                "takes {:.1} GB with cells of {cell_mm} mm{}: expected at most {:.0} GB, by larger cells",
                bytes as f64 / 1e9,
                if self.cell_mm.is_none() { ", a fortieth of the smallest tool's diameter" } else { "" },
                MAX_BYTES as f64 / 1e9
            );
            return self.check.key("cell_mm").fail(problem);
        }
        Ok((stock, cell_mm, bytes))
    }
}

/// A path that cuts stock, as far as it has come.
struct Cutting {
    field: Field,
    slicing: Slicing,
    engagement: Engagement,
    axes: Axes,
    /// Where the tip is, in axes of the field.
    at: Vector3<f64>,
    /// Volume removed for each mm where it was engaged last, mm².
    removed_mm2: f64,
    free_mm: f64,
    /// Largest mean force whose peak within a turn was looked for, N.
    largest_mean: f64,
    /// Whether rapid moves and bodies of tools are refused in material.
    is_checked: bool,
}

/// A tool, or what is wrong with its number.
type Known<'a> = std::result::Result<&'a StockTool, String>;

impl Cutting {
    /// The uncut stock with these axes, into which rapid moves may come by `free_mm`.
    fn new(field: Field, axes: Axes, free_mm: f64) -> Self {
        let (low, high) = field.stock().bounds();
        let slice_mm = ((high.z - low.z) / MAX_SLICES).max(Slicing::default().slice_mm);
        let slicing = Slicing { nose_slices: NOSE_SLICES, slice_mm, ..Slicing::default() };
        let (engagement, at) = (Engagement::default(), Vector3::zeros());
        Self { field, slicing, engagement, axes, at, removed_mm2: 0.0, free_mm, largest_mean: 0.0, is_checked: true }
    }

    /// Puts the tip where the path begins, or goes on after a way that is not known. `Err` if the tool is in the stock there.
    fn begin(&mut self, tool: Known<'_>, position: &Vector3<f64>) -> std::result::Result<(), String> {
        self.at = self.axes * position;
        if !self.is_checked || self.at.z >= self.field.stock().bounds().1.z {
            return Ok(());
        }
        let cutter = &tool?.cutter;
        match self.field.first_in_way(cutter, &self.at, &self.at, self.free_mm).map_err(|error| error.to_string())? {
            Some(_) => Err(
                "begins with the tool in the stock: expected a start beside or above it, on the side of the spindle"
                    .into(),
            ),
            None => Ok(()),
        }
    }

    /// Whether a tool with these axes of the field stands in another direction.
    fn leans(&self, axes: &Axes) -> bool {
        axes.row(2).transpose().cross(&self.axes.row(2).transpose()).norm() > PARALLEL
    }

    /// Moves the tip by `way` without cutting. `Err` says where the tool goes through material.
    fn pass(&mut self, tool: Known<'_>, way: &Vector3<f64>) -> std::result::Result<(), String> {
        let from = self.at;
        self.at += way;
        self.removed_mm2 = 0.0;
        let (low, high) = self.field.stock().bounds();
        if !self.is_checked || from.z.min(self.at.z) >= high.z {
            return Ok(());
        }
        let tool = tool?;
        self.check_bodies(tool, &from, &self.at)?;
        let refused = |error: RemovalError| error.to_string();
        let mut met = self.field.first_in_way(&tool.cutter, &from, &self.at, self.free_mm).map_err(refused)?;
        // Columns see what is wider than a cell; the surface is asked for the rest where the tool may be in material.
        let reach = Vector3::new(tool.cutter.radius_mm(), tool.cutter.radius_mm(), 0.0);
        let (first, last) = (from.inf(&self.at) - reach, from.sup(&self.at) + reach);
        let is_beside = first.x >= high.x || first.y >= high.y || last.x <= low.x || last.y <= low.y;
        if let (None, false, Some((inside, up))) = (met, is_beside, tool.cutter.inside(self.free_mm)) {
            let pieces = (way.norm() / (0.5 * tool.cutter.radius_mm())).ceil().max(1.0);
            for piece in 1..=pieces as u32 {
                let at = from + way * (f64::from(piece) / pieces) + up * Vector3::z();
                self.field.engage(&inside, &at, way, &self.slicing, &mut self.engagement).map_err(refused)?;
                if !self.engagement.is_air() {
                    met = Some(at);
                    break;
                }
            }
        }
        let Some(met) = met else { return Ok(()) };
        let [x, y, z]: [f64; 3] = (self.axes.transpose() * met).into();
        Err(format!(
            "is rapid and goes through the stock at ({x:.2}, {y:.2}, {z:.2}) mm: expected a feed there, or a stock without it"
        ))
    }

    /// `Err` if the shank or the holder of the tool is in the stock while its tip moves from one point to another.
    fn check_bodies(
        &self,
        tool: &StockTool,
        from: &Vector3<f64>,
        to: &Vector3<f64>,
    ) -> std::result::Result<(), String> {
        let top = self.field.stock().bounds().1.z;
        let looked_at = tool.bodies.iter().filter(|own| self.is_checked && from.z.min(to.z) + own.2 < top);
        for (name, body, height) in looked_at {
            let [from, to] = [from, to].map(|own| own + *height * Vector3::z());
            let met = self.field.first_in_way(body, &from, &to, self.free_mm).map_err(|error| error.to_string())?;
            if let Some(met) = met {
                let [x, y, z]: [f64; 3] = (self.axes.transpose() * met).into();
                return Err(format!(
                    "has the {name} of its tool in the stock at ({x:.2}, {y:.2}, {z:.2}) mm: expected one that is higher above the tip than {height} mm, or narrower"
                ));
            }
        }
        Ok(())
    }

    /// Moves the tip by `way` and cuts what it meets; returns the load of the law where the cut is heaviest, with the engagement there, or nothing in air.
    fn feed(
        &mut self,
        tool: &StockTool,
        way: &Vector3<f64>,
        to: &PathPoint,
        law: &CuttingLaw,
    ) -> std::result::Result<Option<(Option<Load>, Engaged)>, String> {
        let pieces = (way.norm() / (0.5 * tool.cutter.radius_mm())).ceil().max(1.0);
        let (step, mut heaviest) = (way / pieces, None::<(Option<Load>, Engaged)>);
        let chord = way.normalize();
        let turn = Some(self.axes * to.tangent).filter(|own| own.dot(&chord) > ALONG).unwrap_or(chord) - chord;
        // The direction of an arc at a share of this way: it has turned as far behind the chord at its begin as beyond it at its end.
        let direction = |share: f64| (chord + turn * (2.0 * share - 1.0)).normalize();
        for piece in 0..pieces as usize {
            let (from, end) = (self.at, self.at + step);
            let share = |part: f64| (piece as f64 + part) / pieces;
            // What moves into material at the end of a piece has not been where it is; where less is met there than before, the most may lie on the way.
            let before = std::mem::take(&mut self.removed_mm2);
            self.meet(tool, &end, &direction(share(1.0)), to, law, &mut heaviest)?;
            if self.removed_mm2 < before {
                let at_end = self.removed_mm2;
                self.meet(tool, &(from + 0.5 * step), &direction(share(0.5)), to, law, &mut heaviest)?;
                self.removed_mm2 = at_end;
            }
            self.field.cut(&tool.cutter, &from, &end, to.source.segment as u32).map_err(|error| error.to_string())?;
            self.check_bodies(tool, &from, &end)?;
            self.at = end;
        }
        Ok(heaviest)
    }

    /// Finds what the tool meets with its tip at `at` on its `way`, and takes it for `heaviest` if that is less.
    fn meet(
        &mut self,
        tool: &StockTool,
        at: &Vector3<f64>,
        way: &Vector3<f64>,
        to: &PathPoint,
        law: &CuttingLaw,
        heaviest: &mut Option<(Option<Load>, Engaged)>,
    ) -> std::result::Result<(), String> {
        let found = self.field.engage(&tool.cutter, at, way, &self.slicing, &mut self.engagement);
        found.map_err(|error| error.to_string())?;
        self.removed_mm2 = self.engagement.volume_per_mm;
        if self.engagement.is_air() || heaviest.as_ref().is_some_and(|own| own.1.removed_mm2 >= self.removed_mm2) {
            return Ok(());
        }
        if let Some(refused) = &tool.refused {
            return Err(refused.clone());
        }
        let contact = Contact { engagement: &self.engagement, tool, axes: &self.axes, way };
        *heaviest = Some(match law {
            CuttingLaw::EngagedMilling(milling) => {
                let (load, c) = contact.load(milling, to)?;
                let mut engaged = summary(&self.engagement, milling.spindle, Some(c));
                let (rise, mean) = (way.z, load.force_N.norm());
                if engaged.end_mm2 * -rise > BY_END * engaged.removed_mm2 {
                    let is_plunge = is_drilling(in_tool_axes(way));
                    engaged.unknown = Some(if is_plunge { UnknownForce::End } else { UnknownForce::EndOnRamp });
                    if is_plunge {
                        *heaviest = Some((None, engaged));
                        return Ok(());
                    }
                }
                if let Some(stub) = &tool.stub {
                    engaged.bend = contact.bend(milling, stub, c)?;
                }
                if mean > LARGER * self.largest_mean {
                    self.largest_mean = mean;
                    engaged.peak_N = Some(milling.peak(&self.engagement, tool.teeth.clone()?, c, rise) as f32);
                }
                (Some(load), engaged)
            }
            CuttingLaw::EngagedDrilling(drill) => {
                let diameter_mm = 2.0 * tool.cutter.radius_mm();
                if (drill.diameter_mm - diameter_mm).abs() > 0.01 {
                    return Err(format!(
                        "drills with {diameter_mm} mm by its tool and {} mm by its force: expected one diameter",
                        drill.diameter_mm
                    ));
                }
                let f = drill.feed_per_rev(to).map_err(|error| error.to_string())?;
                let load = contact.load_of_drill(drill, f)?;
                let own = summary(&self.engagement, drill.spindle, Some(0.5 * f));
                (load.ok(), Engaged { unknown: load.err(), ..own })
            }
            _ => (None, summary(&self.engagement, TurnDirection::Clockwise, None)),
        });
        Ok(())
    }
}

/// Whether the way to this point is not known, as after a return to the reference position: it has no length.
pub(super) fn is_unknown_way(from: &PathPoint, to: &PathPoint) -> bool {
    to.arc_length_mm <= from.arc_length_mm && (to.position_mm - from.position_mm).norm() >= LEAST_WAY
}

/// Whether the move to this point is rapid, and cuts nothing.
pub(super) fn is_rapid(to: &PathPoint) -> bool {
    to.feed_mm_per_min.is_none() && !to.cutting
}

/// Returns a cutter with this shape, and corner and point of `tool`.
pub(super) fn cutter(
    shape: ToolShape,
    diameter_mm: f64,
    tool: &ToolDescription,
) -> std::result::Result<Cutter, RemovalError> {
    match shape {
        ToolShape::Flat => Cutter::flat(diameter_mm),
        ToolShape::Ball => Cutter::ball(diameter_mm),
        ToolShape::BullNose => Cutter::bull(diameter_mm, tool.corner_radius_mm.unwrap_or_default()),
        ToolShape::Drill => Cutter::drill(diameter_mm, tool.point_angle_deg.unwrap_or(POINT_ANGLE_DEG)),
    }
}

/// The error of a path at the move to `point`.
fn fault(origin: &str, point: &PathPoint, problem: &str) -> Error {
    Error::argument(origin, format!("move {}: {problem}", point.source.segment + 1))
}

/// Returns the axes of the field in W where the tool stands as at `point`: x along that of the tool's axes, z to the spindle.
fn axes_of(placed: &PlacedWorkpiece, point: &PathPoint) -> Axes {
    let turned = point.orientation.map_or(*placed, |orientation| placed.with_tool_orientation(&orientation));
    let tool = turned.tool_axes();
    Matrix3::from_rows(&[tool.column(0).transpose(), -tool.column(1).transpose(), -tool.column(2).transpose()])
}

/// A tool in the stock, which engages so on its `way`: a unit vector in the `axes` of the field.
struct Contact<'a> {
    engagement: &'a Engagement,
    tool: &'a StockTool,
    axes: &'a Axes,
    way: &'a Vector3<f64>,
}

impl Contact<'_> {
    /// Returns the mean load on the tool, in W, and the feed per tooth, mm. `Err` says what is missing.
    fn load(&self, milling: &EngagedMilling, point: &PathPoint) -> std::result::Result<(Load, f64), String> {
        let teeth = self.tool.teeth.clone()?;
        let c = milling.feed_per_tooth(point, teeth).map_err(|error| error.to_string())?;
        let mean = milling.mean(self.engagement, teeth, c, self.way.z, lateral_share(*self.way));
        Ok((self.in_workpiece(mean), c))
    }

    /// Returns force (N) and moment (N·mm) along the heading, to its left and to the spindle as a load in W.
    fn in_workpiece(&self, (force, moment): (Vector3<f64>, Vector3<f64>)) -> Load {
        // As the field has it.
        let heading = Vector3::new(self.way.x, self.way.y, 0.0).try_normalize(LEAST_HEADING).unwrap_or_else(Vector3::x);
        let up = Vector3::z();
        let frame = self.axes.transpose() * Matrix3::from_columns(&[heading, up.cross(&heading), up]);
        Load { force_N: frame * force, moment_Nmm: frame * moment }
    }

    /// Returns the load on a drill at the feed `f`, mm/rev, in W; within, why its law does not know it. `Err` if tool and law contradict.
    fn load_of_drill(
        &self,
        drill: &Drilling,
        f: f64,
    ) -> std::result::Result<std::result::Result<Load, UnknownForce>, String> {
        let Self { engagement, tool, axes, way } = self;
        let radius = tool.cutter.radius_mm();
        if !is_drilling(in_tool_axes(way)) {
            return Ok(Err(UnknownForce::Aside));
        }
        if let (Some(lips), DrillingLaw::Kienzle { point_angle, .. }) = (drill.lips(), drill.law) {
            let own_deg = 2.0 * libm::atan2(radius, tool.cutter.nose_height_mm()).to_degrees();
            if (own_deg - point_angle.to_degrees()).abs() > SAME_ANGLE_DEG {
                return Err(format!(
                    "drills with a point of {own_deg:.1}° by its tool and {:.1}° by its force: expected one angle",
                    point_angle.to_degrees()
                ));
            }
            // It is fed along its axis, whatever its motion leans.
            return Ok(Ok(self.in_workpiece(lips.mean(engagement, LIPS, f / f64::from(LIPS), -1.0, 0.0))));
        }
        let whole = std::f64::consts::PI * radius * radius;
        if engagement.volume_per_mm < SOLID * whole {
            return Ok(Err(UnknownForce::PartlySolid));
        }
        let rows = [0, 1, 2].map(|axis| axes.row(axis).transpose());
        let tool_axes = Matrix3::from_columns(&[rows[0], -rows[1], -rows[2]]);
        Ok(Ok(PathLoad::Drilling(drill.force(f)).on_tool(axes.transpose() * *way, &tool_axes)))
    }

    /// Returns how the tool bends in itself; `None` on a way along its axis. `Err` if it cuts with what is in its holder.
    fn bend(&self, milling: &EngagedMilling, stub: &Stub, c: f64) -> std::result::Result<Option<Bend>, String> {
        let Self { engagement, tool, axes, way } = self;
        if engagement.depth_mm >= stub.stick_out_mm {
            return Err(format!(
                "cuts {:.2} mm deep with a tool that sticks out {} mm: expected less, as the holder would cut",
                engagement.depth_mm, stub.stick_out_mm
            ));
        }
        let share = lateral_share(**way);
        let Some(heading) = Vector3::new(way.x, way.y, 0.0).try_normalize(LEAST_HEADING).filter(|_| share == 1.0)
        else {
            return Ok(None);
        };
        let left = axes.transpose() * Vector3::z().cross(&heading);
        let bend = milling.bend(stub, engagement, tool.teeth.clone()?, c, way.z, left);
        let walls = bend.walls.iter().flatten().flat_map(|wall| wall.bends_mm);
        let most = walls.fold(bend.aimed_mm.norm(), |most, own| most.max(f64::from(own).abs()));
        if most > MAX_BEND * tool.cutter.radius_mm() {
            return Err(format!(
                "bends its tool by {most:.3} mm, more than a tenth of its radius: expected another youngs_modulus_N_per_mm2, stick_out_mm or holder_N_per_mm"
            ));
        }
        Ok(Some(bend))
    }
}

/// Returns a direction of the field in axes of the tool.
fn in_tool_axes(way: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(way.x, -way.y, -way.z)
}

/// Returns what is told of an engagement at feed per tooth `c`, mm.
fn summary(engagement: &Engagement, spindle: TurnDirection, c: Option<f64>) -> Engaged {
    let turn = if spindle == TurnDirection::Clockwise { Spindle::Clockwise } else { Spindle::CounterClockwise };
    let angles = || engagement.arcs.iter().map(|arc| arc.tooth_angles(turn));
    let slices = &engagement.slices;
    Engaged {
        regions: slices.chunk_by(|a, b| a.arcs == b.arcs).count(),
        depth_mm: engagement.depth_mm,
        width_mm: engagement.width_mm,
        entry_rad: angles().map(|(entry, _)| entry).min_by(f64::total_cmp),
        exit_rad: angles().map(|(_, exit)| exit).max_by(f64::total_cmp),
        chip_mm: c.map(|c| c * engagement.chip_ratio),
        removed_mm2: engagement.volume_per_mm,
        end_mm2: engagement.end_area_mm2,
        milling: match engagement.milling(turn) {
            Milling::Air => "",
            Milling::Up => "up",
            Milling::Down => "down",
            Milling::Both => "both",
        },
        bend: None,
        unknown: None,
        peak_N: None,
    }
}
