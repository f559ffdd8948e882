//! How near the bodies of machine, tool, workpiece and cell come along a path: between its points by bounds, not by samples.

use std::{collections::BTreeSet, sync::Arc};

use kinetostat_cell::{
    Ball, Body, BodyGrade, Cell, Motion, Separation, Shape, SweepEnd, SweepOptions, spec::may_touch,
};
use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use super::along_path::Arrival;
use crate::{
    compensation::TaskPoint,
    input::error::Result,
    machine::{Configuration, Machine, MachineMotion, O_FRAME, PLATFORM_FRAME, WORKPIECE_FRAME},
    process::{
        Placement,
        file::ProcessCell,
        file::tables::cell::{CellFrame, RapidMove},
    },
    spatial::{BodyOutline, Pose, rotation_log},
    toolpath::{PathPoint, Way},
};

/// Bodies of a machine and of what surrounds it, and the pairs of them that are to be apart along a path.
#[derive(Debug)]
pub struct MachineCell {
    machine: Machine,
    own: Arc<ProcessCell>,
    /// The bodies, with the pairs whose shapes are known, and with those of which one is only assumed: neither may hide what the other hits.
    cells: [Cell; 2],
    /// What moves with the workpiece, and what stands where it is put.
    standing: Cell,
    /// Number of the machine's bodies, which come first.
    of_machine: usize,
    /// What is not among the bodies, and why.
    left_out: Vec<&'static str>,
    /// Number of the machine's frames; those of the workpiece and of the tool follow.
    frames: usize,
    /// The tool in platform axes.
    tool: Isometry3<f64>,
}

/// How near bodies come along a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathClearance {
    /// What is known.
    pub state: ClearanceState,
    /// Least distance that is wanted, mm.
    pub wanted_mm: f64,
    /// No distance is less, mm, along what could be looked at, but where bodies overlap by more than 5 mm; `None` where nothing could.
    pub at_least_mm: Option<f64>,
    /// How far deflection may move what is on the tool from where bodies are looked at, mm; 0 where it is not known.
    pub moved_mm: f64,
    /// Where bodies come nearest; of hits first an overlap, and of like ones first what is certain.
    pub nearest: Option<NearestBodies>,
    /// What else hits: the worst where the workpiece is put and along the path, of known and of assumed shapes.
    pub also: Vec<NearestBodies>,
    /// Bodies whose shapes are only assumed, so that nothing is known to be clear of them.
    pub assumed: Vec<String>,
    /// What could not be looked at, and why, each once.
    pub not_looked_at: Vec<String>,
    /// Pairs of bodies, states that were looked at, and searches for a distance of two convex pieces.
    pub effort: [usize; 3],
}

/// The two bodies that come nearest, and where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NearestBodies {
    /// Their names.
    pub names: [String; 2],
    /// At most their distance, mm; where they overlap, minus a depth.
    pub distance_mm: f64,
    /// Whether a shape of one is only assumed.
    pub is_assumed: bool,
    /// Index of the point of the path on the way to which it is; `None` where the workpiece stands in what it is put on.
    pub point: Option<usize>,
    /// A point of each, O, mm.
    pub points_mm: [[f64; 3]; 2],
    /// Where the machine stands then.
    pub at: Configuration,
}

/// What is known of the clearance along a path.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClearanceState {
    /// Bodies touch, or come nearer than is wanted.
    Hit,
    /// Nothing that was looked at hits, but not all is known or could be looked at.
    #[default]
    Unknown,
    /// All bodies stay apart.
    Clear,
}

impl PathClearance {
    /// Returns what is known; assumed shapes may be in the way, and never clear it.
    fn known(&self) -> ClearanceState {
        let is_open = !self.assumed.is_empty() || !self.not_looked_at.is_empty();
        match self.at_least_mm {
            Some(least) if self.is_too_near(least) => ClearanceState::Hit,
            Some(least) if !is_open && !self.is_too_near(least - self.moved_mm) => ClearanceState::Clear,
            _ => ClearanceState::Unknown,
        }
    }

