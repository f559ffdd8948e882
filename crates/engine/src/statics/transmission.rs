//! Reduction of a chain of rigid or nearly rigid links to the wrenches that it transmits.
//!
//! Where springs alone do not let a chain's end move in six directions, the chain has no compliance to invert; where links hold some of them far
//! stiffer than the drives, its stiffness has no digits left for the others. Its `p` free joints leave `6 − p` wrenches that it transmits. An
//! orthogonal transformation `Qᵀ` of the closure equations makes `J_q` triangular: the first `p` give dq, the others, of those f, hold no dq:
//!
//! ```text
//!          dθ      f     y      1     dρ    dt
//! ∂/∂θ     Ã_θθ    J̃ᵀ    ·      r̃     −k    Ã_θt
//! closure          −s    1      c̃     ·     −Q̃ᵀ
//! ∂/∂y                   −1/s   ·     ·     ·
//! ```
//!
//! Motions of drives and the turn of a loop have columns such as the right-hand side's (dρ, dφ), without part in the closure.
//!
//! Directions in which the chain is rigid have no pivot in `D = J̃ Ã_θθ⁻¹ J̃ᵀ`, so each wrench gets a slack spring of compliance s in series, and
//! a motion y that takes its deflection back: `y = s f`. Exact elimination of y, in the chain where it is elastic or else on the platform
//! ([`Transmission::eliminate_slacks`], [`super::rigid_directions`]), leaves no trace of s; up to there all pivots are regular.

use nalgebra::Matrix6;

use super::bordered::Bordered;
use crate::{
    lanes::{Real, clear, copy, pairs, subtract},
    machine::{Chain, Machine, Motion, MoveScrew, Route, Spring, SpringLaw},
    spatial::Pose,
};

/// A joint whose screw has less than this fraction of itself outside the span of the joints before it is not free of them.
const INDEPENDENT: f64 = 1e-6;
/// A joint whose stiffness is less than this fraction of the terms that make it up is idle.
const IDLE: f64 = 1e-9;
/// A slack whose chain takes back less than this fraction of it is rigid.
const RIGID: f64 = 1e-9;
/// A link that yields less than this fraction of the slack in some direction leaves too few digits to what is softer.
const NEARLY_RIGID: f64 = 1e-5;

/// Length and compliance that make the quantities of a machine's chains comparable.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Length by which rotations are multiplied, mm.
    pub length: f64,
    /// Compliance s of the slack springs, mm/N: a tenth of that of the softest drive.
    pub slack: f64,
}

impl Scale {
    /// Scale of `machine`, by its characteristic length and its softest drive.
    pub fn for_machine(machine: &Machine) -> Self {
        let length = machine.characteristic_length;
        let compliances = machine.drives().map(|(_, d)| d.motion.choose(1.0, length * length) / d.stiffness);
        let softest = compliances.fold(0.0, f64::max);
        Self { length, slack: if softest > 0.0 { 0.1 * softest } else { 1e-6 } }
    }

    /// Whether a link of this `stiffness` is nearly rigid in some direction.
    fn is_nearly_rigid(&self, stiffness: &Matrix6<f64>) -> bool {
        let lever = |i: usize| if i < 3 { 1.0 } else { self.length };
        let at_length = Matrix6::from_fn(|i, j| stiffness[(i, j)] / (lever(i) * lever(j)));
        at_length.symmetric_eigenvalues().max() * self.slack * NEARLY_RIGID > 1.0
    }
}

/// Known steps for which unknowns are substituted: factor of the residual, twist of the target, drive steps, turn of the first frame.
pub(super) struct KnownStep<'a, R> {
    pub residual: f64,
    pub dt: &'a [R; 6],
    pub drives: &'a [R],
    pub turn: &'a [R],
}

/// A chain reduced to its springs and the wrenches it transmits. Unknowns, in this order: coordinates that stay, f, y; then
/// the known columns: right-hand side (1), motion of the drives and turn, dt (6).
#[derive(Debug, Clone)]
pub(super) struct Transmission<R> {
    scale: Scale,
    /// Rows in the chain's system of the coordinates that stay: virtual ones, and joints that depend on others.
    remaining: Vec<usize>,
    virtual_count: usize,
    /// Sum of the sizes of the terms that make up the stiffness of each joint among `remaining`.
    joint_terms: Vec<R>,
    /// Rows of the joints whose steps follow from the closure equations.
    pivots: Vec<usize>,
    /// Number of the columns of drives and turn; and the forces that they have in `pivots`, if they may have any.
    extra: usize,
    extra_forces: Vec<[R; 6]>,
    /// Closure equations in the basis Q: by `pivots`, `remaining`, right-hand side, dt.
    columns: Vec<[R; 6]>,
    /// Inverse diagonal of the triangle that `pivots` make.
    inverse: [R; 6],
    /// By `remaining`, right-hand side, dt: motions of the pivot joints, and the forces in them.
    motions: Vec<[R; 6]>,
    forces: Vec<[R; 6]>,
    reduced: Bordered<R>,
    solution: Vec<R>,
}

