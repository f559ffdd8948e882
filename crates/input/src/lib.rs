//! Reads files and checks values, with file, line and key in errors; the one error type. Files are never longer than a limit; machine files of
//! [kinetostat](https://docs.rs/kinetostat) are read with it.
//!
//! ```
//! use kinetostat_input::toml_file::parse;
//!
//! #[derive(Debug, serde::Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Slide {
//!     travel_mm: f64,
//! }
//!
//! let slide: Slide = parse("travel_mm = 200.0", "slide.toml")?;
//! assert_eq!(slide.travel_mm, 200.0);
//! let fault = parse::<Slide>("travel_mm = \"far\"", "slide.toml").unwrap_err();
//! assert!(fault.to_string().starts_with("slide.toml:1: travel_mm: "));
//! # Ok::<(), kinetostat_input::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod check;
pub mod csv_rows;
pub mod error;
pub mod file;
pub mod names;
pub mod toml_file;

/// Tables of a file: keys that they do not have are refused, and editors are told of those that they have.
#[macro_export]
macro_rules! tables {
    ($($(#[$about:meta])* pub struct $table:ident { $($fields:tt)* })+) => {$(
        $(#[$about])*
        #[derive(Debug, Clone, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub struct $table {
            $($fields)*
        }
    )+};
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
