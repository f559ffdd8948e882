//! Areas, moments and stiffnesses of cross-sections, against textbooks.

use kinetostat_engine::{
    machine::{Material, Section, beam_stiffness, parallelogram_terms},
    nalgebra::{Matrix6, Matrix6x2, SMatrix, Vector3},
    spatial::skew,
};

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
fn hollow_sections_are_differences_of_full_ones_and_thin_walls_have_their_torsion() {
    let rectangle = |width: f64, height: f64| Section::Rectangle { width, height }.second_moments();
    let (outer, inner) = (rectangle(60.0, 100.0), rectangle(50.0, 90.0));
    let hollow = Section::Box { width: 60.0, height: 100.0, wall: 5.0 };
    assert_eq!(hollow.second_moments(), (outer.0 - inner.0, outer.1 - inner.1));
    assert_eq!(hollow.area(), 60.0 * 100.0 - 50.0 * 90.0);
    // As wide as high: Bredt's formula is t a³.
    let square = Section::Box { width: 41.0, height: 41.0, wall: 1.0 };
    assert!((square.torsion_constant() - 40f64.powi(3)).abs() < 1e-9);
    // A web as wide as the flanges makes a rectangle.
    let full = Section::I { width: 30.0, height: 50.0, flange: 10.0, web: 30.0 };
    let (about_y, about_z) = full.second_moments();
    let expected = rectangle(30.0, 50.0);
    assert!((about_y - expected.0).abs() < 1e-9 && (about_z - expected.1).abs() < 1e-9);
    // IPE 200 as its catalogue has it, without the fillets: 26.2 cm², 1 846 cm⁴, 142 cm⁴.
    let ipe = Section::I { width: 100.0, height: 200.0, flange: 8.5, web: 5.6 };
    assert!((ipe.area() / 2725.0 - 1.0).abs() < 0.01 && (ipe.second_moments().0 / 1.846e7 - 1.0).abs() < 0.01);
}

#[test]
fn thin_tube_tends_to_thin_wall_torsion() {
    let tube = Section::Tube { outer: 100.0, inner: 98.0 };
    let thin = 2.0 * std::f64::consts::PI * 49.5f64.powi(3) * 1.0;
    assert!((tube.torsion_constant() / thin - 1.0).abs() < 1e-3);
}

#[test]
fn a_tapered_tube_is_a_tube_where_it_does_not_taper_and_bends_by_its_parts() {
    let tube = beam_stiffness(&Section::Tube { outer: 80.0, inner: 70.0 }, &ALUMINIUM, 400.0);
    let even = beam_stiffness(&Section::TaperedTube { start: 80.0, end: 80.0, wall: 5.0 }, &ALUMINIUM, 400.0);
    assert!((even - tube).amax() < 1e-9 * tube.amax());
    let cone = Section::TaperedTube { start: 40.0, end: 20.0, wall: 10.0 };
    let full = beam_stiffness(&cone, &ALUMINIUM, 200.0).try_inverse().unwrap();
    let by_integral = |f: &dyn Fn(f64) -> f64| {
        let n = 20_000;
        (0..n).map(|i| f((f64::from(i) + 0.5) / f64::from(n)) / f64::from(n)).sum::<f64>()
    };
    let expected = by_integral(&|x| {
        let (s, outer) = ((1.0 - x) * 200.0, 40.0 - 20.0 * x);
        let tube = Section::Tube { outer, inner: outer - 20.0 };
        s * s * 200.0 / (70_000.0 * tube.second_moments().0)
    });
    assert!((full[(1, 1)] / expected - 1.0).abs() < 1e-7, "{} {expected}", full[(1, 1)]);
}

#[test]
fn parallelogram_law_is_the_sum_over_its_bars() {
    let bar = beam_stiffness(&Section::Rectangle { width: 12.0, height: 12.0 }, &ALUMINIUM, 310.0);
    let [mean, cosine, sine] = parallelogram_terms(&bar, 310.0, 80.0);
    // Turned freely about z at the platform's end, and at the other.
    let mut free = Matrix6x2::zeros();
    (free[(1, 0)], free[(5, 0)], free[(5, 1)]) = (310.0, 1.0, 1.0);
    let carried = bar * free;
    let released = bar - carried * (free.transpose() * carried).try_inverse().unwrap() * carried.transpose();
    for q in [-1.0f64, 0.0, 0.4, 1.3] {
        let mut sum = Matrix6::zeros();
        for side in [-40.0, 40.0] {
            let mut s = Matrix6::identity();
            let r = Vector3::new(q.sin(), q.cos(), 0.0) * side;
            s.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(r));
            sum += s.transpose() * released * s;
        }
        let expected: SMatrix<f64, 5, 5> = sum.remove_row(1).remove_column(1);
        let law = mean + cosine * (2.0 * q).cos() + sine * (2.0 * q).sin();
        assert!((law - expected).norm() < 1e-12 * expected.norm(), "q = {q}");
    }
}
