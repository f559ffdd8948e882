//! Words of the command line for formats and colours.

use clap::ValueEnum;
use kinetostat::report::{exchange, figures::Colours};

/// `--format`.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Format {
    /// Tables as CSV (RFC 4180)
    Csv,
    /// Tables as Apache Parquet, units in the metadata
    Parquet,
    /// Maps over the workspace as VTK image data, for ParaView
    Vti,
}

impl Format {
    /// How the names of its files end.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Parquet => "parquet",
            Format::Vti => "vti",
        }
    }
}

impl From<Format> for exchange::Format {
    fn from(format: Format) -> Self {
        match format {
            Format::Csv => exchange::Format::Csv,
            Format::Parquet => exchange::Format::Parquet,
            Format::Vti => exchange::Format::Vti,
        }
    }
}

/// `--colours`.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ColourMap {
    /// Perceptually uniform, from dark violet to yellow
    Viridis,
    /// Perceptually uniform and the same to readers with and without colour vision, from dark blue to yellow
    Cividis,
    /// From dark to light grey, for print without colours
    Grey,
}

impl From<ColourMap> for Colours {
    fn from(map: ColourMap) -> Self {
        match map {
            ColourMap::Viridis => Colours::Viridis,
            ColourMap::Cividis => Colours::Cividis,
            ColourMap::Grey => Colours::Grey,
        }
    }
}
