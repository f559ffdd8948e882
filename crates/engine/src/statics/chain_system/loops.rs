//! Loops of a route: parallel branches between two of its frames S and I, each condensed to a 6×6 stiffness at I as a chain is at P.
//!
//! All is seen in O's axes, and S as if at rest: what a loop does depends on the twist of I against S, which the elementary motions between them
//! make, and on the turn of S against gravity, which those before S make. With F the wrench that the loop receives at I, those between do the
//! work `J_a·F` on it, and `dF = K dt + D dρ + G dφ`. The wrench is kept in the axes of S, where it stays as it is when all that is before S
//! moves. The antisymmetric parts of the loop's and of the route's wrench-weighted Hessian are each other's negative.

use super::{ChainInput, ChainResidual, ChainSystem};
use crate::{
    lanes::{Frame, Real, Screw, Vec3, pairs, rotation_exp},
    machine::{Chain, Loop, Route},
    statics::transmission::Scale,
};

/// System of a loop, and its connection to its route.
#[derive(Debug, Clone)]
pub(in crate::statics) struct LoopSystem<R> {
    pub system: ChainSystem<R>,
    from: usize,
    pub(super) to: usize,
    /// Number of loops within it.
    inner_count: usize,
    /// The frame S where it starts.
    pub(super) start: Frame<R>,
    /// Row, and twist of I, of each elementary motion between S and I.
    pub(super) motions_between: Vec<(usize, Screw<R>)>,
    /// Row, and angular velocity, of each rotation before S.
    pub(super) turns_before: Vec<(usize, Vec3<R>)>,
    /// Twist of I against S in the last step.
    pub(super) twist: [R; 6],
    /// Where its end is to be held instead of at I: shift in the axes of S (mm), rotation in those of I (rad).
    pub shift: Option<Screw<f64>>,
}

impl<R: Real> LoopSystem<R> {
    /// System of the loop `inner` of `chain`.
    pub fn new(chain: &Chain, inner: &Loop, scale: Scale) -> Self {
        let routes = inner.route.with_loops();
        let moves = |coordinate: &usize| routes.iter().any(|route| route.coordinates().contains(coordinate));
        let joints: Vec<usize> = (0..chain.drives.len()).filter(|&d| moves(&chain.drives[d].coordinate)).collect();
        let has_column = |&drive: &usize| joints.iter().any(|&joint| chain.joint_per_drive(joint, drive) != 0.0);
        let drives = (0..chain.drives.len()).filter(has_column).collect();
        Self {
            system: ChainSystem::for_route(chain, &inner.route, drives, true, scale),
            from: inner.from,
            to: inner.to,
            inner_count: inner.route.loop_count(),
            start: Frame { axes: [Vec3::zero(); 3], origin: Vec3::zero() },
            motions_between: Vec::new(),
            turns_before: Vec::new(),
            twist: [R::zero(); 6],
            shift: None,
        }
    }
}

/// Product of a 6×3 matrix by `rows` and the rotation `turn`.
#[inline(always)]
fn product_with_turn<R: Real>(turn: Vec3<R>, rows: &[[R; 3]; 6]) -> [R; 6] {
    let mut column = [R::zero(); 6];
    for (entry, row) in pairs(column.iter_mut(), rows) {
        *entry = row[0] * turn.0[0] + row[1] * turn.0[1] + row[2] * turn.0[2];
    }
    column
}

/// Work of `wrench` on the motion `screw`.
#[inline(always)]
fn work<R: Real>(screw: &Screw<R>, wrench: &[R; 6]) -> R {
    screw.dot(Screw::from_array(*wrench))
}

