//! Tables for the terminal: a rule below the header and none between rows.

use comfy_table::{Cell, CellAlignment, Row, Table, presets::NOTHING};
use comfy_table::{LineStyle, TableStyle};

const STYLE: TableStyle = NOTHING.header_separator(LineStyle::new('─', '─', '─', '─'));

/// Returns an empty table with `header`; columns after the first `left` ones are aligned right, for numbers.
pub fn text_table<H: Into<String>>(header: impl IntoIterator<Item = H>, left: usize) -> Table {
    let align = |column: usize| if column < left { CellAlignment::Left } else { CellAlignment::Right };
    let header: Vec<String> = header.into_iter().map(Into::into).collect();
    let count = header.len();
    let mut table = Table::new();
    let cells = header.into_iter().enumerate().map(|(column, text)| Cell::new(text).set_alignment(align(column)));
    table.load_style(STYLE).set_header(Row::from(cells.collect::<Vec<_>>()));
    for (column, column_format) in table.column_iter_mut().enumerate().take(count) {
        column_format.set_cell_alignment(align(column));
    }
    table
}
