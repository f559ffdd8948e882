//! How an uncertain quantity is distributed about its nominal value, and quantiles of the normal distribution.

use std::f64::consts::{PI, SQRT_2};

/// The standard normal value below which 97.5 % of all are: an interval of 95 % lies between it and its negative.
pub const Z_95_INTERVAL: f64 = 1.959_963_984_540_054;

/// Distribution of a quantity whose nominal value is the median; a standard normal number says how far along it a draw is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// Logarithm of the value over the nominal one: its standard deviations below and above the median.
    Logarithm {
        /// Below the median.
        below: f64,
        /// Above the median.
        above: f64,
    },
    /// Difference from the nominal value: its standard deviations below and above the median, in the unit of the quantity.
    Difference {
        /// Below the median.
        below: f64,
        /// Above the median.
        above: f64,
    },
    /// Evenly between two differences from the nominal value, in the unit of the quantity; the nominal value need not be the median.
    Uniform {
        /// Least difference.
        least: f64,
        /// Largest difference.
        largest: f64,
    },
}

impl Distribution {
    /// Value of the quantity for the standard normal number `z`.
    pub fn value(&self, nominal: f64, z: f64) -> f64 {
        let scaled = |below: f64, above: f64| z * if z < 0.0 { below } else { above };
        match *self {
            Distribution::Logarithm { below, above } => nominal * libm::exp(scaled(below, above)),
            Distribution::Difference { below, above } => nominal + scaled(below, above),
            Distribution::Uniform { least, largest } => nominal + least + (largest - least) * normal_cdf(z),
        }
    }

    /// The distribution if the quantity is measured: its logarithm to ±5 % with 95 % probability, all else twice as well as it is known; and that in words.
    pub fn measured(&self) -> (Self, &'static str) {
        let known = libm::log(1.05) / Z_95_INTERVAL;
        match *self {
            Distribution::Logarithm { below, above } if below.max(above) > known => {
                (Distribution::Logarithm { below: below.min(known), above: above.min(known) }, "known to ±5 %")
            }
            _ => (self.halved(), "known twice as well"),
        }
    }

    /// Interval that holds 95 % of the values about `nominal`.
    pub fn interval_95(&self, nominal: f64) -> [f64; 2] {
        [-Z_95_INTERVAL, Z_95_INTERVAL].map(|z| self.value(nominal, z))
    }

    /// The distribution with half the deviations from the nominal value, of its logarithm where that is normal.
    #[must_use]
    pub fn halved(&self) -> Self {
        let half = |own: f64| 0.5 * own;
        match *self {
            Distribution::Logarithm { below, above } => {
                Distribution::Logarithm { below: half(below), above: half(above) }
            }
            Distribution::Difference { below, above } => {
                Distribution::Difference { below: half(below), above: half(above) }
            }
            Distribution::Uniform { least, largest } => {
                Distribution::Uniform { least: half(least), largest: half(largest) }
            }
        }
    }

    /// Logarithm whose values have the standard deviation `relative_std` over the nominal value, their median.
    pub fn of_relative_std(relative_std: f64) -> Self {
        let std = Self::std_of_logarithm(relative_std);
        Distribution::Logarithm { below: std, above: std }
    }

    /// Standard deviation of the logarithm of values that have the standard deviation `relative_std` over their median.
    pub fn std_of_logarithm(relative_std: f64) -> f64 {
        // The square of the standard deviation over the median is w (w − 1), with w the exponential of the variance of the logarithm.
        let w = 0.5 * (1.0 + (1.0 + 4.0 * relative_std * relative_std).sqrt());
        libm::log(w).sqrt()
    }

    /// The standard deviation over the nominal value of what [`Distribution::of_relative_std`] makes; 0 of other kinds.
    pub fn relative_std(&self) -> f64 {
        let Distribution::Logarithm { above, .. } = self else { return 0.0 };
        let w = libm::exp(above * above);
        (w * (w - 1.0)).sqrt()
    }

    /// The distribution in words.
    pub fn text(&self) -> &'static str {
        match self {
            Distribution::Logarithm { .. } => "lognormal",
            Distribution::Difference { .. } => "normal",
            Distribution::Uniform { .. } => "uniform",
        }
    }
}

/// Probability that a standard normal number is below `z`.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

/// The standard normal number that is not exceeded with `probability`, in (0, 1).
pub fn normal_quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability);
    // Rational approximation to 4.5e-4 (Abramowitz and Stegun, 26.2.23), corrected by steps of the third order with the exact distribution.
    let t = (-2.0 * libm::log(tail)).sqrt();
    let numerator = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let mut z = numerator / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308))) - t;
    for _ in 0..2 {
        let density = libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        let step = (normal_cdf(z) - tail) / density;
        z -= step / (1.0 + 0.5 * z * step);
    }
    if probability < 0.5 { z } else { -z }
}
