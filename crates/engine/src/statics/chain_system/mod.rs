//! The linearised equilibrium of one chain and its condensation to the platform: unknowns, elimination, back-substitution.
//! Forces and stiffness are filled in by `springs`, `weight`, `point_springs` and `loops`.

mod assembly;
mod loops;
mod point_springs;
mod springs;
mod weight;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::{
    bordered::Bordered,
    state::ChainState,
    transmission::{KnownStep, Scale, Transmission},
};
use crate::{
    lanes::{Frame, Real, Screw, Vec3, clear, copy, pairs, rotation_log},
    machine::{Chain, Machine, Motion, Route, Step},
    spatial::{Pose, Wrench},
};
pub(super) use loops::LoopSystem;
use weight::HungMass;

/// Linear system of one chain.
///
/// Unknowns, in this order: dθ, −dF̂, dq; then the known columns: right-hand side (1), motion of the drives, turn of the first
/// frame against gravity (3, in a loop with masses), dt (6). The symmetric matrix over all of them is
///
/// ```text
///          dθ      −dF̂    dq      1     dρ    dφ    dt
/// ∂/∂θ     A_θθ    J_θᵀ   A_θq    r_θ   −k    −L_θ  ·
/// closure          0      J_q     c     ·     ·     −I
/// ∂/∂q                    A_qq    r_q   ·     −L_q  ·
/// ```
///
/// with `A = ∂²U − H`, H the wrench-weighted Hessian `∂(JᵀF)/∂x` made symmetric: its antisymmetric part is `½ J_ωᵀ [m]× J_ω`, which the closure
/// `J dx = dt − c` turns into a term of the platform, so that `dF = dF̂ − (0, ½ m × (dω − c_ω))`. Eliminating the unknowns leaves, against the dt
/// columns, the condensed stiffness K_i of eqs. (4), (5), the wrench at held platform, and the wrench per unit of drive motion.
///
/// Chains without an elastic link are eliminated in the order of [`Transmission`] instead, which may leave slacks to the
/// platform. A loop is a chain of its own between two frames of the route, condensed in the same way ([`loops`]).
#[derive(Debug, Clone)]
pub(super) struct ChainSystem<R = f64> {
    virtual_count: usize,
    passive_count: usize,
    /// Chain coordinates that the route moves, in the order of their rows; and the row of each chain coordinate.
    coordinates: Vec<usize>,
    rows: Vec<usize>,
    /// Indices of the chain's drives that have a column, and of its springs and sprung joints that belong to the route.
    drives: Vec<usize>,
    springs: Vec<usize>,
    joints: Vec<usize>,
    /// Row, column and entry by which the drives move their joints.
    drive_entries: Vec<(usize, usize, f64)>,
    turn_count: usize,
    matrix: Bordered<R>,
    transmission: Option<Transmission<R>>,
    /// Whether a chain coordinate is a rotation.
    is_rotation: Vec<bool>,
    values: Vec<R>,
    /// Elementary motions: coordinate, and twist of the chain's end.
    screws: Vec<(usize, Screw<R>)>,
    /// Frames on which something is mounted, and the number of elementary motions before each.
    frames: Vec<Frame<R>>,
    moves_before: Vec<usize>,
    end: Vec3<R>,
    /// Masses on the route, from its end on, and their weight's lever `L_j` on each elementary motion.
    hung_masses: Vec<HungMass>,
    levers: Vec<Vec3<R>>,
    /// All masses: their sum, kg, and their first moment about O, kg·mm.
    mass: f64,
    moment_of_mass: Vec3<R>,
    loops: Vec<LoopSystem<R>>,
    /// Storage: steps of the drives that have a column, in a loop; wrenches of the loops.
    drive_steps: Vec<R>,
    loop_wrenches: Vec<Screw<R>>,
    /// Closure error c: twist from the platform to the chain's end.
    pub closure: Screw<R>,
    /// Moment carried by the chain, N·mm.
    pub moment: Vec3<R>,
    solution: Vec<R>,
}

/// Inputs of a chain's system: positions of the chain's drives (mm, rad), its coordinates, its wrench and those of its loops (as
/// [`ChainState`] has them), and the weight of a kilogram in O axes (N).
pub(super) struct ChainInput<'a, R> {
    pub drives: &'a [R],
    pub coordinates: &'a [R],
    pub wrench: Screw<R>,
    pub loops: &'a [Screw<R>],
    pub gravity: Vec3<R>,
}

