//! Replacements for formats that this program was built without: they refuse before a file is begun.

/// Replacement for the writer of [`Format::Parquet`](super::Format::Parquet).
#[cfg(not(feature = "parquet"))]
pub mod parquet_file {
    use std::{convert::Infallible, io::Write, marker::PhantomData};

    use crate::files::exchange::{Column, Format, NotBuilt, Table};

    /// A Parquet file, which this program cannot write; no value of it exists.
    pub struct ParquetFile<W: Write + Send>(Infallible, PhantomData<W>);

    impl<W: Write + Send> ParquetFile<W> {
        /// Returns the error that Parquet is not built in.
        pub fn new(_: &[Column], _: W) -> Result<Self, NotBuilt> {
            Err(NotBuilt(Format::Parquet))
        }

        /// Cannot be called, as no value exists.
        pub fn add(&mut self, _: &Table) -> Result<(), NotBuilt> {
            match self.0 {}
        }

        /// Cannot be called, as no value exists.
        pub fn finish(self) -> Result<W, NotBuilt> {
            match self.0 {}
        }
    }

    /// Returns the error that Parquet is not built in.
    pub fn parquet(_: &Table) -> Result<Vec<u8>, NotBuilt> {
        Err(NotBuilt(Format::Parquet))
    }
}

/// Replacement for the writer of VTK files.
#[cfg(not(feature = "vtk"))]
pub mod vtk_file {
    use std::io;

    use crate::{
        files::exchange::{Format, NotBuilt, Surface, image::Array},
        spatial::Grid,
    };

    /// Returns the error that VTK is not built in.
    pub fn image(_: &Grid, _: Vec<Array>) -> io::Result<Vec<u8>> {
        Err(io::Error::other(NotBuilt(Format::Vti)))
    }

    /// Returns that there is none.
    pub fn surface(_: &Surface) -> io::Result<Option<Vec<u8>>> {
        Ok(None)
    }
}
