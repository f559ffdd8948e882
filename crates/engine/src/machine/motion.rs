//! Motions between two configurations, with bounds on the speed of every point: what a sweep of bodies rests on.
//!
//! On a straight move the tool tip T has the constant twist `ẋ`, so that each chain obeys `J(q) q̇ = ẋ`. With `J₀` of full column rank in one state,
//! `q̇ = J₀⁺ (ẋ − (J − J₀) q̇)`. All in mm (angles and turned rows times the characteristic length), `β = ‖J₀⁺‖` and `‖J − J₀‖ ≤ n |q − q₀|`, where `n`
//! follows from the lengths of the chain alone. Within `h` of that state therefore `|q − q₀| ≤ r` with `r = h |q̇₀| / (1 − β n r)` (Newton–Kantorovich), and
//! `|q̇ − q̇₀| ≤ β n r |q̇₀| / (1 − β n r)`. Where no such `r` exists the interval is too long, and the bound is infinite.

use std::collections::BTreeMap;

use kinetostat_cell::{Ball, Motion as SweptMotion};
use nalgebra::{DMatrix, DVector, Isometry3, Vector3, Vector6};

use super::{
    Chain, Configuration, Machine, Motion, MoveScrew, Step,
    bodies::{FIXED_FRAMES, PLATFORM_FRAME},
};
use crate::spatial::{Pose, rotation_exp, rotation_log};

/// How far a prismatic coordinate may move from where reaches were taken, mm.
const SLIDE_MM: f64 = 50.0;
/// Largest distance of the platform of a machine from a straight line that it is said to follow: mm, and rad times the characteristic length.
const OFF_LINE_MM: f64 = 1e-6;
/// States differ by less through rounding, scaled, mm.
const SAME_MM: f64 = 1e-6;

/// How a motion leads from one configuration to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// The tool tip on a straight line at a constant rate, turned about one axis.
    Straight,
    /// All drives at constant rates: of an arm of one chain.
    Joints,
}

/// A motion of a machine over a parameter from 0 to 1, external axes at rest.
#[derive(Debug)]
pub struct MachineMotion<'a> {
    machine: &'a Machine,
    way: Way,
    ends: [Configuration; 2],
    /// Twist of the tool tip on a straight move: mm and rad for each 1 of the parameter, O axes.
    twist: Vector6<f64>,
    /// States known so far, by the bits of the parameter, which order numbers from 0 as they are.
    known: BTreeMap<u64, Configuration>,
    /// The parameter last asked for.
    last: f64,
    /// What is known of the chains in a state; `None` where one of them is singular.
    bounds: Option<(f64, Option<Vec<ChainBounds>>)>,
    poses: Vec<Isometry3<f64>>,
}

impl<'a> MachineMotion<'a> {
    /// The tool tip moves from its place in `from` straight to that in `to`, and turns about one axis at a constant rate.
    ///
    /// # Errors
    /// A machine of which bounds are not known: with loops within chains, more coordinates of a chain than the pose takes, or a platform that turns by itself.
    pub fn straight(machine: &'a Machine, from: &Configuration, to: &Configuration) -> Result<Self, String> {
        if machine.has_parasitic_rotation {
            return Err(
                "the platform turns by itself as it moves, so that what lies between two states is not bounded".into(),
            );
        }
        let tips = [from, to].map(|at| at.pose.transform(machine.tool_tip));
        let turn = rotation_log(&(to.pose.rotation * from.pose.rotation.transpose()));
        let move_mm = tips[1] - tips[0];
        let twist = Vector6::new(move_mm.x, move_mm.y, move_mm.z, turn.x, turn.y, turn.z);
        Self::new(machine, Way::Straight, from, to, twist)
    }

    /// All drives move at constant rates from `from` to `to`, as in a joint move of a robot.
    ///
    /// # Errors
    /// A machine that is no arm of one chain of drives.
    pub fn joints(machine: &'a Machine, from: &Configuration, to: &Configuration) -> Result<Self, String> {
        match &machine.chains[..] {
            [chain] if chain.passive.is_empty() => Self::new(machine, Way::Joints, from, to, Vector6::zeros()),
            _ => Err(
                "it is no arm of one chain of drives, so that where drives take it between two states is not bounded"
                    .into(),
            ),
        }
    }

