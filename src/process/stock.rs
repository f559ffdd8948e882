//! The stock as a path cuts it: where its tools are in material, and the force that this makes.

use std::collections::BTreeMap;

use kinetostat_removal::{Cutter, Engagement, Field, Milling, RemovalError, Slicing, Spindle, Stock};
use nalgebra::{Matrix3, Vector3};

use crate::{
    input::{
        check::Check,
        error::{Error, Result},
    },
    machine::Machine,
    process::{
        PathReference, PlacedWorkpiece, Placement,
        cutting::{CuttingLaw, EngagedMilling, LEAST_HEADING, LoadError, PathLoad, Stub, lateral_share},
    },
    toolpath::{Bend, Engaged, Load, PathPoint, Toolpath, TurnDirection},
};

/// What is cut, in the frame of the workpiece, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

/// A tool that cuts stock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StockTool {
    /// Its shape.
    pub cutter: Cutter,
    /// Number of its teeth.
    pub teeth: u32,
    /// How it bends in itself; `None`: not at all.
    pub stub: Option<Stub>,
}

/// The stock and the tools that cut it.
#[derive(Debug, Clone)]
#[allow(non_snake_case, reason = "the unit is Hz, not hz")]
pub struct StockRemoval {
    shape: StockShape,
    cell_mm: Option<f64>,
    tools: BTreeMap<u32, StockTool>,
    natural_frequencies_Hz: Vec<f64>,
    /// How near rapid moves may come into material, mm.
    free_mm: f64,
    check: Check,
}

/// Cells over the diameter of the smallest tool, if no cell is given.
const CELLS: f64 = 40.0;
/// Slices of a corner, a ball or a point: with them the volume of a pass of a ball is within half a per cent.
const NOSE_SLICES: u32 = 16;
/// Most slices of the side of a tool in a high stock.
const MOST_SLICES: f64 = 400.0;
/// Ways shorter than this are none: what is met by them is within what counts as touched, mm.
const LEAST_WAY: f64 = 1e-5;
/// A rapid move may come so near into material: programs round, mm.
const FREE_MM: f64 = 0.02;
/// Most memory for a field, bytes.
const MOST_BYTES: usize = 4 << 30;
/// A tooth passing frequency is near a natural one within this ratio.
const NEAR: f64 = 1.2;
/// A tool that leans by less is parallel to the one before, as the sine of the angle: programs give angles with so many digits.
const PARALLEL: f64 = 1e-5;

/// Axes of a field of removal in W, its rows: z to the spindle.
type Axes = Matrix3<f64>;

impl StockRemoval {
    /// Creates the stock of a `shape` with the largest cell for the tools by number and natural frequencies, for paths whose arcs have chords that leave them by up to
    /// `chords_mm`.
    pub(super) fn new(
        (shape, cell_mm): (StockShape, Option<f64>),
        (tools, frequencies): (BTreeMap<u32, StockTool>, Vec<f64>),
        chords_mm: f64,
        check: Check,
    ) -> Self {
        Self { shape, cell_mm, tools, natural_frequencies_Hz: frequencies, free_mm: FREE_MM + chords_mm, check }
    }

