//! The engagement arc of a milling tooth, and edge forces integrated over it.

use std::f64::consts::PI;

use super::{EdgeForce, EdgeLaw, Kienzle};

/// The angles ψ between which a tooth cuts, rad, within 0 to π, where the chip thickness is h = c sin ψ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngagementArc {
    /// ψ at which the tooth enters the material, rad.
    pub entry: f64,
    /// ψ at which the tooth leaves the material, rad.
    pub exit: f64,
}

/// Integrals over the engagement arc of a component F of the edge force per mm of axial depth, N/mm.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ArcIntegrals {
    /// ∫ F dψ.
    pub plain: f64,
    /// ∫ F sin ψ dψ.
    pub sine: f64,
    /// ∫ F cos ψ dψ.
    pub cosine: f64,
}

impl ArcIntegrals {
    /// Returns the integrals multiplied by `factor`.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { plain: factor * self.plain, sine: factor * self.sine, cosine: factor * self.cosine }
    }

    /// Returns the integrals over both of two arcs.
    pub(super) fn plus(self, other: Self) -> Self {
        Self { plain: self.plain + other.plain, sine: self.sine + other.sine, cosine: self.cosine + other.cosine }
    }
}

impl EngagementArc {
    /// Returns the arc integrals of tangential, radial and axial force of `edge`, in this order, at feed per tooth `c` (mm).
    pub(super) fn integrals(&self, edge: &EdgeLaw, c: f64) -> [ArcIntegrals; 3] {
        match edge {
            EdgeLaw::Linear { tangential, radial, axial } => {
                [tangential, radial, axial].map(|force| self.linear_integrals(*force, c))
            }
            EdgeLaw::Kienzle { tangential, tangential_share, radial_ratio, axial_ratio } => {
                let main = self.kienzle_integrals(*tangential, c);
                [*tangential_share, *radial_ratio, *axial_ratio].map(|share| main.scaled(share))
            }
        }
    }

    /// Returns the arc integrals of a linear edge force in closed form, at feed per tooth `c` (mm).
    fn linear_integrals(&self, force: EdgeForce, c: f64) -> ArcIntegrals {
        let ((sin_in, cos_in), (sin_out, cos_out)) = (libm::sincos(self.entry), libm::sincos(self.exit));
        let angle = self.exit - self.entry;
        let sine = cos_in - cos_out;
        let sine_squared = 0.5 * (angle + sin_in * cos_in - sin_out * cos_out);
        let sine_cosine = 0.5 * (sin_out - sin_in) * (sin_out + sin_in);
        let cutting = force.cutting * c;
        ArcIntegrals {
            plain: cutting * sine + force.edge * angle,
            sine: cutting * sine_squared + force.edge * sine,
            cosine: cutting * sine_cosine + force.edge * (sin_out - sin_in),
        }
    }

    /// Returns the arc integrals of Kienzle's edge force at feed per tooth `c` (mm); only those of sin^p are computed numerically.
    fn kienzle_integrals(&self, force: Kienzle, c: f64) -> ArcIntegrals {
        let power = 1.0 - force.exponent;
        let primitive = |psi: f64| libm::pow(sine(psi), power + 1.0) / (power + 1.0);
        let integrals = ArcIntegrals {
            plain: self.integrate_sine_power(power),
            sine: self.integrate_sine_power(power + 1.0),
            cosine: primitive(self.exit) - primitive(self.entry),
        };
        integrals.scaled(force.on_edge(c))
    }

    /// Returns ∫ sin^p ψ dψ over the arc by the double exponential rule, which tolerates an infinite slope at the ends:
    /// H. Takahasi and M. Mori, Publ. RIMS 9 (1974).
    fn integrate_sine_power(&self, p: f64) -> f64 {
        double_exponential(self.entry, self.exit, |psi| libm::pow(sine(psi), p))
    }
}

/// Returns the integral of `value` between two angles, where it may rise with an infinite slope at both.
pub(super) fn double_exponential(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 0.1;
    const STEPS: i32 = 32;
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let term = |k: i32| {
        let t = f64::from(k) * STEP;
        let argument = 0.5 * PI * libm::sinh(t);
        let weight = 0.5 * PI * libm::cosh(t) / libm::cosh(argument).powi(2);
        weight * value(middle + half * libm::tanh(argument))
    };
    half * STEP * (-STEPS..=STEPS).map(term).sum::<f64>()
}

/// Returns sin ψ for an angle from 0 to π, never negative by rounding.
fn sine(psi: f64) -> f64 {
    libm::sin(psi).max(0.0)
}