    fn new(
        machine: &'a Machine,
        way: Way,
        from: &Configuration,
        to: &Configuration,
        twist: Vector6<f64>,
    ) -> Result<Self, String> {
        for chain in &machine.chains {
            if chain.route.loop_count() > 0 {
                return Err(format!(
                    "chain {} has a module, whose motion between two states is not bounded",
                    chain.name
                ));
            }
            let count = active_coordinates(machine, chain).len();
            if count > 6 {
                let problem = "more than a pose takes, so that its motion between two states is not bounded";
                return Err(format!("chain {} has {count} coordinates, {problem}", chain.name));
            }
        }
        let ends = [from.clone(), to.clone()];
        let known = BTreeMap::from([(0f64.to_bits(), from.clone()), (1f64.to_bits(), to.clone())]);
        Ok(Self { machine, way, ends, twist, known, last: 0.0, bounds: None, poses: Vec::new() })
    }

    /// The configuration at `s`.
    ///
    /// # Errors
    /// The machine does not reach it, or leaves the line.
    pub fn configuration(&mut self, s: f64) -> Result<Configuration, String> {
        self.last = s;
        if let Some(known) = self.known.get(&s.to_bits()) {
            return Ok(known.clone());
        }
        let found = match self.way {
            Way::Joints => {
                let [from, to] = &self.ends;
                let drives: Vec<f64> =
                    from.drives.iter().zip(&to.drives).map(|(from, to)| from + s * (to - from)).collect();
                self.machine.serial_configuration(&drives)
            }
            Way::Straight => self.on_line(s)?,
        };
        self.known.insert(s.to_bits(), found.clone());
        Ok(found)
    }

    /// Follows the line to `s` from the nearest state known.
    fn on_line(&self, s: f64) -> Result<Configuration, String> {
        let before = self.known.range(..s.to_bits()).next_back();
        let after = self.known.range(s.to_bits()..).next();
        let off = |own: &(&u64, &Configuration)| (f64::from_bits(*own.0) - s).abs();
        let nearest = before.into_iter().chain(after).min_by(|a, b| off(a).total_cmp(&off(b)));
        let nearest = nearest.map_or(&self.ends[0], |own| own.1);
        let start = &self.ends[0].pose;
        let rotation = rotation_exp(self.twist.fixed_rows::<3>(3) * s) * start.rotation;
        let tip = start.transform(self.machine.tool_tip) + self.twist.fixed_rows::<3>(0) * s;
        let wanted = Pose { rotation, translation: tip - rotation * self.machine.tool_tip };
        let found = self.machine.unlimited_inverse_kinematics_from(nearest, &wanted).map_err(|why| why.to_string())?;
        let turned = rotation_log(&(found.pose.rotation * wanted.rotation.transpose())).norm();
        let off = (found.pose.translation - wanted.translation).norm() + turned * self.machine.characteristic_length;
        match off <= OFF_LINE_MM {
            true => Ok(found),
            false => {
                Err(format!("the platform leaves the straight line by {off:.6} mm, as it is not free to follow it"))
            }
        }
    }

    /// Bounds of the chains in the state at one end of `interval`.
    fn bounds_at(&mut self, interval: [f64; 2]) -> Option<&[ChainBounds]> {
        let is_known = |s: f64| self.bounds.as_ref().is_some_and(|(at, _)| *at == s);
        if !interval.into_iter().any(is_known) {
            // Halves of an interval share the state that was last asked for.
            let s = if interval.contains(&self.last) { self.last } else { interval[0] };
            let at = self.configuration(s).ok()?;
            let mut first = 0;
            let of = |(chain, passive): (&Chain, &Vec<f64>)| {
                let rates = (self.way == Way::Joints).then(|| self.joint_rates(chain));
                let own = ChainBounds::new(self.machine, chain, &at.drives[first..], passive, &self.twist, rates);
                first += chain.drives.len();
                own
            };
            self.bounds = Some((s, self.machine.chains.iter().zip(&at.passive).map(of).collect()));
        }
        let (s, bounds) = self.bounds.as_ref()?;
        let bounds = bounds.as_ref()?;
        let other = if *s == interval[0] { interval[1] } else { interval[0] };
        let (mut values, mut first) = (Vec::new(), 0);
        if let Some(at) = self.known.get(&other.to_bits()) {
            for ((chain, passive), bounds) in self.machine.chains.iter().zip(&at.passive).zip(bounds) {
                chain.rigid_values(&at.drives[first..], passive, &mut values);
                if !bounds.leads_to(&values, interval[1] - interval[0]) {
                    return None;
                }
                first += chain.drives.len();
            }
        }
        Some(bounds)
    }