    /// Returns in words how often teeth pass on `path`, which cuts the stock, and what is near; `None` where the spindle speed is not known. The second is a caution.
    pub(crate) fn tooth_passing(&self, path: &Toolpath) -> Option<(String, Option<String>)> {
        let at = |(point, engaged): (&PathPoint, &Engaged)| {
            let speed = point.spindle_rev_per_min.filter(|_| engaged.removed_mm2 > 0.0)?;
            Some(speed / 60.0 * f64::from(self.tool(point.tool).ok()?.teeth))
        };
        let all = path.points().iter().zip(path.engagements()).filter_map(at);
        let ends = all.fold(None, |ends: Option<(f64, f64)>, own| {
            Some(ends.map_or((own, own), |(low, high)| (low.min(own), high.max(own))))
        });
        let (low, high) = ends?;
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
    /// ([`Toolpath::engagements`]). `law` gives the law of a point; `origin` names the path in errors.
    ///
    /// # Errors
    /// A tool that is not in the table, or leans, or is a drill of another diameter than its law; a rapid move through material, a start in it, a path that touches none; loads that come with the path; a feed or a
    /// spindle speed that the law needs and is not there; a field too large.
    pub(super) fn cut<'a>(
        &self,
        path: Toolpath,
        (machine, placement): (&Machine, &Placement),
        law: impl Fn(&PathPoint) -> &'a CuttingLaw,
        origin: &str,
    ) -> Result<Toolpath> {
        if placement.reference != PathReference::ToolTip {
            let problem = "is cut by the tool tip, and the path is of the platform point: expected placement.reference = \"tool_tip\"";
            return self.check.fail(problem.into());
        }
        if let [first, ..] = path.external_axes() {
            let problem = format!("is cut along one direction of the tool, and {origin} commands {first}");
            return self.check.fail(problem);
        }
        if path.points().iter().any(|point| point.load.is_some()) {
            return Err(Error::argument(origin, LoadError::UnusedLoads { other_law: true }.to_string()));
        }
        let placed = placement.place(machine);
        let Some(first) = path.points().first().copied() else { return Ok(path) };
        let mut cutting = Cutting::new(self, axes_of(&placed, &first), &path)?;
        let fault = |point: &PathPoint, problem: String| {
            Error::argument(origin, format!("move {}: {problem}", point.source.segment + 1))
        };
        cutting.begin(self.tool(first.tool), &first.position_mm).map_err(|problem| fault(&first, problem))?;
        let mut points = path.points().to_vec();
        let mut engagements = vec![Engaged::default()];
        for k in 1..points.len() {
            let to = points[k];
            if cutting.leans(&axes_of(&placed, &to)) {
                let problem = "tilts the tool, and stock is cut along one direction of it: expected one orientation, or no [stock]";
                return Err(fault(&to, problem.into()));
            }
            let tool = self.tool(to.tool);
            let way = cutting.axes * to.position_mm - cutting.at;
            if way.norm() < LEAST_WAY {
                // It stays in what it met.
                points[k].load = points[k - 1].load.filter(|_| to.cutting);
                engagements.push(if to.cutting { engagements[k - 1] } else { Engaged::default() });
                continue;
            }
            if is_unknown_way(&points[k - 1], &to) {
                cutting.begin(tool, &to.position_mm).map_err(|problem| fault(&to, problem))?;
                engagements.push(Engaged::default());
                continue;
            }
            let found = match is_rapid(&to) {
                true => cutting.pass(tool, &way).map(|()| None),
                false => tool.and_then(|tool| cutting.feed(tool, &way, &to, law(&to))),
            };
            let (load, engaged) = found.map_err(|problem| fault(&to, problem))?.unwrap_or_default();
            points[k].load = load.filter(|_| to.cutting);
            engagements.push(engaged);
        }
        if engagements.iter().all(|own| own.removed_mm2 == 0.0) {
            let problem = "nothing touches the stock: expected it where the tool goes, in the frame of the program";
            return Err(Error::argument(origin, problem));
        }
        Ok(Toolpath::assemble(points).with_engagements(engagements))
    }

    /// Returns the axes of a field that `path` cuts, in W.
    pub(super) fn axes_along(&self, path: &Toolpath, (machine, placement): (&Machine, &Placement)) -> Axes {
        let placed = placement.place(machine);
        path.points().first().map_or_else(Axes::identity, |first| axes_of(&placed, first))
    }

    /// Returns the tool with this number, the only one where no number is given. `Err` says what is wrong.
    pub(super) fn tool(&self, number: Option<u32>) -> std::result::Result<&StockTool, String> {
        match number {
            None if self.tools.len() == 1 => Ok(self.tools.values().next().expect("one tool")),
            None => Err("does not say which tool cuts: expected T before it, or a single tool in [tools]".into()),
            Some(number) => self
                .tools
                .get(&number)
                .ok_or_else(|| format!("is of tool {number}, whose geometry is not known: expected [tools.{number}]")),
        }
    }

