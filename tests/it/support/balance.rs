//! Whether a state balances, by other means than the engine's: closure by the products of the routes, coordinates by
//! differences of the energy against the power of the wrenches, the platform by the sum of wrenches and weight.

use kinetostat::{
    machine::{Chain, Machine, Motion, Route, Step},
    spatial::{Pose, Twist, Wrench, rotation_log},
    statics::{State, elastic_energy, spring_energies, weight_energy},
};
use nalgebra::{DMatrix, Vector3, Vector6};

/// Largest imbalance, over the largest force there is: wrenches of chains and loops, load, and weight of all masses.
const BALANCE: f64 = 1e-6;
/// Largest gap over the machine's characteristic length.
const GAP: f64 = 1e-7;

/// An elementary motion: coordinate, axis point and direction in O, and whether it turns.
struct Moved {
    coordinate: usize,
    motion: Motion,
    origin: Vector3<f64>,
    direction: Vector3<f64>,
}

impl Moved {
    /// Twist that it gives to a frame with its origin at `place`.
    fn twist_at(&self, place: &Vector3<f64>) -> Twist {
        match self.motion {
            Motion::Prismatic => Twist { linear: self.direction, angular: Vector3::zeros() },
            Motion::Revolute => Twist { linear: self.direction.cross(&(place - self.origin)), angular: self.direction },
        }
    }
}

/// A route as it stands: its end, motions, frames, and the number of motions before each frame.
struct Walked {
    end: Pose,
    moved: Vec<Moved>,
    frames: Vec<(Pose, usize)>,
}

fn walked(route: &Route, start: &Pose, values: &[f64]) -> Walked {
    let mut pose = start.compose(&route.base);
    let (mut moved, mut frames) = (Vec::new(), Vec::new());
    for step in &route.steps {
        match *step {
            Step::Fixed(transform) => pose = pose.compose(&transform),
            Step::Frame => frames.push((pose, moved.len())),
            Step::Move { motion, axis, coordinate, sign } => {
                let direction = pose.rotation.column(axis.index()) * sign;
                moved.push(Moved { coordinate, motion, origin: pose.translation, direction });
                match motion {
                    Motion::Prismatic => pose.translate_along(axis, sign * values[coordinate]),
                    Motion::Revolute => pose.rotate_about(axis, sign * values[coordinate]),
                }
            }
        }
    }
    Walked { end: pose.compose(&route.attachment), moved, frames }
}

/// Chain coordinates with the positions of the drives' joints added.
pub fn joint_values(chain: &Chain, drives: &[f64], coordinates: &[f64]) -> Vec<f64> {
    let mut values = coordinates.to_vec();
    for (joint, drive) in chain.drives.iter().enumerate() {
        values[drive.coordinate] += chain.coupling.as_ref().map_or(0.0, |coupling| coupling.offset[joint]);
        for (shown, rho) in drives.iter().enumerate() {
            values[drive.coordinate] += chain.joint_per_drive(joint, shown) * rho;
        }
    }
    values
}

/// Drives of each chain.
pub fn drives_by_chain<'a>(machine: &Machine, drives: &'a [f64]) -> Vec<&'a [f64]> {
    let mut rest = drives;
    let own = |chain: &Chain| {
        let (own, others) = rest.split_at(chain.drives.len());
        rest = others;
        own
    };
    machine.chains.iter().map(own).collect()
}

/// What is left of closure and balance in one chain.
struct Checked<'a> {
    values: &'a [f64],
    length: f64,
    /// Power of the wrenches per unit of each coordinate.
    power: Vec<f64>,
    /// Largest gap, mm.
    gap: f64,
    /// Largest wrench of a loop.
    largest: f64,
}