    /// Rates of the coordinates of the chain where the drives move at constant rates.
    fn joint_rates(&self, chain: &Chain) -> Vec<f64> {
        let joints = self.ends.each_ref().map(|end| {
            let mut values = Vec::new();
            chain.rigid_values(&end.drives, &[], &mut values);
            values
        });
        joints[1].iter().zip(&joints[0]).map(|(to, from)| to - from).collect()
    }

    /// Bound of the speed of the points of `ball`, fixed to `frame`, within `interval`.
    fn speed_of(&mut self, frame: usize, ball: &Ball, interval: [f64; 2]) -> Option<f64> {
        let length = interval[1] - interval[0];
        if self.ends[0] == self.ends[1] {
            return Some(0.0);
        }
        if frame == PLATFORM_FRAME && self.way == Way::Straight {
            let [linear, angular] = [0, 3].map(|row| self.twist.fixed_rows::<3>(row).norm());
            return Some(linear + angular * ((ball.centre_mm.coords - self.machine.tool_tip).norm() + ball.radius_mm));
        }
        let machine = self.machine;
        let (chain, hung) = match frame {
            PLATFORM_FRAME => (0, None),
            _ if frame < FIXED_FRAMES => return Some(0.0),
            _ => match machine.chain_of_frame(frame) {
                Some((chain, hung)) => (chain, Some(hung)),
                // Of the workpiece carrier, which is at rest.
                None => return Some(0.0),
            },
        };
        self.bounds_at(interval)?[chain].speed(hung, ball, length)
    }
}

impl SweptMotion for MachineMotion<'_> {
    fn poses(&mut self, s: f64, poses: &mut [Isometry3<f64>]) -> Result<(), String> {
        let at = self.configuration(s)?;
        self.machine.frame_poses(&at, &mut self.poses);
        poses[..self.poses.len()].copy_from_slice(&self.poses);
        Ok(())
    }

    fn speed(&mut self, frame: usize, ball: &Ball, interval: [f64; 2]) -> f64 {
        if frame >= self.machine.frame_count() {
            return 0.0;
        }
        self.speed_of(frame, ball, interval).unwrap_or(f64::INFINITY)
    }
}

/// Coordinates of a chain that move: drives that are not locked, and passive joints.
fn active_coordinates(machine: &Machine, chain: &Chain) -> Vec<usize> {
    let before = machine.chains.iter().take_while(|other| other.name != chain.name);
    let first: usize = before.map(|other| other.drives.len()).sum();
    let is_free = |drive: usize| !machine.locked.iter().any(|(locked, _)| *locked == first + drive);
    // A locked drive still turns by what another is coupled to.
    let moves = |joint: usize| (0..chain.drives.len()).any(|d| is_free(d) && chain.joint_per_drive(joint, d) != 0.0);
    let drives = chain.drives.iter().enumerate().filter(|(joint, _)| moves(*joint));
    drives.map(|(_, drive)| drive.coordinate).chain(chain.virtual_count..chain.coordinate_count()).collect()
}

/// An elementary motion of a route in one state.
#[derive(Debug, Clone, Copy)]
struct Move {
    /// Index of its coordinate among the active ones.
    coordinate: Option<usize>,
    motion: Motion,
    screw: MoveScrew,
    /// Length of the chain up to it, mm.
    behind_mm: f64,
}

/// What is known of a chain in one state.
#[derive(Debug)]
struct ChainBounds {
    moves: Vec<Move>,
    frames: Vec<Pose>,
    /// Number of moves before each frame, and length of the chain up to it, mm.
    before_frames: Vec<(usize, f64)>,
    /// Pose of P.
    end: Pose,
    /// Coordinates of the chain, mm or rad, and which of them are active.
    values: Vec<f64>,
    active: Vec<usize>,
    length_mm: f64,
    /// Length of 1 of each active coordinate: 1 mm, or the characteristic length for an angle.
    scales: Vec<f64>,
    /// Rates of the active coordinates, scaled, mm for each 1 of the parameter.
    rates: DVector<f64>,
    /// β n, 1/mm; 0 where rates are constant.
    bend: f64,
}

