//! A chain of rigid or nearly rigid links, seen through the wrenches that it transmits.
//!
//! Where springs alone do not let a chain's end move in six directions, the chain has no compliance to invert; where links hold
//! some of them a great deal stiffer than the drives, its stiffness has no digits left for the others. Its `p` free joints leave `6 − p` wrenches that it transmits. An orthogonal transformation `Qᵀ` of the closure equations makes
//! `J_q` triangular: the first `p` of them give dq, the others, which are those wrenches' f, hold no dq any more:
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
//! Directions in which the chain is rigid have no pivot in `D = J̃ Ã_θθ⁻¹ J̃ᵀ`, so each wrench gets a slack spring of
//! compliance s in series, and a motion y that takes its deflection back: `y = s f`. Exact elimination of y, in the chain
//! where it is elastic ([`Transmission::settle`]) or else on the platform ([`super::rigid_directions`]), leaves no trace of
//! s; up to there all pivots are regular.

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

/// What makes the quantities of a machine's chains comparable.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Length by which rotations are multiplied, mm.
    pub length: f64,
    /// Compliance s of the slack springs, mm/N: a tenth of that of the softest drive.
    pub slack: f64,
}

impl Scale {
    pub fn of(machine: &Machine) -> Self {
        let length = machine.characteristic_length;
        let compliances = machine.drives().map(|(_, drive)| drive.motion.of(1.0, length * length) / drive.stiffness);
        let softest = compliances.fold(0.0, f64::max);
        Self { length, slack: if softest > 0.0 { 0.1 * softest } else { 1e-6 } }
    }

    /// Whether a link of this stiffness is nearly rigid in some direction.
    fn is_nearly_rigid(&self, stiffness: &Matrix6<f64>) -> bool {
        let lever = |i: usize| if i < 3 { 1.0 } else { self.length };
        let at_length = Matrix6::from_fn(|i, j| stiffness[(i, j)] / (lever(i) * lever(j)));
        at_length.symmetric_eigenvalues().max() * self.slack * NEARLY_RIGID > 1.0
    }
}

/// What is known when the unknowns are substituted: share of the present residual, steps of the target, of the drives that
/// have a column and of the turn, if it has columns.
pub(super) struct Known<'a, R> {
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
    staying: Vec<usize>,
    virtual_count: usize,
    /// Of the joints among those: sum of the sizes of the terms that make up their stiffness.
    joint_terms: Vec<R>,
    /// Rows of the joints that closure equations give.
    given: Vec<usize>,
    /// Number of the columns of drives and turn; and the forces that they have in `given`, if they may have any.
    extra: usize,
    extra_forces: Vec<[R; 6]>,
    /// Closure equations in the basis Q: by `given`, `staying`, right-hand side, dt.
    columns: Vec<[R; 6]>,
    /// Inverse diagonal of the triangle that `given` make.
    inverse: [R; 6],
    /// By `staying`, right-hand side, dt: what `given` move, and the forces in them.
    motions: Vec<[R; 6]>,
    forces: Vec<[R; 6]>,
    reduced: Bordered<R>,
    solution: Vec<R>,
}

impl<R: Real> Transmission<R> {
    /// Of a route of `chain` that moves its coordinates `own`, with `extra` columns of drives and turn, which have forces in
    /// passive joints or not. `None` for routes with an elastic link, whose ends move in six directions by it, each by about as much as
    /// by drives.
    pub fn new(
        chain: &Chain,
        route: &Route,
        own: &[usize],
        extra: usize,
        has_extra_forces: bool,
        scale: Scale,
    ) -> Option<Self> {
        let is_elastic = |spring: &Spring| {
            let SpringLaw::Link(stiffness) = &spring.law else { return false };
            own.contains(&spring.start) && !scale.is_nearly_rigid(stiffness)
        };
        if chain.springs.iter().any(is_elastic) {
            return None;
        }
        let virtual_count = own.iter().filter(|&&coordinate| coordinate < chain.virtual_count).count();
        let row = |i: usize| if i < virtual_count { i } else { i + 6 };
        let independent = independent_joints(chain, route, own, scale.length);
        let is_given = |i: &usize| independent.contains(&own[*i]);
        let staying: Vec<usize> = (0..own.len()).filter(|i| !is_given(i)).map(row).collect();
        let given: Vec<usize> = (0..own.len()).filter(is_given).map(row).collect();
        let known = staying.len() + 7;
        let size = staying.len() + 2 * (6 - given.len()) + 1 + extra + 6;
        Some(Self {
            scale,
            virtual_count,
            joint_terms: vec![R::zero(); staying.len() - virtual_count],
            extra,
            extra_forces: vec![[R::zero(); 6]; if has_extra_forces { extra } else { 0 }],
            columns: vec![[R::zero(); 6]; given.len() + known],
            inverse: [R::zero(); 6],
            motions: vec![[R::zero(); 6]; known],
            forces: vec![[R::zero(); 6]; known],
            reduced: Bordered::new(size),
            solution: vec![R::zero(); size],
            staying,
            given,
        })
    }