/// Largest residuals of a chain, which the caller makes dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainResidual<R> {
    /// Closure gap, mm (rotations times the characteristic length).
    pub gap: R,
    /// Out-of-balance generalised force, N (moments over it).
    pub force: R,
}

impl<R: Real> ChainSystem<R> {
    /// Systems of all chains of `machine`, in its order, not filled yet.
    pub fn all(machine: &Machine) -> Vec<Self> {
        let scale = Scale::for_machine(machine);
        machine.chains.iter().map(|chain| Self::new(chain, scale)).collect()
    }

    /// System of a chain that ends on the platform.
    fn new(chain: &Chain, scale: Scale) -> Self {
        Self::for_route(chain, &chain.route, (0..chain.drives.len()).collect(), false, scale)
    }

    /// System of a `route` of `chain`, with columns for `drives`; that of a loop with masses also has columns for its turn against gravity.
    fn for_route(chain: &Chain, route: &Route, drives: Vec<usize>, is_loop: bool, scale: Scale) -> Self {
        let coordinates = route.coordinates();
        let virtual_count = coordinates.iter().filter(|&&coordinate| coordinate < chain.virtual_count).count();
        let passive_count = coordinates.len() - virtual_count;
        let mut rows = vec![usize::MAX; chain.coordinate_count()];
        for (i, &coordinate) in coordinates.iter().enumerate() {
            rows[coordinate] = if i < virtual_count { i } else { i + 6 };
        }
        let is_own = |coordinate: usize| rows[coordinate] != usize::MAX;
        let springs = (0..chain.springs.len()).filter(|&i| is_own(chain.springs[i].start)).collect();
        let joints = (0..chain.passive.len())
            .filter(|&j| is_own(chain.passive_coordinate(j)) && chain.passive[j].stiffness > 0.0)
            .collect();
        let rhs = virtual_count + 6 + passive_count;
        let mut drive_entries = Vec::new();
        for (joint, drive) in chain.drives.iter().enumerate().filter(|(_, drive)| is_own(drive.coordinate)) {
            for (column, &moved) in drives.iter().enumerate() {
                let share = chain.joint_per_drive(joint, moved);
                if share != 0.0 {
                    drive_entries.push((rows[drive.coordinate], rhs + 1 + column, -drive.stiffness * share));
                }
            }
        }
        let turn_count = if is_loop && route.has_mass() { 3 } else { 0 };
        let size = rhs + 1 + drives.len() + turn_count + 6;
        let mut is_rotation = vec![false; chain.coordinate_count()];
        for step in &route.steps {
            if let Step::Move { motion, coordinate, .. } = *step {
                is_rotation[coordinate] = motion == Motion::Revolute;
            }
        }
        let moves_before = route.moves_before_frames();
        let loops: Vec<_> = route.loops.iter().map(|inner| LoopSystem::new(chain, inner, scale)).collect();
        let hung_masses = weight::hung_masses(route, &moves_before);
        let extra = drives.len() + turn_count;
        Self {
            virtual_count,
            passive_count,
            transmission: Transmission::new(chain, route, &coordinates, extra, turn_count + loops.len() > 0, scale),
            coordinates,
            rows,
            drives,
            springs,
            joints,
            drive_entries,
            turn_count,
            matrix: Bordered::new(size),
            is_rotation,
            values: vec![R::zero(); chain.coordinate_count()],
            screws: Vec::with_capacity(route.move_count()),
            frames: Vec::with_capacity(moves_before.len()),
            moves_before,
            end: Vec3::zero(),
            levers: vec![Vec3::zero(); if hung_masses.is_empty() { 0 } else { route.move_count() }],
            hung_masses,
            mass: 0.0,
            moment_of_mass: Vec3::zero(),
            loops,
            drive_steps: Vec::new(),
            loop_wrenches: Vec::new(),
            closure: Screw::zero(),
            moment: Vec3::zero(),
            solution: vec![R::zero(); size],
        }
    }

    /// Column of the right-hand side.
    fn rhs_column(&self) -> usize {
        self.virtual_count + 6 + self.passive_count
    }

    /// First column of the turn of the first frame against gravity.
    fn turn_column(&self) -> usize {
        self.rhs_column() + 1 + self.drives.len()
    }

    /// First column of dt.
    fn twist_column(&self) -> usize {
        self.turn_column() + self.turn_count
    }

    /// Number of unknowns without those of loops: dθ, −dF̂, dq.
    fn route_unknown_count(&self) -> usize {
        self.rhs_column()
    }

    /// Number of drives that have a column.
    pub fn drive_count(&self) -> usize {
        self.drives.len()
    }

