//! Notes on a program (assumptions, unchanged lines), and how to load it, which compensations of the control to switch off, what a dry run
//! shows.

use super::Report;
use crate::{
    files::words::{counted, join_text, millimetres},
    machine::Machine,
    process::PathReference,
    products::program::{ProgramJob, WrittenCalls},
    simulation::{ROUNDING_MM, Source},
    toolpath::{
        ProgramFile,
        gcode::{Dialect, Notes},
        robot::{Language, RobotProgram},
    },
};

/// Most lines of which it is said how the control turns the tool.
const MAX_CHOSEN: usize = 6;
/// Smallest residual rotation that is mentioned, rad.
const LEAST_TURN: f64 = 1e-6;

/// Returns how to use the compensated program: one sentence per line.
pub fn use_text(report: &Report<'_>) -> String {
    let name = report.name;
    let point = match report.job.process.placement.reference {
        PathReference::ToolTip => "the tool tip",
        PathReference::PlatformPoint => "the platform point P",
    };
    let (fed, feed) = if report.job.feed.is_some() { (" and feeds", "") } else { ("", " feed,") };
    let rest = match (report.job.process.redundancy.is_sought(), report.job.is_full_pose()) {
        (false, false) => {
            format!(
                ". Positions{fed} of moves are changed, all else is as in {name}: orientation,{feed} spindle, tool.\n"
            )
        }
        (false, true) => format!(
            " and how the tool stands. Positions{fed} and orientations of moves are changed, all else is as in {name}:{feed} spindle, tool.\n"
        ),
        (true, _) => format!(
            ". The tool is rotated about its axis: positions and orientations of moves are changed, and there are more of them; lines above \
             are those of the rotated program. Feed, spindle and tool are as in {name}.\n"
        ),
    };
    let mut text = format!("The program commands {point} in the frame of {name}{rest}");
    let turned = report.verified.passes.last().and_then(|written| written.summary.max_residual_rotation);
    if let Some(turned) = turned.filter(|angle| *angle > LEAST_TURN) {
        text += &format!(
            "Deflection also rotates the tool, by up to {:.3}°; the written program does not compensate this rotation.\n",
            turned.to_degrees()
        );
    }
    if report.findings.outside.outside() > 0 {
        let machine = &report.job.machine.name;
        text += &format!(
            "Do not load the program: {machine} cannot run it as placed. Place the workpiece inside its workspace box, and compute again.\n"
        );
        return text;
    }
    text + &loading_text(report.job, name) + &switch_off_text(report) + &dry_run_text(report)
}

/// Returns how to load the program, and what must be the same on the control.
fn loading_text(job: &ProgramJob, name: &str) -> String {
    let ProgramFile::Robot(program) = &job.file else {
        return format!("Load the program in place of {name}, with the same work offset and the same tool length.\n");
    };
    match program.language() {
        Language::Krl => format!(
            "Load the program in place of {name}, with the same $BASE and $TOOL (or the same numbers of base and tool), under the name in its \
             DEF line, and with the .dat of {name} beside it if there is one. Old controllers take some thousand lines at most.\n"
        ),
        Language::Rapid => format!(
            "Load the program in place of {name} (the module keeps its name), with the same work objects and tools. Lines that were added have \
             the configuration of the target they lead up to: where the arm changes it along a motion, put ConfL\\Off before.\n"
        ),
        Language::Ls => format!(
            "Load the program in place of {name}, under the name behind /PROG, with the same user frame and tool. Positions that were added have \
             the CONFIG of the one they lead up to.\n"
        ),
        Language::UrScript => {
            format!(
                "Run the program in place of {name}, with the same installation: its TCP, its payload and its features.\n"
            )
        }
        Language::Apt => {
            format!("Post-process the program in place of {name}, with the same machine, origin and tool length.\n")
        }
    }
}

/// Returns which compensations of the control to switch off, as they would correct the same error twice.
fn switch_off_text(report: &Report<'_>) -> String {
    let job = report.job;
    let mut off = vec!["corrections for deflection"];
    if Source::parts(&job.machine).contains(&Source::Weight) {
        off.push("for sag under weight");
    }
    if job.process.errors.iter().any(|errors| !errors.is_none()) {
        off.push("for the chain errors of the process (kinematic or volumetric error tables, if they were off when the errors were measured)");
    }
    if report.verified.takes_play_back && job.machine.drives().any(|(_, drive)| drive.half_backlash > 0.0) {
        off.push("for backlash of the drives");
    }
    format!("Switch off in the control what would correct the same twice: {}.\n", off.join(", "))
}