    /// Returns which bodies hit and by how much; `way` says on which way to a point of the path. `None` where none was found to.
    #[must_use]
    pub fn hit_text(&self, way: impl Fn(usize) -> String) -> Option<String> {
        let nearest = self.nearest.as_ref().filter(|_| self.state == ClearanceState::Hit)?;
        let all = std::iter::once(nearest).chain(&self.also);
        Some(all.map(|own| own.hit_text(self.wanted_mm, &way)).collect::<Vec<_>>().join(". Also "))
    }

    /// Whether a distance is less than wanted, mm.
    fn is_too_near(&self, distance_mm: f64) -> bool {
        distance_mm < self.wanted_mm || distance_mm <= 0.0
    }

    /// Returns that nothing was looked at, as no process names a cell; `None` where `machine` has no bodies either.
    #[must_use]
    pub fn without_cell(machine: &Machine) -> Option<Self> {
        let not_looked_at = vec!["the path, as its process has no table [cell]".into()];
        machine.has_bodies().then(|| Self { not_looked_at, ..Self::default() })
    }

    /// Returns it where deflection moves what is on the tool by up to `moved_mm`.
    #[must_use]
    pub fn moved_by(mut self, moved_mm: f64) -> Self {
        self.moved_mm = moved_mm;
        self.state = self.known();
        self
    }
}

impl NearestBodies {
    /// Returns that they hit and by how much, where `wanted_mm` are wanted; `way` as [`PathClearance::hit_text`].
    fn hit_text(&self, wanted_mm: f64, way: impl Fn(usize) -> String) -> String {
        let Self { names: [a, b], distance_mm, is_assumed, point, .. } = self;
        let assumed = if *is_assumed { ", as far as their assumed shapes say" } else { "" };
        let place = point.map_or_else(|| "where the workpiece is put".into(), way);
        match *distance_mm {
            depth if depth < -TOUCHING_MM => {
                let way_out = format!("; if they may, may_touch = [[\"{a}\", \"{b}\"]] of [cell] says so");
                let way_out = if point.is_none() { way_out } else { String::new() };
                format!("{} {place}{assumed}{way_out}", self.overlap_text(depth))
            }
            depth if depth <= TOUCHING_MM && wanted_mm <= TOUCHING_MM => format!("{a} and {b} touch {place}{assumed}"),
            distance => format!(
                "{a} and {b} come within {distance:.1} mm of each other {place}, and {wanted_mm} mm are wanted{assumed}"
            ),
        }
    }

    /// Returns by how much they overlap, with their distance or its bound known to be `distance_mm`.
    #[must_use]
    pub fn overlap_text(&self, distance_mm: f64) -> String {
        let [a, b] = &self.names;
        let more = if self.point.is_some() && distance_mm < -DEEP_MM { " or more" } else { "" };
        format!("{a} and {b} overlap by {:.1} mm{more}", -distance_mm)
    }
}

