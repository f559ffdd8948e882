//! End stiffness of a uniform beam.

use nalgebra::{Matrix3, Matrix6};

/// Cross-section of a beam whose axis is the local x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Section {
    /// Solid rectangle.
    Rectangle {
        /// Side along local y, mm.
        width: f64,
        /// Side along local z, mm.
        height: f64,
    },
    /// Solid circle.
    Round {
        /// Diameter, mm.
        diameter: f64,
    },
    /// Circular tube.
    Tube {
        /// Outer diameter, mm.
        outer: f64,
        /// Inner diameter, mm.
        inner: f64,
    },
}

impl Section {
    /// Area, mm².
    pub fn area(&self) -> f64 {
        match *self {
            Section::Rectangle { width, height } => width * height,
            Section::Round { diameter } => circle_area(diameter),
            Section::Tube { outer, inner } => circle_area(outer) - circle_area(inner),
        }
    }

    /// Second moments of area (I_y, I_z), mm⁴: I_y governs bending in the x–z plane, I_z in the x–y plane.
    pub fn second_moments(&self) -> (f64, f64) {
        match *self {
            Section::Rectangle { width, height } => (width * height.powi(3) / 12.0, height * width.powi(3) / 12.0),
            Section::Round { diameter } => (circle_moment(diameter), circle_moment(diameter)),
            Section::Tube { outer, inner } => {
                let moment = circle_moment(outer) - circle_moment(inner);
                (moment, moment)
            }
        }
    }

    /// Torsion constant J, mm⁴. For a rectangle a × c, a ≥ c: `a c³ (1/3 − 0.21 (c/a)(1 − c⁴/(12 a⁴)))`
    /// (Roark's formula, exact within 0.5 %).
    pub fn torsion_constant(&self) -> f64 {
        match *self {
            Section::Rectangle { width, height } => {
                let (a, c) = (width.max(height), width.min(height));
                a * c.powi(3) * (1.0 / 3.0 - 0.21 * (c / a) * (1.0 - c.powi(4) / (12.0 * a.powi(4))))
            }
            Section::Round { .. } | Section::Tube { .. } => 2.0 * self.second_moments().0,
        }
    }
}

fn circle_area(diameter: f64) -> f64 {
    std::f64::consts::PI * diameter.powi(2) / 4.0
}

fn circle_moment(diameter: f64) -> f64 {
    std::f64::consts::PI * diameter.powi(4) / 64.0
}

/// Elastic constants of an isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E, N/mm².
    pub youngs_modulus: f64,
    /// Shear modulus G, N/mm².
    pub shear_modulus: f64,
}

/// Stiffness of the free end of a uniform Euler–Bernoulli beam of length `length` mm clamped at its start, in beam axes:
/// `K11 = EA/L, K22 = 12EI_z/L³, K26 = −6EI_z/L², K66 = 4EI_z/L, K33 = 12EI_y/L³, K35 = 6EI_y/L², K55 = 4EI_y/L,
/// K44 = GJ/L` (N, mm, rad; translations before rotations).
pub fn beam_stiffness(section: &Section, material: &Material, length: f64) -> Matrix6<f64> {
    let Material { youngs_modulus: e, shear_modulus: g } = *material;
    let (iy, iz) = section.second_moments();
    let mut k = Matrix6::zeros();
    k[(0, 0)] = e * section.area() / length;
    k[(1, 1)] = 12.0 * e * iz / length.powi(3);
    k[(2, 2)] = 12.0 * e * iy / length.powi(3);
    k[(3, 3)] = g * section.torsion_constant() / length;
    k[(4, 4)] = 4.0 * e * iy / length;
    k[(5, 5)] = 4.0 * e * iz / length;
    let (xy, xz) = (-6.0 * e * iz / length.powi(2), 6.0 * e * iy / length.powi(2));
    (k[(1, 5)], k[(5, 1)]) = (xy, xy);
    (k[(2, 4)], k[(4, 2)]) = (xz, xz);
    k
}

/// Bar stiffness with the revolutes at both its ends released, about the parallelogram's normal:
/// `K_r = K_b − K_b J (Jᵀ K_b J)⁻¹ Jᵀ K_b`, `J = [(0, L, 0, 0, 0, 1)ᵀ, (0, 0, 0, 0, 0, 1)ᵀ]`.
fn released_bar(bar: &Matrix6<f64>, length: f64) -> Matrix6<f64> {
    let mut free = nalgebra::Matrix6x2::zeros();
    free[(1, 0)] = length;
    free[(5, 0)] = 1.0;
    free[(5, 1)] = 1.0;
    let carried = bar * free;
    let inner = (free.transpose() * carried).try_inverse().unwrap_or_default();
    bar - carried * inner * carried.transpose()
}

