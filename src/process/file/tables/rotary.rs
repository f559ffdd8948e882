//! The rotary axes A, B and C of programs: from `[[gcode.rotary]]` and from the machine's drives of these names.

use nalgebra::Vector3;

use crate::{
    compensation::Target,
    input::{check::Check, error::Result},
    machine::{Coordinate, Machine, RotaryDrive},
    process::{
        PathReference, Placement,
        file::spec::{GcodeSpec, RotarySpec, RotaryTip},
    },
    toolpath::gcode::{Rotary, RotaryAxis, RotaryColumn, RotarySide},
};

/// The list `rotary`.
pub(crate) type RotaryList = Vec<RotarySpec>;

/// Directions nearer to each other are the same, rad, and axes that pass each other nearer, mm: files have so many digits.
const SAME_DIRECTION: f64 = 1e-5;
const SAME_PLACE_MM: f64 = 1e-3;

/// Returns the rotary axes of programs, and the path columns of those that are drives; fails if given axes contradict the drives.
pub(crate) fn rotary(
    spec: &GcodeSpec,
    machine: &Machine,
    placement: &Placement,
    target: Target,
    check: &Check,
) -> Result<(Rotary, Vec<RotaryColumn>)> {
    let mut given = given_axes(spec, check)?;
    let (mut axes, mut columns, mut led) = (Vec::new(), Vec::new(), Vec::new());
    let is_turned =
        target == Target::FullPose && machine.controls.iter().any(|own| matches!(own, Coordinate::Rotation(_)));
    let drives = machine_axes(machine, placement);
    check_order(&given, &drives, machine, check)?;
    check_letters(&given, &drives, machine, check)?;
    for (drive, axis) in drives {
        let (letter, column) = (axis.letter, format!("external_{}_deg", drive.label));
        // Where the orientation is corrected as well, the drives of a head serve the task near where the program leads them.
        if is_turned && !drive.carries {
            if let Some((index, given)) = given.iter().find(|(_, given)| given.letter == letter) {
                check_matches_drive(given, &axis, &drive, machine, &check.key("rotary").item(*index))?;
                led.push(RotaryColumn { letter, column, is_given: true, is_led: true });
            }
            continue;
        }
        let is_given = match given.iter().position(|(_, given)| given.letter == axis.letter) {
            Some(at) => {
                let (index, given) = given.remove(at);
                check_matches_drive(&given, &axis, &drive, machine, &check.key("rotary").item(index))?;
                true
            }
            None => false,
        };
        columns.push(RotaryColumn { letter, column, is_given, is_led: false });
        axes.push(axis);
    }
    axes.extend(given.into_iter().map(|(_, axis)| axis));
    columns.append(&mut led);
    Ok((Rotary { axes, always_of_tip: spec.rotary_tip == RotaryTip::Always }, columns))
}

/// Checks the axes given in the file; returns them with their indices in its list.
fn given_axes(spec: &GcodeSpec, check: &Check) -> Result<Vec<(usize, RotaryAxis)>> {
    let mut axes: Vec<(usize, RotaryAxis)> = Vec::new();
    for (index, given) in spec.rotary.iter().enumerate() {
        let check = check.key("rotary").item(index);
        if !['A', 'B', 'C'].contains(&given.letter) || axes.iter().any(|(_, axis)| axis.letter == given.letter) {
            return check.key("letter").fail(format!("\"{}\": expected A, B or C, each once", given.letter));
        }
        let about = check.key("about").finite(given.about)?;
        let Some(about) = about.try_normalize(1e-9) else {
            return check.key("about").fail("has no length: expected a direction".into());
        };
        let through_mm = given.through_mm.map(|point| check.key("through_mm").finite(point)).transpose()?;
        let travel_deg = check.key("travel_deg").interval(given.travel_deg, 1.0)?.map(<[f64; 2]>::from);
        axes.push((index, RotaryAxis { letter: given.letter, about, turns: given.turns, through_mm, travel_deg }));
    }
    Ok(axes)
}

/// Returns the machine's drives A, B and C with their axes in W; points of a head's axes are relative to the point that the path gives.
fn machine_axes(machine: &Machine, placement: &Placement) -> Vec<(RotaryDrive, RotaryAxis)> {
    let rotary = machine.rotary_drives();
    let workpiece = rotary.carrier.compose(&placement.pose());
    let reference_point = match placement.reference {
        PathReference::ToolTip => rotary.platform.transform(machine.tool_tip),
        PathReference::PlatformPoint => rotary.platform.translation,
    };
    let drives = rotary.drives.into_iter().map(|drive| {
        let about = workpiece.rotation.tr_mul(&drive.about);
        let through = match drive.carries {
            true => workpiece.inverse().transform(drive.through),
            false => workpiece.rotation.tr_mul(&(drive.through - reference_point)),
        };
        let turns = if drive.carries { RotarySide::Workpiece } else { RotarySide::Tool };
        let (letter, travel_deg) = (drive.letter, drive.travel_deg);
        let axis = RotaryAxis { letter, about, turns, through_mm: Some(through), travel_deg };
        (drive, axis)
    });
    drives.collect()
}