    /// Returns the uncut stock in axes of the field, as far as `moves` moves need.
    pub(super) fn field(&self, axes: &Axes, path: &Toolpath) -> Result<Field> {
        let stock = match self.shape {
            StockShape::Box { min, max } => {
                if axes.iter().any(|own| own.abs() > PARALLEL && (own.abs() - 1.0).abs() > PARALLEL) {
                    let problem = "stands along axes of the workpiece, and the tool is along none of them";
                    return self.check.key("box").fail(problem.into());
                }
                let [a, b] = [axes * min, axes * max];
                Stock::cuboid(a.inf(&b), a.sup(&b))
            }
            StockShape::Cylinder { base, diameter_mm, height_mm } => {
                if axes[(2, 0)].hypot(axes[(2, 1)]) > PARALLEL {
                    let problem = "stands along z of the workpiece, and the tool is not along it";
                    return self.check.key("cylinder").fail(problem.into());
                }
                let end = base + Vector3::z() * if axes[(2, 2)] < 0.0 { height_mm } else { 0.0 };
                Stock::cylinder(axes * end, diameter_mm, height_mm)
            }
        };
        let wrong = |error: RemovalError| self.check.fail(error.to_string());
        let stock = stock.or_else(wrong)?;
        let used = path.points().iter().filter(|point| !is_rapid(point)).filter_map(|point| self.tool(point.tool).ok());
        let smallest = used.map(|own| own.cutter.radius_mm()).fold(f64::INFINITY, f64::min);
        let (low, high) = stock.bounds();
        let own = 2.0 * smallest.min((high - low).norm()) / CELLS;
        let cell_mm = self.cell_mm.unwrap_or(own);
        let bytes = Field::memory_bytes(&stock, cell_mm, path.len());
        let bytes = bytes.or_else(|error| self.check.key("cell_mm").fail(error.to_string()))?;
        if bytes > MOST_BYTES {
            let problem = format!(
                "takes {:.1} GB with cells of {cell_mm} mm{}: expected at most {:.0} GB, by larger cells",
                bytes as f64 / 1e9,
                if self.cell_mm.is_none() { ", a fortieth of the smallest tool's diameter" } else { "" },
                MOST_BYTES as f64 / 1e9
            );
            return self.check.key("cell_mm").fail(problem);
        }
        Field::new(stock, cell_mm).or_else(|error| self.check.fail(error.to_string()))
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
}

/// A tool, or what is wrong with its number.
type Known<'a> = std::result::Result<&'a StockTool, String>;

impl Cutting {
    /// The uncut stock for a path.
    fn new(removal: &StockRemoval, axes: Axes, path: &Toolpath) -> Result<Self> {
        let field = removal.field(&axes, path)?;
        let (low, high) = field.stock().bounds();
        let slice_mm = ((high.z - low.z) / MOST_SLICES).max(Slicing::default().slice_mm);
        let slicing = Slicing { nose_slices: NOSE_SLICES, slice_mm, ..Slicing::default() };
        let (at, free_mm) = (Vector3::zeros(), removal.free_mm);
        Ok(Self { field, slicing, engagement: Engagement::default(), axes, at, removed_mm2: 0.0, free_mm })
    }

