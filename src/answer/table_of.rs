//! Tables of quantities, whole or written block by block while they are computed.

use super::{FoundOr, Quantity};
use crate::{
    answer::{Run, output::Streamed},
    files::exchange::{Cell, Column, Image, Row, StreamedTable, Table, texts},
    input::error::Result,
    simulation::{Failure, SOLVED},
};

/// A table whose rows lead with cells that tell them apart and go on with the quantities of what was found, an `E`.
pub struct TableOf<E> {
    lead: Vec<Column>,
    has_status: bool,
    quantities: Vec<Quantity<E>>,
}

impl<E: 'static> TableOf<E> {
    /// Its columns: `lead`, `status` and `reason` of what was not found, `quantities`.
    pub fn new(lead: Vec<Column>, quantities: Vec<Quantity<E>>) -> Self {
        Self { lead, has_status: true, quantities }
    }

    /// Without columns that say why nothing was found.
    pub fn without_status(lead: Vec<Column>, quantities: Vec<Quantity<E>>) -> Self {
        Self { lead, has_status: false, quantities }
    }

    /// The columns.
    pub fn columns(&self) -> Vec<Column> {
        let status = texts(["status", "reason"]).into_iter().filter(|_| self.has_status);
        self.lead.iter().cloned().chain(status).chain(self.quantities.iter().map(Quantity::column)).collect()
    }

    /// The table of `rows`.
    pub fn table<'a>(&self, rows: impl IntoIterator<Item = (Row, FoundOr<'a, E>)>) -> Table {
        let row = |(mut row, found): (Row, FoundOr<'a, E>)| {
            row.extend(status_cells(found).into_iter().filter(|_| self.has_status));
            row.extend(self.quantities.iter().map(|quantity| quantity.cell_of(found)));
            row
        };
        Table::new(self.columns(), rows.into_iter().map(row))
    }
}

/// The table of a block of the work.
type OfBlock<'a, B> = Box<dyn Fn(&B) -> Table + Send + Sync + 'a>;

/// Tables that are written block by block, so that memory does not grow with them; only an image is made of all of their rows.
pub struct Streams<'a, B: ?Sized> {
    run: &'a Run<'a>,
    tables: Vec<(String, OfBlock<'a, B>, StreamedTable, Table)>,
    image: Option<Image>,
}

impl<'a, B: ?Sized> Streams<'a, B> {
    /// Into the folder of `run`; `image` is made of the tables where one is wanted.
    pub fn new(run: &'a Run<'a>, image: Option<Image>) -> Self {
        Self { run, tables: Vec::new(), image: image.filter(|_| run.wants_image()) }
    }

    /// With the table `stem`, which is `whole` without rows and whose rows of a block `table` makes.
    ///
    /// # Errors
    /// Its files cannot be written.
    pub fn with(mut self, stem: &str, whole: Table, table: impl Fn(&B) -> Table + Send + Sync + 'a) -> Result<Self> {
        let streamed = StreamedTable::new(self.run.out, stem, whole.columns(), self.run.formats)?;
        self.tables.push((stem.into(), Box::new(table), streamed, whole));
        Ok(self)
    }

    /// Writes the next block.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, block: &B) -> Result<()> {
        for (_, of_block, streamed, whole) in &mut self.tables {
            let table = of_block(block);
            streamed.add(&table)?;
            if self.image.is_some() {
                whole.append(table);
            }
        }
        Ok(())
    }

    /// The files, and the tables without rows.
    ///
    /// # Errors
    /// They cannot be written, or the image cannot hold them.
    pub fn finish(self) -> Result<Streamed> {
        let (mut files, mut whole) = (Vec::new(), Vec::new());
        for (stem, _, streamed, table) in self.tables {
            files.extend(streamed.finish()?);
            whole.push((stem, table));
        }
        if let Some(image) = self.image {
            files.extend(image.files(self.run.out, &whole)?);
        }
        Ok((files, whole.into_iter().map(|(stem, table)| (stem, Table::new(table.columns().to_vec(), []))).collect()))
    }
}

/// The cells of the columns `status` and `reason`.
pub(crate) fn status_cells<T>(answer: std::result::Result<T, &Failure>) -> [Cell; 2] {
    match answer {
        Ok(_) => [SOLVED.into(), Cell::Missing],
        Err(failure) => [(&*failure.status).into(), failure.reason.as_str().into()],
    }
}