/// Checks that each letter names one drive, and that, if any axis is a drive of the machine, all given axes are.
fn check_letters(
    given: &[(usize, RotaryAxis)],
    drives: &[(RotaryDrive, RotaryAxis)],
    machine: &Machine,
    check: &Check,
) -> Result<()> {
    for (k, (drive, axis)) in drives.iter().enumerate() {
        if let Some((other, _)) = drives[..k].iter().find(|(_, other)| other.letter == axis.letter) {
            return check.key("rotary").fail(format!(
                "drives {} and {} of machine {} are both called {}: expected one of them with another name, so that a program tells one",
                other.label, drive.label, machine.name, axis.letter
            ));
        }
    }
    let other = given.iter().find(|(_, given)| drives.iter().all(|(_, axis)| axis.letter != given.letter));
    match other.filter(|_| !drives.is_empty()) {
        None => Ok(()),
        Some((index, given)) => {
            let labels: Vec<&str> = drives.iter().map(|(drive, _)| drive.label.as_str()).collect();
            check.key("rotary").item(*index).key("letter").fail(format!(
                "{} is no drive of machine {}, and {} are: expected all rotary axes among its drives, or none",
                given.letter,
                machine.name,
                labels.join(", ")
            ))
        }
    }
}

/// Checks that the given axes of tool and of workpiece, each with its index in the file, are in the order of the machine's drives.
fn check_order(
    given: &[(usize, RotaryAxis)],
    drives: &[(RotaryDrive, RotaryAxis)],
    machine: &Machine,
    check: &Check,
) -> Result<()> {
    let position = |letter: char| given.iter().position(|(_, axis)| axis.letter == letter);
    for (k, (_, outer)) in drives.iter().enumerate() {
        for (_, inner) in drives[..k].iter().filter(|(_, inner)| inner.turns == outer.turns) {
            if let (Some(inner_at), Some(outer_at)) = (position(inner.letter), position(outer.letter))
                && inner_at > outer_at
            {
                return check.key("rotary").item(given[outer_at].0).key("letter").fail(format!(
                    "{} before {}: in machine {} drive {} carries drive {}; expected the axes from the machine's base outwards",
                    outer.letter, inner.letter, machine.name, inner.letter, outer.letter
                ));
            }
        }
    }
    Ok(())
}

/// Checks that a given axis has side, direction and line of `of_drive`, the axis of the machine's `drive` of the same letter.
fn check_matches_drive(
    given: &RotaryAxis,
    of_drive: &RotaryAxis,
    drive: &RotaryDrive,
    machine: &Machine,
    check: &Check,
) -> Result<()> {
    let (name, label) = (&machine.name, &drive.label);
    if given.turns != of_drive.turns {
        let what = if drive.carries { "workpiece" } else { "tool" };
        let problem = format!("drive {label} of machine {name} turns the {what}: expected \"{what}\"");
        return check.key("turns").fail(problem);
    }
    let shown = |v: Vector3<f64>| v.map(|x| (x * 1e6).round() / 1e6 + 0.0);
    if (given.about - of_drive.about).norm() > SAME_DIRECTION {
        let [x, y, z]: [f64; 3] = shown(of_drive.about).into();
        let problem =
            format!("drive {label} of machine {name} turns about ({x}, {y}, {z}) of W: expected that direction");
        return check.key("about").fail(problem);
    }
    let Some((through, at)) = given.through_mm.zip(of_drive.through_mm) else { return Ok(()) };
    let beside = (through - at).cross(&of_drive.about).norm();
    if beside > SAME_PLACE_MM {
        let nearest = at + of_drive.about * of_drive.about.dot(&(through - at));
        let [x, y, z]: [f64; 3] = shown(nearest).into();
        let from = if drive.carries { "in W" } else { "from the tip of the tool" };
        let problem = format!(
            "lies {beside:.3} mm beside the axis of drive {label} of machine {name}, which passes ({x}, {y}, {z}) mm {from}: expected a point \
             of that axis, or none"
        );
        return check.key("through_mm").fail(problem);
    }
    Ok(())
}
