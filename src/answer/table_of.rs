//! Tables of quantities, made whole or written block by block during the computation.

use super::{FoundOr, Quantity};
use crate::{
    answer::{Run, output::Streamed},
    files::exchange::{Cell, Column, Image, KeptRows, Row, StreamedTable, Table, texts},
    input::error::Result,
    simulation::{Failure, SOLVED},
};

/// Columns of a table whose rows are identifying cells, then quantities of a result of type `E`.
pub struct QuantityTable<E> {
    lead: Vec<Column>,
    has_status: bool,
    quantities: Vec<Quantity<E>>,
}

impl<E: 'static> QuantityTable<E> {
    /// Makes a table with the columns `lead`, `status` and `reason`, then `quantities`.
    pub fn new(lead: Vec<Column>, quantities: Vec<Quantity<E>>) -> Self {
        Self { lead, has_status: true, quantities }
    }

    /// Makes a table without the columns `status` and `reason`.
    pub fn without_status(lead: Vec<Column>, quantities: Vec<Quantity<E>>) -> Self {
        Self { lead, has_status: false, quantities }
    }

    /// Returns all columns of the table, in order.
    pub fn columns(&self) -> Vec<Column> {
        let status = texts(["status", "reason"]).into_iter().filter(|_| self.has_status);
        self.lead.iter().cloned().chain(status).chain(self.quantities.iter().map(Quantity::column)).collect()
    }

    /// Makes the table of `rows`: identifying cells, and a result or why there is none.
    pub fn table<'a>(&self, rows: impl IntoIterator<Item = (Row, FoundOr<'a, E>)>) -> Table {
        let row = |(mut row, result): (Row, FoundOr<'a, E>)| {
            row.extend(status_cells(result).into_iter().filter(|_| self.has_status));
            row.extend(self.quantities.iter().map(|quantity| quantity.cell_of(result)));
            row
        };
        Table::new(self.columns(), rows.into_iter().map(row))
    }
}

/// Makes the table of a block of the work.
type BlockTable<'a, B> = Box<dyn Fn(&B) -> Table + Send + Sync + 'a>;

/// Tables that are written block by block, so that memory does not grow with them; only for an image all rows are kept.
pub struct Streams<'a, B: ?Sized> {
    run: &'a Run<'a>,
    tables: Vec<(String, BlockTable<'a, B>, StreamedTable, Table)>,
    image: Option<Image>,
}

impl<'a, B: ?Sized> Streams<'a, B> {
    /// Starts streaming into the folder of `run`, without tables; `image` is made of them if images are wanted.
    pub fn new(run: &'a Run<'a>, image: Option<Image>) -> Self {
        Self { run, tables: Vec::new(), image: image.filter(|_| run.wants_image()) }
    }

    /// Adds the table `stem`: `empty` has its columns and no rows, `table` makes the rows of a block; `Err` if its files cannot be written.
    pub fn with(self, stem: &str, empty: Table, table: impl Fn(&B) -> Table + Send + Sync + 'a) -> Result<Self> {
        self.with_kept(stem, empty, None, table)
    }

    /// Adds a table as [`Streams::with`] does, whose CSV file gets only the rows `kept`, if given.
    pub fn with_kept(
        mut self,
        stem: &str,
        empty: Table,
        kept: Option<KeptRows>,
        table: impl Fn(&B) -> Table + Send + Sync + 'a,
    ) -> Result<Self> {
        let streamed = StreamedTable::new(self.run.out, stem, empty.columns(), self.run.formats, kept)?;
        self.tables.push((stem.into(), Box::new(table), streamed, empty));
        Ok(self)
    }

    /// Writes the rows of the next block into all tables; keeps the rows where an image is made of them; `Err` if they cannot be written.
    pub fn write_block(&mut self, block: &B) -> Result<()> {
        for (_, make_table, streamed, image_table) in &mut self.tables {
            let table = make_table(block);
            streamed.add(&table)?;
            if self.image.is_some() {
                image_table.append(table);
            }
        }
        Ok(())
    }

    /// Closes all tables and returns their files, and the tables without rows; `Err` if a file or the image cannot be made.
    pub fn finish(self) -> Result<Streamed> {
        let (mut files, mut tables) = (Vec::new(), Vec::new());
        for (stem, _, streamed, table) in self.tables {
            let (written, note) = streamed.finish()?;
            files.extend(written);
            tables.push((stem, table.with_note(note)));
        }
        if let Some(image) = self.image {
            files.extend(image.files(self.run.out, &tables)?);
        }
        Ok((files, tables.into_iter().map(|(stem, table)| (stem, table.without_rows())).collect()))
    }
}

/// Returns the cells of the columns `status` and `reason` for a result or a failure.
pub(crate) fn status_cells<T>(result: std::result::Result<T, &Failure>) -> [Cell; 2] {
    match result {
        Ok(_) => [SOLVED.into(), Cell::Missing],
        Err(failure) => [(&*failure.status).into(), failure.reason.as_str().into()],
    }
}