impl MachineCell {
    /// Gathers the bodies of the machine and of a process.
    ///
    /// # Errors
    /// A mesh of the machine cannot be read, and bodies of machine and tool that overlap at home.
    pub fn new(machine: &Machine, own: &Arc<ProcessCell>) -> Result<Self> {
        let frames = machine.frame_count();
        let mut bodies = machine.bodies()?;
        let of_machine = bodies.len();
        bodies.extend(own.bodies.iter().map(|(on, body)| {
            let frame = match on {
                CellFrame::Base => O_FRAME,
                CellFrame::Table => WORKPIECE_FRAME,
                CellFrame::Part => frames,
                CellFrame::Platform => PLATFORM_FRAME,
                CellFrame::Tool => frames + 1,
            };
            let mut body = body.clone();
            body.frame = frame;
            body
        }));
        let names: Vec<String> = bodies.iter().map(|body| body.name.clone()).collect();
        let at: Vec<usize> = bodies.iter().map(|body| body.frame).collect();
        let rest = machine.resting_frames();
        let is_at_rest = |frame: usize| frame == frames || rest.contains(&frame);
        let joined = machine.joined_frames();
        let is_listed = |a: usize, b: usize| {
            let pair = [names[a].as_str(), &names[b]];
            may_touch(machine.may_touch(), pair) || may_touch(&own.may_touch, pair)
        };
        let stock = own.stock.map(|index| of_machine + index);
        // The cut says what the tool meets of the stock.
        let is_cut =
            |a: usize, b: usize| [[a, b], [b, a]].iter().any(|&[a, b]| Some(a) == stock && at[b] == frames + 1);
        // And what its own shank and holder meet, but not what else is on the tool.
        let of_tool = of_machine + own.before_tool;
        let mut left_out = Vec::new();
        if stock.is_some() && at[..of_tool].contains(&(frames + 1)) {
            left_out.push("what is on the tool against the stock, of which the cut says what it meets");
        }
        let is_allowed = |a: usize, b: usize| {
            let on = [at[a], at[b]].map(|frame| if frame == frames + 1 { PLATFORM_FRAME } else { frame });
            // Links meet in their joint, and the tool its last one; what is put beside them does not.
            let are_links = [a, b].into_iter().all(|own| own < of_machine || own >= of_tool);
            let is_joined = are_links && joined.contains(&[on[0].min(on[1]), on[0].max(on[1])]);
            on[0] == on[1] || is_joined || on.into_iter().all(is_at_rest) || is_cut(a, b) || is_listed(a, b)
        };
        let standing = Cell::new(bodies.clone(), |a, b| {
            let is_put = (at[a] == frames) != (at[b] == frames);
            let stands = [at[a], at[b]].into_iter().all(is_at_rest);
            !is_put || !stands || is_listed(a, b)
        });
        let is_assumed: Vec<bool> = bodies.iter().map(|body| !body.grade.clears()).collect();
        let of_grade =
            |assumed| Cell::new(bodies.clone(), |a, b| (is_assumed[a] || is_assumed[b]) != assumed || is_allowed(a, b));
        let cells = [false, true].map(of_grade);
        let (machine, own, tool) = (machine.clone(), own.clone(), isometry(&machine.tool()));
        let mut found = Self { machine, own, cells, standing, of_machine, left_out, frames, tool };
        found.check_home()?;
        if !found.holds_tip() {
            found.left_out.push(NO_CUTTER);
        }
        Ok(found)
    }

    /// Says why no distance of bodies is known; `None` where one is.
    #[must_use]
    pub fn has_no_distance(&self) -> Option<String> {
        match self.assumed().next() {
            Some(body) => {
                let is_of_table = body >= self.of_machine + self.own.before_tool;
                let expected = if is_of_table { ": expected shank and holder, below P, in [tools.N]" } else { "" };
                let name = &self.bodies()[body].name;
                Some(format!("the shape of {name} is assumed, so that no distance from it is known{expected}"))
            }
            None if self.cells[0].pairs().is_empty() => Some("no two bodies are to be apart".into()),
            None => self.left_out.iter().find(|own| **own == NO_CUTTER).map(|own| format!("not looked at is {own}")),
        }
    }

    /// The bodies.
    fn bodies(&self) -> &[Body] {
        self.cells[0].bodies()
    }

    /// Returns the indices of the bodies looked at whose shapes are only assumed.
    fn assumed(&self) -> impl Iterator<Item = usize> {
        let looked_at: BTreeSet<usize> = self.cells[1].pairs().iter().flatten().copied().collect();
        looked_at.into_iter().filter(|&body| !self.bodies()[body].grade.clears())
    }

