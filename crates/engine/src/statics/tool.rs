//! Bending of what lies between P and T: spindle, holder and cutter.
//!
//! The platform's body carries the tool through a compliance at T. The load acts on the tool; P, as states have it, moves with the tool's end, so
//! that T is where [`Machine::tool`] has it. With θ the six deflections at T, `X_T = X_body X_PT V(θ)` and `θ = C Jᵀ w`, w the load at T. What
//! the body receives is the load, and the moment by which the deflected tool has carried it aside: `(F, M + (p_P − p_body) × F)`. A dead load does not
//! turn with the body, so that the twist of P is `[1, −[δ]×; 0, 1] t_body + C_P (F × ω, M × ω) + C_P dF`, C_P the tool's loaded compliance at P.

use std::ops::AddAssign;

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::{
    outcome::Outcome,
    platform::{Square, subtract_half_moment},
    state::State,
};
use crate::{
    machine::Machine,
    spatial::{Axis, Pose, Wrench, skew},
};

/// Most iterations for the deflections of the tool.
const MAX_ITERATIONS: usize = 50;
/// Deflections change by less than this share of themselves when they are found.
const FOUND: f64 = 1e-15;

/// Pose `V(θ)` of the tool's end relative to the straight tool, by the deflections `theta` (mm, rad).
fn deflection_pose(theta: &Vector6<f64>) -> Pose {
    let mut pose = Pose::from_translation(Vector3::new(theta[0], theta[1], theta[2]));
    for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        pose.rotate_about(axis, theta[3 + i]);
    }
    pose
}

/// Generalised forces `Jᵀ w` of `force` and `moment` at T, in the axes of T before it is deflected by `theta`.
fn generalised_forces(theta: &Vector6<f64>, force: Vector3<f64>, moment: Vector3<f64>) -> Vector6<f64> {
    let mut turned = Pose::identity();
    let mut forces = Vector6::zeros();
    forces.fixed_rows_mut::<3>(0).copy_from(&force);
    for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        forces[3 + i] = turned.rotation.column(i).dot(&moment);
        turned.rotate_about(axis, theta[3 + i]);
    }
    forces
}

/// Pose of P at the end of the deflected tool, the platform's body at `body` under the dead `load` at P (N, N·mm).
pub(super) fn deflected_pose(machine: &Machine, body: &Pose, load: &Wrench) -> Pose {
    bent_tool(machine, body, load).0
}

/// Pose of P at the end of the deflected tool, as [`deflected_pose`], and the deflections at T (mm, rad).
fn bent_tool(machine: &Machine, body: &Pose, load: &Wrench) -> (Pose, Vector6<f64>) {
    let Some(compliance) = &machine.tool_compliance else { return (*body, Vector6::zeros()) };
    let (to_tool, straight) = (machine.tool(), body.compose(&machine.tool()));
    let mut theta = Vector6::zeros();
    let mut pose = *body;
    for _ in 0..MAX_ITERATIONS {
        let tool = straight.compose(&deflection_pose(&theta));
        pose = tool.compose(&to_tool.inverse());
        let moment = load.moment - (tool.translation - pose.translation).cross(&load.force);
        let inward = straight.rotation.transpose();
        let next = **compliance * generalised_forces(&theta, inward * load.force, inward * moment);
        let change = (next - theta).amax();
        theta = next;
        if change.is_nan() || change <= FOUND * theta.amax() {
            break;
        }
    }
    (pose, theta)
}

/// Pose of the platform's body from which the tool under `load` bends to the pose `pose` of P.
fn body_under_tool(machine: &Machine, pose: &Pose, load: &Wrench) -> Pose {
    let Some(compliance) = &machine.tool_compliance else { return *pose };
    let (to_tool, tool) = (machine.tool(), pose.compose(&machine.tool()));
    let moment = load.moment - (tool.translation - pose.translation).cross(&load.force);
    let mut theta = Vector6::zeros();
    let mut straight = tool;
    for _ in 0..MAX_ITERATIONS {
        let inward = straight.rotation.transpose();
        let next = **compliance * generalised_forces(&theta, inward * load.force, inward * moment);
        let change = (next - theta).amax();
        theta = next;
        straight = tool.compose(&deflection_pose(&theta).inverse());
        if change.is_nan() || change <= FOUND * theta.amax() {
            break;
        }
    }
    straight.compose(&to_tool.inverse())
}

/// Wrench that the platform's body at `body` receives of `load` at P, through the deflected tool (N, N·mm).
pub(super) fn load_on_body(machine: &Machine, body: &Pose, load: &Wrench) -> Wrench {
    if machine.tool_compliance.is_none() {
        return *load;
    }
    let aside = deflected_pose(machine, body, load).translation - body.translation;
    Wrench { force: load.force, moment: load.moment + aside.cross(&load.force) }
}

