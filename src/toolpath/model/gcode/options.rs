//! What a program does not say itself, what a reader should know of it, and how it is to be written.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Deserialize;

use crate::toolpath::model::{
    NumberFormat, RewriteError, Toolpath,
    gcode::{Dialect, Distance, Rotary, RotaryColumn, WorkOffset},
};

/// What a program does not say itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GcodeOptions {
    /// The unit before the first G20 or G21; `None` is mm, and [`Program::notes`](crate::toolpath::gcode::Program::notes) then say so.
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
    /// Whether whoever reads the file is to write it out first, by [`Program::parse_expanded`](crate::toolpath::gcode::Program::parse_expanded).
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

/// The length unit of a program's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
pub enum LengthUnit {
    /// Millimetres (G21).
    #[default]
    #[serde(rename = "mm")]
    Millimetre,
    /// Inches of 25.4 mm (G20).
    #[serde(rename = "inch")]
    Inch,
}

impl LengthUnit {
    /// How many mm one unit is.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => 25.4,
        }
    }

    /// Its name: mm or inch.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Inch => "inch",
        }
    }
}

/// What the program did not say, and what followed from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The dialect it was read as.
    pub dialect: Dialect,
    /// The unit taken, and the line (from 1) of the first length before any G20 or G21.
    pub unit_taken: Option<(LengthUnit, usize)>,
    /// Lines (from 1) whose motion leads from or to a place that is not known: they are no part of the path.
    pub not_located: Vec<usize>,
    /// Lines that the program has, and that it was written out in.
    pub written_out: Option<[usize; 2]>,
    /// Whether it leads A, B or C anywhere.
    pub(crate) names_rotary: bool,
}

/// Decimals, and how far from its points a program may be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Writing {
    /// Decimals of the coordinates.
    pub format: NumberFormat,
    /// How far from a corrected point, mm, the line or arc that stands for it may pass, besides rounding. At 0, a block that one
    /// block does not replace to a unit of the last decimal becomes a line to each of its points.
    pub tolerance_mm: f64,
    /// Whether an arc that is flat may be written with a rise; otherwise it becomes lines where its corrections rise.
    pub helical_arcs: bool,
}

impl Writing {
    /// With `tolerance_mm`, arcs helical where they must be.
    #[must_use]
    pub fn within(tolerance_mm: f64, format: NumberFormat) -> Writing {
        Writing { format, tolerance_mm, helical_arcs: true }
    }

    pub(crate) fn checked(self) -> Result<Writing, RewriteError> {
        match self.tolerance_mm.is_finite() && self.tolerance_mm >= 0.0 {
            true => Ok(self),
            false => Err(RewriteError::Tolerance { tolerance_mm: self.tolerance_mm }),
        }
    }
}

/// To a unit of the last decimal, a line to each point of a block that is split.
impl From<NumberFormat> for Writing {
    fn from(format: NumberFormat) -> Writing {
        Writing::within(0.0, format)
    }
}