    /// Puts the tip where the path begins, or goes on after a way that is not known. `Err` if the tool is in the stock there.
    fn begin(&mut self, tool: Known<'_>, position: &Vector3<f64>) -> std::result::Result<(), String> {
        self.at = self.axes * position;
        if self.at.z >= self.field.stock().bounds().1.z {
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
        if from.z.min(self.at.z) >= high.z {
            return Ok(());
        }
        let tool = tool?;
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
        for _ in 0..pieces as usize {
            let (from, end) = (self.at, self.at + step);
            // What moves into material at the end of a piece has not been where it is; where less is met there than before, the most may lie on the way.
            let before = std::mem::take(&mut self.removed_mm2);
            self.meet(tool, &end, way, (to, law), &mut heaviest)?;
            if self.removed_mm2 < before {
                let at_end = self.removed_mm2;
                self.meet(tool, &(from + 0.5 * step), way, (to, law), &mut heaviest)?;
                self.removed_mm2 = at_end;
            }
            self.field.cut(&tool.cutter, &from, &end, to.source.segment as u32).map_err(|error| error.to_string())?;
            self.at = end;
        }
        Ok(heaviest)
    }

    /// Finds what the tool meets with its tip at `at`, and takes it for `heaviest` if that is less.
    fn meet(
        &mut self,
        tool: &StockTool,
        at: &Vector3<f64>,
        way: &Vector3<f64>,
        (to, law): (&PathPoint, &CuttingLaw),
        heaviest: &mut Option<(Option<Load>, Engaged)>,
    ) -> std::result::Result<(), String> {
        let found = self.field.engage(&tool.cutter, at, way, &self.slicing, &mut self.engagement);
        found.map_err(|error| error.to_string())?;
        self.removed_mm2 = self.engagement.volume_per_mm;
        if self.engagement.is_air() || heaviest.as_ref().is_some_and(|own| own.1.removed_mm2 >= self.removed_mm2) {
            return Ok(());
        }
        *heaviest = Some(match law {
            CuttingLaw::EngagedMilling(milling) => {
                let (load, c) = load(milling, (&self.engagement, tool), (&self.axes, way), to)?;
                let mut engaged = summary(&self.engagement, milling.spindle, Some(c));
                if let Some(stub) = &tool.stub {
                    engaged.bend = bend((milling, stub), (&self.engagement, tool), (&self.axes, way), c)?;
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
                let rows = [0, 1, 2].map(|axis| self.axes.row(axis).transpose());
                let tool_axes = Matrix3::from_columns(&[rows[0], -rows[1], -rows[2]]);
                let tangent = self.axes.transpose() * way.normalize();
                let load = PathLoad::Drilling(drill.force(f)).on_tool(tangent, &tool_axes);
                (Some(load), summary(&self.engagement, drill.spindle, Some(0.5 * f)))
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

/// Returns the axes of the field in W where the tool stands as at `point`: x along that of the tool's axes, z to the spindle.
fn axes_of(placed: &PlacedWorkpiece, point: &PathPoint) -> Axes {
    let turned = point.orientation.map_or(*placed, |orientation| placed.with_tool_orientation(&orientation));
    let tool = turned.tool_axes();
    Matrix3::from_rows(&[tool.column(0).transpose(), -tool.column(1).transpose(), -tool.column(2).transpose()])
}

/// Returns the mean load on a tool that engages so on its `way`, in W, and the feed per tooth, mm. `Err` says what is missing.
fn load(
    milling: &EngagedMilling,
    (engagement, tool): (&Engagement, &StockTool),
    (axes, way): (&Axes, &Vector3<f64>),
    point: &PathPoint,
) -> std::result::Result<(Load, f64), String> {
    let c = milling.feed_per_tooth(point, tool.teeth).map_err(|error| error.to_string())?;
    let way = way.normalize();
    // As the field has it.
    let heading = Vector3::new(way.x, way.y, 0.0).try_normalize(LEAST_HEADING).unwrap_or_else(Vector3::x);
    let up = Vector3::z();
    let frame = axes.transpose() * Matrix3::from_columns(&[heading, up.cross(&heading), up]);
    let (force, moment) = milling.mean(engagement, tool.teeth, c, way.z, lateral_share(way));
    Ok((Load { force_N: frame * force, moment_Nmm: frame * moment }, c))
}

/// Returns how the tool bends in itself; `None` on a way along its axis. `Err` if it cuts with what is in its holder.
fn bend(
    (milling, stub): (&EngagedMilling, &Stub),
    (engagement, tool): (&Engagement, &StockTool),
    (axes, way): (&Axes, &Vector3<f64>),
    c: f64,
) -> std::result::Result<Option<Bend>, String> {
    if engagement.depth_mm >= stub.stick_out_mm {
        return Err(format!(
            "cuts {:.2} mm deep with a tool that sticks out {} mm: expected less, as the holder would cut",
            engagement.depth_mm, stub.stick_out_mm
        ));
    }
    let way = way.normalize();
    let share = lateral_share(way);
    let Some(heading) = Vector3::new(way.x, way.y, 0.0).try_normalize(LEAST_HEADING).filter(|_| share == 1.0) else {
        return Ok(None);
    };
    let left = axes.transpose() * Vector3::z().cross(&heading);
    let across = milling.across(stub, engagement, tool.teeth, c, way.z);
    Ok(Some(Bend { aimed_mm: across.aimed_mm * left, left, walls_mm: across.walls_mm, across_N: across.force_N }))
}

/// Returns what is told of an engagement at feed per tooth `c`, mm.
fn summary(engagement: &Engagement, spindle: TurnDirection, c: Option<f64>) -> Engaged {
    let turn = if spindle == TurnDirection::Clockwise { Spindle::Clockwise } else { Spindle::CounterClockwise };
    let angles = || engagement.arcs.iter().map(|arc| arc.tooth_angles(turn));
    Engaged {
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
    }
}