    /// The machine.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Gathers the bodies as [`MachineCell::new`]; `None` where the process names no cell.
    ///
    /// # Errors
    /// As there.
    pub fn of(machine: &Machine, own: Option<&Arc<ProcessCell>>) -> Result<Option<Arc<Self>>> {
        own.map(|own| Self::new(machine, own).map(Arc::new)).transpose()
    }

    /// Whether a body that the machine moves reaches the tool tip, at home, or the tool is known.
    fn holds_tip(&self) -> bool {
        let poses = self.at_home(&Isometry3::identity());
        let tip = Shape::Capsule { ends_mm: [poses[self.frames + 1] * Point3::origin(); 2], radius_mm: TIP_MM };
        let tip = Body::new("tip", O_FRAME, BodyGrade::Given, &[tip]);
        let rest = self.machine.resting_frames();
        let moving = self.bodies().iter().filter(|own| own.frame != self.frames && !rest.contains(&own.frame));
        let all = Cell::new(tip.into_iter().chain(moving.cloned()).collect(), |a, _| a != 0);
        let of_tool = self.bodies().len() > self.of_machine + self.own.before_tool;
        of_tool || all.nearest(&poses).is_some_and(|own| own.distance_mm <= 0.0)
    }

    /// Returns the poses of all frames at home, with the workpiece placed at `workpiece`.
    fn at_home(&self, workpiece: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
        let mut poses = vec![Isometry3::identity(); self.frames + 2];
        self.place(&self.machine.home, workpiece, &mut Vec::new(), &mut poses);
        poses
    }

    /// Checks that no bodies of machine and tool overlap at home.
    fn check_home(&self) -> Result<()> {
        // What surrounds the machine is asked of the path, and a tool that is not known may be anything.
        let is_elsewhere = |index: usize| {
            let (body, at) = (&self.bodies()[index], [O_FRAME, WORKPIECE_FRAME, self.frames]);
            let is_open = index >= self.of_machine + self.own.before_tool && !body.grade.clears();
            index >= self.of_machine && at.contains(&body.frame) || is_open
        };
        let poses = self.at_home(&Isometry3::identity());
        for found in self.cells.iter().flat_map(|cell| cell.separations(&poses)) {
            if found.distance_mm < 0.0 && !found.pair.into_iter().any(is_elsewhere) {
                let [a, b] = found.pair.map(|body| &self.bodies()[body].name);
                let problem = format!(
                    "{a} and {b} overlap by {:.1} mm with the machine at home: is a shape too large or in a wrong place? If they may touch, \
                     may_touch = [[\"{a}\", \"{b}\"]] says so",
                    -found.distance_mm
                );
                return self.own.check.key("may_touch").fail(problem);
            }
        }
        Ok(())
    }