impl ChainBounds {
    /// Computes the bounds in a state; `rates` are those of the chain coordinates where they are constant. `None` where the chain is singular.
    fn new(
        machine: &Machine,
        chain: &Chain,
        drives: &[f64],
        passive: &[f64],
        twist: &Vector6<f64>,
        rates: Option<Vec<f64>>,
    ) -> Option<Self> {
        let active = active_coordinates(machine, chain);
        let (mut values, mut screws, mut frames) = (Vec::new(), Vec::new(), Vec::new());
        chain.rigid_values(drives, passive, &mut values);
        let end = chain.route.forward(&Pose::identity(), &values, &mut screws, &mut frames);
        let (mut moves, mut before_frames) = (Vec::new(), Vec::new());
        let mut length_mm = 0.0;
        let mut scales = vec![1.0; active.len()];
        for step in &chain.route.steps {
            match *step {
                Step::Fixed(transform) => length_mm += transform.translation.norm(),
                Step::Frame => before_frames.push((moves.len(), length_mm)),
                Step::Move { motion, coordinate, .. } => {
                    let index = active.iter().position(|own| *own == coordinate);
                    if let (Some(index), Motion::Revolute) = (index, motion) {
                        scales[index] = machine.characteristic_length;
                    }
                    let screw = screws[moves.len()];
                    moves.push(Move { coordinate: index, motion, screw, behind_mm: length_mm });
                    let is_elastic = index.is_none();
                    if motion == Motion::Prismatic {
                        length_mm += values[coordinate].abs() + if is_elastic { 0.0 } else { SLIDE_MM };
                    }
                }
            }
        }
        length_mm += chain.route.attachment.translation.norm();
        let mut own = Self {
            moves,
            frames,
            before_frames,
            end,
            values,
            length_mm,
            scales,
            rates: DVector::zeros(active.len()),
            active,
            bend: 0.0,
        };
        match rates {
            Some(rates) => own.rates = DVector::from_fn(own.active.len(), |k, _| rates[own.active[k]] * own.scales[k]),
            None => own.solve_rates(machine, twist)?,
        }
        Some(own)
    }

    /// Solves the rates that move the tool tip by `twist`, and β n. `None` where the chain is singular.
    fn solve_rates(&mut self, machine: &Machine, twist: &Vector6<f64>) -> Option<()> {
        let turned = machine.characteristic_length;
        let reach = self.length_mm + machine.tool_tip.norm();
        let (linear, angular) = self.columns(self.moves.len(), self.end.transform(machine.tool_tip));
        let count = self.scales.len();
        let jacobian = DMatrix::from_fn(6, count, |row, k| match row {
            0..3 => linear[k][row] / self.scales[k],
            _ => angular[k][row - 3] * turned / self.scales[k],
        });
        let gram = jacobian.tr_mul(&jacobian);
        let eigen = gram.clone().symmetric_eigenvalues();
        // Rates follow from the squares of singular values, of which half the digits are left.
        if eigen.min() <= 1e-8 * eigen.max() {
            return None;
        }
        // What rounding may have added.
        let least = eigen.min() - 1e-12 * eigen.max();
        let wanted = DVector::from_fn(6, |row, _| if row < 3 { twist[row] } else { twist[row] * turned });
        self.rates = gram.cholesky()?.solve(&jacobian.tr_mul(&wanted));
        self.bend = self.change(self.moves.len(), reach, turned) / least.sqrt();
        Some(())
    }

