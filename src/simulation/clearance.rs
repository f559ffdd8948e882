//! How near the bodies of machine, tool, workpiece and cell come along a path: between its points by bounds, not by samples.

use std::{collections::BTreeSet, sync::Arc};

use kinetostat_cell::{Ball, Cell, Motion, SweepOptions};
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::{
    compensation::TaskPoint,
    input::error::Result,
    machine::{Configuration, Machine, MachineMotion, O_FRAME, PLATFORM_FRAME, WORKPIECE_FRAME},
    process::{
        Placement,
        file::ProcessCell,
        file::tables::cell::{CellFrame, RapidMove},
    },
    spatial::Pose,
};

/// Bodies of a machine and of what surrounds it, and the pairs of them that are to be apart along a path.
#[derive(Debug)]
pub struct MachineCell {
    machine: Machine,
    own: Arc<ProcessCell>,
    cell: Cell,
    /// What moves with the workpiece, and what stands where it is put.
    standing: Cell,
    /// Number of the machine's bodies, which come first.
    of_machine: usize,
    /// Number of the machine's frames; those of the workpiece and of the tool follow.
    frames: usize,
    /// The tool in platform axes.
    tool: Isometry3<f64>,
}

/// How near bodies come along a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathClearance {
    /// Least distance that is wanted, mm.
    pub wanted_mm: f64,
    /// No distance is less, mm, along what could be looked at; `None` without pairs.
    pub at_least_mm: Option<f64>,
    /// Where bodies come nearest.
    pub nearest: Option<NearestBodies>,
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
    /// Index of the point of the path behind which it is.
    pub point: usize,
    /// A point of each, O, mm.
    pub points_mm: [[f64; 3]; 2],
}

/// What is known of the clearance along a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClearanceState {
    /// Bodies touch, or come nearer than is wanted.
    Hit,
    /// Nothing that was looked at hits, but not all is known or could be looked at.
    Unknown,
    /// All bodies stay apart.
    Clear,
}

impl PathClearance {
    /// Returns what is known; assumed shapes may be in the way, and never clear it.
    #[must_use]
    pub fn state(&self) -> ClearanceState {
        match self.at_least_mm {
            Some(least) if least < self.wanted_mm || least <= 0.0 => ClearanceState::Hit,
            _ if !self.assumed.is_empty() || !self.not_looked_at.is_empty() => ClearanceState::Unknown,
            _ => ClearanceState::Clear,
        }
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
        let may_touch = |a: usize, b: usize| {
            let on = [at[a], at[b]];
            // Where the tool is as wide as the cut, the cut says what it meets of the part.
            let cuts = on.contains(&frames) && on.contains(&(frames + 1));
            let on = on.map(|frame| if frame == frames + 1 { PLATFORM_FRAME } else { frame });
            let is_joined = on[0] == on[1] || joined.contains(&[on[0].min(on[1]), on[0].max(on[1])]);
            let is_listed =
                |pair: &[String; 2]| *pair == [names[a].as_str(), &names[b]] || *pair == [names[b].as_str(), &names[a]];
            let listed = machine.may_touch().iter().chain(&own.may_touch);
            cuts || is_joined || on.into_iter().all(is_at_rest) || listed.into_iter().any(is_listed)
        };
        let standing = Cell::new(bodies.clone(), |a, b| {
            let is_listed =
                |pair: &[String; 2]| *pair == [names[a].as_str(), &names[b]] || *pair == [names[b].as_str(), &names[a]];
            let is_put = (at[a] == frames) != (at[b] == frames);
            let stands = [at[a], at[b]].into_iter().all(is_at_rest);
            !is_put || !stands || machine.may_touch().iter().chain(&own.may_touch).any(is_listed)
        });
        let cell = Cell::new(bodies, may_touch);
        let (machine, own, tool) = (machine.clone(), own.clone(), isometry(&machine.tool()));
        let found = Self { machine, own, cell, standing, of_machine, frames, tool };
        found.check_home()?;
        Ok(found)
    }

    /// Gathers the bodies as [`MachineCell::new`]; `None` where the process names no cell.
    ///
    /// # Errors
    /// As there.
    pub fn of(machine: &Machine, own: Option<&Arc<ProcessCell>>) -> Result<Option<Arc<Self>>> {
        own.map(|own| Self::new(machine, own).map(Arc::new)).transpose()
    }

    /// Says what the workpiece at `placement`, or what moves with it, would stand in; `None` where it stands free.
    #[must_use]
    pub fn stands_in(&self, placement: &Placement) -> Option<String> {
        let mut poses = vec![Isometry3::identity(); self.frames + 2];
        self.place(&self.machine.home, &isometry(&placement.pose()), &mut Vec::new(), &mut poses);
        let found = self.standing.nearest(&poses).filter(|found| found.distance_mm < -TOUCHING_MM)?;
        let [a, b] = found.pair.map(|body| &self.standing.bodies()[body].name);
        Some(format!("{a} and {b} would overlap by {:.1} mm", -found.distance_mm))
    }

