//! The linearised equilibrium of one chain and its condensation to the platform.

use nalgebra::{Matrix6, Vector6};

use super::{
    bordered::Bordered,
    state::ChainState,
    transmission::{Scale, Transmission},
};
use crate::{
    lanes::{Frame, Real, Screw, Vec3, clear, copy, pairs, rotation_log, sin_cos},
    machine::{Chain, Machine, Motion, SpringLaw, Step},
    spatial::{Pose, Wrench},
};

/// Linear system of one chain.
///
/// Unknowns, in this order: dθ, −dF̂, dq; then the known columns: right-hand side (1), motion of the drives, dt (6).
/// The symmetric matrix over all of them is
///
/// ```text
///          dθ      −dF̂    dq      1     dρ    dt
/// ∂/∂θ     A_θθ    J_θᵀ   A_θq    r_θ   −k    ·
/// closure          0      J_q     c     ·     −I
/// ∂/∂q                    A_qq    r_q   ·     ·
/// ```
///
/// with `A = ∂²U − H`, H the wrench-weighted Hessian `∂(JᵀF)/∂x` made symmetric: its antisymmetric part is
/// `½ J_ωᵀ [m]× J_ω`, which the closure `J dx = dt − c` turns into a term of the platform, so that
/// `dF = dF̂ − (0, ½ m × (dω − c_ω))`. Eliminating the unknowns leaves, against the dt columns, the condensed stiffness
/// K_i of eqs. (4), (5), the wrench at held platform, and the wrench per unit of drive motion.
///
/// Chains without an elastic link are eliminated in the order of [`Transmission`] instead, which may leave slacks to the
/// platform.
#[derive(Debug, Clone)]
pub(super) struct ChainSystem<R = f64> {
    virtual_count: usize,
    passive_count: usize,
    drive_count: usize,
    matrix: Bordered<R>,
    transmission: Option<Transmission<R>>,
    /// Whether a chain coordinate is a rotation.
    is_rotation: Vec<bool>,
    values: Vec<R>,
    /// Elementary motions: coordinate, and twist of the chain's end.
    screws: Vec<(usize, Screw<R>)>,
    /// Closure error c: twist from the platform to the chain's end.
    pub closure: Screw<R>,
    /// Moment carried by the chain, N·mm.
    pub moment: Vec3<R>,
    solution: Vec<R>,
}

/// Largest residuals of a chain, in its units and made dimensionless by the caller.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainResidual<R> {
    /// Closure gap, mm (rotations times reach).
    pub gap: R,
    /// Out-of-balance generalised force, N (moments over reach).
    pub force: R,
}

impl<R: Real> ChainSystem<R> {
    /// One per chain of `machine`.
    pub fn all(machine: &Machine) -> Vec<Self> {
        let scale = Scale::of(machine);
        machine.chains.iter().map(|chain| Self::new(chain, scale)).collect()
    }

    fn new(chain: &Chain, scale: Scale) -> Self {
        let (virtual_count, passive_count, drive_count) =
            (chain.virtual_count, chain.passive.len(), chain.drives.len());
        let size = virtual_count + 6 + passive_count + 1 + drive_count + 6;
        let mut is_rotation = vec![false; chain.coordinate_count()];
        for step in &chain.steps {
            if let Step::Move { motion, coordinate, .. } = *step {
                is_rotation[coordinate] = motion == Motion::Revolute;
            }
        }
        Self {
            virtual_count,
            passive_count,
            drive_count,
            matrix: Bordered::new(size),
            transmission: Transmission::new(chain, scale),
            is_rotation,
            values: vec![R::zero(); chain.coordinate_count()],
            screws: Vec::with_capacity(chain.move_count()),
            closure: Screw::zero(),
            moment: Vec3::zero(),
            solution: vec![R::zero(); size],
        }
    }

    fn rhs_column(&self) -> usize {
        self.virtual_count + 6 + self.passive_count
    }

    fn drive_column(&self, drive: usize) -> usize {
        self.rhs_column() + 1 + drive
    }

    fn twist_column(&self) -> usize {
        self.rhs_column() + 1 + self.drive_count
    }