impl<R: Real> Transmission<R> {
    /// Reduction of a `route` of `chain` that moves these `coordinates`, with `extra` columns of drives and turn, which may have forces in
    /// passive joints. `None` for routes with an elastic link, whose ends move in six directions by it, each by about as much as by drives.
    pub fn new(
        chain: &Chain,
        route: &Route,
        coordinates: &[usize],
        extra: usize,
        has_extra_forces: bool,
        scale: Scale,
    ) -> Option<Self> {
        let is_elastic = |spring: &Spring| {
            let SpringLaw::Link(stiffness) = &spring.law else { return false };
            coordinates.contains(&spring.start) && !scale.is_nearly_rigid(stiffness)
        };
        if chain.springs.iter().any(is_elastic) {
            return None;
        }
        let virtual_count = coordinates.iter().filter(|&&coordinate| coordinate < chain.virtual_count).count();
        let row = |i: usize| if i < virtual_count { i } else { i + 6 };
        let independent = independent_joints(chain, route, coordinates, scale.length);
        let is_pivot = |i: &usize| independent.contains(&coordinates[*i]);
        let remaining: Vec<usize> = (0..coordinates.len()).filter(|i| !is_pivot(i)).map(row).collect();
        let pivots: Vec<usize> = (0..coordinates.len()).filter(is_pivot).map(row).collect();
        let known = remaining.len() + 7;
        let size = remaining.len() + 2 * (6 - pivots.len()) + 1 + extra + 6;
        Some(Self {
            scale,
            virtual_count,
            joint_terms: vec![R::zero(); remaining.len() - virtual_count],
            extra,
            extra_forces: vec![[R::zero(); 6]; if has_extra_forces { extra } else { 0 }],
            columns: vec![[R::zero(); 6]; pivots.len() + known],
            inverse: [R::zero(); 6],
            motions: vec![[R::zero(); 6]; known],
            forces: vec![[R::zero(); 6]; known],
            reduced: Bordered::new(size),
            solution: vec![R::zero(); size],
            remaining,
            pivots,
        })
    }

    /// Number of wrenches the chain transmits.
    #[inline(always)]
    pub fn wrench_count(&self) -> usize {
        6 - self.pivots.len()
    }

    /// Stiffness of the slack springs, N/mm.
    pub fn slack_stiffness(&self) -> f64 {
        1.0 / self.scale.slack
    }

    /// Row of the first slack.
    #[inline(always)]
    fn first_slack_row(&self) -> usize {
        self.remaining.len() + self.wrench_count()
    }

    /// Right-hand column of the reduced system.
    #[inline(always)]
    pub fn rhs_column(&self) -> usize {
        self.first_slack_row() + self.wrench_count()
    }

    /// The reduced system: rows of slacks and known columns, after [`Transmission::eliminate`].
    #[inline(always)]
    pub fn reduced(&self) -> &Bordered<R> {
        &self.reduced
    }

    /// Eliminates all unknowns but the slacks from the chain's system `matrix`, whose wrench rows begin at `wrench_row` and whose
    /// right-hand side is column `rhs`; returns the lanes in which that works.
    #[inline(always)]
    pub fn eliminate(&mut self, matrix: &Bordered<R>, wrench_row: usize, rhs: usize) -> u8 {
        self.copy_closure(matrix, wrench_row, rhs);
        let good = self.make_triangular();
        self.fill_reduced(matrix, rhs);
        let (size, remaining) = (self.reduced.size(), self.remaining.len());
        let mut good = good & self.reduced.eliminate(0..self.virtual_count, size, 1.0, 0.0);
        for (joint, &terms) in self.joint_terms.iter().enumerate() {
            good &= self.reduced.eliminate_or_leave(self.virtual_count + joint, R::splat(IDLE) * terms);
        }
        good & self.reduced.eliminate(remaining..self.first_slack_row(), size, -1.0, 0.0)
    }

