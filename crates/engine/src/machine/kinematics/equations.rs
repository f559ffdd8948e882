//! The closure equations of a machine with what is commanded, linearised at a configuration in each lane.

use crate::{
    lanes::{Frame, Real, Screw, Vec3, clear, copy, pairs, rotation_exp, rotation_log},
    machine::{Chain, Coordinate, Machine, Motion, Route},
    spatial::Pose,
};

/// Command in each lane: a pose of P or the drives.
#[derive(Clone, Copy)]
pub(super) enum LaneCommand<'a, R> {
    /// The controlled task coordinates of this pose.
    Task(&'a Frame<R>),
    /// The drives.
    Drives(&'a [R]),
}

/// Rigid configuration of a machine in each lane.
#[derive(Clone, Copy)]
pub(super) struct RigidState<'a, R> {
    pub platform: &'a Frame<R>,
    pub drives: &'a [R],
    /// Passive joint coordinates of each chain.
    pub passive: &'a [Vec<R>],
}

/// Elementary motions and frames of a route.
#[derive(Debug, Clone)]
struct RouteMotions<R> {
    screws: Vec<(usize, Screw<R>)>,
    frames: Vec<Frame<R>>,
}

/// The unknowns that move a chain coordinate, and by how much.
type Columns = Vec<(usize, f64)>;

/// Residual and Jacobian of the closure equations, in mm: rotations (errors and unknowns alike) are multiplied by the characteristic length.
///
/// Unknowns: twist of P (6), drives, passive joints chain by chain. Rows: six for each route that must end somewhere, a chain's
/// before those of its loops; then those of what is commanded.
#[derive(Debug, Clone)]
pub(super) struct Equations<R> {
    pub rows: usize,
    pub unknowns: usize,
    /// Characteristic length, mm.
    scale: f64,
    /// By columns.
    pub jacobian: Vec<R>,
    pub residual: Vec<R>,
    /// Chain coordinates of the chain under way.
    values: Vec<R>,
    /// Motions and frames of routes, one entry for each depth of loops.
    walks: Vec<RouteMotions<R>>,
    columns: Vec<Vec<Columns>>,
}

/// Columns of the coordinates of each chain; none for those of springs, which stay undeflected.
fn coordinate_columns(machine: &Machine) -> Vec<Vec<Columns>> {
    let (mut drive, mut joint) = (6, 6 + machine.drive_count());
    let chain_columns = |chain: &Chain| {
        let mut columns = vec![Columns::new(); chain.virtual_count];
        for (shown, moved) in chain.drives.iter().enumerate() {
            columns[moved.coordinate] = match &chain.coupling {
                None => vec![(drive + shown, 1.0)],
                Some(coupling) => {
                    let shares = coupling.per_shown.row(shown);
                    let shares = shares.iter().enumerate().filter(|(_, share)| **share != 0.0);
                    shares.map(|(other, share)| (drive + other, *share)).collect()
                }
            };
        }
        columns.extend((joint..joint + chain.passive.len()).map(|column| vec![(column, 1.0)]));
        drive += chain.drives.len();
        joint += chain.passive.len();
        columns
    };
    machine.chains.iter().map(chain_columns).collect()
}

impl<R: Real> Equations<R> {
    /// Storage for the equations of `machine`, not linearised yet.
    pub fn new(machine: &Machine) -> Self {
        let passive: usize = machine.chains.iter().map(|chain| chain.passive.len()).sum();
        Self {
            rows: 0,
            scale: machine.characteristic_length,
            unknowns: 6 + machine.drive_count() + passive,
            jacobian: Vec::new(),
            residual: Vec::new(),
            values: Vec::new(),
            walks: Vec::new(),
            columns: coordinate_columns(machine),
        }
    }