    /// Number of unknowns: dθ, dF, dq.
    pub fn unknown_count(&self) -> usize {
        self.rhs_column()
    }

    /// Number of drives.
    pub fn drive_count(&self) -> usize {
        self.drive_count
    }

    /// Row of the first wrench unknown.
    pub fn wrench_row(&self) -> usize {
        self.virtual_count
    }

    /// Row of chain coordinate `coordinate`: virtual ones first, passive ones behind the wrench.
    #[inline(always)]
    fn row(&self, coordinate: usize) -> usize {
        if coordinate < self.virtual_count { coordinate } else { coordinate + 6 }
    }

    /// Fills the system with coordinates at `coordinates` and the chain carrying `wrench`, this chain's drives at `drives`
    /// and the platform at `platform`.
    #[inline(always)]
    pub fn fill(&mut self, chain: &Chain, drives: &[R], coordinates: &[R], wrench: Screw<R>, platform: &Frame<R>) {
        copy(&mut self.values, coordinates);
        for (drive, &rho) in pairs(&chain.drives, drives) {
            self.values[drive.coordinate] += rho;
        }
        self.screws.clear();
        let end = chain.propagate(
            &self.values,
            #[inline(always)]
            |coordinate, twist| {
                self.screws.push((coordinate, twist));
            },
        );
        for (coordinate, twist) in &mut self.screws {
            if self.is_rotation[*coordinate] {
                twist.linear += twist.angular.cross(end.origin);
            }
        }
        self.moment = wrench.angular;
        self.closure =
            Screw { linear: end.origin - platform.origin, angular: rotation_log(end.rotation_from(platform)) };
        self.matrix.clear();
        self.fill_jacobian_and_residual(wrench);
        self.fill_hessian(wrench);
        self.fill_springs(chain, coordinates);
        let (wrench_row, twist_column) = (self.virtual_count, self.twist_column());
        for i in 0..6 {
            *self.matrix.at(wrench_row + i, twist_column + i) = R::splat(-1.0);
        }
        for (d, drive) in chain.drives.iter().enumerate() {
            let column = self.drive_column(d);
            *self.matrix.at(drive.coordinate, column) = R::splat(-drive.stiffness);
        }
    }

    #[inline(always)]
    fn fill_jacobian_and_residual(&mut self, wrench: Screw<R>) {
        let (first, rhs) = (self.virtual_count, self.rhs_column());
        for index in 0..self.screws.len() {
            let (coordinate, twist) = self.screws[index];
            let row = self.row(coordinate);
            for (i, value) in twist.to_array().into_iter().enumerate() {
                *self.matrix.at(row.min(first + i), row.max(first + i)) += value;
            }
            *self.matrix.at(row, rhs) -= twist.dot(wrench);
        }
        for (i, value) in self.closure.to_array().into_iter().enumerate() {
            *self.matrix.at(first + i, rhs) = value;
        }
    }

    /// Subtracts the symmetric wrench-weighted Hessian: for k before or at j in the chain,
    /// `H_jk = ω_k · (v_j × f + ½ ω_j × m)`.
    #[inline(always)]
    fn fill_hessian(&mut self, wrench: Screw<R>) {
        let half_moment = wrench.angular.scale(R::splat(0.5));
        for j in 0..self.screws.len() {
            let (later, twist) = self.screws[j];
            let mut lever = twist.linear.cross(wrench.linear);
            if self.is_rotation[later] {
                lever += twist.angular.cross(half_moment);
            }
            let row_j = self.row(later);
            for k in 0..=j {
                let (earlier, twist) = self.screws[k];
                if !self.is_rotation[earlier] {
                    continue;
                }
                let value = twist.angular.dot(lever);
                let row_k = self.row(earlier);
                // A coordinate that drives two moves (parallelogram) meets itself twice, from either side.
                let twice = row_j == row_k && k != j;
                let entry = self.matrix.at(row_k.min(row_j), row_k.max(row_j));
                *entry -= if twice { value + value } else { value };
            }
        }
    }