    /// Begins a path with the workpiece at `placement`.
    #[must_use]
    pub fn begin(&self, placement: &Placement) -> ClearanceAlong<'_> {
        let clearance = PathClearance {
            wanted_mm: self.own.clearance_mm,
            assumed: self.assumed().map(|body| self.bodies()[body].name.clone()).collect(),
            effort: [self.cells.iter().map(|cell| cell.pairs().len()).sum(), 0, 0],
            ..PathClearance::default()
        };
        let workpiece = isometry(&placement.pose());
        let mut along = ClearanceAlong {
            cell: self,
            found: Default::default(),
            standing: Vec::new(),
            workpiece,
            ends_at_hit: false,
            clearance,
            said: BTreeSet::new(),
            before: None,
            tool: None,
            count: 0,
        };
        self.left_out.iter().for_each(|what| along.leave_out(what));
        let poses = self.at_home(&along.workpiece);
        for of_assumed in [false, true] {
            let is_asked = |pair: [usize; 2]| pair.iter().any(|&own| !self.bodies()[own].grade.clears()) == of_assumed;
            let found = self.standing.nearest_of(&poses, is_asked).filter(|own| own.distance_mm < -TOUCHING_MM);
            along.standing.extend(found.map(|own| self.named(&own, None, &self.machine.home)));
        }
        along
    }

    /// Returns at which of `tasks`, with the workpiece at `placement`, shank or holder of the tool hits most what moves with the workpiece: no
    /// place and no rotation about the tool axis mends that.
    #[must_use]
    pub fn hit_everywhere(
        &self,
        placement: &Placement,
        tasks: &[TaskPoint],
        points: &[PathPoint],
    ) -> Option<PathClearance> {
        let mut along = self.begin(placement);
        along.standing.clear();
        let mut poses = self.at_home(&along.workpiece);
        let of_tool = |body: usize| body >= self.of_machine + self.own.before_tool;
        let with_part = |body: usize| self.bodies()[body].frame == self.frames;
        let tool = points.iter().find_map(|point| point.tool);
        let is_known = |k: &usize| points[*k].tool.is_none_or(|own| tool == Some(own));
        let is_placed = |k: &usize| tasks[*k].external.is_none() && tasks[*k].led.is_none();
        (0..tasks.len()).filter(is_known).filter(is_placed).for_each(|k| {
            poses[self.frames + 1] = isometry(&tasks[k].pose) * self.tool;
            let is_asked = |[a, b]: [usize; 2]| of_tool(a) && with_part(b) || of_tool(b) && with_part(a);
            along.look_at(&self.machine.home, &poses, k, is_asked);
        });
        Some(along.finish()).filter(|found| found.state == ClearanceState::Hit)
    }

    /// Returns a pair with its names, which is met at point `k` or on the way there, or where the workpiece is put.
    fn named(&self, found: &Separation, k: Option<usize>, at: &Configuration) -> NearestBodies {
        let pair = found.pair.map(|body| &self.bodies()[body]);
        NearestBodies {
            names: pair.map(|body| body.name.clone()),
            distance_mm: found.distance_mm,
            is_assumed: pair.iter().any(|body| !body.grade.clears()),
            point: k,
            points_mm: found.points_mm.map(|point| point.coords.into()),
            at: at.clone(),
        }
    }

    /// Returns all bodies in the configuration `at` with the workpiece at `placement`, for drawings.
    #[must_use]
    pub fn outlines(&self, at: &Configuration, placement: &Placement) -> Vec<BodyOutline> {
        let mut poses = vec![Isometry3::identity(); self.frames + 2];
        self.place(at, &isometry(&placement.pose()), &mut Vec::new(), &mut poses);
        let tenths = |x: f64| (10.0 * x).round() / 10.0 + 0.0;
        let outline = |body: &Body| BodyOutline {
            name: body.name.clone(),
            is_moving: ![O_FRAME, WORKPIECE_FRAME, self.frames].contains(&body.frame),
            shapes_mm: body
                .outlines(&poses[body.frame])
                .iter()
                .map(|shape| shape.iter().map(|point| point.coords.map(tenths).into()).collect())
                .collect(),
        };
        self.bodies().iter().map(outline).collect()
    }

    /// Writes the poses of all frames in a configuration with the workpiece placed at `workpiece`; `own` is storage.
    fn place(
        &self,
        at: &Configuration,
        workpiece: &Isometry3<f64>,
        own: &mut Vec<Isometry3<f64>>,
        poses: &mut [Isometry3<f64>],
    ) {
        self.machine.frame_poses(at, own);
        poses[..self.frames].copy_from_slice(own);
        poses[self.frames] = poses[WORKPIECE_FRAME] * workpiece;
        poses[self.frames + 1] = poses[PLATFORM_FRAME] * self.tool;
    }
}

/// What is found so far of some pairs.
#[derive(Debug, Default)]
struct Found {
    /// No distance is less, mm; `None` where nothing was looked at.
    least_mm: Option<f64>,
    nearest: Option<NearestBodies>,
    /// Lower bounds of the distances at the last point, mm; empty where they are not known.
    margins_mm: Vec<f64>,
}

