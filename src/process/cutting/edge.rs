//! Laws of the force on a cutting edge: linear in the chip thickness, or a power of it (Kienzle).

use nalgebra::Vector3;

/// Coefficients of one component of the force on a tooth: per chip area and per length of edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EdgeForce {
    /// K_c, N/mm²: times depth and chip thickness.
    pub cutting: f64,
    /// K_e, N/mm: times depth.
    pub edge: f64,
}

impl EdgeForce {
    /// Returns the force per edge length K_c h + K_e, N/mm, for a chip of thickness `h` (mm).
    #[must_use]
    pub fn on_edge(self, h: f64) -> f64 {
        self.cutting * h + self.edge
    }

    /// Returns `forces` without those of any other index than `component`.
    pub(super) fn only(forces: [Self; 3], component: usize) -> [Self; 3] {
        std::array::from_fn(|own| if own == component { forces[own] } else { Self::default() })
    }
}

/// Kienzle's law: the specific cutting force `k_c = k_c1.1 h^(−m_c)` of a chip of thickness h, so that an edge of length b
/// receives `F_c = k_c1.1 b h^(1−m_c)`.
///
/// Source: O. Kienzle, Die Bestimmung von Kräften und Leistungen an spanenden Werkzeugen und Werkzeugmaschinen, VDI-Z 94 (1952).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kienzle {
    /// k_c1.1, N/mm²: of a chip 1 mm thick.
    pub specific_force: f64,
    /// m_c, from 0 to below 1.
    pub exponent: f64,
}

impl Kienzle {
    /// Returns the force per edge length k_c1.1 h^(1−m_c), N/mm, for a chip of thickness `h` (mm).
    #[must_use]
    pub fn on_edge(self, h: f64) -> f64 {
        self.specific_force * libm::pow(h, 1.0 - self.exponent)
    }
}

/// The law of the force on a tooth's edge per mm of axial depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EdgeLaw {
    /// K_c h + K_e for each component.
    Linear {
        /// K_tc and K_te: against the tooth's motion.
        tangential: EdgeForce,
        /// K_rc and K_re: from the tooth towards the tool's axis.
        radial: EdgeForce,
        /// K_ac and K_ae: along the tool's axis, towards the spindle.
        axial: EdgeForce,
    },
    /// Kienzle's law against the tooth's motion, and shares of it.
    Kienzle {
        /// The tangential force.
        tangential: Kienzle,
        /// Share of the tangential force that counts: 1, or 0 for the other components alone.
        tangential_share: f64,
        /// Radial force as a share of the tangential one.
        radial_ratio: f64,
        /// Axial force as a share of the tangential one, towards the spindle if above 0.
        axial_ratio: f64,
    },
}

impl EdgeLaw {
    /// Returns tangential, radial and axial force per mm of depth for a chip of thickness `h` (mm), N/mm.
    #[must_use]
    pub fn on_edge(&self, h: f64) -> Vector3<f64> {
        match self {
            EdgeLaw::Linear { tangential, radial, axial } => {
                Vector3::new(tangential.on_edge(h), radial.on_edge(h), axial.on_edge(h))
            }
            EdgeLaw::Kienzle { tangential, tangential_share, radial_ratio, axial_ratio } => {
                Vector3::new(*tangential_share, *radial_ratio, *axial_ratio) * tangential.on_edge(h)
            }
        }
    }

    /// Returns the law with its component of this index alone: tangential, radial, axial.
    #[must_use]
    pub fn with_only(&self, component: usize) -> Self {
        let only = |own: usize| if own == component { 1.0 } else { 0.0 };
        match *self {
            EdgeLaw::Linear { tangential, radial, axial } => {
                let [tangential, radial, axial] = EdgeForce::only([tangential, radial, axial], component);
                EdgeLaw::Linear { tangential, radial, axial }
            }
            EdgeLaw::Kienzle { tangential, tangential_share, radial_ratio, axial_ratio } => EdgeLaw::Kienzle {
                tangential,
                tangential_share: tangential_share * only(0),
                radial_ratio: radial_ratio * only(1),
                axial_ratio: axial_ratio * only(2),
            },
        }
    }
}
