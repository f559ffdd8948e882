//! One machine asked for equilibria one by one, held against the function that does it.

use kinetostat_engine::{
    Machine, Method, Pose, Session, Solver, Target, TaskPoint, Wrench, compensate,
    compensation::CompensationSettings,
    machine::catalogue,
    nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3},
    spatial::rotation_exp,
    statics::{Scratch, Settings, State, Status, equilibrium},
};

const LOAD: Wrench = Wrench { force: Vector3::new(40.0, -30.0, -100.0), moment: Vector3::new(500.0, 0.0, -200.0) };

#[test]
fn each_answer_is_the_equilibrium_whatever_came_before() {
    for name in catalogue::names() {
        let machine = Machine::named(name).unwrap();
        let mut solver = Solver::new(&machine);
        let loads = [LOAD, LOAD.scale(1e4), Wrench::zero(), LOAD];
        let answers = loads.map(|load| solver.solve(&machine.home.drives, &load).unwrap());
        for (load, answer) in loads.iter().zip(&answers) {
            let at = machine.forward_kinematics(&machine.home.drives).unwrap();
            let mut state = State::rigid(&machine, &at);
            let mut scratch = Scratch::new(&machine);
            let outcome = equilibrium(&machine, &at.drives, load, &mut state, &mut scratch, &Settings::default());
            assert_eq!((&answer.status, &answer.pose), (&outcome.status, &state.pose), "{}", machine.name);
        }
        assert_eq!(answers[0], answers[3]);
        assert_eq!(answers[0].status, Status::Solved, "{}", machine.name);
    }
}

#[test]
fn a_machine_with_errors_is_solved_from_where_the_one_without_stands() {
    let machine = Machine::named("orthoglide").unwrap();
    let actual = machine.with_errors(&machine.assembly_errors(&[1.0, -1.0, 1.0]));
    let commanded = machine.inverse_kinematics_at(Vector3::new(30.0, -40.0, 75.0)).unwrap();
    let [unloaded, loaded] = [Wrench::zero(), LOAD].map(|load| Solver::new(&actual).solve_at(&commanded, &load));
    assert_eq!(loaded.status, Status::Solved);
    assert!(machine.tool_displacement(&commanded.pose, &unloaded.pose).norm() > 0.01);
    assert!(machine.tool_displacement(&unloaded.pose, &loaded.pose).norm() > 0.01);
}

#[test]
fn drives_that_close_no_chain_are_refused() {
    let machine = Machine::named("orthoglide").unwrap();
    let far = [5000.0, 0.0, 0.0];
    assert!(Solver::new(&machine).solve(&far, &LOAD).unwrap_err().to_string().contains("chain"));
}

#[test]
#[should_panic = "drives of orthoglide"]
fn drives_are_as_many_as_the_machine_has() {
    let machine = Machine::named("orthoglide").unwrap();
    let _ = Solver::new(&machine).solve(&[0.0], &LOAD);
}

#[test]
fn poses_go_into_isometries_and_back() {
    for vector in [Vector3::zeros(), Vector3::new(0.1, -0.7, 2.0), Vector3::new(std::f64::consts::PI, 0.0, 0.0)] {
        let pose = Pose { rotation: rotation_exp(vector), translation: Vector3::new(1.0, -2.0, 3.0) };
        let isometry = Isometry3::from(pose);
        let expected = UnitQuaternion::from_scaled_axis(vector);
        assert!(isometry.rotation.angle_to(&expected) < 1e-7 && isometry.translation.vector == pose.translation);
        let point = Vector3::new(5.0, 6.0, 7.0);
        assert!((isometry * Point3::from(point) - Point3::from(pose.transform(point))).norm() < 1e-12);
        assert!((Pose::from(isometry).rotation - pose.rotation).amax() < 1e-15);
    }
}

#[test]
fn a_machine_that_jumps_far_stays_assembled_as_it_is() {
    // Drives that jump by 50 degrees leave the arms of the delta closed above the base as well, 2 m away.
    let machine = Machine::named("rotary_delta").unwrap();
    for (method, load) in [(Method::None, Wrench::zero()), (Method::Direct, Wrench::zero()), (Method::Direct, LOAD)] {
        let mut session = Session::new(&machine, &machine, CompensationSettings::default());
        for at in [[283.5, 284.25, -1095.0], [-285.0, -285.75, -904.5], [286.5, -287.25, -904.0]] {
            let pose = machine.pose_at(at.into());
            let task = TaskPoint::new(pose, load, Target::ToolTip);
            let found = compensate(&mut session, &task, method);
            let error = found.position_error.norm();
            assert!(found.outcome.is_some() && error < 1e-6, "{method:?} at {at:?}: {:?}, {error} mm", found.status);
        }
    }
}
