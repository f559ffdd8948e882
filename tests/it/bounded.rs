//! Corrections of a whole path within limits: exact where the limits allow, best where they do not, limits kept and named.

use kinetostat::{
    compensation::{
        BoundedError, BoundedPath, BoundedPoint, BoundedSettings, BoundedStatus, CompensationSettings, CorrectedPoint,
        ErrorNorm, LimitKind, Limits, Method, Session, Target, TaskPoint, compensate, compensate_bounded,
    },
    machine::{ChainError, Machine},
    process::MillingForce,
};
use nalgebra::Vector3;

use crate::support::cases::cases;

/// A machine, the same with errors, and a path for it.
struct Case {
    nominal: Machine,
    actual: Machine,
    tasks: Vec<TaskPoint>,
}

impl Case {
    /// The circle of 50 mm around Q1, cut once around with `points` points.
    fn orthoglide(points: usize) -> Self {
        Self::circle("orthoglide", [126.35; 3], points, MillingForce::KLIMCHIK_GROOVE)
    }

    /// A circle on the Tripteron, under a force that bends it by some tenths of a millimetre.
    fn tripteron(points: usize) -> Self {
        Self::circle("tripteron", [450.0, 550.0, 500.0], points, MillingForce::KLIMCHIK_GROOVE)
    }

    fn circle(name: &str, centre: [f64; 3], points: usize, force: MillingForce) -> Self {
        let nominal = Machine::named_or_file(name).unwrap();
        let turns = [1.0f64, -1.0, 1.0];
        let error = |(chain, degrees): (_, f64)| ChainError::turn_about_drive_axis(chain, degrees.to_radians());
        let errors: Vec<ChainError> = nominal.chains.iter().zip(turns).map(error).collect();
        let actual = nominal.with_errors(&errors);
        let task = |k: usize| {
            let phi = std::f64::consts::TAU * k as f64 / points as f64;
            let position = Vector3::from(centre) + 25.0 * Vector3::new(phi.cos(), phi.sin(), 0.0);
            let load = force.wrench(phi, &nominal.tool());
            TaskPoint::new(nominal.pose_at(position), load, Target::ToolTip)
        };
        let tasks = (0..points).map(task).collect();
        Self { nominal, actual, tasks }
    }

    fn solve(&self, limits: &Limits, objective: ErrorNorm) -> Result<BoundedPath, BoundedError> {
        let settings = BoundedSettings::default();
        compensate_bounded(&self.nominal, &self.actual, &self.tasks, limits, objective, &settings, &|_| {})
    }

    fn solved(&self, limits: &Limits, objective: ErrorNorm) -> BoundedPath {
        let path = self.solve(limits, objective).unwrap_or_else(|error| panic!("{error}"));
        let status = path.summary.status;
        assert!(matches!(status, BoundedStatus::Converged | BoundedStatus::Unbounded), "{objective:?}: {status:?}");
        path
    }

    /// Unbounded corrections.
    fn direct(&self) -> Vec<Vec<f64>> {
        let mut session = Session::new(&self.nominal, &self.actual, CompensationSettings::default());
        self.tasks.iter().map(|task| compensate(&mut session, task, Method::Direct).drives).collect()
    }

    /// Nominal drives.
    fn commands(&self) -> Vec<Vec<f64>> {
        let drives = |task: &TaskPoint| self.nominal.inverse_kinematics(&task.pose).unwrap().drives;
        self.tasks.iter().map(drives).collect()
    }

