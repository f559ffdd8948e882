//! One location, for reading and for programs.

use nalgebra::{Matrix6, Vector3};
use serde_json::{Value, json};

use crate::{
    machine::Motion,
    report::{machine::tool_axis_words, table::shown_positions, words::counted},
    spatial::rotation_log,
    statics::Status,
    study::point::{PointAnswer, PointLoad, PointQuestion},
};

fn rows(matrix: &Matrix6<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn array(vector: Vector3<f64>) -> [f64; 3] {
    vector.into()
}

fn change(answer: &PointAnswer) -> Option<Vec<f64>> {
    let compensated = answer.compensated.as_ref().ok()?;
    Some(compensated.drives.iter().zip(&answer.nominal.drives).map(|(after, before)| after - before).collect())
}

fn tool_displacement(answer: &PointAnswer) -> Vector3<f64> {
    answer.question.machine.tool_displacement(&answer.nominal.pose, &answer.loaded.pose)
}

/// Force on the tool in axes of the tool frame T, N. That of milling is eq. (17) itself, without the rounding of its way
/// through O.
fn force_on_tool(answer: &PointAnswer) -> Vector3<f64> {
    match answer.question.load {
        PointLoad::Milling(force, phi) => force.force(phi),
        PointLoad::Wrench(_) => answer.tool.rotation.tr_mul(&answer.wrench.force),
    }
}

/// The object of [`point_json`] for a location that the machine cannot reach: every quantity is null.
pub fn unreachable_json(question: &PointQuestion, assembly_deg: &[f64]) -> Value {
    let null = |keys: &[&str]| keys.iter().map(|key| (key.to_string(), Value::Null)).collect::<serde_json::Map<_, _>>();
    let mut object = Value::Object(null(&[
        "phi_deg",
        "tool_axis",
        "force_tool_frame_N",
        "wrench_N_Nmm",
        "rho_nominal_mm",
        "platform_mm",
        "platform_rotvec_rad",
        "tool_displacement_mm",
        "actuator_force_N",
        "chain_wrench_N_Nmm",
        "stiffness_unloaded",
        "stiffness_loaded",
        "rho_compensated_mm",
        "delta_rho_mm",
        "compensated_rotvec_rad",
        "compensated_actuator_force_N",
        "residual",
    ]));
    object["position_mm"] = json!(array(question.position));
    object["assembly_deg"] = json!(assembly_deg);
    object["status"] = json!("unreachable");
    object["iterations"] = json!(0);
    object
}

/// One object with the keys of `tests/reference/orthoglide.json` and `status`, `iterations`, `residual`; `tool_axis`, the
/// direction from the spindle to the tool tip in O axes, and `force_tool_frame_N`, the force in axes of the tool frame.
///
/// `assembly_deg` is passed through. Keys whose quantity does not exist in this outcome are null.
pub fn point_json(answer: &PointAnswer, assembly_deg: &[f64]) -> Value {
    let (machine, loaded) = (&answer.question.machine, &answer.loaded);
    let phi_deg = match answer.question.load {
        PointLoad::Milling(_, phi) => Some((phi.to_degrees() * 1e9).round() / 1e9),
        PointLoad::Wrench(_) => None,
    };
    let mut object = json!({
        "position_mm": array(answer.question.position),
        "phi_deg": phi_deg,
        "assembly_deg": assembly_deg,
        "tool_axis": array(answer.tool.rotation.column(2).into()),
        "force_tool_frame_N": array(force_on_tool(answer)),
        "wrench_N_Nmm": answer.wrench.to_array(),
        "rho_nominal_mm": shown_positions(machine, &answer.nominal.drives),
        "platform_mm": null, "platform_rotvec_rad": null, "tool_displacement_mm": null, "actuator_force_N": null,
        "chain_wrench_N_Nmm": null,
        "stiffness_unloaded": answer.stiffness_unloaded.as_ref().map(rows),
        "stiffness_loaded": loaded.stiffness.as_ref().map(rows),
        "rho_compensated_mm": null, "delta_rho_mm": null, "compensated_rotvec_rad": null,
        "compensated_actuator_force_N": null,
        "status": loaded.status.label(),
        "iterations": loaded.iterations,
        "residual": loaded.residual,
    });
    if !matches!(loaded.status, Status::NotConverged { .. }) {
        object["platform_mm"] = json!(array(loaded.pose.translation));
        object["platform_rotvec_rad"] = json!(array(rotation_log(&loaded.pose.rotation)));
        object["tool_displacement_mm"] = json!(array(tool_displacement(answer)));
        object["actuator_force_N"] = json!(loaded.drive_forces());
        let wrenches: Vec<[f64; 6]> = loaded.chains.iter().map(|chain| chain.wrench.to_array()).collect();
        object["chain_wrench_N_Nmm"] = json!(wrenches);
    }
    if let (Ok(compensated), Some(change)) = (&answer.compensated, change(answer)) {
        object["rho_compensated_mm"] = json!(shown_positions(machine, &compensated.drives));
        object["delta_rho_mm"] = json!(shown_positions(machine, &change));
        object["compensated_rotvec_rad"] = json!(array(rotation_log(&compensated.solution.pose.rotation)));
        object["compensated_actuator_force_N"] = json!(compensated.solution.drive_forces());
    }
    object
}

/// Rounded components, without a minus sign before zero.
fn triple(v: Vector3<f64>, decimals: usize) -> String {
    let unit = 10f64.powi(decimals as i32);
    let [x, y, z]: [f64; 3] = v.map(|c| (c * unit).round() / unit + 0.0).into();
    format!("({x:.decimals$}, {y:.decimals$}, {z:.decimals$})")
}

/// A summary for reading.
pub fn point_text(answer: &PointAnswer) -> String {
    let (machine, loaded) = (&answer.question.machine, &answer.loaded);
    let wrench = answer.wrench;
    let mut text = format!("{}\n", machine.title);
    text += &format!("  commanded position of P   {} mm\n", triple(answer.question.position, 3));
    text += &format!(
        "  tool axis                 {} in base axes, from the spindle to the tip{}\n",
        triple(answer.tool.rotation.column(2).into(), 3),
        tool_axis_words(machine.tool_axis_source)
    );
    if let PointLoad::Milling(force, phi) = answer.question.load {
        text += &format!("  tool angle                {:.1} deg\n", phi.to_degrees());
        text += &format!(
            "  milling force             radial {} N along φ, tangential {} N along φ + 90°, axial {} N {}\n",
            force.radial,
            force.tangential,
            force.axial,
            if force.axial < 0.0 { "(into the spindle)" } else { "(out of the spindle)" }
        );
        text += &format!(
            "  eq. (17) {:<16} {} N along x, y, z of the tool\n",
            force.law.label(),
            triple(force_on_tool(answer), 1)
        );
    }
    text += &format!(
        "  load at P                 force {} N, moment {} N·mm\n",
        triple(wrench.force, 1),
        triple(wrench.moment, 0)
    );
    text +=
        &format!("  equilibrium               {}, {}", loaded.status.label(), counted(loaded.iterations, "iteration"));
    if loaded.residual.is_finite() {
        text += &format!(", residual {:.1e}", loaded.residual);
    }
    text.push('\n');
    if loaded.status != Status::Solved {
        text += &format!("  reason                    {}\n", loaded.status.reason(machine));
    }
    if matches!(loaded.status, Status::NotConverged { .. }) {
        return text;
    }
    let displacement = tool_displacement(answer);
    let turn = rotation_log(&(loaded.pose.rotation * answer.nominal.pose.rotation.transpose()));
    text += &format!("  tool displacement         {:.4} mm = {} mm\n", displacement.norm(), triple(displacement, 4));
    text += &format!(
        "  platform displacement     {} mm, rotation {} mrad\n",
        triple(loaded.pose.translation - answer.nominal.pose.translation, 4),
        triple(turn * 1e3, 3)
    );
    if let Some(stability) = loaded.stability {
        text += &format!("  softest direction         {stability:.1} N/mm (rotations at {:.0} mm)\n", machine.reach);
    }
    text + &drive_table(answer)
}

/// Drives: nominal and compensated commands, forces, internal wrench of their chains.
fn drive_table(answer: &PointAnswer) -> String {
    let machine = &answer.question.machine;
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["drive", "ρ nominal", "ρ compensated", "Δρ", "force before", "force after", "internal force"]);
    let nominal = shown_positions(machine, &answer.nominal.drives);
    let after = answer.compensated.as_ref().ok();
    let compensated = after.map(|after| shown_positions(machine, &after.drives));
    let change = change(answer).map(|change| shown_positions(machine, &change));
    let forces = answer.loaded.drive_forces();
    let forces_after = after.map(|after| after.solution.drive_forces());
    for (d, (label, (chain, drive))) in machine.drive_labels().into_iter().zip(machine.drives()).enumerate() {
        let (unit, force_unit) = match drive.motion {
            Motion::Prismatic => ("mm", "N"),
            Motion::Revolute => ("deg", "N·mm"),
        };
        let optional = |value: Option<&Vec<f64>>, decimals: usize, unit: &str| {
            value.map_or_else(|| "–".into(), |v| format!("{:.decimals$} {unit}", v[d]))
        };
        let internal = answer.loaded.chains[chain].internal_wrench;
        table.add_row([
            label,
            format!("{:.4} {unit}", nominal[d]),
            optional(compensated.as_ref(), 4, unit),
            optional(change.as_ref(), 4, unit),
            format!("{:.1} {force_unit}", forces[d]),
            optional(forces_after.as_ref(), 1, force_unit),
            internal.map_or_else(|| "–".into(), |w| format!("{:.1} N", w.force.norm())),
        ]);
    }
    let mut text = format!("{table}\n");
    for (d, (label, (_, drive))) in machine.drive_labels().into_iter().zip(machine.drives()).enumerate() {
        let largest = forces_after.iter().map(|after| after[d].abs()).fold(forces[d].abs(), f64::max);
        if let Some(limit) = drive.force_limit.filter(|limit| largest > *limit) {
            text += &format!("drive {label} is beyond its force limit: {largest:.1}, limit {limit:.1}\n");
        }
    }
    if let Err(reason) = &answer.compensated {
        text += &format!("not compensated: {reason}\n");
    }
    text
}