/// Returns how far from its path the tool is in a dry run without cutting.
fn dry_run_text(report: &Report<'_>) -> String {
    let largest = report.findings.most_by_cutting_mm;
    match largest > ROUNDING_MM {
        true => format!(
            "Try the program above the part with nothing to cut: the tool is then beside the drawn path by up to {}, since its commands \
             work against a cutting force that is absent. The tool springs there too where the feed stops in the cut: retract the tool before.\n",
            millimetres(largest, 3)
        ),
        false => "Try the program above the part: with no cutting force in the process, the tool then follows the drawn path.\n"
            .into(),
    }
}

/// Most lines that are named; of more, only the number is given.
const NAMED: usize = 8;

/// Returns notes on what was assumed about the program and which lines stay unchanged, in sentences; empty for a polyline.
pub fn notes_text(job: &ProgramJob, calls: &WrittenCalls) -> String {
    match &job.file {
        ProgramFile::Gcode(program) => gcode_notes(program.notes(), calls),
        ProgramFile::Robot(program) => robot_notes(program, calls) + &posture_notes(program, &job.machine),
        ProgramFile::Polyline(_) => String::new(),
    }
}

/// Returns the notes on a G-code program: dialect, unit, calls, unchanged lines.
fn gcode_notes(notes: &Notes, calls: &WrittenCalls) -> String {
    let mut text = String::new();
    if notes.dialect != Dialect::Iso {
        text += &format!("Read as a {} program, and written as one.\n", notes.dialect.name());
    }
    if let Some((unit, line)) = notes.assumed_unit {
        text += &format!(
            "The program names no unit before line {line}: {} is taken; {} or unit in [gcode] says which it is.\n",
            unit.name(),
            if notes.dialect == Dialect::Sinumerik { "G700, G710" } else { "G20, G21" }
        );
    }
    if let Some([lines, written]) = notes.written_out {
        text += &calls_text(calls, lines, written);
    }
    if !notes.cutter_radii_mm.is_empty() {
        let radii = notes.cutter_radii_mm.iter().map(|(of, radius)| format!("{of} = {}", millimetres(*radius, 3)));
        text += &format!(
            "Cutter radius compensation is off in the written program: the lines are the path of the tool centre, for radii of {}. A radius or \
             wear in the control's table no longer moves it; lengths (H) and work offsets act as before.\n",
            radii.collect::<Vec<_>>().join(", ")
        );
    }
    if !notes.chosen_angles.is_empty() {
        let shown = notes.chosen_angles.iter().take(MAX_CHOSEN).map(|(line, angles)| {
            let named = ["A", "B", "C"].into_iter().zip(angles).filter(|(_, angle)| **angle != 0.0);
            let named: Vec<String> = named.map(|(letter, angle)| format!("{letter}{:.3}", angle)).collect();
            format!("in line {line} to {}", if named.is_empty() { "0".into() } else { named.join(" ") })
        });
        let more = if notes.chosen_angles.len() > MAX_CHOSEN { ", and so on" } else { "" };
        text += &format!(
            "The control chooses how the rotary axes stand in inclined planes; by its rule {}{more}. See that it does: the machine bends otherwise \
             at other angles.\n",
            shown.collect::<Vec<_>>().join(", ")
        );
    }
    if !notes.turned_alone_lines.is_empty() {
        let lines = motion_lines(&notes.turned_alone_lines);
        text += &match notes.dialect {
            Dialect::Haas => format!(
                "How fast rotary axes move alone is not known: {lines}. To Haas F is the feed at the diameter of settings 34 and 79, which the program does not say, and X, Y and Z move as well where they are corrected; G93 is without doubt.\n"
            ),
            dialect => format!(
                "F is taken as degrees a minute where rotary axes move alone: {lines}{}.\n",
                match dialect {
                    Dialect::Iso =>
                        "; so Fanuc and LinuxCNC read it, while Haas takes it as the feed at the diameter of settings 34 and 79. The corrected lines move X, Y and Z as well, and are written in inverse time (G93), which all read alike",
                    Dialect::LinuxCnc =>
                        ". The corrected lines move X, Y and Z as well, and are written in inverse time (G93)",
                    Dialect::Sinumerik => ", unless FGREF or FGROUP says otherwise",
                    Dialect::Heidenhain =>
                        ", unless M116 is on. The corrected lines move X, Y and Z as well: see how fast the control drives them",
                    Dialect::Fanuc | Dialect::Haas => "",
                }
            ),
        };
    }
    if !notes.unlocated_lines.is_empty() {
        text += &format!(
            "Left as written: {}, where the position of the tool in X, Y and Z is not known; start_mm in [gcode] says where the \
             program begins.\n",
            motion_lines(&notes.unlocated_lines)
        );
    }
    text
}