    /// Unbounded Δρ.
    fn wanted(&self) -> Vec<Vec<f64>> {
        let difference = |(a, b): (Vec<f64>, Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        self.direct().into_iter().zip(self.commands()).map(difference).collect()
    }

    /// Errors in mm by an independent simulation of `drives`.
    fn errors(&self, drives: &[Vec<f64>]) -> Vec<f64> {
        use kinetostat::statics::{self, Scratch, State, equilibrium};
        let (mut scratch, tip) = (Scratch::new(&self.actual), self.nominal.tool_tip);
        let settings = statics::Settings { tolerance: 1e-13, ..statics::Settings::default() };
        let error = |(task, drives): (&TaskPoint, &Vec<f64>)| {
            let at = self.nominal.inverse_kinematics(&task.pose).unwrap();
            let mut state = State::rigid(&self.nominal, &at);
            let outcome = equilibrium(&self.actual, drives, &task.load, &mut state, &mut scratch, &settings);
            assert_eq!(outcome.status, statics::Status::Solved);
            (state.pose.transform(tip) - task.pose.transform(tip)).norm()
        };
        self.tasks.iter().zip(drives).map(error).collect()
    }
}

fn points(path: &BoundedPath) -> Vec<&CorrectedPoint> {
    path.points.iter().map(|point| point.corrected().expect("every point takes part")).collect()
}

fn drives(path: &BoundedPath) -> Vec<Vec<f64>> {
    points(path).into_iter().map(|point| point.drives.clone()).collect()
}

fn largest<'v>(values: impl IntoIterator<Item = &'v Vec<f64>>) -> f64 {
    values.into_iter().flatten().fold(0.0, |most, value| most.max(value.abs()))
}

fn largest_change(corrections: &[Vec<f64>]) -> f64 {
    let changes = corrections.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()));
    changes.fold(0.0, f64::max)
}

fn corrections(path: &BoundedPath) -> Vec<Vec<f64>> {
    points(path).into_iter().map(|point| point.correction.clone()).collect()
}

fn correction(limit: f64) -> Limits {
    Limits { correction: Some(vec![limit; 3]), ..Limits::default() }
}

fn force(limit: f64) -> Limits {
    Limits { force: Some(vec![limit; 3]), ..Limits::default() }
}

fn forces(path: &BoundedPath) -> Vec<Vec<f64>> {
    points(path).into_iter().map(|point| point.drive_forces.clone()).collect()
}

fn change(limit: f64) -> Limits {
    Limits { correction_change: Some(vec![limit; 3]), ..Limits::default() }
}

#[test]
fn loose_limits_return_the_unbounded_corrections() {
    for case in [Case::orthoglide(24), Case::tripteron(24)] {
        let wanted = case.wanted();
        let loose = Limits {
            correction: Some(vec![1.01 * largest(&wanted); 3]),
            correction_change: Some(vec![1.01 * largest_change(&wanted); 3]),
            force: Some(vec![1e5; 3]),
            travel: Some(vec![(-2e3, 2e3); 3]),
        };
        for limits in [Limits::default(), loose] {
            for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
                let path = case.solved(&limits, objective);
                assert_eq!(path.summary.status, BoundedStatus::Unbounded);
                for (got, expected) in drives(&path).iter().flatten().zip(case.direct().iter().flatten()) {
                    assert!((got - expected).abs() < 1e-6, "{got} differs from {expected}");
                }
                assert!(path.summary.after.worst < 1e-9 && path.summary.before.worst > 0.1, "{:?}", path.summary);
                assert!(path.summary.prices.is_empty());
            }
        }
    }
}

