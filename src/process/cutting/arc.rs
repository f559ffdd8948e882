//! The part of a turn in which a tooth cuts, and forces integrated over it.

use std::f64::consts::PI;

use super::{EdgeForce, EdgeLaw, Kienzle};

/// From which angle to which a tooth cuts, rad, from 0 to π: h = c sin ψ there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// ψ at which it enters.
    pub entry: f64,
    /// ψ at which it leaves.
    pub exit: f64,
}

/// Integrals over the arc of a component F of the force on an edge, for each mm of depth: N/mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OverArc {
    /// ∫ F dψ.
    pub plain: f64,
    /// ∫ F sin ψ dψ.
    pub sine: f64,
    /// ∫ F cos ψ dψ.
    pub cosine: f64,
}

impl OverArc {
    fn scaled(self, by: f64) -> Self {
        Self { plain: by * self.plain, sine: by * self.sine, cosine: by * self.cosine }
    }
}

impl Arc {
    /// Tangential, radial and axial force of `edge` over the arc, at feed per tooth `c` in mm.
    pub(super) fn integrals(&self, edge: &EdgeLaw, c: f64) -> [OverArc; 3] {
        match edge {
            EdgeLaw::Linear { tangential, radial, axial } => {
                [tangential, radial, axial].map(|force| self.of_linear(*force, c))
            }
            EdgeLaw::Kienzle { tangential, radial_ratio, axial_ratio } => {
                let main = self.of_power(*tangential, c);
                [main, main.scaled(*radial_ratio), main.scaled(*axial_ratio)]
            }
        }
    }

    /// In closed form.
    fn of_linear(&self, force: EdgeForce, c: f64) -> OverArc {
        let ((sin_in, cos_in), (sin_out, cos_out)) = (self.entry.sin_cos(), self.exit.sin_cos());
        let angle = self.exit - self.entry;
        let sine = cos_in - cos_out;
        let sine_squared = 0.5 * (angle + sin_in * cos_in - sin_out * cos_out);
        let sine_cosine = 0.5 * (sin_out - sin_in) * (sin_out + sin_in);
        let cutting = force.cutting * c;
        OverArc {
            plain: cutting * sine + force.edge * angle,
            sine: cutting * sine_squared + force.edge * sine,
            cosine: cutting * sine_cosine + force.edge * (sin_out - sin_in),
        }
    }

    /// The integrals of sin^p alone have no elementary form.
    fn of_power(&self, force: Kienzle, c: f64) -> OverArc {
        let power = 1.0 - force.exponent;
        let primitive = |psi: f64| sine(psi).powf(power + 1.0) / (power + 1.0);
        let integrals = OverArc {
            plain: self.of_sine_power(power),
            sine: self.of_sine_power(power + 1.0),
            cosine: primitive(self.exit) - primitive(self.entry),
        };
        integrals.scaled(force.on_edge(c))
    }

    /// ∫ sin^p ψ dψ by the double exponential rule, which an infinite slope at the ends does not disturb: H. Takahasi and
    /// M. Mori, Publ. RIMS 9 (1974).
    fn of_sine_power(&self, p: f64) -> f64 {
        const STEP: f64 = 0.1;
        const STEPS: i32 = 32;
        let (middle, half) = (0.5 * (self.entry + self.exit), 0.5 * (self.exit - self.entry));
        let term = |k: i32| {
            let t = f64::from(k) * STEP;
            let bent = 0.5 * PI * t.sinh();
            let weight = 0.5 * PI * t.cosh() / bent.cosh().powi(2);
            weight * sine(middle + half * bent.tanh()).powf(p)
        };
        half * STEP * (-STEPS..=STEPS).map(term).sum::<f64>()
    }
}

/// sin ψ of an angle from 0 to π, where rounding makes nothing negative of it.
fn sine(psi: f64) -> f64 {
    psi.sin().max(0.0)
}