/// Returns what became of the calls of a program of so many `lines`, or of `written` lines if it is written out.
fn calls_text(calls: &WrittenCalls, lines: usize, written: usize) -> String {
    let grown = format!("Written out: {written} lines for the {lines} of the program");
    match calls {
        WrittenCalls::None => format!("{grown}.\n"),
        WrittenCalls::WrittenOut { because } => format!("{grown}; {because}.\n"),
        WrittenCalls::Stay { beside, .. } => {
            let names: Vec<&str> = beside.iter().map(|file| file.name.as_str()).collect();
            let with = match names[..] {
                [] => String::new(),
                _ => format!(" The program calls {} beside the file.", join_text(&names)),
            };
            format!(
                "What the program calls and computes stays: no line needs other corrections each time that it runs.{with}\n"
            )
        }
    }
}

/// Returns the notes on a robot or APT program: language, unchanged lines, named points.
fn robot_notes(program: &RobotProgram, calls: &WrittenCalls) -> String {
    let (notes, mut text) = (program.notes(), String::new());
    if let Some(tool) = &notes.assumed_tool {
        text += &format!(
            "The orientation of the tool is assumed: the program does not give the frame of {tool}, and tool_rotation_deg in [robot_program] \
             is not given, so that it is taken as the flange has it. Every pose of the tool depends on it: give tool_rotation_deg.\n"
        );
    }
    if !notes.uncalled.is_empty() {
        let names: Vec<&str> = notes.uncalled.iter().map(String::as_str).collect();
        text += &format!(
            "Not called from main, so that their motions stay as they are: {}. Run by themselves, they are not corrected.\n",
            join_text(&names)
        );
    }
    text += &format!("Read as a program in {}.\n", program.language().name());
    if let Some([lines, written]) = notes.written_out {
        text += &calls_text(calls, lines, written);
    }
    if !notes.unlocated_lines.is_empty() {
        text += &format!(
            "Left as written: {}, where the position of the tool is not known: motions to positions of joints, or without a full pose \
             behind one.\n",
            motion_lines(&notes.unlocated_lines)
        );
    }
    if !notes.spline_lines.is_empty() {
        text += &format!(
            "Corrected at their points alone, as segments of splines (SPL): {}. How the controller leads the tool between them is not verified: \
             forces, and what is cut, are those of straight lines from point to point, and the curve moves with its points.\n",
            motion_lines(&notes.spline_lines)
        );
    }
    if notes.lines_in_splines {
        text += "Where a SLIN or SCIRC within SPLINE has become several, the controller stops at the corners between them, however flat they are; \
                 a larger write_tolerance_mm keeps it whole.\n";
    }
    if notes.named_points && program.language() != Language::Ls {
        text += "Points stay as they are declared; a motion to one of them that is corrected has numbers in place of its name.\n";
    }
    text
}

/// Returns what is said of the posture of the arm, and where it is left open.
fn posture_notes(program: &RobotProgram, machine: &Machine) -> String {
    let (notes, mut text) = (program.notes(), String::new());
    if machine.arm_angles(&machine.home).is_none() {
        return text;
    }
    if notes.configured_line.is_some() && !program.says_postures() {
        return "How the arm stands is not taken from the program (ignore_configuration of [robot_program]): its data stay as they are.\n".into();
    }
    if !notes.open_posture_lines.is_empty() {
        text += &format!(
            "Which posture the arm takes is left open by the program at {}: it is simulated as it goes on from the point before, the first from \
             home. See that the robot does the same.\n",
            motion_lines(&notes.open_posture_lines)
        );
    }
    if notes.leaves_paths_open {
        text += "On paths, the data of the posture do not act (ConfL\\Off, Wjnt, qnear of movel): the arm goes on as it comes.\n";
    }
    text
}

/// Returns the number of motions on `lines` and the first of these line numbers, in words.
fn motion_lines(lines: &[usize]) -> String {
    let mut names: Vec<String> = lines.iter().take(NAMED).map(usize::to_string).collect();
    if lines.len() > NAMED {
        names.push(format!("{} more", lines.len() - NAMED));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let word = if lines.len() == 1 { "line" } else { "lines" };
    format!("{}, {word} {}", counted(lines.len(), "motion"), join_text(&names))
}
