//! Tables for single drives as LinuxCNC reads them: a `COMP_FILE` of type 1.
//!
//! A line each of nominal position and the trims for both directions, ascending, at most 256, and nothing else: LinuxCNC stops at the
//! first line that is none. It adds the trim to the position of the motor, linearly between lines and constant beyond them
//! (LinuxCNC, src/emc/motion: usrmotintf.cc, command.c, control.c; `COMP_FILE_TYPE` in its "INI Configuration").

use crate::{files::OutputFile, products::correction::JointTable};

/// Name of the file of a drive.
pub(super) fn name(table: &JointTable) -> String {
    format!("joint_{}.comp", table.drive)
}

/// The file of a drive, mm.
pub(super) fn file(table: &JointTable) -> OutputFile {
    let line = |(position, correction): (&f64, &f64)| format!("{position:.6} {correction:.6} {correction:.6}\n");
    let lines: String = table.positions_mm.iter().zip(&table.corrections_mm).map(line).collect();
    OutputFile::new(name(table), lines)
}

/// What stands in LinuxCNC's INI file for these drives, in their order.
pub(super) fn ini(tables: &[JointTable]) -> String {
    let joint = |(index, table): (usize, &JointTable)| {
        format!("[JOINT_{index}]\nCOMP_FILE = {}\nCOMP_FILE_TYPE = 1\n", name(table))
    };
    tables.iter().enumerate().map(joint).collect::<Vec<_>>().join("\n")
}