    #[inline(always)]
    fn fill_springs(&mut self, chain: &Chain, coordinates: &[R]) {
        let rhs = self.rhs_column();
        for spring in &chain.springs {
            let start = spring.start;
            match &spring.law {
                SpringLaw::Drive(stiffness) => {
                    *self.matrix.at(start, start) += R::splat(*stiffness);
                    *self.matrix.at(start, rhs) += R::splat(*stiffness) * coordinates[start];
                }
                SpringLaw::Link(stiffness) => {
                    for index in 0..36 {
                        let (i, j) = (index / 6, index % 6);
                        let k = stiffness[(i, j)];
                        if k == 0.0 {
                            continue;
                        }
                        *self.matrix.at(start + i, rhs) += R::splat(k) * coordinates[start + j];
                        if j >= i {
                            *self.matrix.at(start + i, start + j) += R::splat(k);
                        }
                    }
                }
                SpringLaw::Parallelogram { passive, terms } => {
                    self.fill_parallelogram(
                        &coordinates[start..start + 5],
                        start,
                        coordinates[*passive],
                        *passive,
                        terms,
                    );
                }
            }
        }
        for (j, joint) in chain.passive.iter().enumerate() {
            if joint.stiffness > 0.0 {
                let (coordinate, row) = (chain.passive_coordinate(j), chain.passive_coordinate(j) + 6);
                let (stiffness, neutral) = (R::splat(joint.stiffness), R::splat(joint.neutral));
                *self.matrix.at(row, row) += stiffness;
                *self.matrix.at(row, rhs) += stiffness * (coordinates[coordinate] - neutral);
            }
        }
    }

    /// `U = ½ θᵀ K(q) θ` with the first of `theta` at row `start` and `q` the passive coordinate `passive`.
    #[inline(always)]
    fn fill_parallelogram(
        &mut self,
        theta: &[R],
        start: usize,
        q: R,
        passive: usize,
        [mean, cosine, sine]: &[nalgebra::SMatrix<f64, 5, 5>; 3],
    ) {
        let (rhs, row_q) = (self.rhs_column(), self.row(passive));
        let (s, c) = sin_cos(q + q);
        let (mut slope_force, mut curvature_force) = (R::zero(), R::zero());
        for i in 0..5 {
            let (mut force, mut slope, mut swing_force) = (R::zero(), R::zero(), R::zero());
            for j in 0..5 {
                let (mean, cosine, sine) = (mean[(i, j)], cosine[(i, j)], sine[(i, j)]);
                if mean == 0.0 && cosine == 0.0 && sine == 0.0 {
                    continue;
                }
                let (mean, cosine, sine) = (R::splat(mean), R::splat(cosine), R::splat(sine));
                let swing = cosine * c + sine * s;
                let stiffness = mean + swing;
                force += stiffness * theta[j];
                slope += (sine * c - cosine * s) * theta[j];
                swing_force += swing * theta[j];
                if j >= i {
                    *self.matrix.at(start + i, start + j) += stiffness;
                }
            }
            slope += slope;
            *self.matrix.at(start + i, rhs) += force;
            *self.matrix.at(start + i, row_q) += slope;
            slope_force += slope * theta[i];
            curvature_force -= swing_force * theta[i];
        }
        *self.matrix.at(row_q, rhs) += R::splat(0.5) * slope_force;
        *self.matrix.at(row_q, row_q) += R::splat(2.0) * curvature_force;
    }

    /// Present residual, before elimination; `reach` in mm makes rotations and moments comparable.
    #[inline(always)]
    pub fn residual(&self, reach: f64) -> ChainResidual<R> {
        let rhs = self.rhs_column();
        let per_reach = R::splat(1.0 / reach);
        let mut force = R::zero();
        for (coordinate, &is_rotation) in self.is_rotation.iter().enumerate() {
            let entry = self.matrix.get(self.row(coordinate), rhs).abs();
            force = force.larger(if is_rotation { entry * per_reach } else { entry });
        }
        let gap = self.closure.linear.norm().larger(self.closure.angular.norm() * R::splat(reach));
        ChainResidual { gap, force }
    }