#[test]
fn corrections_are_clipped_where_needed_and_exact_elsewhere() {
    for case in [Case::orthoglide(36), Case::tripteron(36)] {
        let wanted = case.wanted();
        let limit = 0.8 * largest(&wanted);
        let exact: Vec<bool> = wanted.iter().map(|u| largest([u]) <= limit).collect();
        assert!(exact.contains(&true) && exact.contains(&false));
        for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
            let path = case.solved(&correction(limit), objective);
            assert!(largest(&corrections(&path)) <= limit + 1e-9);
            for ((point, wanted), exact) in points(&path).into_iter().zip(&wanted).zip(&exact) {
                let off = point.correction.iter().zip(wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                assert!(!exact || off < 1e-6, "{objective:?}: a point the limit does not concern is off by {off:e} mm");
                assert_eq!(*exact, point.binding.is_empty(), "{objective:?}: {point:?}");
                assert!(point.binding.iter().all(|binding| binding.kind == LimitKind::Correction));
            }
            let simulated = case.errors(&drives(&path));
            for (point, simulated) in points(&path).into_iter().zip(simulated) {
                assert!((point.error - simulated).abs() < 1e-9);
                assert!((point.position_error.norm() - point.error).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn changes_from_point_to_point_are_limited() {
    for case in [Case::orthoglide(36), Case::tripteron(36)] {
        let wanted = case.wanted();
        for share in [0.0, 0.3, 0.7] {
            let limit = share * largest_change(&wanted);
            for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
                let path = case.solved(&change(limit), objective);
                let got = largest_change(&corrections(&path));
                assert!(got <= limit + 1e-9, "{objective:?}: changes by {got} mm, allowed {limit} mm");
                assert!(path.summary.after.worst > 1e-6);
                assert!(points(&path).iter().any(|point| !point.binding.is_empty()));
            }
        }
    }
}

#[test]
fn a_change_limit_that_binds_in_one_place_leaves_the_rest_exact() {
    let mut case = Case::orthoglide(60);
    // A jump of the load in the middle of the path.
    for task in &mut case.tasks[30..] {
        task.load.force.y += 300.0;
    }
    let wanted = case.wanted();
    let elsewhere = largest_change(&wanted[..30]).max(largest_change(&wanted[30..]));
    assert!(largest_change(&wanted) > 2.0 * elsewhere);
    for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
        let path = case.solved(&change(1.2 * elsewhere), objective);
        assert!(path.summary.after.worst > 1e-3);
        for k in (0..20).chain(40..60) {
            let point = points(&path)[k];
            assert!(point.error < 1e-9, "{objective:?}: point {k} is off by {:e} mm", point.error);
        }
    }
}

#[test]
fn travel_is_kept_even_where_the_nominal_command_leaves_it() {
    for case in [Case::orthoglide(36), Case::tripteron(36)] {
        let wanted = case.direct();
        let range = |i: usize| {
            let rho = wanted.iter().map(|drives| drives[i]);
            rho.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rho| (low.min(rho), high.max(rho)))
        };
        // 0.05 mm inside what the exact corrections need, for the drives that move much.
        let inside = |(low, high): (f64, f64)| if high - low > 5.0 { (low + 0.05, high - 0.05) } else { (low, high) };
        let travel: Vec<(f64, f64)> = (0..3).map(range).map(inside).collect();
        let limits = Limits { travel: Some(travel.clone()), ..Limits::default() };
        for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
            let path = case.solved(&limits, objective);
            for (rho, (low, high)) in drives(&path).iter().flat_map(|rho| rho.iter().zip(&travel)) {
                assert!((low - 1e-9..=high + 1e-9).contains(rho), "{rho} outside {low}..{high}");
            }
            let mut binding = points(&path).into_iter().flat_map(|point| &point.binding);
            assert!(binding.all(|binding| binding.kind == LimitKind::Travel));
            assert!(path.summary.after.worst > 1e-3 && path.summary.after.worst < 0.2, "{:?}", path.summary);
        }
    }
}

#[test]
fn forces_are_kept_in_the_nonlinear_simulation() {
    let case = Case::orthoglide(24);
    let largest_force = largest(&forces(&case.solved(&Limits::default(), ErrorNorm::Rms)));
    for less in [0.1, 10.0] {
        let limit = largest_force - less;
        for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
            let path = case.solved(&force(limit), objective);
            let largest = largest(&forces(&path));
            assert!(largest <= limit * (1.0 + 1e-6), "{largest} N, allowed {limit} N");
            assert!(path.summary.force_excess <= 1e-6);
            assert!(path.summary.after.worst > 1e-3, "{:?}", path.summary);
            assert!(path.summary.prices.iter().all(|price| price.kind == LimitKind::Force && price.price >= 0.0));
            assert!(path.summary.prices.iter().any(|price| price.price > 0.0));
        }
    }
}