/// Stiffness law of a parallelogram of two equal bars (`bar`: end stiffness of one, bar axes) of length `length` mm, end
/// midlines `width` mm apart: the terms (mean, cosine, sine) of `K_Pa(q) = mean + cosine·cos 2q + sine·sin 2q` over the
/// five coordinates left when motion along local y is the passive coordinate itself.
///
/// `K_Pa(q) = Σ_± S_±ᵀ K_r S_±`, `S_± = [I, −[r_±]×; 0, I]`, `r_± = ±(width/2)(sin q, cos q, 0)`: the terms odd in r
/// cancel, what is left is `2 K_r` and, on the rotations, `2 [r]×ᵀ K_r,ff [r]×`, quadratic in (sin q, cos q).
pub fn parallelogram_terms(bar: &Matrix6<f64>, length: f64, width: f64) -> [nalgebra::SMatrix<f64, 5, 5>; 3] {
    let released = released_bar(bar, length);
    let force_block: Matrix3<f64> = released.fixed_view::<3, 3>(0, 0).into();
    let along = crate::spatial::skew(nalgebra::Vector3::x() * (width / 2.0));
    let across = crate::spatial::skew(nalgebra::Vector3::y() * (width / 2.0));
    let sin_sin = along.transpose() * force_block * along * 2.0;
    let cos_cos = across.transpose() * force_block * across * 2.0;
    let sin_cos = (along.transpose() * force_block * across + across.transpose() * force_block * along) * 2.0;
    let on_rotations = |block: Matrix3<f64>| {
        let mut k = Matrix6::zeros();
        k.fixed_view_mut::<3, 3>(3, 3).copy_from(&block);
        k
    };
    [
        released * 2.0 + on_rotations((sin_sin + cos_cos) * 0.5),
        on_rotations((cos_cos - sin_sin) * 0.5),
        on_rotations(sin_cos * 0.5),
    ]
    .map(|k| k.remove_row(1).remove_column(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{SMatrix, Vector3};

    const ALUMINIUM: Material = Material { youngs_modulus: 70_000.0, shear_modulus: 27_000.0 };

    #[test]
    fn cantilever_tip_deflection_is_the_textbook_one() {
        let section = Section::Rectangle { width: 20.0, height: 10.0 };
        let compliance = beam_stiffness(&section, &ALUMINIUM, 300.0).try_inverse().unwrap();
        let (iy, iz) = (20.0 * 1000.0 / 12.0, 10.0 * 8000.0 / 12.0);
        assert!((compliance[(2, 2)] / (300f64.powi(3) / (3.0 * 70_000.0 * iy)) - 1.0).abs() < 1e-12);
        assert!((compliance[(1, 1)] / (300f64.powi(3) / (3.0 * 70_000.0 * iz)) - 1.0).abs() < 1e-12);
        assert!((compliance[(5, 1)] / (300f64.powi(2) / (2.0 * 70_000.0 * iz)) - 1.0).abs() < 1e-12);
        assert!((compliance[(4, 2)] / (-(300f64.powi(2)) / (2.0 * 70_000.0 * iy)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn thin_tube_tends_to_thin_wall_torsion() {
        let tube = Section::Tube { outer: 100.0, inner: 98.0 };
        let thin = 2.0 * std::f64::consts::PI * 49.5f64.powi(3) * 1.0;
        assert!((tube.torsion_constant() / thin - 1.0).abs() < 1e-3);
    }

    #[test]
    fn parallelogram_law_is_the_sum_over_its_bars() {
        let bar = beam_stiffness(&Section::Rectangle { width: 12.0, height: 12.0 }, &ALUMINIUM, 310.0);
        let [mean, cosine, sine] = parallelogram_terms(&bar, 310.0, 80.0);
        let released = released_bar(&bar, 310.0);
        for q in [-1.0f64, 0.0, 0.4, 1.3] {
            let mut sum = Matrix6::zeros();
            for side in [-40.0, 40.0] {
                let mut s = Matrix6::identity();
                let r = Vector3::new(q.sin(), q.cos(), 0.0) * side;
                s.fixed_view_mut::<3, 3>(0, 3).copy_from(&-crate::spatial::skew(r));
                sum += s.transpose() * released * s;
            }
            let expected: SMatrix<f64, 5, 5> = sum.remove_row(1).remove_column(1);
            let law = mean + cosine * (2.0 * q).cos() + sine * (2.0 * q).sin();
            assert!((law - expected).norm() < 1e-12 * expected.norm(), "q = {q}");
        }
    }
}
