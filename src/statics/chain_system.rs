//! The linearised equilibrium of one chain and its condensation to the platform.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::{bordered::BadPivot, bordered::Bordered, state::ChainState};
use crate::{
    machine::{Chain, Motion, MoveScrew, SpringLaw, Step},
    spatial::{Pose, Twist, Wrench, larger, rotation_exp, rotation_log, skew},
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
#[derive(Debug, Clone)]
pub(super) struct ChainSystem {
    virtual_count: usize,
    passive_count: usize,
    drive_count: usize,
    matrix: Bordered,
    /// Whether a chain coordinate is a rotation.
    is_rotation: Vec<bool>,
    values: Vec<f64>,
    screws: Vec<MoveScrew>,
    /// Closure error c: twist from the platform to the chain's end.
    pub closure: Twist,
    /// Moment carried by the chain, N·mm.
    moment: Vector3<f64>,
    solution: Vec<f64>,
    /// Residual (rows θ, F, q) that a load step leaves in place; its rows F are held as a shift of the target instead.
    held_residual: Vec<f64>,
    /// Closure error that a load step leaves in place: shift in O axes, and turn in platform axes.
    held_closure: Twist,
}

/// Largest residuals of a chain, in its units and made dimensionless by the caller.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChainResidual {
    /// Closure gap, mm (rotations times reach).
    pub gap: f64,
    /// Out-of-balance generalised force, N (moments over reach).
    pub force: f64,
}

/// What a chain does to the platform.
#[derive(Debug, Clone)]
pub(super) struct Condensed {
    /// Symmetric part K_i.
    pub stiffness: Matrix6<f64>,
    /// Change of the chain wrench F̂ when the platform is held.
    pub held_wrench: Vector6<f64>,
}