impl Found {
    /// Notes that bodies may come as near as this, mm.
    fn lower(&mut self, distance_mm: f64) {
        if distance_mm < self.least_mm.unwrap_or(f64::INFINITY) {
            self.least_mm = Some(distance_mm);
        }
    }

    /// Notes a pair, if none was nearer.
    fn note(&mut self, found: NearestBodies) {
        if self.nearest.as_ref().is_none_or(|known| found.distance_mm < known.distance_mm) {
            self.nearest = Some(found);
        }
    }
}

/// What is known so far along a path.
pub struct ClearanceAlong<'c> {
    cell: &'c MachineCell,
    /// What is found of the pairs of each of [`MachineCell::cells`].
    found: [Found; 2],
    /// What the workpiece stands in.
    standing: Vec<NearestBodies>,
    workpiece: Isometry3<f64>,
    /// Whether the first hit is enough.
    ends_at_hit: bool,
    clearance: PathClearance,
    said: BTreeSet<String>,
    /// Configuration at the last point.
    before: Option<Configuration>,
    /// The tool at the first point.
    tool: Option<u32>,
    /// Number of points so far.
    count: usize,
}

impl<'c> ClearanceAlong<'c> {
    /// Returns how near bodies come along the points added.
    #[must_use]
    pub fn finish(mut self) -> PathClearance {
        self.clearance.at_least_mm = self.least_mm();
        let mut all = self.standing;
        all.extend(self.found.into_iter().filter_map(|own| own.nearest));
        let known = &self.clearance;
        let rank = |own: &NearestBodies| match own.distance_mm {
            overlap if overlap <= TOUCHING_MM && known.is_too_near(overlap) => (0, own.is_assumed),
            near if known.is_too_near(near) => (1, own.is_assumed),
            _ => (2, false),
        };
        all.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.distance_mm.total_cmp(&b.distance_mm)));
        let hits = all.iter().filter(|own| known.is_too_near(own.distance_mm)).count();
        all.truncate(hits.max(1));
        let mut all = all.into_iter();
        self.clearance.nearest = all.next();
        self.clearance.also = all.collect();
        self.clearance.state = self.clearance.known();
        self.clearance
    }

    /// No distance so far is less, mm; `None` where nothing was looked at.
    fn least_mm(&self) -> Option<f64> {
        let standing = self.standing.iter().map(|own| own.distance_mm);
        standing.chain(self.found.iter().filter_map(|own| own.least_mm)).reduce(f64::min)
    }

    /// Looks no further than to the first hit.
    #[must_use]
    pub fn to_first_hit(self) -> Self {
        Self { ends_at_hit: true, ..self }
    }

    /// Returns whether bodies hit along the points added so far.
    #[must_use]
    pub fn hits(&self) -> bool {
        self.least_mm().is_some_and(|least| self.clearance.is_too_near(least))
    }

    /// Adds the way to the next point of the path, and that point: its task, and the configuration `at` it, if the machine reaches it.
    pub fn add(&mut self, task: &TaskPoint, at: Option<&Configuration>, to: Arrival) {
        let k = self.count;
        self.count += 1;
        let before = std::mem::replace(&mut self.before, at.cloned());
        let margins_mm = [0, 1].map(|own| std::mem::take(&mut self.found[own].margins_mm));
        let first = k == 0;
        self.tool = self.tool.or(to.tool);
        let Some(here) = at else { return self.leave_out("points that the machine does not reach") };
        if task.external.is_some() || task.led.is_some() {
            return self.leave_out("ways along which external axes may move");
        }
        let is_other = to.tool.is_some_and(|tool| self.tool != Some(tool));
        let motion = match (&before, first) {
            _ if is_other => Err("ways of other tools than the first: what is on the tool is on that one".into()),
            (_, true) => self.motion(here, here, Way::Followed),
            (Some(from), _) => self.motion(from, here, to.way),
            (None, _) => Err("ways from points that the machine does not reach".into()),
        };
        match motion {
            Ok(own) => {
                let mut motion = CellMotion { cell: self.cell, workpiece: self.workpiece, own, poses: Vec::new() };
                for (own, margins_mm) in margins_mm.into_iter().enumerate() {
                    self.sweep(&mut motion, k, own, margins_mm);
                }
            }
            Err(why) => {
                self.leave_out(&why);
                let (cell, on_tool) = (self.cell, self.cell.frames + 1);
                let mut poses = vec![Isometry3::identity(); on_tool + 1];
                cell.place(here, &self.workpiece, &mut Vec::new(), &mut poses);
                self.look_at(here, &poses, k, |pair| {
                    !is_other || pair.iter().all(|&own| cell.bodies()[own].frame != on_tool)
                });
            }
        }
    }

    /// Returns the motion of the machine on the way from one point to the next. `Err` with the ways of which it is not known.
    fn motion(
        &self,
        from: &Configuration,
        to: &Configuration,
        way: Way,
    ) -> std::result::Result<MachineMotion<'c>, String> {
        let machine: &'c Machine = &self.cell.machine;
        let is_arm = machine.chains.len() == 1 && machine.chains[0].passive.is_empty();
        let turned = rotation_log(&(to.pose.rotation * from.pose.rotation.transpose())).norm();
        match (way, self.cell.own.rapid) {
            (Way::Rapid, Some(RapidMove::Linear)) if turned > STEADY_RAD => {
                Err("rapid moves that turn the tool, whose axes may turn it another way".into())
            }
            (Way::Followed, _) | (Way::Rapid, Some(RapidMove::Linear)) => MachineMotion::straight(machine, from, to),
            (Way::PointToPoint, _) if is_arm => MachineMotion::joints(machine, from, to),
            (Way::PointToPoint, Some(RapidMove::Linear)) => MachineMotion::straight(machine, from, to),
            (Way::Rapid | Way::PointToPoint, Some(RapidMove::Joint)) => MachineMotion::joints(machine, from, to),
            (Way::Rapid | Way::PointToPoint, Some(RapidMove::PerAxis)) => {
                Err("rapid moves of axes one by one, which may be anywhere between the ends".into())
            }
            (Way::Rapid | Way::PointToPoint, None) => {
                Err("rapid moves, as the process does not say how the control makes them ([cell] rapid)".into())
            }
            (Way::Curve, _) => Err("splines, of which only the ends are known".into()),
            (Way::Unknown, _) => {
                Err("ways whose start the program does not say, as after G28 or a change of tools".into())
            }
        }
    }

    /// Says what could not be looked at.
    pub fn leave_out(&mut self, what: &str) {
        if self.said.insert(what.into()) {
            self.clearance.not_looked_at.push(what.into());
        }
    }

    /// Looks at the configuration at point `k` alone, to which the way is not known, with its `poses`, at the pairs that are asked for: it may hit, and
    /// clears nothing.
    fn look_at(
        &mut self,
        at: &Configuration,
        poses: &[Isometry3<f64>],
        k: usize,
        is_asked: impl Fn([usize; 2]) -> bool,
    ) {
        let cell = self.cell;
        for (own, found) in cell.cells.iter().zip(&mut self.found) {
            self.clearance.effort[1] += 1;
            let nearest = own.nearest_of(poses, &is_asked);
            if let Some(nearest) = nearest.filter(|own| self.clearance.is_too_near(own.distance_mm)) {
                found.lower(nearest.distance_mm);
                found.note(cell.named(&nearest, Some(k), at));
            }
        }
    }

    /// Looks at a motion to point `k`, at the pairs number `own`.
    fn sweep(&mut self, motion: &mut CellMotion<'_>, k: usize, own: usize, mut margins_mm: Vec<f64>) {
        let (cell, pairs) = (self.cell, &self.cell.cells[own]);
        if pairs.pairs().is_empty() || self.ends_at_hit && self.hits() {
            return;
        }
        let wanted_mm = cell.own.clearance_mm.max(f64::MIN_POSITIVE);
        let (enough_mm, beyond_mm) = match self.ends_at_hit {
            // How near they come is not asked, if it is far enough.
            true => (wanted_mm, wanted_mm),
            false => (-DEEP_MM, self.found[own].least_mm.unwrap_or(f64::INFINITY)),
        };
        let options =
            SweepOptions { wanted_mm, enough_mm, beyond_mm, max_states: MAX_STATES, ..SweepOptions::default() };
        let nearest = pairs.sweep_on(motion, cell.frames + 2, &options, &mut margins_mm);
        self.clearance.effort[1] += nearest.states;
        self.clearance.effort[2] += nearest.searches;
        let found = &mut self.found[own];
        found.margins_mm = margins_mm;
        let upper = nearest.at.map_or(f64::INFINITY, |(_, own)| own.distance_mm);
        if let Some((s, own)) = &nearest.at
            && let Ok(at) = motion.own.configuration(*s)
        {
            found.note(cell.named(own, Some(k), &at));
        }
        match nearest.end {
            SweepEnd::Whole if nearest.lower_mm.is_finite() => found.lower(nearest.lower_mm),
            SweepEnd::Whole => {}
            // What was looked at hits, and no more is known.
            _ if self.clearance.is_too_near(upper) => found.lower(upper),
            SweepEnd::Enough | SweepEnd::Undecided => {
                found.lower(upper);
                self.leave_out("ways next to singular postures, of which bounds do not tell how near bodies come");
            }
            SweepEnd::Broken(why) => {
                found.lower(upper);
                self.leave_out(&format!("a way of which a state is not known: {why}"));
            }
        }
    }
}