    /// Eliminates the chain's unknowns but for its slacks; the lanes in which that works. In the others a pivot has the wrong
    /// sign: the chain, held at its end, is not stable, has an idle joint or stands in a singular configuration.
    #[inline(always)]
    pub fn eliminate(&mut self) -> u8 {
        let (theta, rhs, twist) = (self.virtual_count, self.rhs_column(), self.twist_column());
        if let Some(transmission) = &mut self.transmission {
            return transmission.eliminate(&self.matrix, theta, rhs);
        }
        let good = self.matrix.eliminate(0..theta, twist, 1.0, 0.0);
        let good = good & self.matrix.eliminate(theta..theta + 6, twist + 6, -1.0, 0.0);
        good & self.matrix.eliminate(theta + 6..rhs, twist + 6, 1.0, 0.0)
    }

    /// What is left after [`ChainSystem::eliminate`], and its right-hand column, behind which are drives and dt.
    #[inline(always)]
    fn condensed(&self) -> (&Bordered<R>, usize) {
        match &self.transmission {
            Some(transmission) => (transmission.reduced(), transmission.rhs_column()),
            None => (&self.matrix, self.rhs_column()),
        }
    }

    /// Number of slacks that [`ChainSystem::eliminate`] leaves to the platform.
    #[inline(always)]
    pub fn slack_count(&self) -> usize {
        self.transmission.as_ref().map_or(0, Transmission::wrench_count)
    }

    /// Stiffness of the slack springs; `None` without slacks.
    pub fn slack_stiffness(&self) -> Option<f64> {
        self.transmission.as_ref().map(Transmission::slack_stiffness)
    }

    /// After [`ChainSystem::eliminate`]: wrench F̂ per unit of slack `slack`, the platform held.
    #[inline(always)]
    pub fn slack_wrench(&self, slack: usize) -> [R; 6] {
        self.transmission.as_ref().map_or([R::zero(); 6], |transmission| transmission.slack_wrench(slack))
    }

    /// After [`ChainSystem::eliminate`]: what is left of slack `slack` per unit of slack `other`, the platform held, N/mm.
    #[inline(always)]
    pub fn slack_response(&self, slack: usize, other: usize) -> R {
        self.transmission.as_ref().map_or(R::zero(), |transmission| transmission.slack_response(slack, other))
    }

    /// After [`ChainSystem::eliminate`]: force in slack `slack` by the present residual, or per unit motion of `drive`.
    #[inline(always)]
    pub fn slack_force(&self, slack: usize, drive: Option<usize>) -> R {
        self.transmission.as_ref().map_or(R::zero(), |transmission| transmission.slack_force(slack, drive))
    }

    /// After [`ChainSystem::eliminate`]: symmetric part K_i of the chain's stiffness, with its slack springs.
    #[inline(always)]
    pub fn stiffness(&self, i: usize, j: usize) -> R {
        let (matrix, rhs) = self.condensed();
        let twist = rhs + 1 + self.drive_count;
        matrix.get(twist + i.min(j), twist + i.max(j))
    }

    /// After [`ChainSystem::eliminate`]: change of the chain wrench F̂ when the platform is held.
    #[inline(always)]
    pub fn held_wrench(&self) -> [R; 6] {
        self.wrench_by(0)
    }

    /// After [`ChainSystem::eliminate`]: wrench F̂ per unit motion of drive `drive` with the platform held.
    #[inline(always)]
    pub fn drive_wrench(&self, drive: usize) -> [R; 6] {
        self.wrench_by(1 + drive)
    }

    /// Wrench by the known column `column` behind the unknowns.
    #[inline(always)]
    fn wrench_by(&self, column: usize) -> [R; 6] {
        let (matrix, rhs) = self.condensed();
        let (row, twist) = (rhs + column, rhs + 1 + self.drive_count);
        let mut wrench = [R::zero(); 6];
        for (i, entry) in wrench.iter_mut().enumerate() {
            *entry = matrix.get(row, twist + i);
        }
        wrench
    }

    /// What the closure error contributes to the platform's moment balance: `½ m × c_ω`.
    #[inline(always)]
    pub fn closure_moment(&self) -> Vec3<R> {
        self.moment.cross(self.closure.angular).scale(R::splat(0.5))
    }

