//! Uncondensed linear system of a chain with its loops, for the full solver and for load steps.

use nalgebra::DMatrix;

use super::{ChainSystem, LoopSystem};
use crate::lanes::Vec3;

/// Rotations that turn the first frame of a loop: rows in the assembled system, and angular velocities.
type Turns = Vec<(usize, Vec3<f64>)>;

impl ChainSystem<f64> {
    /// Number of unknowns: dθ, −dF̂, dq of the route, and behind them those of its loops.
    pub fn unknown_count(&self) -> usize {
        self.route_unknown_count() + self.loops.iter().map(|inner| inner.system.unknown_count()).sum::<usize>()
    }

    /// The loops of the route, each with the row of its first unknown, where the system begins at row `start`.
    fn loops_with_rows(&self, start: usize) -> impl Iterator<Item = (&LoopSystem<f64>, usize)> {
        let mut first = start + self.route_unknown_count();
        self.loops.iter().map(move |inner| {
            let row = first;
            first += inner.system.unknown_count();
            (inner, row)
        })
    }

    /// Writes the system before elimination into `matrix` from row `start` on, coupled with the platform's twist in row `platform`.
    pub fn assemble(&self, matrix: &mut DMatrix<f64>, start: usize, platform: usize) {
        self.assemble_route(matrix, start, &Vec::new());
        for i in 0..6 {
            let row = start + self.wrench_row() + i;
            matrix[(row, platform + i)] = -1.0;
            matrix[(platform + i, row)] = -1.0;
        }
    }

    /// Writes the system of a route and its loops into `matrix` from row `start` on; `turned_by` turns its first frame.
    fn assemble_route(&self, matrix: &mut DMatrix<f64>, start: usize, turned_by: &Turns) {
        let count = self.route_unknown_count();
        for i in 0..count {
            for j in 0..count {
                matrix[(start + i, start + j)] += self.matrix.get(i.min(j), i.max(j));
            }
            for &(row, turn) in turned_by {
                let columns = 0..self.turn_count;
                let value: f64 = columns.map(|k| self.matrix.get(i, self.turn_column() + k) * turn.0[k]).sum();
                matrix[(start + i, row)] += value;
                matrix[(row, start + i)] += value;
            }
        }
        for (inner, first) in self.loops_with_rows(start) {
            let own = inner.turns_before.iter().filter(|(row, _)| *row < count).map(|&(row, turn)| (start + row, turn));
            let turns: Turns = own.chain(turned_by.iter().copied()).collect();
            inner.system.assemble_route(matrix, first, &turns);
            for (row, twist) in &inner.motions_between {
                for (i, part) in twist.to_array().into_iter().enumerate() {
                    let closure = first + inner.system.wrench_row() + i;
                    matrix[(closure, start + row)] -= part;
                    matrix[(start + row, closure)] -= part;
                }
            }
        }
    }

    /// Right-hand sides before elimination: `S z + rhs − [dt in the wrench rows] = 0`, in the order of the unknowns.
    pub fn right_hand_sides(&self) -> Vec<f64> {
        let rhs = self.rhs_column();
        let mut right: Vec<f64> = (0..self.route_unknown_count()).map(|row| self.matrix.get(row, rhs)).collect();
        for inner in &self.loops {
            let moment = inner.system.closure_moment();
            for (row, twist) in &inner.motions_between {
                right[*row] += twist.angular.dot(moment);
            }
        }
        for inner in &self.loops {
            right.extend(inner.system.right_hand_sides());
        }
        right
    }

    /// Right-hand sides of the route only, before elimination, without the terms of its loops' closure errors.
    pub fn route_right_hand_sides(&self) -> Vec<f64> {
        (0..self.route_unknown_count()).map(|row| self.matrix.get(row, self.rhs_column())).collect()
    }

    /// Subtracts `share` of `amounts` from the right-hand sides of the route before elimination, but for those of its closure.
    pub fn subtract_share(&mut self, amounts: &[f64], share: f64) {
        let (rhs, wrench) = (self.rhs_column(), self.wrench_row());
        for row in (0..wrench).chain(wrench + 6..self.route_unknown_count()) {
            *self.matrix.at(row, rhs) -= share * amounts[row];
        }
    }

    /// Rows of all closure equations (six of the chain's route, then six of each loop) in a matrix where this system begins at row `start`.
    pub fn closure_rows(&self, start: usize) -> Vec<usize> {
        let first_closure_row = start + self.wrench_row();
        let loop_rows = self.loops_with_rows(start).flat_map(|(inner, first)| inner.system.closure_rows(first));
        (first_closure_row..first_closure_row + 6).chain(loop_rows).collect()
    }

    /// Row of a chain coordinate where the first unknown is in row `start`; `None` if neither the route nor its loops move it.
    pub fn row_of(&self, coordinate: usize, start: usize) -> Option<usize> {
        match self.rows[coordinate] {
            usize::MAX => self.loops_with_rows(start).find_map(|(inner, first)| inner.system.row_of(coordinate, first)),
            row => Some(start + row),
        }
    }

    /// Sets the unknowns found by another solver, in the order of [`ChainSystem::assemble`].
    pub fn set_solution(&mut self, unknowns: &[f64]) {
        let (route_part, mut rest) = unknowns.split_at(self.route_unknown_count());
        self.solution[..route_part.len()].copy_from_slice(route_part);
        for inner in &mut self.loops {
            let (within, others) = rest.split_at(inner.system.unknown_count());
            inner.system.set_solution(within);
            inner.twist = [0.0; 6];
            for &(row, twist) in &inner.motions_between {
                for (entry, part) in inner.twist.iter_mut().zip(twist.to_array()) {
                    *entry += part * route_part[row];
                }
            }
            rest = others;
        }
    }

    /// The unknowns last solved for, in the order of [`ChainSystem::assemble`].
    pub fn unknowns(&self) -> Vec<f64> {
        let mut unknowns = self.solution[..self.route_unknown_count()].to_vec();
        unknowns.extend(self.loops.iter().flat_map(|inner| inner.system.unknowns()));
        unknowns
    }

    /// The loops of the route.
    pub fn loops(&self) -> &[LoopSystem<f64>] {
        &self.loops
    }

    /// The loops of the route, to be changed.
    pub fn loops_mut(&mut self) -> &mut [LoopSystem<f64>] {
        &mut self.loops
    }
}

impl LoopSystem<f64> {
    /// Closure error of the loop: shift in the axes of the frame where it starts, turn in those of the frame where it ends.
    pub fn closure(&self, route: &ChainSystem<f64>) -> crate::lanes::Screw<f64> {
        let error = self.system.closure;
        crate::lanes::Screw {
            linear: self.start.inward(error.linear),
            angular: route.frames[self.to].inward(error.angular),
        }
    }
}
