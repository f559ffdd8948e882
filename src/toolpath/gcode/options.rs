//! What a program does not say itself: unit, start, work offsets, switches of the control.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Deserialize;

use crate::toolpath::Toolpath;
use crate::toolpath::gcode::{
    Dialect,
    modal::{Distance, LengthUnit},
    offsets::WorkOffset,
    rotary::{Rotary, RotaryColumn},
};

/// What a program does not say itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GcodeOptions {
    /// The unit before the first G20 or G21; `None` is mm, and [`Program::notes`](super::Program::notes) then say so.
    pub unit: Option<LengthUnit>,
    /// Where the tool is before the program begins, mm in the workpiece frame; by default not known, and motions stay as
    /// they are until X, Y and Z are.
    pub start_mm: Option<Vector3<f64>>,
    /// The zeros of work offsets, mm in the workpiece frame. G54 that is not given is the workpiece frame itself; without
    /// any given, the work offset that the program uses first is. Others are known if G10 L2 says how they stand to one
    /// that is; a program that uses one that is not known is refused.
    pub work_offsets_mm: BTreeMap<WorkOffset, Vector3<f64>>,
    /// What becomes of lines with a leading `/`.
    pub block_delete: BlockDelete,
    /// The dialect the program is in; `None` is what its text shows ([`Dialect::of`]).
    pub dialect: Option<Dialect>,
    /// The meaning of I, J and K before the first G90.1 or G91.1.
    pub arc_centres: ArcCentres,
    /// Texts that begin a feature of the program where a line, comments included, has one of them; of several, the longest.
    /// It ends at the next or at a tool change.
    pub features: Vec<String>,
    /// What A, B and C turn.
    pub rotary: Rotary,
    /// The axes of `rotary` that are drives of the machine: paths tell these where to stand.
    pub rotary_columns: Vec<RotaryColumn>,
    /// Whether whoever reads the file is to write it out first, by [`Program::parse_expanded`](super::Program::parse_expanded).
    pub expand: Expand,
}

/// Which programs are written out as the motion that they make before they are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Expand {
    /// None: subprograms and macros are refused.
    Never,
    /// Those with subprograms, variables, expressions, branches or loops.
    #[default]
    WhereNeeded,
    /// All, their cycles as well.
    Always,
}

impl GcodeOptions {
    /// Whether `path`, of a program read so, tells rotary drives of the machine where to stand.
    pub fn turns_drives(&self, path: &Toolpath) -> bool {
        self.rotary_columns.iter().any(|column| path.external_axes().contains(&column.column))
    }
}

/// The position of the machine's block-delete switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BlockDelete {
    /// Off: lines with a leading `/` run.
    #[default]
    Run,
    /// On: they are skipped, and copied as they are. The rewritten program is right with the switch on only.
    Skip,
}

/// What I, J and K lead from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ArcCentres {
    /// From the start of the arc (G91.1).
    #[default]
    Incremental,
    /// From the zero of the coordinates (G90.1).
    Absolute,
}

impl From<ArcCentres> for Distance {
    fn from(centres: ArcCentres) -> Distance {
        match centres {
            ArcCentres::Incremental => Distance::Incremental,
            ArcCentres::Absolute => Distance::Absolute,
        }
    }
}