    /// Checks that no bodies of machine and tool overlap at home.
    fn check_home(&self) -> Result<()> {
        let mut poses = vec![Isometry3::identity(); self.frames + 2];
        self.place(&self.machine.home, &Isometry3::identity(), &mut Vec::new(), &mut poses);
        // What surrounds the machine is asked of the path.
        let is_of_part = |body: usize| {
            body >= self.of_machine && [O_FRAME, WORKPIECE_FRAME, self.frames].contains(&self.cell.bodies()[body].frame)
        };
        for found in self.cell.separations(&poses) {
            if found.distance_mm < 0.0 && !found.pair.into_iter().any(is_of_part) {
                let [a, b] = found.pair.map(|body| &self.cell.bodies()[body].name);
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
        let bodies = self.cell.bodies();
        let looked_at: BTreeSet<usize> = self.cell.pairs().iter().flatten().copied().collect();
        let assumed = looked_at.into_iter().map(|body| &bodies[body]).filter(|body| !body.grade.clears());
        let clearance = PathClearance {
            wanted_mm: self.own.clearance_mm,
            assumed: assumed.map(|body| body.name.clone()).collect(),
            effort: [self.cell.pairs().len(), 0, 0],
            ..PathClearance::default()
        };
        ClearanceAlong {
            cell: self,
            workpiece: isometry(&placement.pose()),
            ends_at_hit: false,
            clearance,
            said: BTreeSet::new(),
            before: None,
            count: 0,
        }
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

/// What is known so far along a path.
pub struct ClearanceAlong<'c> {
    cell: &'c MachineCell,
    workpiece: Isometry3<f64>,
    /// Whether the first hit is enough.
    ends_at_hit: bool,
    clearance: PathClearance,
    said: BTreeSet<String>,
    /// Configuration at the last point.
    before: Option<Configuration>,
    /// Number of points so far.
    count: usize,
}

impl ClearanceAlong<'_> {
    /// Returns how near bodies come along the points added.
    #[must_use]
    pub fn finish(self) -> PathClearance {
        self.clearance
    }

    /// Looks no further than to the first hit.
    #[must_use]
    pub fn to_first_hit(self) -> Self {
        Self { ends_at_hit: true, ..self }
    }

    /// Returns how near bodies come along the points added so far.
    #[must_use]
    pub fn so_far(&self) -> &PathClearance {
        &self.clearance
    }

    /// Adds the way to the next point of the path, and that point: its task, the configuration `at` it, if the machine reaches it, and whether the way is rapid.
    pub fn add(&mut self, task: &TaskPoint, at: Option<&Configuration>, is_rapid: bool) {
        let k = self.count;
        self.count += 1;
        let before = std::mem::replace(&mut self.before, at.cloned());
        let Some(to) = at else { return self.not_looked_at("points that the machine does not reach") };
        if task.external.is_some() || task.led.is_some() {
            return self.not_looked_at("ways along which external axes move");
        }
        let (from, is_rapid) = match &before {
            Some(from) => (from, is_rapid),
            None if k == 0 => (to, false),
            None => return self.not_looked_at("ways from points that the machine does not reach"),
        };
        let machine = &self.cell.machine;
        let motion = match self.cell.own.rapid {
            Some(RapidMove::Joint) if is_rapid => MachineMotion::joints(machine, from, to),
            Some(RapidMove::PerAxis) if is_rapid => {
                Err("rapid moves of axes one by one, which may be anywhere between the ends".into())
            }
            None if is_rapid => {
                Err("rapid moves, as the process does not say how the control makes them ([cell] rapid)".into())
            }
            _ => MachineMotion::straight(machine, from, to),
        };
        match motion {
            Ok(motion) => self.sweep(motion, k),
            Err(why) => self.not_looked_at(&why),
        }
    }

    fn not_looked_at(&mut self, what: &str) {
        if self.said.insert(what.into()) {
            self.clearance.not_looked_at.push(what.into());
        }
    }

    /// Looks at a motion to point `k`.
    fn sweep(&mut self, motion: MachineMotion<'_>, k: usize) {
        let cell = self.cell;
        let mut motion = CellMotion { cell, workpiece: self.workpiece, own: motion, poses: Vec::new() };
        let least = self.clearance.at_least_mm.unwrap_or(f64::INFINITY);
        let enough_mm = if self.ends_at_hit { cell.own.clearance_mm } else { f64::NEG_INFINITY };
        let options = SweepOptions { enough_mm, beyond_mm: least, max_states: MAX_STATES, ..SweepOptions::default() };
        match cell.cell.sweep(&mut motion, cell.frames + 2, &options) {
            Err(why) => self.not_looked_at(&format!("a way of which a state is not known: {why}")),
            Ok(found) => {
                self.clearance.effort[1] += found.states;
                self.clearance.effort[2] += found.searches;
                let bodies = cell.cell.bodies();
                if found.lower_mm < least {
                    self.clearance.at_least_mm = Some(found.lower_mm);
                }
                let known = self.clearance.nearest.as_ref().map_or(f64::INFINITY, |own| own.distance_mm);
                if let Some((_, own)) = found.at.filter(|(_, own)| own.distance_mm < known) {
                    let pair = own.pair.map(|body| &bodies[body]);
                    self.clearance.nearest = Some(NearestBodies {
                        names: pair.map(|body| body.name.clone()),
                        distance_mm: own.distance_mm,
                        is_assumed: pair.iter().any(|body| !body.grade.clears()),
                        point: k,
                        points_mm: own.points_mm.map(|point| point.coords.into()),
                    });
                }
            }
        }
    }
}

/// Bodies that stand on one another may overlap by so much, mm.
const TOUCHING_MM: f64 = 0.05;
/// States at most that are looked at between two points of a path.
const MAX_STATES: usize = 20_000;

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