    /// Computes residual and Jacobian at `at`, with rows for `command` behind those of the closures.
    #[inline(always)]
    pub fn linearise(&mut self, machine: &Machine, at: &RigidState<'_, R>, command: &LaneCommand<'_, R>) {
        let closures = 6 * machine.closure_count();
        let rows = closures
            + match command {
                LaneCommand::Task(_) => machine.controls.len(),
                LaneCommand::Drives(_) => machine.drive_count(),
            };
        if self.rows != rows {
            self.rows = rows;
            self.jacobian = vec![R::zero(); rows * self.unknowns];
            self.residual = vec![R::zero(); rows];
        }
        clear(&mut self.jacobian);
        let (mut drive, mut row) = (0, 0);
        let (mut walks, columns) = (std::mem::take(&mut self.walks), std::mem::take(&mut self.columns));
        for ((chain, columns), passive) in pairs(pairs(&machine.chains, &columns), at.passive) {
            let drives = &at.drives[drive..drive + chain.drives.len()];
            self.values.resize(chain.coordinate_count(), R::zero());
            clear(&mut self.values);
            chain.add_joint_positions(drives, &mut self.values);
            copy(&mut self.values[chain.virtual_count..], passive);
            for i in 0..6 {
                self.jacobian[i * rows + row + i] = R::splat(-1.0);
            }
            let start = Frame::splat(&Pose::identity());
            self.route_rows(&chain.route, columns, &start, at.platform, &mut row, &mut walks);
            drive += drives.len();
        }
        (self.walks, self.columns) = (walks, columns);
        self.command_rows(machine, at, command, closures);
    }

    /// Fills the rows from `row` on: of `route`, which starts at `start` and should end at `target`, then of its loops; moves `row` behind them.
    #[inline(always)]
    fn route_rows(
        &mut self,
        route: &Route,
        columns: &[Columns],
        start: &Frame<R>,
        target: &Frame<R>,
        row: &mut usize,
        walks: &mut Vec<RouteMotions<R>>,
    ) {
        let mut walk = walks.pop().unwrap_or(RouteMotions { screws: Vec::new(), frames: Vec::new() });
        walk.screws.clear();
        walk.frames.clear();
        // Loops ask for the motions by their number.
        let keeps_all = !route.loops.is_empty();
        let end = route.propagate(
            start.compose(&route.base),
            &self.values,
            #[inline(always)]
            |coordinate, screw| {
                if keeps_all || !columns[coordinate].is_empty() {
                    walk.screws.push((coordinate, screw));
                }
            },
            #[inline(always)]
            |frame| walk.frames.push(frame),
        );
        for (_, screw) in &mut walk.screws {
            screw.linear += screw.angular.cross(end.origin);
        }
        let gap = end.origin - target.origin;
        let turn = rotation_log(end.rotation_from(target)).scale(R::splat(self.scale));
        copy(&mut self.residual[*row..], &Screw { linear: gap, angular: turn }.to_array());
        for (coordinate, screw) in &walk.screws {
            self.add_screw(*row, &columns[*coordinate], screw, 1.0);
        }
        *row += 6;
        if keeps_all {
            self.loop_rows(route, columns, end.origin, &walk, row, walks);
        }
        walks.push(walk);
    }

    /// Fills the rows of the loops of `route`, which ends at `end`. A recursive function cannot be inlined, and so is vectorised by itself.
    fn loop_rows(
        &mut self,
        route: &Route,
        columns: &[Columns],
        end: Vec3<R>,
        walk: &RouteMotions<R>,
        row: &mut usize,
        walks: &mut Vec<RouteMotions<R>>,
    ) {
        R::vectorized(
            #[inline(always)]
            || {
                let before = route.moves_before_frames();
                for inner in &route.loops {
                    let (from, to) = (walk.frames[inner.from], walk.frames[inner.to]);
                    let first = *row;
                    self.route_rows(&inner.route, columns, &from, &to, row, walks);
                    // What the frame at the loop's end does with the motions between its ends.
                    for (coordinate, screw) in &walk.screws[before[inner.from]..before[inner.to]] {
                        let mut screw = *screw;
                        screw.linear += screw.angular.cross(to.origin - end);
                        self.add_screw(first, &columns[*coordinate], &screw, -1.0);
                    }
                }
            },
        );
    }

