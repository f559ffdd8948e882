//! Options for reading a G-code program, notes on what was assumed, and options for writing it.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Deserialize;

use crate::model::{
    NumberFormat, RewriteError, Toolpath,
    gcode::{CutterOf, Dialect, Distance, Rotary, RotaryColumn, WorkOffset},
};

/// What a G-code program does not say itself: unit, start, work offsets, dialect, rotary axes and how to read it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GcodeOptions {
    /// The unit before the first G20 or G21; `None` is mm, and [`GcodeProgram::notes`](crate::gcode::GcodeProgram::notes) then say so.
    pub unit: Option<LengthUnit>,
    /// Where the tool is before the program begins, mm in the workpiece frame; unknown by default, so that motions stay as
    /// they are until X, Y and Z are known.
    pub start_mm: Option<Vector3<f64>>,
    /// The zeros of work offsets, mm in the workpiece frame. G54 that is not given is the workpiece frame itself; without
    /// any given, the work offset that the program uses first is. Others are known if G10 L2 says how they stand to one
    /// that is; a program that uses one that is not known is refused.
    pub work_offsets_mm: BTreeMap<WorkOffset, Vector3<f64>>,
    /// What becomes of lines with a leading `/`.
    pub block_delete: BlockDelete,
    /// The dialect the program is in; `None` is what its text shows ([`Dialect::detect`]).
    pub dialect: Option<Dialect>,
    /// The meaning of I, J and K before the first G90.1 or G91.1.
    pub arc_centres: ArcCentres,
    /// Texts that begin a feature: a line that contains one, comments included, starts it (of several, the longest);
    /// it ends at the next feature or at a tool change.
    pub features: Vec<String>,
    /// The rotary axes A, B and C, and what they turn.
    pub rotary: Rotary,
    /// The axes of `rotary` that are drives of the machine, which paths command.
    pub rotary_columns: Vec<RotaryColumn>,
    /// How the tool stands in programs that do not say it, from its tip to the spindle, a unit vector in W; the normal of their plane if not given.
    pub tool_axis: Option<Vector3<f64>>,
    /// Whether to expand the program first, by [`GcodeProgram::parse_expanded`](crate::gcode::GcodeProgram::parse_expanded).
    pub expand: Expand,
    /// Numbers of programs whose calls (M98, M198, G65) move nothing: these lines stay as they are and are not followed.
    pub calls_kept: Vec<u32>,
    /// Radii of cutters, mm, with which contours in cutter radius compensation are written as the path of the tool centre; `None`: such
    /// programs are refused.
    pub cutter_radii_mm: Option<BTreeMap<CutterOf, f64>>,
    /// Whether paths come with what comments say about tools ([`Toolpath::tools`]).
    pub tool_comments: bool,
}

/// Which programs are expanded into the moves that they make before they are read.
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
    /// Whether `path`, read with these options, commands rotary drives of the machine.
    pub fn commands_rotary_drives(&self, path: &Toolpath) -> bool {
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

/// The reference of the arc centres I, J and K: the start of the arc or the zero.
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
    /// Converts to the distance mode of arc centres.
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
    /// Returns how many mm one unit is.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => 25.4,
        }
    }

    /// Returns the unit's name: mm or inch.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Inch => "inch",
        }
    }
}

/// What was assumed where the program says nothing, and which of its lines were left as they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The dialect in which the program was read.
    pub dialect: Dialect,
    /// The assumed unit, and the line (from 1) of the first length before any G20 or G21.
    pub assumed_unit: Option<(LengthUnit, usize)>,
    /// Lines (from 1) whose motion starts or ends at an unknown position: they are not part of the path.
    pub unlocated_lines: Vec<usize>,
    /// Numbers of lines of the program and of its expansion, if it was expanded.
    pub written_out: Option<[usize; 2]>,
    /// Angles of A, B and C, degrees, that the control chooses by its rule, and the lines (from 1) where it does.
    pub chosen_angles: Vec<(usize, [f64; 3])>,
    /// Radii, mm, with which contours in cutter radius compensation became the path of the tool centre.
    pub cutter_radii_mm: BTreeMap<CutterOf, f64>,
    /// Lines (from 1) on which rotary axes move alone at F, not in inverse time.
    pub turned_alone_lines: Vec<usize>,
    /// Whether the program moves A, B or C.
    pub names_rotary_axes: bool,
    /// Whether it feeds in a plane whose normal is x (G19), y (G18) or z (G17).
    pub feed_normals: [bool; 3],
}

/// Options for writing a program: decimals, tolerance of the written path, and whether arcs may become helical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WriteOptions {
    /// Decimals of the coordinates.
    pub format: NumberFormat,
    /// How far from a corrected point, mm, the line or arc that stands for it may pass, besides rounding. At 0, a block that one
    /// block does not replace to a unit of the last decimal becomes a line to each of its points.
    pub tolerance_mm: f64,
    /// Whether an arc that is flat may be written with a rise; otherwise it becomes lines where its corrections rise.
    pub helical_arcs: bool,
}

impl WriteOptions {
    /// Creates options with these decimals and no tolerance; flat arcs may become helical.
    #[must_use]
    pub fn with_decimals(format: NumberFormat) -> WriteOptions {
        WriteOptions { format, ..WriteOptions::default() }
    }

    /// Returns the options if the tolerance is finite and not negative, or an error.
    pub(crate) fn checked(self) -> Result<WriteOptions, RewriteError> {
        match self.tolerance_mm.is_finite() && self.tolerance_mm >= 0.0 {
            true => Ok(self),
            false => Err(RewriteError::Tolerance { tolerance_mm: self.tolerance_mm }),
        }
    }
}

impl Default for WriteOptions {
    /// The default decimals and no tolerance; flat arcs may become helical.
    fn default() -> WriteOptions {
        WriteOptions { format: NumberFormat::default(), tolerance_mm: 0.0, helical_arcs: true }
    }
}
