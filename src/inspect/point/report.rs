//! Reports of one location, as text and as JSON.

use std::fmt::Display;

use nalgebra::{Matrix6, Vector3};
use serde_json::{Map, Value, json};

use crate::{
    answer::{cautions, drive_columns::shown_positions, tool_axis_text},
    files::{
        text_table::text_table,
        words::{counted, millimetres, tidy_degrees, with_minus_signs},
    },
    inspect::{
        machine_check::report::{branch_margin_text, conditioning_text},
        point::{PointLoad, PointQuestion, PointResult},
    },
    machine::{Drive, Machine, Motion, Unreachable},
    process::MillingForce,
    simulation::{Failure, status_of},
    spatial::rotation_log,
    statics::Status,
};

/// Returns the rows of a matrix, from the top.
fn matrix_rows(matrix: &Matrix6<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// Returns the components of a vector.
fn components(vector: Vector3<f64>) -> [f64; 3] {
    vector.into()
}

/// Returns the displacement of the tool tip, O axes, mm; `None` where the machine is not in equilibrium as calibrated.
fn tool_displacement(answer: &PointResult) -> Option<Vector3<f64>> {
    let zero = answer.zero.as_ref().ok()?;
    Some(answer.question.machine.tool_displacement(zero, &answer.loaded.pose))
}

/// Returns the force on the tool in axes of the tool frame T, N; a milling force directly from eq. (17), without rounding by way of O.
fn force_on_tool(answer: &PointResult) -> Vector3<f64> {
    match answer.question.load {
        PointLoad::Milling(force, phi) | PointLoad::Cut(force, phi, _) => force.force(phi),
        PointLoad::Wrench(_) => answer.tool.rotation.tr_mul(&answer.wrench.force),
    }
}

/// Version of the object of [`point_json`].
const SCHEMA: u32 = 3;

/// Returns label, chain, kind and units of each drive, in the order of lists of drive values.
fn drive_descriptions(machine: &Machine) -> Vec<Value> {
    let description = |(label, (chain, drive)): (String, (usize, &Drive))| {
        json!({
            "label": label,
            "chain": machine.chains[chain].name,
            "motion": drive.motion.label(),
            "position_unit": drive.motion.position_unit(),
            "force_unit": drive.motion.force_unit(),
        })
    };
    machine.drive_labels().into_iter().zip(machine.drives()).map(description).collect()
}

/// Returns drive values under `key` of each kind of drive, with null for drives of the other kind; null for all if there are no values.
fn by_kind(machine: &Machine, key: impl Fn(Motion) -> String, values: Option<Vec<f64>>) -> Map<String, Value> {
    let entry = |kind: Motion| {
        let of_kind = |values: &Vec<f64>| -> Value {
            let drives = values.iter().zip(machine.drives());
            drives.map(|(value, (_, drive))| (drive.motion == kind).then_some(*value)).collect()
        };
        (key(kind), values.as_ref().map_or(Value::Null, of_kind))
    };
    machine.drive_kinds().map(entry).collect()
}

/// Returns drive positions (mm, rad) under `KEY_mm` for prismatic joints and `KEY_deg` for revolute joints.
fn position_keys(machine: &Machine, key: &str, values: Option<&[f64]>) -> Map<String, Value> {
    let shown = values.map(|values| shown_positions(machine, values));
    by_kind(machine, |kind| format!("{key}_{}", kind.position_unit()), shown)
}

/// Returns drive forces under `PREFIXactuator_force_N` for prismatic joints and `PREFIXactuator_torque_Nmm` for revolute joints.
fn force_keys(machine: &Machine, prefix: &str, values: Option<Vec<f64>>) -> Map<String, Value> {
    by_kind(machine, |kind| format!("{prefix}actuator_{}_{}", kind.force_word(), kind.force_unit()), values)
}

/// Returns the object of [`point_json`] for a location that cannot be reached: every quantity is null.
pub fn unreachable_json(question: &PointQuestion, chain_errors_deg: &[f64], unreachable: &Unreachable) -> Value {
    point_object(question, chain_errors_deg, Err(&Failure::from(unreachable.clone())))
}

/// Returns an object with the keys of `tests/reference/orthoglide.json`, where drives are prismatic joints, and `schema`, `drives`, `status`, `reason`,
/// `iterations`, `residual` and the residual error; `tool_axis`, the direction from the spindle to the tool tip in O axes, and
/// `force_tool_frame_N`, the force in axes of the tool frame; `conditioning` ([`Machine::conditioning`]) and, of arms, `branch` and
/// `clearance` ([`Machine::clearance`]); `cautions`, the sentences of the text.
///
/// Keys of drive values end with their unit: `_mm` and `_N` of prismatic joints, `_deg` and `_Nmm` of revolute joints (`actuator_torque_Nmm`). A machine with
/// both has both, each with null where a drive is of the other kind. `chain_errors_deg` is passed through. Keys whose quantity does not exist
/// in this outcome are null.
pub fn point_json(answer: &PointResult, chain_errors_deg: &[f64]) -> Value {
    point_object(&answer.question, chain_errors_deg, Ok(answer))
}

/// Returns the object of [`point_json`]; `answer` is the result or why there is none.
fn point_object(question: &PointQuestion, chain_errors_deg: &[f64], answer: Result<&PointResult, &Failure>) -> Value {
    let machine = &question.machine;
    let known = answer.ok();
    let balanced = known.filter(|answer| answer.loaded.status.is_equilibrium());
    let rotation = |answer: &PointResult| answer.loaded.pose.rotation * answer.nominal.pose.rotation.transpose();
    let wrenches = |answer: &PointResult| answer.loaded.chains.iter().map(|c| c.wrench.to_array()).collect::<Vec<_>>();
    let done = known.and_then(|answer| answer.compensated.as_ref().ok());
    let tip_error = known.zip(done).map(|(answer, done)| {
        machine.tool_displacement(answer.zero.as_ref().unwrap_or(&answer.nominal.pose), &done.solution.pose)
    });
    let commanded = question.place.position().or(known.map(|answer| answer.nominal.pose.translation));
    let subjects = commanded.map_or_else(Vec::new, |at| question_cautions(question, at));
    let cautions = subjects.into_iter().map(|(what, said)| format!("{what}: {said}"));
    let cautions: Vec<String> = cautions.chain(balanced.into_iter().flat_map(beyond_limits)).collect();
    let phi_deg = match question.load {
        PointLoad::Milling(_, phi) | PointLoad::Cut(_, phi, _) => Some(tidy_degrees(phi.to_degrees())),
        PointLoad::Wrench(_) => None,
    };
    let [status, reason, compensation_status, compensation_reason] = match answer {
        Ok(PointResult { loaded, compensated, .. }) => [
            json!(loaded.status.label()),
            json!((loaded.status != Status::Solved).then(|| loaded.status.reason(machine))),
            json!(status_of(compensated)),
            json!(compensated.as_ref().err().map(|failure| &failure.reason)),
        ],
        Err(Failure { status, reason }) => [json!(status), json!(reason), json!(status), json!(reason)],
    };
    let mut object: Map<String, Value> = [
        ("schema", json!(SCHEMA)),
        ("drives", json!(drive_descriptions(machine))),
        ("zeroed", json!(machine.own_load_text().map(|_| machine.zeroed.label()))),
        ("phi_deg", json!(phi_deg)),
        ("chain_errors_deg", json!(chain_errors_deg)),
        ("position_mm", json!(known.map(|a| a.nominal.pose.translation).or(question.place.position()).map(components))),
        ("tool_axis", json!(known.map(|a| components(a.tool.rotation.column(2).into())))),
        ("branch", json!(known.and_then(|a| a.branch).map(|(branch, _)| branch.label()))),
        ("clearance", json!(known.and_then(|a| a.branch).map(|(_, clearance)| clearance))),
        ("conditioning", json!(known.map(|a| a.conditioning))),
        ("force_tool_frame_N", json!(known.map(|a| components(force_on_tool(a))))),
        ("wrench_N_Nmm", json!(known.map(|a| a.wrench.to_array()))),
        ("stiffness_unloaded", json!(known.and_then(|a| a.stiffness_unloaded.as_ref()).map(matrix_rows))),
        ("stiffness_loaded", json!(known.and_then(|a| a.loaded.stiffness.as_ref()).map(matrix_rows))),
        ("status", status),
        ("reason", reason),
        ("compensation_status", compensation_status),
        ("compensation_reason", compensation_reason),
        ("cautions", json!(cautions)),
        ("iterations", json!(known.map_or(0, |a| a.loaded.iterations))),
        ("residual", json!(known.map(|a| a.loaded.residual))),
        ("platform_mm", json!(balanced.map(|a| components(a.loaded.pose.translation)))),
        ("platform_rotvec_rad", json!(balanced.map(|a| components(rotation_log(&a.loaded.pose.rotation))))),
        ("platform_turn_rad", json!(balanced.map(|a| components(rotation_log(&rotation(a)))))),
        ("tool_displacement_mm", json!(balanced.and_then(tool_displacement).map(components))),
        (
            "tool_displacement_by_weight_mm",
            json!(known.and_then(|a| Some(components(*a.by_weight.as_ref()?.as_ref().ok()?)))),
        ),
        ("tool_play_mm", json!(balanced.and_then(|a| a.loaded.tool_play).map(components))),
        ("chain_wrench_N_Nmm", json!(balanced.map(wrenches))),
        ("compensated_rotvec_rad", json!(done.map(|c| components(rotation_log(&c.solution.pose.rotation))))),
        ("tip_error_after_compensation_mm", json!(tip_error.map(components))),
        ("tip_error_after_compensation_norm_mm", json!(tip_error.map(|tip_error| tip_error.norm()))),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_string(), value))
    .collect();
    let locked: Map<String, Value> =
        machine.locked_drives().into_iter().map(|(label, value, _)| (label, json!(value))).collect();
    if !locked.is_empty() {
        object.insert("locked".into(), locked.into());
    }
    object.append(&mut position_keys(machine, "rho_nominal", known.map(|a| a.nominal.drives.as_slice())));
    object.append(&mut position_keys(machine, "rho_compensated", done.map(|c| c.drives.as_slice())));
    object.append(&mut position_keys(machine, "delta_rho", known.and_then(PointResult::corrections).as_deref()));
    object.append(&mut force_keys(machine, "", balanced.map(|a| a.loaded.drive_forces())));
    object.append(&mut force_keys(machine, "compensated_", done.map(|c| c.solution.drive_forces())));
    object.into()
}