    /// Adds `sign` times an elementary motion to the rows from `row` on, in the columns of its coordinate.
    #[inline(always)]
    fn add_screw(&mut self, row: usize, columns: &Columns, screw: &Screw<R>, sign: f64) {
        for &(column, share) in columns {
            let share = R::splat(sign * share);
            let [x, y, z] = screw.angular.0;
            let is_revolute = !(x.all_zero() && y.all_zero() && z.all_zero());
            let unit = R::splat(if is_revolute { 1.0 / self.scale } else { 1.0 });
            let entries = &mut self.jacobian[column * self.rows + row..][..6];
            for i in 0..3 {
                entries[i] += share * screw.linear.0[i] * unit;
                entries[3 + i] += share * screw.angular.0[i];
            }
        }
    }

    /// Fills the rows of `command`, from row `first` on.
    #[inline(always)]
    fn command_rows(&mut self, machine: &Machine, at: &RigidState<'_, R>, command: &LaneCommand<'_, R>, first: usize) {
        let scale = R::splat(machine.characteristic_length);
        match command {
            LaneCommand::Drives(target) => {
                let mut d = 0;
                for chain in &machine.chains {
                    for drive in &chain.drives {
                        self.residual[first + d] =
                            (at.drives[d] - target[d]) * R::splat(mm_per_unit(machine, drive.motion));
                        self.jacobian[(6 + d) * self.rows + first + d] = R::splat(1.0);
                        d += 1;
                    }
                }
            }
            LaneCommand::Task(target) => {
                let [x, y, z] = at.platform.axes;
                let turn = rotation_log([target.inward(x), target.inward(y), target.inward(z)]);
                for (row, coordinate) in machine.controls.iter().enumerate() {
                    self.residual[first + row] = match *coordinate {
                        Coordinate::Translation(axis) => at.platform.origin.0[axis] - target.origin.0[axis],
                        Coordinate::Rotation(axis) => turn.0[axis] * scale,
                    };
                    for i in 0..6 {
                        self.jacobian[i * self.rows + first + row] = task_entry(*coordinate, target, i);
                    }
                }
            }
        }
    }
}

/// Factor from the coordinate of a joint (mm, rad) to a length in mm: 1, or the characteristic length.
pub(super) fn mm_per_unit(machine: &Machine, motion: Motion) -> f64 {
    motion.choose(1.0, machine.characteristic_length)
}

/// Derivative of a task coordinate by unknown `i` of the twist of P, the platform pose `target` being commanded.
#[inline(always)]
pub(super) fn task_entry<R: Real>(coordinate: Coordinate, target: &Frame<R>, i: usize) -> R {
    match coordinate {
        Coordinate::Translation(axis) if i == axis => R::splat(1.0),
        Coordinate::Rotation(axis) if (3..6).contains(&i) => target.axes[axis].0[i - 3],
        _ => R::zero(),
    }
}

/// Moves `platform` by a twist of P whose rotations are multiplied by `scale`, mm.
#[inline(always)]
pub(super) fn move_platform<R: Real>(platform: &Frame<R>, twist: &[R], scale: f64) -> Frame<R> {
    let scale = R::splat(scale);
    let rotation = Vec3([twist[3] / scale, twist[4] / scale, twist[5] / scale]);
    let turn = Frame { axes: rotation_exp(rotation), origin: Vec3::zero() };
    let [x, y, z] = platform.axes;
    let translation = Vec3([twist[0], twist[1], twist[2]]);
    Frame { axes: [turn.outward(x), turn.outward(y), turn.outward(z)], origin: platform.origin + translation }
}