    /// Number of wrenches the chain transmits.
    #[inline(always)]
    pub fn wrench_count(&self) -> usize {
        6 - self.given.len()
    }

    /// Stiffness of the slack springs, N/mm.
    pub fn slack_stiffness(&self) -> f64 {
        1.0 / self.scale.slack
    }

    /// Row of the first slack.
    #[inline(always)]
    fn slack_row(&self) -> usize {
        self.staying.len() + self.wrench_count()
    }

    /// Right-hand column of the reduced system.
    #[inline(always)]
    pub fn rhs_column(&self) -> usize {
        self.slack_row() + self.wrench_count()
    }

    /// What is left of the system.
    #[inline(always)]
    pub fn reduced(&self) -> &Bordered<R> {
        &self.reduced
    }

    /// Eliminates all unknowns but the slacks from the chain's system `matrix`, whose wrench rows begin at `wrench_row` and
    /// whose right-hand side is column `rhs`; the lanes in which that works.
    #[inline(always)]
    pub fn eliminate(&mut self, matrix: &Bordered<R>, wrench_row: usize, rhs: usize) -> u8 {
        self.take_closure(matrix, wrench_row, rhs);
        let good = self.make_triangular();
        self.project(matrix, rhs);
        let (size, staying) = (self.reduced.size(), self.staying.len());
        let mut good = good & self.reduced.eliminate(0..self.virtual_count, size, 1.0, 0.0);
        for (joint, &terms) in self.joint_terms.iter().enumerate() {
            good &= self.reduced.eliminate_or_leave(self.virtual_count + joint, R::splat(IDLE) * terms);
        }
        good & self.reduced.eliminate(staying..self.slack_row(), size, -1.0, 0.0)
    }

    /// Eliminates the slacks as well; the lanes in which the chain is elastic in all wrenches that it transmits.
    #[inline(always)]
    pub fn settle(&mut self) -> u8 {
        let (size, least) = (self.reduced.size(), RIGID / self.scale.slack);
        self.reduced.eliminate(self.slack_row()..self.rhs_column(), size, -1.0, least)
    }