/// Returns a number as text with so many `decimals`, without a minus sign before zero.
fn decimal_text(value: f64, decimals: usize) -> String {
    let unit = 10f64.powi(decimals as i32);
    format!("{:.decimals$}", (value * unit).round() / unit + 0.0)
}

/// Returns a vector as text with components of so many `decimals`.
fn vector(v: Vector3<f64>, decimals: usize) -> String {
    let [x, y, z]: [String; 3] = v.map(|c| decimal_text(c, decimals)).into();
    format!("({x}, {y}, {z})")
}

/// Returns a line of the summary: the label `what` and its value.
fn line(what: &str, value: impl Display) -> String {
    format!("  {what:<25} {value}\n")
}

/// Returns the cautions about the question with P commanded to `commanded` (O, mm): subject and sentence.
fn question_cautions(question: &PointQuestion, commanded: Vector3<f64>) -> Vec<(&'static str, String)> {
    let machine = &question.machine;
    let outside = machine.outside_workspace(commanded).map(|outside| ("outside the workspace", outside.to_string()));
    let subject = if machine.carrier.is_some() { "workpiece" } else { "drives" };
    let sentences = [
        ("zero", cautions::zeroing(machine)),
        (subject, cautions::carrier(machine)),
        ("large error", cautions::large_errors(machine, &question.errors)),
    ];
    let lines = sentences.iter().flat_map(|(what, text)| text.lines().map(|sentence| (*what, sentence.to_string())));
    outside.into_iter().chain(lines).collect()
}