impl Checked<'_> {
    fn add_power(&mut self, moved: &[Moved], place: &Vector3<f64>, wrench: &Wrench, sign: f64) {
        for motion in moved {
            let Twist { linear, angular } = motion.twist_at(place);
            self.power[motion.coordinate] += sign * (wrench.force.dot(&linear) + wrench.moment.dot(&angular));
        }
    }

    /// A route from `start` to `target` that receives `wrench` there; `loops`: what its loops receive.
    fn route(&mut self, route: &Route, start: &Pose, target: &Pose, wrench: &Wrench, loops: &[Wrench]) {
        let Walked { end, moved, frames } = walked(route, start, self.values);
        let turn = rotation_log(&(end.rotation * target.rotation.transpose())).norm() * self.length;
        self.gap = self.gap.max((end.translation - target.translation).norm()).max(turn);
        self.add_power(&moved, &end.translation, wrench, 1.0);
        let mut first = 0;
        for inner in &route.loops {
            let ((from, before), (to, until)) = (frames[inner.from], frames[inner.to]);
            let own = loops[first];
            let received = Wrench { force: from.rotation * own.force, moment: from.rotation * own.moment };
            self.largest = self.largest.max(received.norm(self.length));
            let within = inner.route.loop_count();
            self.add_power(&moved[before..until], &to.translation, &received, -1.0);
            self.route(&inner.route, &from, &to, &received, &loops[first + 1..first + 1 + within]);
            first += 1 + within;
        }
        assert_eq!(first, loops.len());
    }
}

/// Weight of all masses, N.
fn weight_of_all(machine: &Machine) -> f64 {
    let of_chain = |chain: &Chain| -> f64 {
        chain.route.with_loops().iter().flat_map(|route| &route.masses).map(|mass| mass.kilograms).sum()
    };
    let platform = machine.platform_mass.map_or(0.0, |mass| mass.kilograms);
    machine.gravity.norm() * (platform + machine.chains.iter().map(of_chain).sum::<f64>())
}

/// Weight of what moves with the platform, at P in O axes.
pub fn platform_weight(machine: &Machine, pose: &Pose) -> Wrench {
    let Some(mass) = machine.platform_mass else { return Wrench::zero() };
    let force = machine.gravity * mass.kilograms;
    Wrench { force, moment: (pose.rotation * mass.at).cross(&force) }
}

/// Energy of springs and masses.
pub fn energy(machine: &Machine, drives: &[f64], state: &State) -> f64 {
    elastic_energy(machine, drives, state) + weight_energy(machine, drives, state)
}

/// Derivative of the energy by coordinate `i` of chain `c`, by central differences of fourth order.
fn energy_slope(machine: &Machine, drives: &[f64], state: &mut State, c: usize, i: usize, step: f64) -> f64 {
    let x = state.chains[c].coordinates[i];
    let mut at = |steps: f64| {
        state.chains[c].coordinates[i] = x + steps * step;
        energy(machine, drives, state)
    };
    let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step);
    state.chains[c].coordinates[i] = x;
    slope
}

/// Fails unless `state` is in equilibrium under `load`, the drives at `drives`.
pub fn assert_balanced(machine: &Machine, drives: &[f64], load: &Wrench, state: &State) {
    let length = machine.characteristic_length;
    let mut scale = load.norm(length).max(1.0).max(weight_of_all(machine));
    let mut left = load.to_vector() + platform_weight(machine, &state.pose).to_vector();
    let mut found = Vec::new();
    for ((chain, own), drives) in machine.chains.iter().zip(&state.chains).zip(drives_by_chain(machine, drives)) {
        left -= own.wrench.to_vector();
        let values = joint_values(chain, drives, &own.coordinates);
        let power = vec![0.0; values.len()];
        let mut checked = Checked { values: &values, length, power, gap: 0.0, largest: own.wrench.norm(length) };
        checked.route(&chain.route, &Pose::identity(), &state.pose, &own.wrench, &own.loops);
        assert!(checked.gap <= GAP * length, "chain {} gapes by {} mm", chain.name, checked.gap);
        scale = scale.max(checked.largest);
        found.push(checked.power);
    }
    // Energies are sums of numbers of this size.
    let height = length + state.pose.translation.norm();
    let springs = spring_energies(machine, drives, state).into_iter().map(|(_, energy)| energy.abs()).sum::<f64>();
    let rounding = 10.0 * f64::EPSILON * (springs + weight_of_all(machine) * height);
    let mut state = state.clone();
    for (c, power) in found.iter().enumerate() {
        let turns = rotations(&machine.chains[c]);
        // Slides may stand many times the reach away: a turn then moves what is behind it as much farther.
        let slid = state.chains[c].coordinates.iter().zip(&turns).filter(|(_, turns)| !**turns);
        let far = length + slid.map(|(value, _)| value.abs()).sum::<f64>();
        for (i, power) in power.iter().enumerate() {
            let (step, lever) = if turns[i] { (1e-4 * length / far, length) } else { (1e-3, 1.0) };
            let slope = energy_slope(machine, drives, &mut state, c, i, step);
            let off = ((power - slope).abs() - rounding / step).max(0.0) / lever;
            assert!(
                off <= BALANCE * scale,
                "chain {c}, coordinate {i}: {power} N or N·mm against {slope}, of {scale} N"
            );
        }
    }
    let left = Wrench::from_vector(&left).norm(length);
    assert!(left <= BALANCE * scale, "the platform is out of balance by {left} N of {scale} N");
}

