//! Polyline files (CSV): read, and sampled as paths.

pub(crate) mod column;
pub(crate) mod error;
pub(crate) mod read;
pub(crate) mod sample;

pub(crate) use {column::*, error::*};

use std::ops::Range;

use crate::model::{NumberFormat, Toolpath};

/// A polyline file that has been read.
#[derive(Clone, Debug)]
pub struct Polyline {
    pub(crate) name: String,
    pub(crate) source: Vec<u8>,
    pub(crate) columns: Vec<Column>,
    /// The bytes of each row, without its line ending.
    pub(crate) rows: Vec<Range<usize>>,
    /// The line of each row, from 1.
    pub(crate) lines: Vec<usize>,
    pub(crate) path: Toolpath,
    pub(crate) own_format: NumberFormat,
}

impl Polyline {
    /// The rows of the file as a path; [`PointSource::segment`](crate::PointSource) is the row, from 0.
    #[must_use]
    pub fn toolpath(&self) -> &Toolpath {
        &self.path
    }

    /// The file's bytes.
    pub(crate) fn source(&self) -> &[u8] {
        &self.source
    }

    /// The line, from 1, that the row of a point stands on; blank lines count. `None` if there is no such point.
    #[must_use]
    pub fn line_of(&self, segment: usize) -> Option<usize> {
        self.lines.get(segment).copied()
    }

    /// The bytes of the row of a point, without its line ending; `None` if there is no such point.
    #[must_use]
    pub fn content_of(&self, segment: usize) -> Option<&[u8]> {
        self.rows.get(segment).map(|row| &self.source[row.clone()])
    }

    /// Most decimals of the positions in the file, at least 3.
    #[must_use]
    pub fn own_format(&self) -> NumberFormat {
        self.own_format
    }
}