/// Converts a state of the platform's body, and the outcome of its solve, to those of P at the end of the deflected tool.
pub(super) fn convert_to_tool_end(machine: &Machine, load: &Wrench, state: &mut State, outcome: &mut Outcome) {
    if machine.tool_compliance.is_none() {
        return;
    }
    let body = state.pose;
    let pose = deflected_pose(machine, &body, load);
    (state.pose, state.body) = (pose, Some(body));
    let tool_compliance = loaded_compliance(machine, &body, load);
    let aside = pose.translation - body.translation;
    let twist_transfer = twist_transfer_at(aside, &tool_compliance, load);
    outcome.drive_sensitivity = twist_transfer * &outcome.drive_sensitivity;
    if let Some(compliance) = &mut outcome.compliance {
        let mut loaded = Matrix6::identity();
        let lever = skew(load.force) * tool_compliance.fixed_rows::<3>(0);
        let mut moments = loaded.fixed_rows_mut::<3>(3);
        moments -= lever;
        loaded.fixed_view_mut::<3, 3>(3, 0).add_assign(skew(aside));
        *compliance = twist_transfer * *compliance * loaded + tool_compliance;
        outcome.stiffness = compliance.try_inverse();
    }
}

/// Twist of P per twist of the body under a constant load; the tool has this `compliance`, and its end is shifted by `aside` (mm).
fn twist_transfer_at(aside: Vector3<f64>, compliance: &Matrix6<f64>, load: &Wrench) -> Matrix6<f64> {
    let mut twist_transfer = Matrix6::identity();
    twist_transfer.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(aside));
    twist_transfer + compliance * dead_load_stiffness(load)
}

/// Twist of P per twist of the body at `body`, `load` being constant.
pub(super) fn twist_transfer(machine: &Machine, body: &Pose, load: &Wrench) -> Matrix6<f64> {
    if machine.tool_compliance.is_none() {
        return Matrix6::identity();
    }
    let aside = deflected_pose(machine, body, load).translation - body.translation;
    twist_transfer_at(aside, &loaded_compliance(machine, body, load), load)
}

/// Loaded compliance of the tool: twist of P per dead wrench at P in O axes, the platform's body held at `body`.
fn loaded_compliance(machine: &Machine, body: &Pose, load: &Wrench) -> Matrix6<f64> {
    let Some(stiffness) = machine.tool_stiffness() else { return Matrix6::zeros() };
    let (pose, theta) = bent_tool(machine, body, load);
    let mut at = body.compose(&machine.tool());
    let mut screws = Matrix6::zeros();
    for i in 0..3 {
        screws.fixed_view_mut::<3, 1>(0, i).copy_from(&at.rotation.column(i));
    }
    let from_tip = -(pose.rotation * machine.tool_tip);
    for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        let turn = at.rotation.column(i).into_owned();
        screws.fixed_view_mut::<3, 1>(0, 3 + i).copy_from(&turn.cross(&from_tip));
        screws.fixed_view_mut::<3, 1>(3, 3 + i).copy_from(&turn);
        at.rotate_about(axis, theta[3 + i]);
    }
    // As of a chain: the wrench-weighted Hessian made symmetric, and what that leaves out.
    let mut tangent = stiffness;
    for j in 0..6 {
        let (linear, angular) = (screws.fixed_view::<3, 1>(0, j), screws.fixed_view::<3, 1>(3, j));
        let lever = linear.cross(&load.force) + angular.cross(&load.moment) * 0.5;
        for k in 0..=j {
            let value = screws.fixed_view::<3, 1>(3, k).dot(&lever);
            tangent[(k, j)] -= value;
            if k != j {
                tangent[(j, k)] -= value;
            }
        }
    }
    let Some(inward) = screws.try_inverse() else { return Matrix6::zeros() };
    let mut tangent = inward.transpose() * tangent * inward;
    subtract_half_moment(&mut tangent, *load);
    tangent.try_inverse().unwrap_or_else(Matrix6::zeros)
}

/// Change of a dead load at P, as a turning body sees it, per twist of the body.
fn dead_load_stiffness(load: &Wrench) -> Matrix6<f64> {
    let mut stays = Matrix6::zeros();
    stays.fixed_view_mut::<3, 3>(0, 3).copy_from(&skew(load.force));
    stays.fixed_view_mut::<3, 3>(3, 3).copy_from(&skew(load.moment));
    stays
}

/// Adds the stiffness by the load that the deflected tool carries aside to `tangent`: in the rotations, `(δ·F) 1 − δ Fᵀ + [F]× ∂δ/∂ω`.
pub(super) fn add_stiffness(machine: &Machine, body: &Pose, load: &Wrench, tangent: &mut Square<f64>) {
    if machine.tool_compliance.is_none() {
        return;
    }
    let aside = deflected_pose(machine, body, load).translation - body.translation;
    let by_bending = loaded_compliance(machine, body, load).fixed_rows::<3>(0) * dead_load_stiffness(load);
    let stiffness = Matrix3::identity() * aside.dot(&load.force) - aside * load.force.transpose()
        + skew(load.force) * by_bending.fixed_columns::<3>(3);
    for i in 0..3 {
        for j in 0..3 {
            tangent[3 + i][3 + j] += stiffness[(i, j)];
        }
    }
}

/// Pose of the platform's body, and compliance of the tool, for P held at `pose` by `load`.
pub(super) fn body_and_compliance(machine: &Machine, pose: &Pose, load: &Wrench) -> (Pose, Matrix6<f64>) {
    let body = body_under_tool(machine, pose, load);
    (body, loaded_compliance(machine, &body, load))
}