// Loops contain loops: what calls itself cannot be inlined, and so is compiled for vectors anew.
impl<R: Real> ChainSystem<R> {
    /// Fills the systems of the loops, and adds the wrenches that they receive to the system of the route.
    pub(super) fn fill_loops(&mut self, chain: &Chain, route: &Route, input: &ChainInput<'_, R>) {
        R::vectorized(
            #[inline(always)]
            || {
                let mut loops = std::mem::take(&mut self.loops);
                let mut first = 0;
                for (own, inner) in pairs(&mut loops, &route.loops) {
                    let (start, mut target) = (self.frames[own.from], self.frames[own.to]);
                    let stored = input.loops[first];
                    let wrench = Screw { linear: start.outward(stored.linear), angular: start.outward(stored.angular) };
                    self.record_motions(own, target.origin);
                    self.add_reaction(own, wrench);
                    if let Some(shift) = &own.shift {
                        let splat = |v: Vec3<f64>| Vec3(v.0.map(R::splat));
                        target.origin += start.outward(splat(shift.linear));
                        target.axes = target.turned_axes(&rotation_exp(target.outward(splat(shift.angular))));
                    }
                    let within =
                        ChainInput { wrench, loops: &input.loops[first + 1..first + 1 + own.inner_count], ..*input };
                    let base = start.compose(&inner.route.base);
                    own.system.fill_route(chain, &inner.route, &base, &target, &within);
                    own.start = start;
                    first += 1 + own.inner_count;
                }
                self.loops = loops;
            },
        );
    }

    /// Records the elementary motions between the ends of a loop, whose end is at `end` in O, and the rotations before it.
    #[inline(always)]
    fn record_motions(&self, own: &mut LoopSystem<R>, end: Vec3<R>) {
        let (first, last) = (self.moves_before[own.from], self.moves_before[own.to]);
        own.motions_between.clear();
        for j in first..last {
            let (coordinate, twist) = self.screws[j];
            let at_end = Screw { linear: self.velocity_at(j, end), angular: twist.angular };
            own.motions_between.push((self.rows[coordinate], at_end));
        }
        own.turns_before.clear();
        if own.system.turn_count == 0 {
            return;
        }
        for &(coordinate, twist) in &self.screws[..first] {
            if self.is_rotation[coordinate] {
                own.turns_before.push((self.rows[coordinate], twist.angular));
            }
        }
        // What turns the route turns the loop.
        for i in 0..self.turn_count {
            let mut axis = Vec3::zero();
            axis.0[i] = R::splat(1.0);
            own.turns_before.push((self.turn_column() + i, axis));
        }
    }

    /// Adds the work of the wrench that a loop receives, and its part in the Hessian: `ω_k · (v_j × f + ½ ω_j × m)`.
    #[inline(always)]
    fn add_reaction(&mut self, own: &LoopSystem<R>, wrench: Screw<R>) {
        let (rhs, first) = (self.rhs_column(), self.moves_before[own.from]);
        let half_moment = wrench.angular.scale(R::splat(0.5));
        for (j, &(row, twist)) in own.motions_between.iter().enumerate() {
            *self.matrix.at(row, rhs) += twist.dot(wrench);
            let lever = twist.linear.cross(wrench.linear) + twist.angular.cross(half_moment);
            for (k, (_, earlier)) in own.motions_between[..=j].iter().enumerate() {
                self.add_second_derivative(first + j, first + k, earlier.angular.dot(lever));
            }
        }
    }

    /// Condenses the loops and adds them to the system of the route; returns the lanes in which that works.
    pub(super) fn condense_loops(&mut self) -> u8 {
        R::vectorized(
            #[inline(always)]
            || {
                let mut loops = std::mem::take(&mut self.loops);
                let mut good = R::ALL;
                for own in &mut loops {
                    good &= own.system.eliminate();
                    good &= own.system.eliminate_slacks();
                    self.add_condensed_loop(own);
                }
                self.loops = loops;
                good
            },
        )
    }

