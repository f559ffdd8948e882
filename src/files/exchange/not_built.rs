//! What stands for formats that this program was built without: they are refused before a file is begun.

/// For [`Format::Parquet`](super::Format::Parquet).
#[cfg(not(feature = "parquet"))]
pub mod parquet_file {
    use std::{convert::Infallible, io::Write, marker::PhantomData};

    use crate::files::exchange::{Column, Format, NotBuilt, Table};

    /// A table as a Parquet file, which this program cannot make.
    pub struct ParquetFile<W: Write + Send>(Infallible, PhantomData<W>);

    impl<W: Write + Send> ParquetFile<W> {
        /// Refuses.
        pub fn new(_: &[Column], _: W) -> Result<Self, NotBuilt> {
            Err(NotBuilt(Format::Parquet))
        }

        /// Never comes to be.
        pub fn add(&mut self, _: &Table) -> Result<(), NotBuilt> {
            match self.0 {}
        }

        /// Never comes to be.
        pub fn finish(self) -> Result<W, NotBuilt> {
            match self.0 {}
        }
    }

    /// Refuses.
    pub fn parquet(_: &Table) -> Result<Vec<u8>, NotBuilt> {
        Err(NotBuilt(Format::Parquet))
    }
}

/// For [`Format::Vti`](super::Format::Vti).
#[cfg(not(feature = "vtk"))]
pub mod vti_file {
    use std::io;

    use crate::{
        files::exchange::{Format, NotBuilt, image::Array},
        spatial::Grid,
    };

    /// Refuses.
    pub fn bytes(_: &Grid, _: Vec<Array>) -> io::Result<Vec<u8>> {
        Err(io::Error::other(NotBuilt(Format::Vti)))
    }
}