    /// Row of the first wrench unknown.
    fn wrench_row(&self) -> usize {
        self.virtual_count
    }

    /// Row of chain coordinate `coordinate`, which the route must move: virtual ones first, passive ones behind the wrench.
    #[inline(always)]
    fn row(&self, coordinate: usize) -> usize {
        self.rows[coordinate]
    }

    /// Fills the system of a chain from its inputs `input`, the platform at `platform`.
    #[inline(always)]
    pub fn fill(&mut self, chain: &Chain, platform: &Frame<R>, input: &ChainInput<'_, R>) {
        self.fill_route(chain, &chain.route, &Frame::splat(&chain.route.base), platform, input);
    }

    /// Fills the system of a `route` whose first frame is at `first` and whose end belongs at `target`.
    #[inline(always)]
    fn fill_route(
        &mut self,
        chain: &Chain,
        route: &Route,
        first: &Frame<R>,
        target: &Frame<R>,
        input: &ChainInput<'_, R>,
    ) {
        copy(&mut self.values, input.coordinates);
        chain.add_joint_positions(input.drives, &mut self.values);
        self.screws.clear();
        self.frames.clear();
        let end = route.propagate(
            *first,
            &self.values,
            #[inline(always)]
            |coordinate, twist| {
                self.screws.push((coordinate, twist));
            },
            #[inline(always)]
            |frame| self.frames.push(frame),
        );
        for (coordinate, twist) in &mut self.screws {
            if self.is_rotation[*coordinate] {
                twist.linear += twist.angular.cross(end.origin);
            }
        }
        self.end = end.origin;
        self.moment = input.wrench.angular;
        self.closure = Screw { linear: end.origin - target.origin, angular: rotation_log(end.rotation_from(target)) };
        self.matrix.clear();
        if !self.loops.is_empty() {
            self.fill_loops(chain, route, input);
        }
        if !self.hung_masses.is_empty() {
            self.add_weight(route, input.gravity);
        }
        self.fill_jacobian_and_residual(input.wrench);
        self.fill_hessian(input.wrench);
        self.fill_springs(chain, input.coordinates);
        self.fill_point_springs(route);
        let (wrench_row, twist_column) = (self.virtual_count, self.twist_column());
        for i in 0..6 {
            *self.matrix.at(wrench_row + i, twist_column + i) = R::splat(-1.0);
        }
        for &(row, column, entry) in &self.drive_entries {
            *self.matrix.at(row, column) = R::splat(entry);
        }
    }

    /// Fills in the Jacobian, the closure error and the generalised forces `−Jᵀ F` of `wrench`.
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