/// Returns a sentence for each drive that carries more than its limit, before or after compensation.
fn beyond_limits(answer: &PointResult) -> Vec<String> {
    let machine = &answer.question.machine;
    let (before, after) = (answer.loaded.drive_forces(), answer.compensated.as_ref().ok());
    let after = after.map(|after| after.solution.drive_forces());
    let drives = machine.drive_labels().into_iter().zip(machine.drives()).enumerate();
    let beyond = drives.filter_map(|(d, (label, (_, drive)))| {
        let limit = drive.force_limit?;
        let largest = after.iter().map(|after| after[d].abs()).fold(before[d].abs(), f64::max);
        let (word, unit) = (drive.motion.force_word(), drive.motion.shown_force_unit());
        (largest > limit)
            .then(|| format!("drive {label} is beyond its {word} limit: {largest:.1} {unit}, limit {limit:.1} {unit}"))
    });
    beyond.collect()
}

/// Returns the question and all results as lines of text.
fn details_text(answer: &PointResult) -> String {
    let (machine, loaded) = (&answer.question.machine, &answer.loaded);
    let wrench = answer.wrench;
    let mut text = format!("{}\n", machine.title);
    let commanded = answer.question.place.position().unwrap_or(answer.nominal.pose.translation);
    text += &line("commanded position of P", format!("{} mm", vector(commanded, 3)));
    text.extend(question_cautions(&answer.question, commanded).into_iter().map(|(what, said)| line(what, said)));
    let tool_axis = vector(answer.tool.rotation.column(2).into(), 3);
    let assumed = tool_axis_text(machine.tool_axis_source);
    text += &line("tool axis", format!("{tool_axis} in base axes, from the spindle to the tip{assumed}"));
    text += &line("singularity", conditioning_text(answer.conditioning));
    if let Some((branch, clearance)) = &answer.branch {
        text += &line("branch", format!("{branch}: {}", branch_margin_text(clearance)));
    }
    if let PointLoad::Milling(force, phi) | PointLoad::Cut(force, phi, _) = answer.question.load {
        let MillingForce { radial, tangential, axial, law } = force;
        // What a cutter gives has more digits than anyone reads.
        let [radial, tangential, axial] = [radial, tangential, axial].map(|force| (force * 1e3).round() / 1e3);
        let way = if axial < 0.0 { "(into the spindle)" } else { "(out of the spindle)" };
        let along = vector(force_on_tool(answer), 1);
        text += &line("tool angle", format!("{:.1}°", phi.to_degrees()));
        text += &line(
            "milling force",
            format!("radial {radial} N along φ, tangential {tangential} N along φ + 90°, axial {axial} N {way}"),
        );
        text += &line(&format!("eq. (17) {}", law.label()), format!("{along} N along x, y, z of the tool"));
    }
    let (force, moment) = (vector(wrench.force, 1), vector(wrench.moment, 0));
    text += &line("load at P", format!("force {force} N, moment {moment} N·mm"));
    let residual = loaded.residual.is_finite().then(|| format!(", residual {:.1e}", loaded.residual));
    let (status, iterations) = (loaded.status.label(), counted(loaded.iterations, "iteration"));
    text += &line("equilibrium", format!("{status}, {iterations}{}", residual.unwrap_or_default()));
    if loaded.status != Status::Solved {
        text += &line("reason", loaded.status.reason(machine));
    }
    if !loaded.status.is_equilibrium() {
        return text;
    }
    let moved_by = |shift: Vector3<f64>| format!("{:.4} mm = {} mm", shift.norm(), vector(shift, 4));
    let shift = answer.zero.as_ref().map(|zero| moved_by(machine.tool_displacement(zero, &loaded.pose)));
    text += &line("tool displacement", shift.unwrap_or_else(|failure| format!("unknown: {}", failure.reason)));
    text += &match &answer.by_weight {
        Some(Ok(sunk)) => line("by weight, of rigid model", moved_by(*sunk)),
        Some(Err(failure)) => line("by weight", format!("unknown: {}", failure.reason)),
        None => String::new(),
    };
    if let Some(play) = loaded.tool_play {
        text += &line("play at the tool", format!("±{} mm by backlash and friction of the drives", vector(play, 4)));
    }
    if let Ok(zero) = &answer.zero {
        let turn = vector(rotation_log(&(loaded.pose.rotation * zero.rotation.transpose())) * 1e3, 3);
        let what = if machine.tool_compliance.is_some() { "P, as the tool has it" } else { "platform displacement" };
        let shift = vector(loaded.pose.translation - zero.translation, 4);
        text += &line(what, format!("{shift} mm, rotation {turn} mrad"));
    }
    if let Some(principal) = answer.tool_stiffness {
        let shown = principal.map(|k| if k.is_finite() { format!("{k:.1}") } else { "rigid".into() });
        text += &line("tool stiffness", format!("{} N/mm (principal, of the tool tip)", shown.join(", ")));
    }
    text
}