    /// Adds a condensed loop to the system of the route: its stiffness, forces, drives and turn.
    #[inline(always)]
    fn add_condensed_loop(&mut self, own: &LoopSystem<R>) {
        let inner = &own.system;
        let (rhs, turn_column) = (self.rhs_column(), self.turn_column());
        let mut held = inner.held_wrench();
        let moment = inner.closure_moment();
        for i in 0..3 {
            held[3 + i] += moment.0[i];
        }
        let mut stiffness = [[R::zero(); 6]; 6];
        for (i, row) in stiffness.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = inner.stiffness(i, j);
            }
        }
        for &(row, ref twist) in &own.motions_between {
            let mut force = [R::zero(); 6];
            for (entry, by) in pairs(force.iter_mut(), &stiffness) {
                *entry = work(twist, by);
            }
            for &(other, ref other_twist) in &own.motions_between {
                if row <= other {
                    *self.matrix.at(row, other) += work(other_twist, &force);
                }
            }
            *self.matrix.at(row, rhs) += work(twist, &held);
            for (column, drive) in inner.drives.iter().enumerate() {
                let target = self.column_of(*drive);
                *self.matrix.at(row, target) += work(twist, &inner.drive_wrench(column));
            }
        }
        if own.turns_before.is_empty() {
            return;
        }
        // Twist of I and turn of S, turn and turn, turn and right-hand side, turn and drives.
        let by_turn = inner.turn_wrenches();
        let own_turns = inner.turn_moments();
        for (k, &(row, axis)) in own.turns_before.iter().enumerate() {
            let force = product_with_turn(axis, &by_turn);
            for &(other, ref twist) in &own.motions_between {
                *self.matrix.at(row.min(other), row.max(other)) += work(twist, &force);
            }
            let moment =
                Vec3([Vec3(own_turns[0]).dot(axis), Vec3(own_turns[1]).dot(axis), Vec3(own_turns[2]).dot(axis)]);
            for (l, &(other, other_axis)) in own.turns_before.iter().enumerate() {
                if row < other || row == other && k <= l {
                    let value = other_axis.dot(moment);
                    let twice = row == other && k != l;
                    *self.matrix.at(row, other) += if twice { value + value } else { value };
                }
            }
            let by_rest = inner.turn_moment_by_column(0).dot(axis);
            *self.matrix.at(row.min(rhs), row.max(rhs)) += by_rest;
            for (column, &drive) in inner.drives.iter().enumerate() {
                let value = inner.turn_moment_by_column(1 + column).dot(axis);
                let target = self.column_of(drive);
                *self.matrix.at(row.min(target), row.max(target)) += value;
            }
        }
        debug_assert!(turn_column >= rhs);
    }

    /// Column of a drive of the chain.
    #[inline(always)]
    fn column_of(&self, drive: usize) -> usize {
        let mut column = self.rhs_column() + 1;
        for &own in &self.drives {
            if own == drive {
                break;
            }
            column += 1;
        }
        column
    }

    /// First column of the turn in a matrix whose right-hand side is column `rhs`.
    #[inline(always)]
    fn turn_column_from(&self, rhs: usize) -> usize {
        rhs + 1 + self.drives.len()
    }

    /// Wrench per turn against gravity, by rows, after [`ChainSystem::eliminate`].
    #[inline(always)]
    fn turn_wrenches(&self) -> [[R; 3]; 6] {
        let (matrix, rhs) = self.condensed_matrix();
        let (turn, twist) = (self.turn_column_from(rhs), self.twist_column_from(rhs));
        let mut wrenches = [[R::zero(); 3]; 6];
        for (i, row) in wrenches.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = matrix.get(turn + j, twist + i);
            }
        }
        wrenches
    }

    /// Moment at the start of the loop per turn against gravity, after [`ChainSystem::eliminate`].
    #[inline(always)]
    fn turn_moments(&self) -> [[R; 3]; 3] {
        let (matrix, rhs) = self.condensed_matrix();
        let turn = self.turn_column_from(rhs);
        let mut moments = [[R::zero(); 3]; 3];
        for (i, row) in moments.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = matrix.get(turn + i.min(j), turn + i.max(j));
            }
        }
        moments
    }

    /// Moment at the start of the loop by the right-hand side (0) or per unit motion of a drive, after [`ChainSystem::eliminate`].
    #[inline(always)]
    fn turn_moment_by_column(&self, column: usize) -> Vec3<R> {
        let (matrix, rhs) = self.condensed_matrix();
        let turn = self.turn_column_from(rhs);
        let mut moment = [R::zero(); 3];
        for (i, entry) in moment.iter_mut().enumerate() {
            *entry = matrix.get(rhs + column, turn + i);
        }
        Vec3(moment)
    }

    /// Computes the unknowns of the loops from those of the route. `drives`: steps of the drives that have a column here.
    pub(super) fn substitute_loops(&mut self, residual: f64, drives: &[R]) {
        R::vectorized(
            #[inline(always)]
            || {
                let mut loops = std::mem::take(&mut self.loops);
                for own in &mut loops {
                    let mut twist = Screw::zero();
                    for &(row, screw) in &own.motions_between {
                        twist.linear += screw.linear.scale(self.solution[row]);
                        twist.angular += screw.angular.scale(self.solution[row]);
                    }
                    let mut turn = Vec3::zero();
                    for &(row, axis) in &own.turns_before {
                        turn += axis.scale(self.solution[row]);
                    }
                    own.twist = twist.to_array();
                    let mut drive_steps = std::mem::take(&mut own.system.drive_steps);
                    drive_steps.clear();
                    for drive in &own.system.drives {
                        let column = self.column_of(*drive) - self.rhs_column() - 1;
                        drive_steps.push(drives.get(column).copied().unwrap_or(R::zero()));
                    }
                    let turn = if own.system.turn_count > 0 { &turn.0[..] } else { &[] };
                    own.system.substitute_route(residual, &own.twist, &drive_steps, turn, None);
                    if !own.system.loops.is_empty() {
                        own.system.substitute_loops(residual, &drive_steps);
                    }
                    own.system.drive_steps = drive_steps;
                }
                self.loops = loops;
            },
        );
    }

    /// Step of a chain coordinate that a loop moves; zero for any other.
    pub(super) fn step_in_loops(&self, coordinate: usize) -> R {
        for own in &self.loops {
            let system = &own.system;
            if system.rows[coordinate] != usize::MAX {
                return system.solution[system.rows[coordinate]];
            }
            if system.loops.iter().any(|inner| inner.system.moves_coordinate(coordinate)) {
                return system.step_in_loops(coordinate);
            }
        }
        R::zero()
    }

    /// Whether the route or one of its loops moves a chain coordinate.
    fn moves_coordinate(&self, coordinate: usize) -> bool {
        self.rows[coordinate] != usize::MAX || self.loops.iter().any(|inner| inner.system.moves_coordinate(coordinate))
    }

    /// The larger of `largest` and the largest rotation in the steps of the loops, rad.
    pub(super) fn largest_rotation_in_loops(&self, mut largest: R) -> R {
        for own in &self.loops {
            largest = largest.larger(R::vectorized(
                #[inline(always)]
                || own.system.largest_rotation(),
            ));
        }
        largest
    }

    /// The larger residuals of the route (`own`) and of its loops.
    pub(super) fn residual_with_loops(&self, own: ChainResidual<R>, characteristic_length: f64) -> ChainResidual<R> {
        let mut all = own;
        for inner in &self.loops {
            let residual = R::vectorized(
                #[inline(always)]
                || inner.system.residual(characteristic_length),
            );
            all = ChainResidual { gap: all.gap.larger(residual.gap), force: all.force.larger(residual.force) };
        }
        all
    }

    /// Calls `each` with the step of each loop's wrench, in the axes of the frame where the loop starts, in the order of `ChainState::loops`.
    pub fn loop_wrench_steps(&self, each: &mut impl FnMut([R; 6])) {
        for own in &self.loops {
            let step = R::vectorized(
                #[inline(always)]
                || {
                    let step = Screw::from_array(own.system.wrench_step(&own.twist));
                    Screw { linear: own.start.inward(step.linear), angular: own.start.inward(step.angular) }.to_array()
                },
            );
            each(step);
            own.system.loop_wrench_steps(each);
        }
    }
}
