//! How the written program is used: what it is, how it is loaded, what must be off, and what a dry run shows.

use super::Proved;
use crate::{
    files::words::millimetres,
    process::PathReference,
    products::program::ProgramJob,
    simulation::{ProgramFile, ROUNDING_MM, Source},
    toolpath::robot::Language,
};

/// Rotation that is worth a word, rad.
const LEAST_TURN: f64 = 1e-6;

/// A sentence a line.
pub fn use_text(job: &ProgramJob, proved: &Proved<'_>) -> String {
    let name = proved.name;
    let point = match job.process.placement.reference {
        PathReference::ToolTip => "the tool tip",
        PathReference::PlatformPoint => "the platform point P",
    };
    let mut text = match (job.process.tool_turn.is_sought(), job.turns_tool()) {
        (false, false) => format!(
            "The program commands {point} in the frame of {name}. Positions of moves are changed, all else is as in {name}: \
             orientation, feed, spindle, tool.\n"
        ),
        (false, true) => format!(
            "The program commands {point} in the frame of {name} and how the tool stands. Positions and orientations of moves are \
             changed, all else is as in {name}: feed, spindle, tool.\n"
        ),
        (true, _) => format!(
            "The program commands {point} in the frame of {name}. It is turned about the tool's axis: positions and orientations of \
             moves are changed, and there are more of them; lines above are those of the turned program. Feed, spindle and tool are as in \
             {name}.\n"
        ),
    };
    let turned = proved.passes.last().and_then(|written| written.summary.max_leftover_rotation);
    if let Some(turned) = turned.filter(|angle| *angle > LEAST_TURN) {
        text += &format!("What bends also turns the tool, by up to {:.3}°, and that is left.\n", turned.to_degrees());
    }
    if proved.outside.any() {
        let machine = job.machine.short_title();
        return text
            + &format!(
                "Do not load it: the {machine} cannot run it as placed. Place the workpiece inside its workspace box, and compute again.\n"
            );
    }
    text + &loaded(job, name) + &switched_off(job) + &dry_run(proved)
}

/// How it is loaded, and what has to be the same there.
fn loaded(job: &ProgramJob, name: &str) -> String {
    let ProgramFile::Robot(program) = &job.file else {
        return format!("Load it in place of {name}, with the same work offset and the same tool length.\n");
    };
    match program.language() {
        Language::Krl => format!(
            "Load it in place of {name}, with the same $BASE and $TOOL (or the same numbers of base and tool), under the name in its \
             DEF line, and with the .dat of {name} beside it if there is one. Old controllers take some thousand lines at most.\n"
        ),
        Language::Rapid => format!(
            "Load it in place of {name} (the module keeps its name), with the same work objects and tools. Lines that were added have \
             the configuration of the target they lead up to: where the arm changes it along a motion, put ConfL\\Off before.\n"
        ),
        Language::Apt => {
            format!("Post-process it in place of {name}, with the same machine, origin and tool length.\n")
        }
    }
}

/// What else in the control would correct the same once more.
fn switched_off(job: &ProgramJob) -> String {
    let mut off = vec!["corrections for deflection"];
    if Source::parts(&job.machine).contains(&Source::Weight) {
        off.push("for sag under weight");
    }
    if job.process.errors.iter().any(|errors| !errors.is_none()) {
        off.push("for the chain errors of the process (kinematic or volumetric error tables that were off when these were measured)");
    }
    format!("Switch off in the control what would correct the same twice: {}.\n", off.join(", "))
}

/// How far from the drawn path the tool is to be where nothing is cut.
fn dry_run(proved: &Proved<'_>) -> String {
    let largest = proved.findings.most_by_cutting_mm;
    match largest > ROUNDING_MM {
        true => format!(
            "Try it above the part with nothing to cut: the tool is then beside the drawn path by up to {}, since it is sent \
             against a cutting force that is not there. It springs there too wherever the feed stops in the cut: lead it out of the part before.\n",
            millimetres(largest, 3)
        ),
        false => "Try it above the part: with no cutting force in the process, the tool then follows the drawn path.\n"
            .into(),
    }
}
