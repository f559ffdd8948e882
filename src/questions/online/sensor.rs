//! A force sensor and its way into the controller: noise, bias, delay, low-pass and the cycle of the commands.
//!
//! In cycle j, at the time `t_j = j T`, the controller has
//!
//! ```text
//! y_j = y_{j−1} + (1 − a) (F(t_j − delay) + bias + noise_j − y_{j−1}),   a = e^(−2π f T)
//! ```
//!
//! with f the corner frequency of the low-pass (without one, a = 0). What it commands from `y_j` holds from `t_{j+1}` on, until the
//! next. The filter begins at rest, at the first force with its bias.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};

/// Force sensor and its way into the controller. Times in s, frequencies in Hz, forces in N.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Sensor {
    /// T: time between two commands of the controller.
    pub cycle_s: f64,
    /// Delay from the force to its measured value.
    pub delay_s: f64,
    /// f: corner frequency of the low-pass; `None` without one.
    pub low_pass_Hz: Option<f64>,
    /// Standard deviation of the noise of each value of each axis.
    pub noise_N: f64,
    /// Standard deviation, over sensors, of the constant error of each axis.
    pub bias_N: f64,
}

/// Draws three independent standard normal numbers, one for each axis.
pub(super) fn gaussians(random: &mut impl rand::Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(random))
}

impl Sensor {
    /// Returns the share of its former value that the low-pass keeps in one cycle; 0 without a low-pass.
    fn filter_factor(&self) -> f64 {
        self.low_pass_Hz.map_or(0.0, |corner| libm::exp(-TAU * corner * self.cycle_s))
    }

    /// Returns the number of cycles of the controller that pass in `duration_s`.
    pub fn cycles(&self, duration_s: f64) -> f64 {
        (duration_s / self.cycle_s).ceil() + 1.0
    }

    /// Returns the measured force, N, behind the command in effect at each of `times_s` (ascending); `forces` are real, linear between.
    pub fn measured(&self, times_s: &[f64], forces: &[Vector3<f64>], random: &mut impl rand::Rng) -> Vec<Vector3<f64>> {
        let Some(first) = forces.first() else { return Vec::new() };
        let bias = gaussians(random) * self.bias_N;
        let filter_factor = self.filter_factor();
        let mut force = ForceHistory { times_s, forces, next: 0 };
        let (mut filtered, mut cycle) = (first + bias, 0.0);
        let mut measured = Vec::with_capacity(forces.len());
        for &time in times_s {
            // The last cycle whose command is in force.
            while (cycle + 1.0) * self.cycle_s <= time {
                let reading = force.at(cycle * self.cycle_s - self.delay_s) + bias + gaussians(random) * self.noise_N;
                filtered += (reading - filtered) * (1.0 - filter_factor);
                cycle += 1.0;
            }
            measured.push(filtered);
        }
        measured
    }
}

/// A force over time, to be evaluated at ascending times.
struct ForceHistory<'a> {
    times_s: &'a [f64],
    forces: &'a [Vector3<f64>],
    /// Index of the first time not before that of the last evaluation.
    next: usize,
}

impl ForceHistory<'_> {
    /// Returns the force at `time_s`, N, linear between the given times and constant before and behind.
    fn at(&mut self, time_s: f64) -> Vector3<f64> {
        while self.next < self.times_s.len() && self.times_s[self.next] < time_s {
            self.next += 1;
        }
        match self.next {
            0 => self.forces[0],
            next if next == self.times_s.len() => self.forces[next - 1],
            next => {
                let (from, to) = (self.times_s[next - 1], self.times_s[next]);
                self.forces[next - 1].lerp(&self.forces[next], (time_s - from) / (to - from))
            }
        }
    }
}