/// Returns the main sentence: tool displacement and drive corrections, or why they are unknown.
fn main_sentence(answer: &PointResult) -> String {
    let machine = &answer.question.machine;
    let Some(moved) = tool_displacement(answer).filter(|_| answer.loaded.status.is_equilibrium()) else {
        return format!("How far the tool moves is unknown: {}.\n", answer.loaded.status.reason(machine));
    };
    let mut text = format!("The tool moves by {}", millimetres(moved.norm(), 4));
    let Some(change) = answer.corrections() else { return text + "; there is no correction.\n" };
    let shown = shown_positions(machine, &change);
    let drives = machine.drive_labels().into_iter().zip(machine.drives()).zip(&shown);
    let words: Vec<String> = drives
        .map(|((label, (_, drive)), value)| {
            let sign = if *value > 0.0 { "+" } else { "" };
            format!("{label} {sign}{}{}", decimal_text(*value, 4), drive.motion.position_suffix())
        })
        .collect();
    text += &with_minus_signs(&format!("; to keep the tool there, command {}.\n", words.join(", ")));
    text
}

/// Returns a summary for reading: main sentence, drives and details.
pub fn point_text(answer: &PointResult) -> String {
    let details = details_text(answer);
    match answer.loaded.status.is_equilibrium() {
        true => format!("{}\n{}\n{details}", main_sentence(answer), drive_table(answer)),
        false => format!("{}\n{details}", main_sentence(answer)),
    }
}