    /// Eliminates the slacks as well; returns the lanes in which the chain is elastic in all wrenches that it transmits.
    #[inline(always)]
    pub fn eliminate_slacks(&mut self) -> u8 {
        let (size, least) = (self.reduced.size(), RIGID / self.scale.slack);
        self.reduced.eliminate(self.first_slack_row()..self.rhs_column(), size, -1.0, least)
    }

    /// Copies the closure equations of `matrix` into `columns`, rotations taken at the characteristic length.
    #[inline(always)]
    fn copy_closure(&mut self, matrix: &Bordered<R>, wrench_row: usize, rhs: usize) {
        let (one, length) = (R::splat(1.0), R::splat(self.scale.length));
        let levers = [one, one, one, length, length, length];
        let pivots = self.pivots.len();
        let (columns, twists) = self.columns.split_at_mut(pivots + self.remaining.len() + 1);
        for (k, column) in columns.iter_mut().enumerate() {
            let source =
                if k < pivots { self.pivots[k] } else { self.remaining.get(k - pivots).map_or(rhs, |&row| row) };
            for (i, entry) in column.iter_mut().enumerate() {
                let row = wrench_row + i;
                *entry = matrix.get(row.min(source), row.max(source)) * levers[i];
            }
        }
        for (k, column) in twists.iter_mut().enumerate() {
            *column = [R::zero(); 6];
            column[k] = -levers[k];
        }
    }

    /// Makes the closure equations triangular by Householder reflections; returns the lanes in which the pivot joints are independent.
    #[inline(always)]
    fn make_triangular(&mut self) -> u8 {
        let mut good = R::ALL;
        for j in 0..self.pivots.len() {
            let (first, others) = self.columns.split_at_mut(j + 1);
            let column = &mut first[j];
            let mut above = R::zero();
            for &entry in &column[..j] {
                above += entry * entry;
            }
            let mut square = R::zero();
            for &entry in &column[j..] {
                square += entry * entry;
            }
            let bound = R::splat(INDEPENDENT * INDEPENDENT) * (above + square);
            good &= R::mask_to_bits(square.greater(bound));
            let norm = square.sqrt();
            let head = column[j];
            let diagonal = R::select(head.greater(R::zero()), -norm, norm);
            column[j] = head - diagonal;
            let weight = R::splat(1.0) / (norm * (norm + head.abs()));
            for other in others {
                let mut along = R::zero();
                for (&mirror, &entry) in pairs(&column[j..], &other[j..]) {
                    along += mirror * entry;
                }
                along = along * weight;
                subtract(&mut other[j..], along, &column[j..]);
            }
            column[j] = diagonal;
            self.inverse[j] = R::splat(1.0) / diagonal;
        }
        good
    }

