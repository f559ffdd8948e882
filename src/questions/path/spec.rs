//! A path study as written: raw, units in the keys, unknown keys refused. Checked by [`crate::questions::Study`].

use serde::Deserialize;

use crate::questions::spec::CircleSpec;

/// A path as the study file gives it: a circle, a line or a program.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// A full circle in the xy-plane. A path has this, `line` or `file`.
    pub circle: Option<CircleSpec>,
    /// A straight line. A path has this, `circle` or `file`.
    pub line: Option<LineSpec>,
    /// A program, relative to the study's folder. A path has this, `circle` or `line`.
    pub file: Option<String>,
    /// Methods compared, by name; all of them if not given.
    pub methods: Option<Vec<String>>,
}

/// A straight line in the workpiece frame, split as the process says.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineSpec {
    /// First point, W.
    pub start_mm: [f64; 3],
    /// Last point, W.
    pub end_mm: [f64; 3],
}