    /// After [`ChainSystem::eliminate`]: the chain's unknowns for the platform step `dt`, the step `drives` of its drives and
    /// its `slacks`, with the present residual times `residual`. Without slacks, after [`ChainSystem::condense`], they follow
    /// from the chain alone.
    #[inline(always)]
    pub fn substitute(&mut self, residual: f64, dt: &[R; 6], drives: &[R], slacks: Option<&[R]>) {
        let (rhs, twist) = (self.rhs_column(), self.twist_column());
        if let Some(transmission) = &mut self.transmission {
            let unknowns = &mut self.solution;
            return transmission.substitute(residual, dt, drives, slacks, self.virtual_count, unknowns);
        }
        clear(&mut self.solution[rhs..]);
        self.solution[rhs] = R::splat(residual);
        copy(&mut self.solution[rhs + 1..], drives);
        copy(&mut self.solution[twist..], dt);
        self.matrix.back_substitute(rhs, &mut self.solution);
    }

    /// Step of chain coordinate `coordinate`; of a drive's, the step of its joint ρ + θ_a.
    #[inline(always)]
    pub fn coordinate_step(&self, coordinate: usize) -> R {
        self.solution[self.row(coordinate)]
    }

    /// Step of the wrench for the platform step `dt`. Between dF̂ and dF lies the moment `½ m × (dω − c_ω)`.
    #[inline(always)]
    pub fn wrench_step(&self, dt: &[R; 6]) -> [R; 6] {
        let mut step = [R::zero(); 6];
        for (entry, &negative) in pairs(step.iter_mut(), &self.solution[self.virtual_count..]) {
            *entry = -negative;
        }
        let turn = Vec3([dt[3], dt[4], dt[5]]) - self.closure.angular;
        let correction = self.moment.cross(turn).scale(R::splat(0.5));
        for i in 0..3 {
            step[3 + i] -= correction.0[i];
        }
        step
    }

    /// Largest rotation of a joint or spring in the step, rad.
    #[inline(always)]
    pub fn largest_rotation(&self) -> R {
        let mut largest = R::zero();
        for (coordinate, &is_rotation) in self.is_rotation.iter().enumerate() {
            if is_rotation {
                largest = largest.larger(self.coordinate_step(coordinate).abs());
            }
        }
        largest
    }
}

impl ChainSystem<f64> {
    /// Fills the system at `state` with drives at `drives` (this chain's) and the platform at `platform`.
    pub fn linearise(&mut self, chain: &Chain, drives: &[f64], state: &ChainState, platform: &Pose) {
        self.fill(chain, drives, &state.coordinates, state.wrench.into(), &Frame::splat(platform));
    }

    /// Eliminates all unknowns of the chain; the symmetric part K_i of its stiffness. `None` as [`ChainSystem::eliminate`],
    /// and for a chain that is rigid in some direction.
    pub fn condense(&mut self) -> Option<Matrix6<f64>> {
        let good = self.eliminate() == 1 && self.transmission.as_mut().is_none_or(|own| own.settle() == 1);
        good.then(|| Matrix6::from_fn(|i, j| self.stiffness(i, j)))
    }

    /// Takes over unknowns found by another solver, in this system's order.
    pub fn set_solution(&mut self, unknowns: &[f64]) {
        self.solution[..unknowns.len()].copy_from_slice(unknowns);
    }

    /// Adds the step to `state`.
    pub fn apply(&self, dt: &Vector6<f64>, state: &mut ChainState) {
        for (coordinate, value) in state.coordinates.iter_mut().enumerate() {
            *value += self.coordinate_step(coordinate);
        }
        let wrench = state.wrench.to_vector() + Vector6::from(self.wrench_step(&(*dt).into()));
        state.wrench = Wrench::from_vector(&wrench);
    }

    /// Entry of the symmetric system over the unknowns, before elimination.
    pub fn coefficient(&self, i: usize, j: usize) -> f64 {
        self.matrix.get(i.min(j), i.max(j))
    }

    /// Right-hand side entry before elimination: `S z + rhs − [dt in the wrench rows] = 0`.
    pub fn right_hand_side(&self, row: usize) -> f64 {
        self.matrix.get(row, self.rhs_column())
    }

    /// Takes `amount` off a right-hand side entry before elimination.
    pub fn release(&mut self, row: usize, amount: f64) {
        let rhs = self.rhs_column();
        *self.matrix.at(row, rhs) -= amount;
    }
}