    /// Fills the reduced system: `Ã_ab = A_ab + A_aq W_b + W_aᵀ (A_qb + A_qq W_b)` with dq = W (dθ, 1, dt).
    #[inline(always)]
    fn fill_reduced(&mut self, matrix: &Bordered<R>, rhs: usize) {
        let (pivots, remaining, slack) = (self.pivots.len(), self.remaining.len(), self.scale.slack);
        let (first_slack_row, rhs_column) = (self.first_slack_row(), self.rhs_column());
        let twist_column = rhs_column + 1 + self.extra;
        let known = remaining + 7;
        // Column in the chain's system; dt has no entries in the rows of joints and springs.
        let source = |a: usize| if a < remaining { self.remaining[a] } else { rhs };
        let target = |a: usize| match a {
            a if a < remaining => a,
            a if a == remaining => rhs_column,
            a => twist_column + a - remaining - 1,
        };
        for a in 0..known {
            let column = &self.columns[pivots + a];
            let mut motion = [R::zero(); 6];
            for i in (0..pivots).rev() {
                let mut rest = column[i];
                for (later, &moved) in pairs(&self.columns[i + 1..pivots], &motion[i + 1..]) {
                    rest += later[i] * moved;
                }
                motion[i] = -(rest * self.inverse[i]);
            }
            let force = &mut self.forces[a];
            for (i, &row) in self.pivots.iter().enumerate() {
                let mut sum = R::zero();
                if a <= remaining {
                    let column = source(a);
                    sum = matrix.get(row.min(column), row.max(column));
                }
                for (k, &other) in self.pivots.iter().enumerate() {
                    sum += matrix.get(row.min(other), row.max(other)) * motion[k];
                }
                force[i] = sum;
            }
            self.motions[a] = motion;
        }
        self.reduced.clear();
        for (joint, terms) in self.joint_terms.iter_mut().enumerate() {
            let a = self.virtual_count + joint;
            let joint_row = self.remaining[a];
            *terms = matrix.get(joint_row, joint_row).abs();
            for (i, &row) in self.pivots.iter().enumerate() {
                let (motion, coupling) = (self.motions[a][i], matrix.get(row.min(joint_row), row.max(joint_row)));
                *terms += (motion * self.forces[a][i]).abs() + (motion * coupling).abs();
            }
        }
        for a in 0..known {
            for b in a..known {
                let mut sum = R::zero();
                if a < remaining && b <= remaining {
                    let (row, column) = (source(a), source(b));
                    sum = matrix.get(row.min(column), row.max(column));
                }
                for i in 0..pivots {
                    sum += self.motions[a][i] * self.forces[b][i];
                }
                if a <= remaining {
                    let column = source(a);
                    for (i, &row) in self.pivots.iter().enumerate() {
                        sum += matrix.get(row.min(column), row.max(column)) * self.motions[b][i];
                    }
                }
                *self.reduced.at(target(a), target(b)) = sum;
            }
            for (k, &entry) in self.columns[pivots + a][pivots..].iter().enumerate() {
                let (row, column) = (remaining + k, target(a));
                *self.reduced.at(row.min(column), row.max(column)) = entry;
            }
        }
        for extra in 0..self.extra {
            for (a, &row) in self.remaining.iter().enumerate() {
                *self.reduced.at(a, rhs_column + 1 + extra) = matrix.get(row, rhs + 1 + extra);
            }
        }
        if !self.extra_forces.is_empty() {
            self.add_extra_forces(matrix, rhs, target);
        }
        for k in 0..first_slack_row - remaining {
            *self.reduced.at(remaining + k, remaining + k) = R::splat(-slack);
            *self.reduced.at(remaining + k, first_slack_row + k) = R::splat(1.0);
            *self.reduced.at(first_slack_row + k, first_slack_row + k) = R::splat(-1.0 / slack);
        }
    }

    /// Adds the forces of the columns of drives and turn that act through the pivot joints to the reduced system.
    #[inline(always)]
    fn add_extra_forces(&mut self, matrix: &Bordered<R>, rhs: usize, target: impl Fn(usize) -> usize) {
        let (pivots, remaining, rhs_column) = (self.pivots.len(), self.remaining.len(), self.rhs_column());
        for (extra, forces) in self.extra_forces.iter_mut().enumerate() {
            let (from, to) = (rhs + 1 + extra, rhs_column + 1 + extra);
            for (force, &row) in pairs(forces.iter_mut(), &self.pivots) {
                *force = matrix.get(row, from);
            }
            for a in 0..remaining + 7 {
                let mut sum = R::zero();
                for (&motion, &force) in pairs(&self.motions[a][..pivots], &forces[..pivots]) {
                    sum += motion * force;
                }
                let column = target(a);
                *self.reduced.at(column.min(to), column.max(to)) += sum;
            }
            for other in extra..self.extra {
                *self.reduced.at(to, rhs_column + 1 + other) = matrix.get(from, rhs + 1 + other);
            }
            *self.reduced.at(rhs_column, to) += matrix.get(rhs, from);
        }
    }

    /// Computes the route's `unknowns` for the `known` steps and these `slacks`; `None`: as [`Transmission::eliminate_slacks`] has them.
    #[inline(always)]
    pub fn substitute(&mut self, known: KnownStep<'_, R>, slacks: Option<&[R]>, wrench_row: usize, unknowns: &mut [R]) {
        let KnownStep { residual, dt, drives, turn } = known;
        let (pivots, remaining) = (self.pivots.len(), self.remaining.len());
        let (first_slack_row, rhs) = (self.first_slack_row(), self.rhs_column());
        let twist = rhs + 1 + self.extra;
        clear(&mut self.solution[rhs..]);
        self.solution[rhs] = R::splat(residual);
        copy(&mut self.solution[rhs + 1..], drives);
        copy(&mut self.solution[twist - turn.len()..], turn);
        copy(&mut self.solution[twist..], dt);
        match slacks {
            Some(slacks) => {
                copy(&mut self.solution[first_slack_row..rhs], slacks);
                self.reduced.back_substitute(first_slack_row, &mut self.solution);
            }
            None => self.reduced.back_substitute(rhs, &mut self.solution),
        }
        let (mut motion, mut force) = ([R::zero(); 6], [R::zero(); 6]);
        for a in 0..remaining + 7 {
            let value = match a {
                a if a < remaining => self.solution[a],
                a if a == remaining => self.solution[rhs],
                a => self.solution[twist + a - remaining - 1],
            };
            for i in 0..pivots {
                motion[i] += self.motions[a][i] * value;
                force[i] += self.forces[a][i] * value;
            }
        }
        for (forces, &value) in pairs(&self.extra_forces, &self.solution[rhs + 1..]) {
            for i in 0..pivots {
                force[i] += forces[i] * value;
            }
        }
        let mut wrench = [R::zero(); 6];
        for i in 0..pivots {
            let mut rest = force[i];
            for (k, &earlier) in wrench[..i].iter().enumerate() {
                rest += self.columns[i][k] * earlier;
            }
            wrench[i] = -(rest * self.inverse[i]);
        }
        copy(&mut wrench[pivots..], &self.solution[remaining..first_slack_row]);
        for (&row, &value) in pairs(&self.remaining, &self.solution) {
            unknowns[row] = value;
        }
        for (&row, &value) in pairs(&self.pivots, &motion) {
            unknowns[row] = value;
        }
        for (k, column) in self.columns[pivots + remaining + 1..].iter().enumerate() {
            let mut sum = R::zero();
            for (&entry, &part) in pairs(column.iter(), &wrench) {
                sum -= entry * part;
            }
            unknowns[wrench_row + k] = sum;
        }
    }