    /// Subtracts the symmetric wrench-weighted Hessian: for k before or at j in the chain, `H_jk = ω_k · (v_j × f + ½ ω_j × m)`.
    #[inline(always)]
    fn fill_hessian(&mut self, wrench: Screw<R>) {
        let half_moment = wrench.angular.scale(R::splat(0.5));
        for j in 0..self.screws.len() {
            let (later, twist) = self.screws[j];
            let mut lever = twist.linear.cross(wrench.linear);
            if self.is_rotation[later] {
                lever += twist.angular.cross(half_moment);
            }
            if let Some(&by_weight) = self.levers.get(j) {
                lever += by_weight;
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

    /// Largest closure gap and force out of balance at present, before elimination; `scale` in mm makes rotations and moments comparable.
    #[inline(always)]
    pub fn residual(&self, scale: f64) -> ChainResidual<R> {
        let rhs = self.rhs_column();
        let per_length = R::splat(1.0 / scale);
        let mut force = R::zero();
        for &coordinate in &self.coordinates {
            let entry = self.matrix.get(self.row(coordinate), rhs).abs();
            force = force.larger(if self.is_rotation[coordinate] { entry * per_length } else { entry });
        }
        let gap = self.closure.linear.norm().larger(self.closure.angular.norm() * R::splat(scale));
        let route_residual = ChainResidual { gap, force };
        if self.loops.is_empty() { route_residual } else { self.residual_with_loops(route_residual, scale) }
    }

    /// Eliminates the chain's unknowns but for its slacks; returns the lanes in which that works. In the others a pivot has the wrong sign:
    /// the chain, held at its end, is not stable, has an idle joint or is in a singular configuration.
    #[inline(always)]
    pub fn eliminate(&mut self) -> u8 {
        let (theta, rhs, twist) = (self.virtual_count, self.rhs_column(), self.twist_column());
        let good = if self.loops.is_empty() { R::ALL } else { self.condense_loops() };
        if let Some(transmission) = &mut self.transmission {
            return good & transmission.eliminate(&self.matrix, theta, rhs);
        }
        let good = good & self.matrix.eliminate(0..theta, twist, 1.0, 0.0);
        let good = good & self.matrix.eliminate(theta..theta + 6, twist + 6, -1.0, 0.0);
        good & self.matrix.eliminate(theta + 6..rhs, twist + 6, 1.0, 0.0)
    }

    /// The matrix that [`ChainSystem::eliminate`] leaves, and its right-hand column, behind which are drives, turn and dt.
    #[inline(always)]
    fn condensed_matrix(&self) -> (&Bordered<R>, usize) {
        match &self.transmission {
            Some(transmission) => (transmission.reduced(), transmission.rhs_column()),
            None => (&self.matrix, self.rhs_column()),
        }
    }

    /// First column of dt in a matrix whose right-hand side is column `rhs`.
    #[inline(always)]
    fn twist_column_from(&self, rhs: usize) -> usize {
        rhs + 1 + self.drives.len() + self.turn_count
    }

    /// Number of slacks that [`ChainSystem::eliminate`] leaves to the platform.
    #[inline(always)]
    pub fn slack_count(&self) -> usize {
        self.transmission.as_ref().map_or(0, Transmission::wrench_count)
    }

    /// Stiffness of the slack springs, N/mm; `None` without slacks.
    pub fn slack_stiffness(&self) -> Option<f64> {
        self.transmission.as_ref().map(Transmission::slack_stiffness)
    }

    /// Wrench F̂ on the held platform per unit of slack `slack`, after [`ChainSystem::eliminate`].
    #[inline(always)]
    pub fn slack_wrench(&self, slack: usize) -> [R; 6] {
        self.transmission.as_ref().map_or([R::zero(); 6], |transmission| transmission.slack_wrench(slack))
    }

    /// Part of slack `slack` left per unit of slack `other`, the platform held, after [`ChainSystem::eliminate`], N/mm.
    #[inline(always)]
    pub fn slack_response(&self, slack: usize, other: usize) -> R {
        self.transmission.as_ref().map_or(R::zero(), |transmission| transmission.slack_response(slack, other))
    }

    /// Force in slack `slack` by the present residual, or per unit motion of `drive`, after [`ChainSystem::eliminate`].
    #[inline(always)]
    pub fn slack_force(&self, slack: usize, drive: Option<usize>) -> R {
        self.transmission.as_ref().map_or(R::zero(), |transmission| transmission.slack_force(slack, drive))
    }

    /// Entry of the symmetric part K_i of the chain's stiffness, with its slack springs, after [`ChainSystem::eliminate`].
    #[inline(always)]
    pub fn stiffness(&self, i: usize, j: usize) -> R {
        let (matrix, rhs) = self.condensed_matrix();
        let twist = self.twist_column_from(rhs);
        matrix.get(twist + i.min(j), twist + i.max(j))
    }

    /// Change of the chain wrench F̂ (N, N·mm, at P in O axes) with the platform held, after [`ChainSystem::eliminate`].
    #[inline(always)]
    pub fn held_wrench(&self) -> [R; 6] {
        self.wrench_by_column(0)
    }

    /// Wrench F̂ per unit motion of drive `drive` with the platform held, after [`ChainSystem::eliminate`].
    #[inline(always)]
    pub fn drive_wrench(&self, drive: usize) -> [R; 6] {
        self.wrench_by_column(1 + drive)
    }

    /// Wrench F̂ by a known column, counted from the right-hand side (0) on, with the platform held.
    #[inline(always)]
    fn wrench_by_column(&self, column: usize) -> [R; 6] {
        let (matrix, rhs) = self.condensed_matrix();
        let (row, twist) = (rhs + column, self.twist_column_from(rhs));
        let mut wrench = [R::zero(); 6];
        for (i, entry) in wrench.iter_mut().enumerate() {
            *entry = matrix.get(row, twist + i);
        }
        wrench
    }

    /// Moment that the closure error adds to the platform's balance, `½ m × c_ω`, N·mm.
    #[inline(always)]
    pub fn closure_moment(&self) -> Vec3<R> {
        self.moment.cross(self.closure.angular).scale(R::splat(0.5))
    }

    /// Computes the chain's unknowns, after [`ChainSystem::eliminate`], for the platform step `dt`, the step `drives` of its drives and its
    /// `slacks`, with the present residual times `residual`. Without slacks, after [`ChainSystem::condense`], they follow from the chain alone.
    #[inline(always)]
    pub fn substitute(&mut self, residual: f64, dt: &[R; 6], drives: &[R], slacks: Option<&[R]>) {
        self.substitute_route(residual, dt, drives, &[], slacks);
        if !self.loops.is_empty() {
            self.substitute_loops(residual, drives);
        }
    }

    /// Computes the unknowns of the route itself, its first frame turned by `turn` against gravity; `drives`: steps of those that have a column.
    #[inline(always)]
    fn substitute_route(&mut self, residual: f64, dt: &[R; 6], drives: &[R], turn: &[R], slacks: Option<&[R]>) {
        let (rhs, turn_column, twist) = (self.rhs_column(), self.turn_column(), self.twist_column());
        copy(&mut self.solution[turn_column..], turn);
        if let Some(transmission) = &mut self.transmission {
            let known = KnownStep { residual, dt, drives, turn };
            return transmission.substitute(known, slacks, self.virtual_count, &mut self.solution);
        }
        clear(&mut self.solution[rhs..turn_column]);
        self.solution[rhs] = R::splat(residual);
        copy(&mut self.solution[rhs + 1..], drives);
        copy(&mut self.solution[twist..], dt);
        self.matrix.back_substitute(rhs, &mut self.solution);
    }

    /// Step of chain coordinate `coordinate`, mm or rad; for a drive's, the step of its joint ρ + θ_a.
    #[inline(always)]
    pub fn coordinate_step(&self, coordinate: usize) -> R {
        match self.rows[coordinate] {
            usize::MAX => self.step_in_loops(coordinate),
            row => self.solution[row],
        }
    }

    /// Step of the chain's wrench F for the platform step `dt`. Between dF̂ and dF lies the moment `½ m × (dω − c_ω)`.
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

    /// Eliminates the slacks as well; returns the lanes in which the chain is elastic in all wrenches that it transmits.
    #[inline(always)]
    fn eliminate_slacks(&mut self) -> u8 {
        match &mut self.transmission {
            Some(transmission) => transmission.eliminate_slacks(),
            None => R::ALL,
        }
    }

    /// Largest rotation of a joint or spring in the step, rad.
    #[inline(always)]
    pub fn largest_rotation(&self) -> R {
        let mut largest = R::zero();
        for &coordinate in &self.coordinates {
            if self.is_rotation[coordinate] {
                largest = largest.larger(self.solution[self.rows[coordinate]].abs());
            }
        }
        if self.loops.is_empty() { largest } else { self.largest_rotation_in_loops(largest) }
    }
}

impl ChainSystem<f64> {
    /// Fills the system in `state`, this chain's drives at `drives` (mm, rad), the platform at `platform`, a kilogram weighing `gravity` (N).
    pub fn linearise(
        &mut self,
        chain: &Chain,
        drives: &[f64],
        state: &ChainState,
        platform: &Pose,
        gravity: &Vector3<f64>,
    ) {
        let mut loops = std::mem::take(&mut self.loop_wrenches);
        loops.clear();
        loops.extend(state.loops.iter().map(|&wrench| Screw::from(wrench)));
        let input = ChainInput {
            drives,
            coordinates: &state.coordinates,
            wrench: state.wrench.into(),
            loops: &loops,
            gravity: Vec3::splat(gravity),
        };
        self.fill(chain, &Frame::splat(platform), &input);
        self.loop_wrenches = loops;
    }

    /// Eliminates all unknowns; returns the symmetric part K_i of the stiffness, `None` where it is unstable, idle, singular or rigid.
    pub fn condense(&mut self) -> Option<Matrix6<f64>> {
        let good = self.eliminate() == 1 && self.eliminate_slacks() == 1;
        good.then(|| Matrix6::from_fn(|i, j| self.stiffness(i, j)))
    }

    /// Adds the chain's step to `state`; `dt` is the step of the platform, a twist of P in O axes (mm, rad).
    pub fn apply(&self, dt: &Vector6<f64>, state: &mut ChainState) {
        for (coordinate, value) in state.coordinates.iter_mut().enumerate() {
            *value += self.coordinate_step(coordinate);
        }
        let wrench = state.wrench.to_vector() + Vector6::from(self.wrench_step(&(*dt).into()));
        state.wrench = Wrench::from_vector(&wrench);
        let mut number = 0;
        self.loop_wrench_steps(&mut |step| {
            let wrench = state.loops[number].to_vector() + Vector6::from(step);
            state.loops[number] = Wrench::from_vector(&wrench);
            number += 1;
        });
    }
}
