//! Singularities on the way between two configurations, against the determinant of the whole linearised problem.

use kinetostat_engine::{
    Machine, Pose,
    machine::{Configuration, Coordinate, Motion, catalogue},
    nalgebra::{DMatrix, Vector3},
    spatial::rotation_exp,
};
use proptest::prelude::*;

/// Home with every coordinate moved: up to `size` of the reach or rad.
fn moved(machine: &Machine, size: f64, shares: &mut impl Iterator<Item = f64>) -> Configuration {
    let mut next = || size * shares.next().unwrap_or(0.0);
    let mut at = machine.home.clone();
    let turn = Vector3::from_fn(|_, _| next());
    at.pose = Pose {
        rotation: rotation_exp(turn) * at.pose.rotation,
        translation: at.pose.translation + Vector3::from_fn(|_, _| next() * machine.characteristic_length),
    };
    let passive = machine.chains.iter().flat_map(|chain| chain.passive.iter().map(|joint| joint.motion));
    let motions = machine.drives().map(|(_, drive)| drive.motion).chain(passive);
    for (value, motion) in at.drives.iter_mut().chain(at.passive.iter_mut().flatten()).zip(motions) {
        *value += next() * if motion == Motion::Prismatic { machine.characteristic_length } else { 1.0 };
    }
    at
}

/// The closure equations at `at` with the drives commanded, and with the task commanded.
fn problems(machine: &Machine, at: &Configuration) -> [DMatrix<f64>; 2] {
    let closures = machine.closure_jacobian(at);
    let with = |commanded: usize, entry: &dyn Fn(usize, usize) -> f64| {
        let (rows, columns) = closures.shape();
        let own = |i: usize, j: usize| if i < rows { closures[(i, j)] } else { entry(i - rows, j) };
        DMatrix::from_fn(rows + commanded, columns, own)
    };
    let task = |i: usize, j: usize| match machine.controls[i] {
        Coordinate::Translation(axis) if j == axis => 1.0,
        Coordinate::Rotation(axis) if (3..6).contains(&j) => at.pose.rotation[(j - 3, axis)],
        _ => 0.0,
    };
    [with(machine.drive_count(), &|i, j| f64::from(j == 6 + i)), with(machine.controls.len(), &task)]
}

/// Whether a triangle with this diagonal has a pivot that is zero.
fn is_singular(pivots: &[f64]) -> bool {
    let least = pivots.iter().fold(f64::INFINITY, |least, pivot| least.min(pivot.abs()));
    least < 1e-9 * pivots.iter().fold(0.0f64, |largest, pivot| largest.max(pivot.abs()))
}

/// Whether the determinant on the column space at `from` changes its sign; from a singular problem, whether it is regular at home.
fn changes_sign(from: &DMatrix<f64>, to: &DMatrix<f64>, home: &DMatrix<f64>) -> bool {
    if from.nrows() < from.ncols() {
        return false;
    }
    let qr = from.clone().qr();
    let pivots = qr.r().diagonal();
    if is_singular(pivots.as_slice()) {
        return !is_singular(home.clone().qr().r().diagonal().as_slice());
    }
    let sign: f64 = pivots.iter().map(|pivot| pivot.signum()).product();
    sign * qr.q().tr_mul(to).determinant() < 0.0
}

proptest! {
    #![proptest_config(crate::cases::cases(24))]

    #[test]
    fn chains_one_by_one_say_what_the_whole_problem_says(
        which in 0..catalogue::names().count(),
        sizes in [0.0..0.3f64, 0.0..0.3f64],
        shares in proptest::collection::vec(-1.0..1.0f64, 200),
    ) {
        let machine = Machine::named(catalogue::names().nth(which).unwrap()).unwrap();
        let mut shares = shares.into_iter();
        let from = moved(&machine, sizes[0], &mut shares);
        let to = moved(&machine, sizes[1], &mut shares);
        let [before, after, home] = [&from, &to, &machine.home].map(|at| problems(&machine, at));
        let expected = (0..2).any(|asked| changes_sign(&before[asked], &after[asked], &home[asked]));
        prop_assert_eq!(machine.passes_singularity(&from, &to), expected, "{}", machine.name);
    }
}

/// The passive joints of such a chain cannot be eliminated by their own equations: the problem is judged as a whole.
#[test]
fn a_chain_stretched_at_both_ends_is_judged_by_the_whole_problem() {
    let mut count = 0;
    for name in ["hexapod", "tricept"] {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/machines");
        let machine = Machine::from_file(&folder.join(format!("{name}.toml"))).unwrap();
        let home = problems(&machine, &machine.home);
        let mut before_chain = 6 + machine.drive_count();
        for (which, chain) in machine.chains.iter().enumerate() {
            let columns = before_chain..before_chain + chain.passive.len();
            before_chain = columns.end;
            for joint in 0..chain.passive.len() {
                let stretched = |size: f64| {
                    let mut shares = (1..200).map(|k| (f64::from(k) * 1.7).sin());
                    let mut at = moved(&machine, size, &mut shares);
                    at.passive[which].clone_from(&machine.home.passive[which]);
                    at.passive[which][joint] = std::f64::consts::FRAC_PI_2;
                    at
                };
                let (from, to) = (stretched(0.01), stretched(0.03));
                let own = machine.closure_jacobian(&from).columns_range(columns.clone()).into_owned();
                let values = own.singular_values();
                if values.min() > 1e-12 * values.max() {
                    continue;
                }
                count += 1;
                let [before, after] = [&from, &to].map(|at| problems(&machine, at));
                let expected = (0..2).any(|asked| changes_sign(&before[asked], &after[asked], &home[asked]));
                assert!(expected, "{name}: chain {which}, joint {joint} is singular at home");
                assert!(machine.passes_singularity(&from, &to), "{name}: chain {which}, joint {joint}");
            }
        }
    }
    assert!(count > 0, "no chain can be stretched");
}