#[test]
fn each_objective_is_the_better_one_in_its_own_terms() {
    for case in [Case::orthoglide(36), Case::tripteron(36)] {
        let wanted = case.wanted();
        for limits in [correction(0.7 * largest(&wanted)), change(0.4 * largest_change(&wanted))] {
            let (rms, worst) = (case.solved(&limits, ErrorNorm::Rms), case.solved(&limits, ErrorNorm::Worst));
            let (rms, worst) = (rms.summary.after, worst.summary.after);
            assert!(worst.worst <= rms.worst * (1.0 + 3e-5), "worst {worst:?}, rms {rms:?}");
            assert!(rms.rms <= worst.rms * (1.0 + 1e-8), "worst {worst:?}, rms {rms:?}");
        }
    }
}

/// Numbers in −1..1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[test]
fn random_search_finds_nothing_better() {
    for mut case in [Case::orthoglide(9), Case::tripteron(9)] {
        case.tasks.truncate(3);
        let (commands, wanted) = (case.commands(), case.wanted());
        let (size, step) = (0.9 * largest(&wanted), 0.3 * largest_change(&wanted));
        let limits =
            Limits { correction: Some(vec![size; 3]), correction_change: Some(vec![step; 3]), ..Limits::default() };
        for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
            let path = case.solved(&limits, objective);
            let value = |drives: &[Vec<f64>]| {
                let errors = case.errors(drives);
                match objective {
                    ErrorNorm::Rms => (errors.iter().map(|e| e * e).sum::<f64>() / 3.0).sqrt(),
                    ErrorNorm::Worst => errors.into_iter().fold(0.0, f64::max),
                }
            };
            let best = value(&drives(&path));
            assert!(best > 1e-3, "the limits should bind: {best}");
            let mut random = Random(1);
            let mut closest = f64::INFINITY;
            for trial in 0..cases(3000).cases.min(6000) {
                let radius = 0.3 * 0.3f64.powi(trial as i32 % 8);
                let mut moved = corrections(&path);
                moved.iter_mut().flatten().for_each(|u| *u += radius * random.next());
                // Into the limits, point after point.
                let mut before: Option<Vec<f64>> = None;
                for own in &mut moved {
                    for (i, u) in own.iter_mut().enumerate() {
                        let (low, high) = before.as_ref().map_or((-size, size), |b| (b[i] - step, b[i] + step));
                        *u = u.clamp(low.max(-size), high.min(size));
                    }
                    before = Some(own.clone());
                }
                let rho: Vec<Vec<f64>> = commands
                    .iter()
                    .zip(&moved)
                    .map(|(rho, u)| rho.iter().zip(u).map(|(rho, u)| rho + u).collect())
                    .collect();
                closest = closest.min(value(&rho));
            }
            assert!(closest > best * (1.0 - 3e-5), "{objective:?}: {closest} is better than {best}");
            assert!(closest < best * 1.01, "{objective:?}: the search should come near: {closest}, {best}");
        }
    }
}

#[test]
fn prices_are_differences_of_the_objective_by_the_limit() {
    for case in [Case::orthoglide(24), Case::tripteron(24)] {
        let wanted = case.wanted();
        let largest_force = largest(&forces(&case.solved(&Limits::default(), ErrorNorm::Rms)));
        type Make<'a> = &'a dyn Fn(f64) -> Limits;
        let families: [(LimitKind, Make<'_>, f64, f64); 3] = [
            (LimitKind::Correction, &correction, 0.75 * largest(&wanted), 1e-3),
            (LimitKind::Change, &change, 0.4 * largest_change(&wanted), 1e-4),
            (LimitKind::Force, &force, largest_force - 0.1, 1e-3),
        ];
        for (kind, make, limit, step) in families {
            // The Tripteron's drives carry the load whatever the corrections.
            if kind == LimitKind::Force && case.nominal.name == "tripteron" {
                continue;
            }
            for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
                let value = |limit: f64| {
                    let after = case.solved(&make(limit), objective).summary.after;
                    if objective == ErrorNorm::Rms { after.rms } else { after.worst }
                };
                let prices = case.solved(&make(limit), objective).summary.prices;
                assert!(prices.iter().all(|price| price.kind == kind));
                let price: f64 = prices.iter().map(|price| price.price).sum();
                let difference = (value(limit - step) - value(limit + step)) / (2.0 * step);
                assert!(
                    (price - difference).abs() < 2e-2 * difference,
                    "{kind:?} {objective:?}: {price}, {difference}"
                );
            }
        }
    }
}

