//! What must be known of a program: what was taken for granted, and which lines stay as they are.

use crate::{
    files::words::{counted, listed},
    products::program::{ProgramJob, WrittenCalls},
    simulation::ProgramFile,
    toolpath::{
        gcode::{Dialect, Notes},
        robot::RobotProgram,
    },
};

/// Lines that are named; of more, only the number is said.
const NAMED: usize = 8;

/// What of the program nobody may have meant, in sentences; nothing for a polyline.
pub fn notes_text(job: &ProgramJob, calls: &WrittenCalls) -> String {
    match &job.file {
        ProgramFile::Gcode(program) => text(program.notes(), calls),
        ProgramFile::Robot(program) => of_robot(program),
        ProgramFile::Polyline(_) => String::new(),
    }
}

fn text(notes: &Notes, calls: &WrittenCalls) -> String {
    let mut text = String::new();
    if notes.dialect != Dialect::Iso {
        text += &format!("Read as a {} program, and written as one.\n", notes.dialect.name());
    }
    if let Some((unit, line)) = notes.unit_taken {
        text += &format!(
            "The program names no unit before line {line}: {} is taken; {} or unit in [gcode] says which it is.\n",
            unit.name(),
            if notes.dialect == Dialect::Sinumerik { "G700, G710" } else { "G20, G21" }
        );
    }
    if let Some([lines, written]) = notes.written_out {
        text += &calls_text(calls, lines, written);
    }
    if !notes.not_located.is_empty() {
        text += &format!(
            "Left as written: {}, where it is not known in X, Y and Z where the tool is; start_mm in [gcode] says where the program \
             begins.\n",
            motions(&notes.not_located)
        );
    }
    text
}

/// What became of the calls of a program of so many `lines`, or `written` ones if it is written out.
fn calls_text(calls: &WrittenCalls, lines: usize, written: usize) -> String {
    let grown = format!("Written out: {written} lines for the {lines} of the program");
    match calls {
        WrittenCalls::None => format!("{grown}.\n"),
        WrittenCalls::WrittenOut { because } => format!("{grown}; {because}.\n"),
        WrittenCalls::Stay { beside, .. } => {
            let names: Vec<&str> = beside.iter().map(|file| file.name.as_str()).collect();
            let with = match names[..] {
                [] => String::new(),
                _ => format!(" It calls {} beside it.", listed(&names)),
            };
            format!(
                "What the program calls and computes stays: no line needs other corrections each time that it runs.{with}\n"
            )
        }
    }
}

fn of_robot(program: &RobotProgram) -> String {
    let (notes, mut text) = (program.notes(), format!("Read as a program in {}.\n", program.language().name()));
    if !notes.not_located.is_empty() {
        text += &format!(
            "Left as written: {}, where it is not known where the tool is: motions to positions of joints, or without a full pose \
             behind one.\n",
            motions(&notes.not_located)
        );
    }
    if notes.named_points {
        text += "Points stay as they are declared; a motion to one of them that is corrected has numbers in place of its name.\n";
    }
    text
}

/// How many motions `lines` have, and which lines these are.
fn motions(lines: &[usize]) -> String {
    let mut names: Vec<String> = lines.iter().take(NAMED).map(usize::to_string).collect();
    if lines.len() > NAMED {
        names.push(format!("{} more", lines.len() - NAMED));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let word = if lines.len() == 1 { "line" } else { "lines" };
    format!("{}, {word} {}", counted(lines.len(), "motion"), listed(&names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toolpath::gcode::LengthUnit;

    #[test]
    fn lines_and_units_are_named() {
        let notes = Notes { unit_taken: Some((LengthUnit::Inch, 3)), not_located: vec![3, 5], ..Notes::default() };
        assert_eq!(
            text(&notes, &WrittenCalls::None),
            "The program names no unit before line 3: inch is taken; G20, G21 or unit in [gcode] says which it is.\n\
             Left as written: 2 motions, lines 3 and 5, where it is not known in X, Y and Z where the tool is; start_mm in \
             [gcode] says where the program begins.\n"
        );
        assert_eq!(text(&Notes::default(), &WrittenCalls::None), "");
        let many = text(&Notes { not_located: (1..20).collect(), ..Notes::default() }, &WrittenCalls::None);
        assert!(many.contains("19 motions, lines 1, 2, 3, 4, 5, 6, 7, 8 and 11 more,"), "{many}");
    }
}