    /// Row of slack `slack`.
    #[inline(always)]
    fn slack_row(&self, slack: usize) -> usize {
        self.first_slack_row() + slack
    }

    /// Wrench F̂ on the held platform per unit of slack `slack`, after [`Transmission::eliminate`].
    #[inline(always)]
    pub fn slack_wrench(&self, slack: usize) -> [R; 6] {
        let twist = self.rhs_column() + 1 + self.extra;
        let mut wrench = [R::zero(); 6];
        for (i, entry) in wrench.iter_mut().enumerate() {
            *entry = self.reduced.get(self.slack_row(slack), twist + i);
        }
        wrench
    }

    /// Entry of E, N/mm: the part of slack `slack` that remains per unit of slack `other`, the platform held.
    #[inline(always)]
    pub fn slack_response(&self, slack: usize, other: usize) -> R {
        let (a, b) = (self.slack_row(slack), self.slack_row(other));
        -self.reduced.get(a.min(b), a.max(b))
    }

    /// Force in slack `slack`, the platform held, by the right-hand side (`None`) or per unit motion of a drive.
    #[inline(always)]
    pub fn slack_force(&self, slack: usize, drive: Option<usize>) -> R {
        let column = self.rhs_column() + drive.map_or(0, |drive| 1 + drive);
        self.reduced.get(self.slack_row(slack), column)
    }
}

/// Coordinates of a route's passive joints whose screws are independent of those before them, at a configuration without symmetry.
fn independent_joints(chain: &Chain, route: &Route, coordinates: &[usize], scale: f64) -> Vec<usize> {
    let mut values = vec![0.0; chain.coordinate_count()];
    let offset = |coordinate: usize| 0.4 * libm::sin(1.0 + 2.3 * coordinate as f64);
    for drive in &chain.drives {
        let length = if drive.motion == Motion::Prismatic { scale } else { 1.0 };
        values[drive.coordinate] = drive.home + offset(drive.coordinate) * length;
    }
    for (j, joint) in chain.passive.iter().enumerate() {
        let coordinate = chain.passive_coordinate(j);
        let length = if joint.motion == Motion::Prismatic { scale } else { 1.0 };
        values[coordinate] = joint.home + offset(coordinate) * length;
    }
    let mut screws: Vec<MoveScrew> = Vec::new();
    route.forward(&Pose::identity(), &values, &mut screws, &mut Vec::new());
    let mut basis: Vec<nalgebra::Vector6<f64>> = Vec::new();
    let mut independent = Vec::new();
    for &coordinate in coordinates.iter().filter(|&&coordinate| coordinate >= chain.virtual_count) {
        let moves = screws.iter().filter(|screw| screw.coordinate == coordinate);
        let mut screw: nalgebra::Vector6<f64> = moves.map(|screw| screw.twist.to_vector()).sum();
        screw.fixed_rows_mut::<3>(3).scale_mut(scale);
        let size = screw.norm();
        // Twice, against rounding.
        for _ in 0..2 {
            for direction in &basis {
                screw -= direction * direction.dot(&screw);
            }
        }
        if screw.norm() > INDEPENDENT * size {
            basis.push(screw.normalize());
            independent.push(coordinate);
        }
    }
    independent
}