impl ChainSystem {
    pub fn new(chain: &Chain) -> Self {
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
            is_rotation,
            values: vec![0.0; chain.coordinate_count()],
            screws: Vec::with_capacity(chain.move_count()),
            closure: Twist::default(),
            moment: Vector3::zeros(),
            solution: vec![0.0; size],
            held_residual: Vec::new(),
            held_closure: Twist::default(),
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

    /// Row of chain coordinate `coordinate`: virtual ones first, passive ones behind the wrench.
    fn row(&self, coordinate: usize) -> usize {
        if coordinate < self.virtual_count { coordinate } else { coordinate + 6 }
    }

    /// Fills the system at `state` with drives at `drives` (this chain's) and the platform at `platform`.
    pub fn linearise(&mut self, chain: &Chain, drives: &[f64], state: &ChainState, platform: &Pose) {
        self.values.copy_from_slice(&state.coordinates);
        for (drive, rho) in chain.drives.iter().zip(drives) {
            self.values[drive.coordinate] += rho;
        }
        let mut screws = std::mem::take(&mut self.screws);
        let end = chain.forward(&self.values, &mut screws);
        self.screws = screws;
        self.moment = state.wrench.moment;
        self.closure = Twist {
            linear: end.translation - platform.translation,
            angular: rotation_log(&(end.rotation * platform.rotation.transpose())),
        };
        self.matrix.clear();
        self.fill_jacobian_and_residual(&state.wrench);
        self.fill_hessian(&state.wrench);
        self.fill_springs(chain, &state.coordinates);
        let (wrench_row, twist_column) = (self.virtual_count, self.twist_column());
        for i in 0..6 {
            *self.matrix.at(wrench_row + i, twist_column + i) = -1.0;
        }
        for (d, drive) in chain.drives.iter().enumerate() {
            let column = self.drive_column(d);
            *self.matrix.at(drive.coordinate, column) = -drive.stiffness;
        }
    }

    fn fill_jacobian_and_residual(&mut self, wrench: &Wrench) {
        let (first, rhs) = (self.virtual_count, self.rhs_column());
        for index in 0..self.screws.len() {
            let screw = self.screws[index];
            let Twist { linear, angular } = screw.twist;
            let components = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
            if screw.coordinate < self.virtual_count {
                let row = self.matrix.row_mut(screw.coordinate);
                for (entry, value) in row[first..first + 6].iter_mut().zip(components) {
                    *entry += value;
                }
            } else {
                for (i, value) in components.into_iter().enumerate() {
                    *self.matrix.at(first + i, screw.coordinate + 6) += value;
                }
            }
            let row = self.row(screw.coordinate);
            *self.matrix.at(row, rhs) -= linear.dot(&wrench.force) + angular.dot(&wrench.moment);
        }
        let Twist { linear, angular } = self.closure;
        for (i, value) in [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z].into_iter().enumerate() {
            *self.matrix.at(first + i, rhs) = value;
        }
    }

    /// Subtracts the symmetric wrench-weighted Hessian: for k before or at j in the chain,
    /// `H_jk = ω_k · (v_j × f + ½ ω_j × m)`.
    fn fill_hessian(&mut self, wrench: &Wrench) {
        for j in 0..self.screws.len() {
            let later = self.screws[j];
            let lever = later.twist.linear.cross(&wrench.force) + later.twist.angular.cross(&wrench.moment) * 0.5;
            let row_j = self.row(later.coordinate);
            for k in 0..=j {
                let earlier = self.screws[k];
                if !self.is_rotation[earlier.coordinate] {
                    continue;
                }
                let value = earlier.twist.angular.dot(&lever);
                let row_k = self.row(earlier.coordinate);
                // A coordinate that drives two moves (parallelogram) meets itself twice, from either side.
                let twice = row_j == row_k && k != j;
                let entry = self.matrix.at(row_k.min(row_j), row_k.max(row_j));
                *entry -= if twice { 2.0 * value } else { value };
            }
        }
    }

    fn fill_springs(&mut self, chain: &Chain, coordinates: &[f64]) {
        let rhs = self.rhs_column();
        for spring in &chain.springs {
            let start = spring.start;
            let theta = &coordinates[start..start + spring.law.size()];
            match &spring.law {
                SpringLaw::Drive(stiffness) => {
                    *self.matrix.at(start, start) += stiffness;
                    *self.matrix.at(start, rhs) += stiffness * theta[0];
                }
                SpringLaw::Link(stiffness) => {
                    for (i, column) in stiffness.column_iter().enumerate() {
                        let row = self.matrix.row_mut(start + i);
                        let mut force = 0.0;
                        for (k, t) in column.iter().zip(theta) {
                            force += k * t;
                        }
                        for (entry, k) in row[start + i..start + 6].iter_mut().zip(column.iter().skip(i)) {
                            *entry += k;
                        }
                        row[rhs] += force;
                    }
                }
                SpringLaw::Parallelogram { passive, terms } => {
                    let (row_q, [mean, cosine, sine]) = (passive + 6, &**terms);
                    let (s, c) = (2.0 * coordinates[*passive]).sin_cos();
                    let (mut slope_force, mut curvature_force) = (0.0, 0.0);
                    for i in 0..5 {
                        let (mut force, mut slope) = (0.0, 0.0);
                        for j in 0..5 {
                            let swing = cosine[(i, j)] * c + sine[(i, j)] * s;
                            let stiffness = mean[(i, j)] + swing;
                            let derivative = 2.0 * (sine[(i, j)] * c - cosine[(i, j)] * s);
                            force += stiffness * theta[j];
                            slope += derivative * theta[j];
                            curvature_force -= 4.0 * swing * theta[i] * theta[j];
                            if j >= i {
                                *self.matrix.at(start + i, start + j) += stiffness;
                            }
                        }
                        *self.matrix.at(start + i, rhs) += force;
                        *self.matrix.at(start + i, row_q) += slope;
                        slope_force += slope * theta[i];
                    }
                    *self.matrix.at(row_q, rhs) += 0.5 * slope_force;
                    *self.matrix.at(row_q, row_q) += 0.5 * curvature_force;
                }
            }
        }
        for (j, joint) in chain.passive.iter().enumerate() {
            if joint.stiffness > 0.0 {
                let (coordinate, row) = (chain.passive_coordinate(j), chain.passive_coordinate(j) + 6);
                *self.matrix.at(row, row) += joint.stiffness;
                *self.matrix.at(row, rhs) += joint.stiffness * (coordinates[coordinate] - joint.neutral);
            }
        }
    }

    /// Remembers the present residual, at the platform pose `platform`, for load stepping.
    pub fn hold_residual(&mut self, platform: &Pose) {
        let rhs = self.rhs_column();
        self.held_residual.clear();
        self.held_residual.extend((0..rhs).map(|row| self.matrix.get(row, rhs)));
        let angular = platform.rotation.transpose() * self.closure.angular;
        self.held_closure = Twist { linear: self.closure.linear, angular };
    }

    /// Where the chain's end belongs when `share` of the held closure error is left in place.
    ///
    /// The shift is fixed to O and the turn to the platform, so that the target moves with the twist of the platform and
    /// the iteration stays a Newton iteration however large the turn is.
    pub fn held_target(&self, platform: &Pose, share: f64) -> Pose {
        Pose {
            rotation: platform.rotation * rotation_exp(self.held_closure.angular * share),
            translation: platform.translation + self.held_closure.linear * share,
        }
    }

    /// Takes `share` of the held generalised forces off the present ones.
    pub fn release_residual(&mut self, share: f64) {
        let (wrench, rhs) = (self.virtual_count, self.rhs_column());
        for row in (0..wrench).chain(wrench + 6..rhs) {
            *self.matrix.at(row, rhs) -= share * self.held_residual[row];
        }
    }

    /// Present residual; `reach` in mm makes rotations and moments comparable.
    pub fn residual(&self, reach: f64) -> ChainResidual {
        let rhs = self.rhs_column();
        let mut force: f64 = 0.0;
        for (coordinate, &is_rotation) in self.is_rotation.iter().enumerate() {
            let entry = self.matrix.get(self.row(coordinate), rhs).abs();
            force = larger(force, if is_rotation { entry / reach } else { entry });
        }
        let gap = larger(self.closure.linear.norm(), self.closure.angular.norm() * reach);
        ChainResidual { gap, force }
    }

    /// Eliminates the chain's unknowns.
    ///
    /// # Errors
    /// A pivot of the wrong sign: the chain, held at its end, is not stable, or its end cannot move in six directions.
    pub fn condense(&mut self) -> Result<Condensed, BadPivot> {
        let (theta, rhs, twist) = (self.virtual_count, self.rhs_column(), self.twist_column());
        self.matrix.eliminate(0..theta, twist, 1.0)?;
        self.matrix.eliminate(theta..theta + 6, twist + 6, -1.0)?;
        self.matrix.eliminate(theta + 6..rhs, twist + 6, 1.0)?;
        let stiffness = Matrix6::from_fn(|i, j| self.matrix.get(twist + i.min(j), twist + i.max(j)));
        let held_wrench = Vector6::from_fn(|i, _| self.matrix.get(rhs, twist + i));
        Ok(Condensed { stiffness, held_wrench })
    }

    /// After [`ChainSystem::condense`]: wrench F̂ per unit motion of drive `drive` with the platform held.
    pub fn drive_wrench(&self, drive: usize) -> Vector6<f64> {
        let (row, twist) = (self.drive_column(drive), self.twist_column());
        Vector6::from_fn(|i, _| self.matrix.get(row, twist + i))
    }

    /// Moment correction `½ m × (dω − c_ω)` between dF̂ and dF.
    fn moment_correction(&self, platform_turn: Vector3<f64>) -> Vector3<f64> {
        0.5 * self.moment.cross(&(platform_turn - self.closure.angular))
    }

    /// `½ [m]×`, what the chain's dead moment takes from the platform's tangent.
    pub fn half_moment(&self) -> Matrix3<f64> {
        skew(self.moment) * 0.5
    }

    /// What the closure error contributes to the platform's moment balance: `½ m × c_ω`.
    pub fn closure_moment(&self) -> Vector3<f64> {
        0.5 * self.moment.cross(&self.closure.angular)
    }

    /// After [`ChainSystem::condense`]: the chain's unknowns for the platform step `dt` and the step `drives` of its drives.
    pub fn back_substitute(&mut self, dt: &Vector6<f64>, drives: &[f64]) {
        self.substitute(1.0, dt, drives);
    }

    /// The same without the present residual: the derivative along `dt` and `drives`.
    pub fn respond(&mut self, dt: &Vector6<f64>, drives: &[f64]) {
        self.substitute(0.0, dt, drives);
    }

    fn substitute(&mut self, residual: f64, dt: &Vector6<f64>, drives: &[f64]) {
        let (rhs, twist) = (self.rhs_column(), self.twist_column());
        self.solution[rhs..].fill(0.0);
        self.solution[rhs] = residual;
        self.solution[rhs + 1..][..drives.len()].copy_from_slice(drives);
        self.solution[twist..twist + 6].copy_from_slice(dt.as_slice());
        self.matrix.back_substitute(rhs, &mut self.solution);
    }

    /// Takes over unknowns found by another solver, in this system's order.
    pub fn set_solution(&mut self, unknowns: &[f64]) {
        self.solution[..unknowns.len()].copy_from_slice(unknowns);
    }

    /// Step of chain coordinate `coordinate`; of a drive's, the step of its joint ρ + θ_a.
    pub fn coordinate_step(&self, coordinate: usize) -> f64 {
        self.solution[self.row(coordinate)]
    }

    /// Largest rotation of a joint or spring in the step, rad.
    pub fn largest_rotation(&self) -> f64 {
        let rotations = self.is_rotation.iter().enumerate().filter(|(_, is_rotation)| **is_rotation);
        rotations.fold(0.0, |most, (coordinate, _)| most.max(self.solution[self.row(coordinate)].abs()))
    }

    /// Adds the step to `state`.
    pub fn apply(&self, dt: &Vector6<f64>, state: &mut ChainState) {
        let theta = self.virtual_count;
        for (coordinate, value) in state.coordinates.iter_mut().enumerate() {
            *value += self.solution[self.row(coordinate)];
        }
        let correction = self.moment_correction(dt.fixed_rows::<3>(3).into());
        for i in 0..3 {
            state.wrench.force[i] -= self.solution[theta + i];
            state.wrench.moment[i] -= self.solution[theta + 3 + i] + correction[i];
        }
    }

    /// Entry of the symmetric system over the unknowns, before elimination.
    pub fn coefficient(&self, i: usize, j: usize) -> f64 {
        self.matrix.get(i.min(j), i.max(j))
    }

    /// Right-hand side entry before elimination: `S z + rhs − [dt in the wrench rows] = 0`.
    pub fn right_hand_side(&self, row: usize) -> f64 {
        self.matrix.get(row, self.rhs_column())
    }

    /// Row of the first wrench unknown.
    pub fn wrench_row(&self) -> usize {
        self.virtual_count
    }
}