#[test]
fn contradictory_limits_are_named() {
    let case = Case::orthoglide(12);
    let commands = case.commands();
    let message = |limits: &Limits| match case.solve(limits, ErrorNorm::Rms) {
        Err(error) => error.to_string(),
        Ok(path) => panic!("there should be no solution: {:?}", path.summary),
    };
    assert_eq!(
        message(&Limits { correction: Some(vec![1.0, 2.0]), ..Limits::default() }),
        "limit on the correction: 2 values for 3 drives"
    );
    assert_eq!(
        message(&Limits { force: Some(vec![1.0, 2.0, f64::NAN]), ..Limits::default() }),
        "force limit of drive z: expected a number above 0, got NaN"
    );
    let high = commands.iter().map(|rho| rho[0]).fold(f64::NEG_INFINITY, f64::max);
    let travel = vec![(-1e3, high - 2.0), (-1e3, 1e3), (-1e3, 1e3)];
    let limits = Limits { travel: Some(travel), correction: Some(vec![0.5; 3]), ..Limits::default() };
    assert_eq!(
        message(&limits),
        "drive x at point 1: ρ = -129.690 mm must change by 2.000 mm into its travel of -1000.000 to -131.690 mm, but \
         the limit on the correction is 0.500 mm"
    );
    let low = commands.iter().map(|rho| rho[0]).fold(f64::INFINITY, f64::min);
    let travel = vec![(low + 2.0, high - 2.0), (-1e3, 1e3), (-1e3, 1e3)];
    let limits = Limits { travel: Some(travel), ..change(0.1) };
    assert_eq!(
        message(&limits),
        "drive x from point 1 to 6: its travel and the limit on its correction make Δρ change by 1.4908 mm, but the \
         limit on the change from point to point allows 0.5000 mm (5 × 0.1000 mm)"
    );
}

#[test]
fn force_limits_that_cannot_be_kept_are_named() {
    let case = Case::orthoglide(12);
    let message = |case: &Case, limits: &Limits| case.solve(limits, ErrorNorm::Rms).unwrap_err().to_string();
    let largest_force = largest(&forces(&case.solved(&Limits::default(), ErrorNorm::Rms)));
    let limits = Limits { correction: Some(vec![0.1; 3]), ..force(largest_force - 3.0) };
    assert_eq!(
        message(&case, &limits),
        "drive x at point 11: its force cannot be brought below 400.424 N, the force limit is 399.438 N; the force \
         limit could be kept without the limit on the correction"
    );
    assert_eq!(
        message(&Case::tripteron(12), &force(200.0)),
        "drive x at point 0: its force cannot be brought below 215.001 N, the force limit is 200.000 N; no other limit \
         alone is the reason"
    );
}

#[test]
fn points_without_a_solution_are_left_out_and_labelled() {
    let mut case = Case::orthoglide(12);
    case.tasks[5].pose.translation = Vector3::new(5e3, 0.0, 0.0);
    let path = case.solved(&correction(0.5), ErrorNorm::Rms);
    assert!(
        matches!(&path.points[5], BoundedPoint::LeftOut(status) if status.label() == "unreachable"),
        "{:?}",
        path.points[5]
    );
    assert_eq!(path.points.iter().filter(|point| point.corrected().is_some()).count(), 11);
    case.tasks.clear();
    assert_eq!(case.solve(&correction(0.5), ErrorNorm::Worst).unwrap().summary.status, BoundedStatus::Empty);
}