/// Bodies that stand on one another may overlap by so much, mm.
pub(crate) const TOUCHING_MM: f64 = 0.05;
/// How much more bodies overlap is not looked for, mm.
const DEEP_MM: f64 = 5.0;
/// Said where no body is the cutter.
const NO_CUTTER: &str = "the cutter: no body reaches the tool tip ([tools.N] of a [stock], or on = \"tool\", gives it)";
/// A body that comes so near to the tool tip reaches it, mm.
const TIP_MM: f64 = 1.0;
/// A rapid move that turns the tool by less turns it about one axis, rad.
const STEADY_RAD: f64 = 0.035;
/// States at most that are looked at between two points of a path.
const MAX_STATES: usize = 10_000;

/// The motion of all frames: those of the machine, the workpiece's and the tool's.
struct CellMotion<'c> {
    cell: &'c MachineCell,
    workpiece: Isometry3<f64>,
    own: MachineMotion<'c>,
    poses: Vec<Isometry3<f64>>,
}

impl Motion for CellMotion<'_> {
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> std::result::Result<(), String> {
        let at = self.own.configuration(s)?;
        self.cell.place(&at, &self.workpiece, &mut self.poses, poses);
        Ok(())
    }

    fn speed(&mut self, frame: usize, ball: &Ball, interval: [f64; 2]) -> f64 {
        let count = self.cell.frames;
        match frame.checked_sub(count) {
            None => self.own.speed(frame, ball, interval),
            // The workpiece is at rest.
            Some(0) => 0.0,
            Some(_) => {
                let ball = Ball { centre_mm: self.cell.tool * ball.centre_mm, ..*ball };
                self.own.speed(PLATFORM_FRAME, &ball, interval)
            }
        }
    }
}

/// Returns a pose as an isometry.
fn isometry(pose: &Pose) -> Isometry3<f64> {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation);
    Isometry3::from_parts(pose.translation.into(), nalgebra::UnitQuaternion::from_rotation_matrix(&rotation))
}
