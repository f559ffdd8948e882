//! End stiffness of a beam, uniform or tapered.

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
    /// Doubly symmetric I, its web in the x–z plane.
    I {
        /// Of the flanges, along local y, mm.
        width: f64,
        /// Over both flanges, along local z, mm.
        height: f64,
        /// Thickness of a flange, mm.
        flange: f64,
        /// Thickness of the web, mm.
        web: f64,
    },
    /// Rectangular hollow section.
    Box {
        /// Outer side along local y, mm.
        width: f64,
        /// Outer side along local z, mm.
        height: f64,
        /// Thickness of the wall, mm.
        wall: f64,
    },
    /// Circular tube whose diameter changes evenly from start to end.
    TaperedTube {
        /// Outer diameter where the beam is clamped, mm.
        start: f64,
        /// Outer diameter at its free end, mm.
        end: f64,
        /// Thickness of the wall, mm.
        wall: f64,
    },
}

impl Section {
    /// Cross-sectional area, mm²; of a tapered tube, at half its length.
    pub fn area(&self) -> f64 {
        match *self {
            Section::Rectangle { width, height } => width * height,
            Section::Round { diameter } => circle_area(diameter),
            Section::Tube { outer, inner } => circle_area(outer) - circle_area(inner),
            Section::I { width, height, flange, web } => 2.0 * width * flange + (height - 2.0 * flange) * web,
            Section::Box { width, height, wall } => width * height - (width - 2.0 * wall) * (height - 2.0 * wall),
            Section::TaperedTube { .. } => self.section_at(0.5).area(),
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
            Section::I { width, height, flange, web } => {
                let inner = height - 2.0 * flange;
                let about_y = (width * height.powi(3) - (width - web) * inner.powi(3)) / 12.0;
                (about_y, (2.0 * flange * width.powi(3) + inner * web.powi(3)) / 12.0)
            }
            Section::Box { width, height, wall } => {
                let (inner_width, inner_height) = (width - 2.0 * wall, height - 2.0 * wall);
                let moment = |a: f64, b: f64, c: f64, d: f64| (a * b.powi(3) - c * d.powi(3)) / 12.0;
                (moment(width, height, inner_width, inner_height), moment(height, width, inner_height, inner_width))
            }
            Section::TaperedTube { .. } => self.section_at(0.5).second_moments(),
        }
    }

    /// Torsion constant J, mm⁴. For a rectangle a × c, a ≥ c: `a c³ (1/3 − 0.21 (c/a)(1 − c⁴/(12 a⁴)))` (Roark's formula, exact within 0.5 %). For
    /// an I, thin walls that can warp: `Σ b t³/3`; for a box, Bredt's `4 A² t / perimeter` of the wall's middle line.
    pub fn torsion_constant(&self) -> f64 {
        match *self {
            Section::Rectangle { width, height } => {
                let (a, c) = (width.max(height), width.min(height));
                a * c.powi(3) * (1.0 / 3.0 - 0.21 * (c / a) * (1.0 - c.powi(4) / (12.0 * a.powi(4))))
            }
            Section::Round { .. } | Section::Tube { .. } | Section::TaperedTube { .. } => 2.0 * self.second_moments().0,
            Section::I { width, height, flange, web } => {
                (2.0 * width * flange.powi(3) + (height - flange) * web.powi(3)) / 3.0
            }
            Section::Box { width, height, wall } => {
                let (width, height) = (width - wall, height - wall);
                2.0 * (width * height).powi(2) * wall / (width + height)
            }
        }
    }

    /// The section at the share `x` of a beam's length from its clamped end.
    fn section_at(&self, x: f64) -> Section {
        match *self {
            Section::TaperedTube { start, end, wall } => {
                let outer = start + (end - start) * x;
                Section::Tube { outer, inner: outer - 2.0 * wall }
            }
            uniform => uniform,
        }
    }
}

/// Area of a circle, mm².
fn circle_area(diameter: f64) -> f64 {
    std::f64::consts::PI * diameter.powi(2) / 4.0
}

/// Second moment of area of a circle about its diameter, mm⁴.
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
/// `K11 = EA/L, K22 = 12EI_z/L³, K26 = −6EI_z/L², K66 = 4EI_z/L, K33 = 12EI_y/L³, K35 = 6EI_y/L², K55 = 4EI_y/L, K44 = GJ/L` (N, mm, rad;
/// translations before rotations). Of a tapered beam, the inverse of its compliance, which sums up that of its parts.
pub fn beam_stiffness(section: &Section, material: &Material, length: f64) -> Matrix6<f64> {
    if let Section::TaperedTube { .. } = section {
        return tapered_compliance(section, material, length).try_inverse().unwrap_or_default();
    }
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

/// Parts of a tapered beam, each with the three points of Gauss' formula: together good to rounding.
const PARTS: usize = 64;
/// Points of Gauss' formula in −1..1, and their weights.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Compliance of the free end of a beam whose section changes: with `s` the way to the end, `C11 = ∫ 1/EA`, `C22 = ∫ s²/EI_z`,
/// `C26 = ∫ s/EI_z`, `C66 = ∫ 1/EI_z`, `C35 = −∫ s/EI_y` and so on.
fn tapered_compliance(section: &Section, material: &Material, length: f64) -> Matrix6<f64> {
    let mut c = Matrix6::zeros();
    for part in 0..PARTS {
        for (point, weight) in GAUSS {
            let x = (part as f64 + 0.5 * (1.0 + point)) / PARTS as f64;
            let (there, s, dx) = (section.section_at(x), (1.0 - x) * length, 0.5 * weight * length / PARTS as f64);
            let (iy, iz) = there.second_moments();
            let (e, g) = (material.youngs_modulus, material.shear_modulus);
            c[(0, 0)] += dx / (e * there.area());
            c[(1, 1)] += dx * s * s / (e * iz);
            c[(1, 5)] += dx * s / (e * iz);
            c[(5, 5)] += dx / (e * iz);
            c[(2, 2)] += dx * s * s / (e * iy);
            c[(2, 4)] -= dx * s / (e * iy);
            c[(4, 4)] += dx / (e * iy);
            c[(3, 3)] += dx / (g * there.torsion_constant());
        }
    }
    (c[(5, 1)], c[(4, 2)]) = (c[(1, 5)], c[(2, 4)]);
    c
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
/// cancel, what remains is `2 K_r` and, on the rotations, `2 [r]×ᵀ K_r,ff [r]×`, quadratic in (sin q, cos q).
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