#[test]
fn random_limits_are_kept() {
    let mut random = Random(7);
    for case in [Case::orthoglide(12), Case::tripteron(12)] {
        let wanted = case.wanted();
        let largest_force = largest(&forces(&case.solved(&Limits::default(), ErrorNorm::Rms)));
        for trial in 0..30 {
            let mut share = || 0.5 + 0.5 * random.next();
            let mut three = |size: f64| Some((0..3).map(|_| 1.2 * size * share()).collect::<Vec<f64>>());
            let mut limits = Limits { correction: three(largest(&wanted)), ..Limits::default() };
            if trial % 2 == 0 {
                limits.correction_change = three(largest_change(&wanted));
            }
            if trial % 5 == 0 {
                limits.correction = Some(vec![0.0, 0.3, f64::INFINITY]);
            }
            if trial % 3 == 0 {
                limits.force = Some(vec![largest_force + 1.0 - 4.0 * share(); 3]);
            }
            for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
                let path = match case.solve(&limits, objective) {
                    Ok(path) => path,
                    Err(BoundedError::Force { .. }) => continue,
                    Err(error) => panic!("{limits:?} {objective:?}: {error}"),
                };
                let status = path.summary.status;
                assert!(
                    matches!(status, BoundedStatus::Converged | BoundedStatus::Unbounded),
                    "{limits:?} {objective:?}: {:?}",
                    path.summary
                );
                assert!(path.summary.after.rms.is_finite());
                let sizes = limits.correction.as_ref().unwrap();
                for own in corrections(&path) {
                    assert!(own.iter().zip(sizes).all(|(u, size)| u.abs() <= size + 1e-9));
                }
                if let Some(steps) = &limits.correction_change {
                    for pair in corrections(&path).windows(2) {
                        assert!((0..3).all(|i| (pair[0][i] - pair[1][i]).abs() <= steps[i] + 1e-9));
                    }
                }
            }
        }
    }
}

#[test]
#[ignore = "takes long; prints times with --nocapture"]
fn paths_of_2000_points_are_solved() {
    for case in [Case::orthoglide(2000), Case::tripteron(2000)] {
        let wanted = case.wanted();
        let most = largest(&forces(&case.solved(&Limits::default(), ErrorNorm::Rms)));
        let tight = [
            correction(0.7 * largest(&wanted)),
            change(0.4 * largest_change(&wanted)),
            force(most - 5.0),
            force(0.65 * most),
        ];
        for (limits, objective) in
            tight.iter().flat_map(|limits| [(limits, ErrorNorm::Rms), (limits, ErrorNorm::Worst)])
        {
            let start = std::time::Instant::now();
            let path = case.solve(limits, objective);
            let seconds = start.elapsed().as_secs_f64();
            let summary = path.map(|path| path.summary);
            println!("{} {objective:?} {seconds:.2} s: {summary:?}", case.nominal.name);
            match summary {
                Ok(summary) => {
                    let is_found = matches!(summary.status, BoundedStatus::Unbounded | BoundedStatus::Converged);
                    assert!(is_found, "{}, {objective:?}: {summary:?}", case.nominal.name);
                }
                // Its drives carry the load whatever the corrections, so a limit on forces is kept or cannot be.
                Err(error) => {
                    assert_eq!(case.nominal.name, "tripteron", "{error}");
                    assert!(error.to_string().contains("its force cannot be brought below"), "{error}");
                }
            }
        }
    }
}

#[test]
fn the_worst_point_is_never_worse_than_without_correction() {
    let mut binding = 0;
    for machine in [Case::orthoglide, Case::tripteron] {
        // Forces that turn round from point to point, as in the corners of a small square.
        for turning in [1, 2, 5] {
            let mut case = machine(24);
            for (k, task) in case.tasks.iter_mut().enumerate() {
                if (k / turning) % 2 == 1 {
                    task.load.force = -task.load.force;
                    task.load.moment = -task.load.moment;
                }
                task.load.force *= 1.0 + k as f64 / 8.0;
            }
            let (wanted, before) = (case.wanted(), case.errors(&case.commands()).into_iter().fold(0.0, f64::max));
            for share in [0.02, 0.1, 0.3] {
                for limits in [change(share * largest_change(&wanted)), correction(share * largest(&wanted))] {
                    for objective in [ErrorNorm::Rms, ErrorNorm::Worst] {
                        let after = case.solve(&limits, objective).unwrap().summary.after;
                        assert!(after.worst <= before * (1.0 + 1e-12), "{share} {objective:?}: {after:?}, {before}");
                        binding += usize::from(after.worst > 0.9 * before);
                    }
                }
            }
        }
    }
    assert!(binding > 10, "{binding}");
}