    /// Velocity of `point` (O, mm) and rotation by each 1 of the active coordinates of the first `count` moves.
    fn columns(&self, count: usize, point: Vector3<f64>) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let mut linear = vec![Vector3::zeros(); self.scales.len()];
        let mut angular = linear.clone();
        for own in &self.moves[..count] {
            if let Some(k) = own.coordinate {
                let twist = &own.screw.twist;
                linear[k] += twist.linear + twist.angular.cross(&(point - self.end.translation));
                angular[k] += twist.angular;
            }
        }
        (linear, angular)
    }

    /// Bound of how much the scaled columns of the first `count` moves at a point that is `reach` mm from the base along the chain change (Frobenius norm) for 1
    /// mm of the scaled coordinates; `turned` weighs their rotation.
    fn change(&self, count: usize, reach: f64, turned: f64) -> f64 {
        let moves = &self.moves[..count];
        let mut sums = vec![[0.0; 2]; self.scales.len()];
        for (m, own) in moves.iter().enumerate() {
            let Some(k) = own.coordinate else { continue };
            let mut by = vec![[0.0; 2]; self.scales.len()];
            for (i, other) in moves.iter().enumerate() {
                let Some(by) = other.coordinate.map(|other| &mut by[other]) else { continue };
                let far = reach - moves[i.max(m)].behind_mm;
                match (own.motion, other.motion) {
                    (Motion::Revolute, Motion::Revolute) => {
                        by[0] += far;
                        by[1] += if i < m { 1.0 } else { 0.0 };
                    }
                    (Motion::Revolute, Motion::Prismatic) => by[0] += if i > m { 1.0 } else { 0.0 },
                    (Motion::Prismatic, Motion::Revolute) => by[0] += if i < m { 1.0 } else { 0.0 },
                    (Motion::Prismatic, Motion::Prismatic) => {}
                }
            }
            for part in 0..2 {
                let squares = by.iter().zip(&self.scales).map(|(by, scale)| (by[part] / scale).powi(2));
                sums[k][part] += squares.sum::<f64>().sqrt();
            }
        }
        let squares = sums.iter().zip(&self.scales);
        squares.map(|(sum, scale)| (sum[0].powi(2) + (turned * sum[1]).powi(2)) / scale.powi(2)).sum::<f64>().sqrt()
    }

    /// Bound of the speed of the points of `ball` on a frame of the chain, or on the platform, within `length` of the parameter.
    fn speed(&self, hung: Option<usize>, ball: &Ball, length: f64) -> Option<f64> {
        let (count, behind, pose) = match hung {
            Some(frame) => (self.before_frames[frame].0, self.before_frames[frame].1, self.frames[frame]),
            None => (self.moves.len(), self.length_mm, self.end),
        };
        let Ball { centre_mm, radius_mm } = *ball;
        let (rate, moved) = (self.rates.norm(), self.distance_within(length)?);
        let fastest = rate / (1.0 - self.bend * moved);
        let other_rate = self.bend * moved * fastest;
        let (linear, angular) = self.columns(count, pose.transform(centre_mm.coords));
        let (mut velocity, mut turning, mut gain) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for k in 0..self.scales.len() {
            let rate = self.rates[k] / self.scales[k];
            velocity += linear[k] * rate;
            turning += angular[k] * rate;
            gain += ((linear[k].norm() + angular[k].norm() * radius_mm) / self.scales[k]).powi(2);
        }
        let reach = behind + centre_mm.coords.norm() + radius_mm;
        let change = self.change(count, reach, 0.0);
        Some(velocity.norm() + turning.norm() * radius_mm + gain.sqrt() * other_rate + change * moved * fastest)
    }

    /// Bound of how far the scaled coordinates move within `length` of the parameter, mm; `None` where none is known.
    fn distance_within(&self, length: f64) -> Option<f64> {
        let way = length * self.rates.norm();
        let moved = match 1.0 - 4.0 * self.bend * way {
            left if left < 0.0 => return None,
            left if self.bend > 0.0 => (1.0 - left.sqrt()) / (2.0 * self.bend),
            _ => way,
        };
        let slides = self.moves.iter().any(|own| own.motion == Motion::Prismatic && own.coordinate.is_some());
        (!slides || moved <= SLIDE_MM).then_some(moved)
    }

    /// Whether the coordinates `values` are as near as they are within `length` of the parameter: a state farther off is on another branch.
    fn leads_to(&self, values: &[f64], length: f64) -> bool {
        let Some(moved) = self.distance_within(length) else { return false };
        let mut square = 0.0;
        for (k, &coordinate) in self.active.iter().enumerate() {
            square += ((values[coordinate] - self.values[coordinate]) * self.scales[k]).powi(2);
        }
        square.sqrt() <= moved + SAME_MM
    }
}