    #[inline(always)]
    fn take_closure(&mut self, matrix: &Bordered<R>, wrench_row: usize, rhs: usize) {
        let (one, length) = (R::splat(1.0), R::splat(self.scale.length));
        let levers = [one, one, one, length, length, length];
        let given = self.given.len();
        let (columns, twists) = self.columns.split_at_mut(given + self.staying.len() + 1);
        for (k, column) in columns.iter_mut().enumerate() {
            let source = if k < given { self.given[k] } else { self.staying.get(k - given).map_or(rhs, |&row| row) };
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

    /// Turns the closure equations by Householder reflections; the lanes in which the given joints are independent.
    #[inline(always)]
    fn make_triangular(&mut self) -> u8 {
        let mut good = R::ALL;
        for j in 0..self.given.len() {
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
            good &= R::bits(square.greater(bound));
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
    fn project(&mut self, matrix: &Bordered<R>, rhs: usize) {
        let (given, staying) = (self.given.len(), self.staying.len());
        let (slack_row, rhs_column) = (self.slack_row(), self.rhs_column());
        let twist_column = rhs_column + 1 + self.extra;
        let known = staying + 7;
        // Column in the chain's system; dt has no entries in the rows of joints and springs.
        let source = |a: usize| if a < staying { self.staying[a] } else { rhs };
        let target = |a: usize| match a {
            a if a < staying => a,
            a if a == staying => rhs_column,
            a => twist_column + a - staying - 1,
        };
        for a in 0..known {
            let column = &self.columns[given + a];
            let mut motion = [R::zero(); 6];
            for i in (0..given).rev() {
                let mut rest = column[i];
                for (later, &moved) in pairs(&self.columns[i + 1..given], &motion[i + 1..]) {
                    rest += later[i] * moved;
                }
                motion[i] = -(rest * self.inverse[i]);
            }
            let force = &mut self.forces[a];
            for (i, &row) in self.given.iter().enumerate() {
                let mut sum = R::zero();
                if a <= staying {
                    let column = source(a);
                    sum = matrix.get(row.min(column), row.max(column));
                }
                for (k, &other) in self.given.iter().enumerate() {
                    sum += matrix.get(row.min(other), row.max(other)) * motion[k];
                }
                force[i] = sum;
            }
            self.motions[a] = motion;
        }
        self.reduced.clear();
        for (joint, terms) in self.joint_terms.iter_mut().enumerate() {
            let a = self.virtual_count + joint;
            let own = self.staying[a];
            *terms = matrix.get(own, own).abs();
            for (i, &row) in self.given.iter().enumerate() {
                let (motion, coupling) = (self.motions[a][i], matrix.get(row.min(own), row.max(own)));
                *terms += (motion * self.forces[a][i]).abs() + (motion * coupling).abs();
            }
        }
        for a in 0..known {
            for b in a..known {
                let mut sum = R::zero();
                if a < staying && b <= staying {
                    let (row, column) = (source(a), source(b));
                    sum = matrix.get(row.min(column), row.max(column));
                }
                for i in 0..given {
                    sum += self.motions[a][i] * self.forces[b][i];
                }
                if a <= staying {
                    let column = source(a);
                    for (i, &row) in self.given.iter().enumerate() {
                        sum += matrix.get(row.min(column), row.max(column)) * self.motions[b][i];
                    }
                }
                *self.reduced.at(target(a), target(b)) = sum;
            }
            for (k, &entry) in self.columns[given + a][given..].iter().enumerate() {
                let (row, column) = (staying + k, target(a));
                *self.reduced.at(row.min(column), row.max(column)) = entry;
            }
        }
        for extra in 0..self.extra {
            for (a, &row) in self.staying.iter().enumerate() {
                *self.reduced.at(a, rhs_column + 1 + extra) = matrix.get(row, rhs + 1 + extra);
            }
        }
        if !self.extra_forces.is_empty() {
            self.project_extra(matrix, rhs, target);
        }
        let slack = self.scale.slack;
        for k in 0..slack_row - staying {
            *self.reduced.at(staying + k, staying + k) = R::splat(-slack);
            *self.reduced.at(staying + k, slack_row + k) = R::splat(1.0);
            *self.reduced.at(slack_row + k, slack_row + k) = R::splat(-1.0 / slack);
        }
    }

    /// What the columns of drives and turn do through the joints that closure gives.
    #[inline(always)]
    fn project_extra(&mut self, matrix: &Bordered<R>, rhs: usize, target: impl Fn(usize) -> usize) {
        let (given, staying, rhs_column) = (self.given.len(), self.staying.len(), self.rhs_column());
        for (extra, forces) in self.extra_forces.iter_mut().enumerate() {
            let (from, to) = (rhs + 1 + extra, rhs_column + 1 + extra);
            for (force, &row) in pairs(forces.iter_mut(), &self.given) {
                *force = matrix.get(row, from);
            }
            for a in 0..staying + 7 {
                let mut sum = R::zero();
                for (&motion, &force) in pairs(&self.motions[a][..given], &forces[..given]) {
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

    /// The route's unknowns for what is `known`, into `unknowns` in the order of its system. The slacks are `slacks`, or, after
    /// [`Transmission::settle`], those of the route alone.
    #[inline(always)]
    pub fn substitute(&mut self, known: Known<'_, R>, slacks: Option<&[R]>, wrench_row: usize, unknowns: &mut [R]) {
        let Known { residual, dt, drives, turn } = known;
        let (given, staying) = (self.given.len(), self.staying.len());
        let (slack_row, rhs) = (self.slack_row(), self.rhs_column());
        let twist = rhs + 1 + self.extra;
        clear(&mut self.solution[rhs..]);
        self.solution[rhs] = R::splat(residual);
        copy(&mut self.solution[rhs + 1..], drives);
        copy(&mut self.solution[twist - turn.len()..], turn);
        copy(&mut self.solution[twist..], dt);
        match slacks {
            Some(slacks) => {
                copy(&mut self.solution[slack_row..rhs], slacks);
                self.reduced.back_substitute(slack_row, &mut self.solution);
            }
            None => self.reduced.back_substitute(rhs, &mut self.solution),
        }
        let (mut motion, mut force) = ([R::zero(); 6], [R::zero(); 6]);
        for a in 0..staying + 7 {
            let value = match a {
                a if a < staying => self.solution[a],
                a if a == staying => self.solution[rhs],
                a => self.solution[twist + a - staying - 1],
            };
            for i in 0..given {
                motion[i] += self.motions[a][i] * value;
                force[i] += self.forces[a][i] * value;
            }
        }
        for (forces, &value) in pairs(&self.extra_forces, &self.solution[rhs + 1..]) {
            for i in 0..given {
                force[i] += forces[i] * value;
            }
        }
        let mut wrench = [R::zero(); 6];
        for i in 0..given {
            let mut rest = force[i];
            for (k, &earlier) in wrench[..i].iter().enumerate() {
                rest += self.columns[i][k] * earlier;
            }
            wrench[i] = -(rest * self.inverse[i]);
        }
        copy(&mut wrench[given..], &self.solution[staying..slack_row]);
        for (&row, &value) in pairs(&self.staying, &self.solution) {
            unknowns[row] = value;
        }
        for (&row, &value) in pairs(&self.given, &motion) {
            unknowns[row] = value;
        }
        for (k, column) in self.columns[given + staying + 1..].iter().enumerate() {
            let mut sum = R::zero();
            for (&entry, &part) in pairs(column.iter(), &wrench) {
                sum -= entry * part;
            }
            unknowns[wrench_row + k] = sum;
        }
    }

    /// Row of slack `slack`.
    #[inline(always)]
    fn slack(&self, slack: usize) -> usize {
        self.slack_row() + slack
    }

    /// After [`Transmission::eliminate`]: wrench F̂ per unit of slack `slack`, the platform held.
    #[inline(always)]
    pub fn slack_wrench(&self, slack: usize) -> [R; 6] {
        let twist = self.rhs_column() + 1 + self.extra;
        let mut wrench = [R::zero(); 6];
        for (i, entry) in wrench.iter_mut().enumerate() {
            *entry = self.reduced.get(self.slack(slack), twist + i);
        }
        wrench
    }

    /// Deflection over slack compliance that the slacks leave untaken, per unit of slack `other`.
    #[inline(always)]
    pub fn slack_response(&self, slack: usize, other: usize) -> R {
        let (a, b) = (self.slack(slack), self.slack(other));
        -self.reduced.get(a.min(b), a.max(b))
    }

    /// The same by the right-hand side (`None`) or per unit motion of a drive, with the platform held.
    #[inline(always)]
    pub fn slack_force(&self, slack: usize, drive: Option<usize>) -> R {
        let column = self.rhs_column() + drive.map_or(0, |drive| 1 + drive);
        self.reduced.get(self.slack(slack), column)
    }
}

/// Coordinates of a route's passive joints whose screws are independent of those before them, in a configuration of no symmetry.
fn independent_joints(chain: &Chain, route: &Route, own: &[usize], scale: f64) -> Vec<usize> {
    let mut values = vec![0.0; chain.coordinate_count()];
    let offset = |coordinate: usize| 0.4 * (1.0 + 2.3 * coordinate as f64).sin();
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
    for &coordinate in own.iter().filter(|&&coordinate| coordinate >= chain.virtual_count) {
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