/// Which coordinates of a chain turn.
fn rotations(chain: &Chain) -> Vec<bool> {
    let mut turns = vec![false; chain.coordinate_count()];
    for step in chain.route.with_loops().iter().flat_map(|route| &route.steps) {
        if let Step::Move { motion, coordinate, .. } = *step {
            turns[coordinate] = motion == Motion::Revolute;
        }
    }
    turns
}

/// Whether the wrenches of all chains and loops follow from balance: no wrenches of rigid parts against each other are free.
pub fn is_determinate(machine: &Machine, drives: &[f64], state: &State) -> bool {
    let closures: usize = machine.chains.iter().map(|chain| 1 + chain.route.loop_count()).sum();
    let coordinates: usize = machine.chains.iter().map(Chain::coordinate_count).sum();
    let mut jacobian = DMatrix::zeros(6 * closures, 6 + coordinates);
    let (mut row, mut first) = (0, 6);
    for ((chain, own), drives) in machine.chains.iter().zip(&state.chains).zip(drives_by_chain(machine, drives)) {
        for i in 0..6 {
            jacobian[(row + i, i)] = -1.0;
        }
        let values = joint_values(chain, drives, &own.coordinates);
        closure_rows(
            &chain.route,
            &Pose::identity(),
            &values,
            &mut jacobian,
            &mut row,
            first,
            machine.characteristic_length,
        );
        first += chain.coordinate_count();
    }
    let values = jacobian.singular_values();
    values.iter().filter(|&&value| value > 1e-7 * values.max()).count() == 6 * closures
}

fn closure_rows(
    route: &Route,
    start: &Pose,
    values: &[f64],
    jacobian: &mut DMatrix<f64>,
    row: &mut usize,
    first: usize,
    length: f64,
) {
    let Walked { end, moved, frames } = walked(route, start, values);
    let own = *row;
    let mut add = |row: usize, moved: &[Moved], place: &Vector3<f64>, sign: f64| {
        for motion in moved {
            let Twist { linear, angular } = motion.twist_at(place);
            let unit = if motion.motion == Motion::Revolute { 1.0 / length } else { 1.0 };
            let twist = Twist { linear: linear * unit, angular: angular * unit * length };
            let mut entries = jacobian.fixed_view_mut::<6, 1>(row, first + motion.coordinate);
            entries += Vector6::from(twist.to_vector()) * sign;
        }
    };
    add(own, &moved, &end.translation, 1.0);
    *row += 6;
    let mut loop_rows = *row;
    for inner in &route.loops {
        let ((_, before), (to, until)) = (frames[inner.from], frames[inner.to]);
        add(loop_rows, &moved[before..until], &to.translation, -1.0);
        loop_rows += 6 * (1 + inner.route.loop_count());
    }
    for inner in &route.loops {
        closure_rows(&inner.route, &frames[inner.from].0, values, jacobian, row, first, length);
    }
}