/// Returns a table of the drives: nominal and compensated positions, forces, internal force of their chains.
fn drive_table(answer: &PointResult) -> String {
    let machine = &answer.question.machine;
    let load = machine.drive_kinds().map(Motion::force_word).collect::<Vec<_>>().join(" or ");
    let [before, after] = ["before", "after"].map(|when| format!("{load} {when}"));
    let mut table = text_table(["drive", "nominal ρ", "compensated ρ", "Δρ", &before, &after, "internal"], 1);
    let nominal = shown_positions(machine, &answer.nominal.drives);
    let after = answer.compensated.as_ref().ok();
    let compensated = after.map(|after| shown_positions(machine, &after.drives));
    let change = answer.corrections().map(|change| shown_positions(machine, &change));
    let forces = answer.loaded.drive_forces();
    let forces_after = after.map(|after| after.solution.drive_forces());
    for (d, (label, (chain, drive))) in machine.drive_labels().into_iter().zip(machine.drives()).enumerate() {
        let optional = |value: Option<&Vec<f64>>, decimals: usize, unit: &str| {
            value.map_or_else(|| "–".into(), |v| format!("{}{unit}", decimal_text(v[d], decimals)))
        };
        let (unit, force_unit) = (drive.motion.position_suffix(), format!(" {}", drive.motion.shown_force_unit()));
        let internal = answer.loaded.chains[chain].internal_wrench;
        table.add_row([
            label,
            format!("{}{unit}", decimal_text(nominal[d], 4)),
            optional(compensated.as_ref(), 4, unit),
            optional(change.as_ref(), 4, unit),
            format!("{}{force_unit}", decimal_text(forces[d], 1)),
            optional(forces_after.as_ref(), 1, &force_unit),
            internal.map_or_else(|| "–".into(), |w| format!("{:.1} N", w.force.norm())),
        ]);
    }
    let mut text = format!("{table}\n");
    beyond_limits(answer).iter().for_each(|sentence| text += &format!("{sentence}\n"));
    if let Err(failure) = &answer.compensated {
        text += &format!("not compensated: {}\n", failure.reason);
    }
    text
}
