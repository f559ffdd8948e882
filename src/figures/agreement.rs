//! Figure that compares published numbers with computed ones, each against its own tolerance.

use super::axis::{self, Axis, Plot, Spacing};
use super::drawing::{Anchor, Drawing, Point, Rect, Rgb, Stroke, Text};
use super::error::{FigureError, check_drawable};
use super::style::{self, BORDER, CURVES, GRID, INK, MUTED, Sizes, outline};
use super::text::{self, Weight};

/// Height of a row as a multiple of the type size.
const ROW: f64 = 1.42;
/// Largest difference on the axis, in tolerances.
const ENDS: f64 = 3.0;
/// Widest column of names, of published and of computed numbers, as shares of the page.
const WIDEST: [f64; 3] = [0.38, 0.13, 0.22];
/// The same on the width of a telephone.
const WIDEST_OF_PORTRAIT: [f64; 3] = [0.35, 0.16, 0.26];
const GAP: f64 = 24.0;
const MARK: f64 = 13.0;
/// Colour of the band in which the numbers agree.
pub(super) const BAND: Rgb = [214, 232, 224];

/// How the computed number must relate to the published one for the two to agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Equal to it within its tolerance.
    About,
    /// Not below it.
    AtLeast,
    /// Not above it.
    AtMost,
}

/// One published number and the computed one it is compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct AgreementRow {
    /// What the number is, in few words.
    pub label: String,
    /// Published number as text, and the computed one with the unit of both.
    pub numbers: [String; 2],
    /// How the computed number must relate to the published one.
    pub criterion: Criterion,
    /// Computed minus published number, divided by the tolerance; `None` if there is no computed number.
    pub difference: Option<f64>,
    /// Whether the two numbers agree.
    pub agrees: bool,
}

/// Rows of compared numbers over one axis: the difference divided by the tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct AgreementFigure {
    /// What is compared.
    pub title: String,
    /// Conditions of the comparison.
    pub subtitle: String,
    /// Headings of the columns of published and computed numbers.
    pub numbers: [String; 2],
    /// The compared numbers, in the order shown.
    pub rows: Vec<AgreementRow>,
}

/// Lays the figure out; `Err` when it has no rows or a difference cannot be drawn.
pub(super) fn drawing(figure: &AgreementFigure, sizes: Sizes) -> Result<Drawing, FigureError> {
    if figure.rows.is_empty() {
        return Err(FigureError::Empty { what: "figure of agreement".into() });
    }
    check_drawable(figure.rows.iter().filter_map(|row| row.difference), || "agreement".into())?;
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let (size, room) = (sizes.body, sizes.width - 2.0 * BORDER);
    let widest = if sizes.is_portrait() { WIDEST_OF_PORTRAIT } else { WIDEST };
    let lines = |content: &str, share: f64| text::wrap(content, size, Weight::Regular, share * room);
    let cells: Vec<[Vec<String>; 3]> = figure
        .rows
        .iter()
        .map(|AgreementRow { label, numbers: [quoted, ours], .. }| {
            [lines(label, widest[0]), lines(quoted, widest[1]), lines(ours, widest[2])]
        })
        .collect();
    let heads = ["", &figure.numbers[0], &figure.numbers[1]];
    let width = |column: usize| {
        let head = text::width(heads[column], size, Weight::Bold).min(widest[column] * room);
        let all = cells.iter().flat_map(|cell| &cell[column]);
        all.map(|line| text::width(line, size, Weight::Regular)).fold(head, f64::max)
    };
    let quoted_end = BORDER + width(0) + GAP + width(1);
    let left = quoted_end + GAP + width(2) + GAP;
    let columns = [(Anchor::Start, BORDER), (Anchor::End, quoted_end), (Anchor::End, left - GAP)];
    let head = top + ROW * size;
    for (words, (anchor, x)) in heads.into_iter().zip(columns) {
        drawing.text(Text::new(words, size, [x, top + size], anchor).bold());
    }
    let height = cells.iter().map(|cell| row_height(cell, size)).sum();
    let rect = Rect { x: left, y: head, width: sizes.width - BORDER - 0.5 * size - left, height };
    let plot = Plot {
        rect,
        x: Axis::horizontal(-ENDS - 0.3, ENDS + 0.3, Spacing::Linear, rect.width, sizes.tick),
        y: Axis::vertical(0.0, 1.0, Spacing::Linear, 1.0, sizes.tick),
    };
    let mut y = head;
    for (row, cell) in figure.rows.iter().zip(&cells) {
        draw_row(&mut drawing, &plot, row, cell, columns, y, size);
        y += row_height(cell, size);
    }
    let zero = plot.page_point(0.0, 0.0)[0];
    drawing.line(vec![[zero, rect.y], [zero, rect.bottom()]], Stroke { colour: MUTED, width: 2.0, dash: &[8.0, 8.0] });
    drawing.outline(&rect.corners(), outline());
    plot.draw_x_axis(&mut drawing, "", size, sizes.tick);
    let below = rect.bottom() + axis::depth_below(sizes.tick) + 1.2 * size;
    drawing.text(Text::new("(ours − quoted) / tolerance", size, [sizes.width - BORDER, below], Anchor::End));
    drawing.height = draw_legend(&mut drawing, below + 1.5 * size, size) + BORDER;
    Ok(drawing)
}

/// Returns the height of a row with `cell` as its wrapped label and numbers.
fn row_height(cell: &[Vec<String>; 3], size: f64) -> f64 {
    cell.iter().map(Vec::len).max().unwrap_or(1) as f64 * ROW * size
}

/// Draws one row at height `y`, with `cell` as its wrapped label and numbers in `columns`: texts, the band in which the numbers agree, and a mark.
fn draw_row(
    drawing: &mut Drawing,
    plot: &Plot,
    row: &AgreementRow,
    cell: &[Vec<String>; 3],
    columns: [(Anchor, f64); 3],
    y: f64,
    size: f64,
) {
    let rect = plot.rect;
    let x_of = |difference: f64| plot.page_point(difference, 0.0)[0];
    let (from, to) = match row.criterion {
        Criterion::About => (x_of(-1.0), x_of(1.0)),
        Criterion::AtLeast => (x_of(0.0), rect.right()),
        Criterion::AtMost => (rect.x, x_of(0.0)),
    };
    let inset = 0.14 * size;
    let band = Rect { x: from, y: y + inset, width: to - from, height: row_height(cell, size) - 2.0 * inset };
    drawing.convex(band.corners().to_vec(), BAND);
    drawing.line(vec![[BORDER, y], [rect.right(), y]], Stroke { colour: GRID, width: 2.0, dash: &[] });
    for (lines, (anchor, x)) in cell.iter().zip(columns) {
        for (k, line) in lines.iter().enumerate() {
            let baseline = y + (k as f64 + 0.5) * ROW * size + text::capital_height(size) / 2.0;
            drawing.text(Text::new(line, size, [x, baseline], anchor));
        }
    }
    let middle = y + 0.5 * ROW * size;
    match row.difference {
        None => drawing.text(Text::new("no number", size, [rect.centre()[0], middle + 0.36 * size], Anchor::Middle)),
        Some(difference) => draw_mark(drawing, [x_of(difference.clamp(-ENDS, ENDS)), middle], difference, row.agrees),
    }
}

/// Draws a disc where the numbers agree, a square on its tip where they differ, and a triangle for a `difference` beyond the axis.
fn draw_mark(drawing: &mut Drawing, [x, y]: Point, difference: f64, agrees: bool) {
    let colour = if agrees { CURVES[2] } else { CURVES[1] };
    let corner = |angle: f64, radius: f64| [x + radius * libm::cos(angle), y - radius * libm::sin(angle)];
    let angle = |k: usize, of: usize| std::f64::consts::TAU * k as f64 / of as f64;
    let corners: Vec<Point> = if difference.abs() > ENDS {
        let way = difference.signum();
        vec![[x + 1.5 * MARK * way, y], [x - 0.6 * MARK * way, y - 1.2 * MARK], [x - 0.6 * MARK * way, y + 1.2 * MARK]]
    } else if agrees {
        (0..24).map(|k| corner(angle(k, 24), MARK)).collect()
    } else {
        (0..4).map(|k| corner(angle(k, 4), 1.35 * MARK)).collect()
    };
    drawing.convex(corners, colour);
}

/// Draws the legend of marks and band with its baseline at `y`, and returns its lower end.
fn draw_legend(drawing: &mut Drawing, y: f64, size: f64) -> f64 {
    let (mut x, mut y) = (BORDER, y);
    let mut entry = |drawing: &mut Drawing, draw: &dyn Fn(&mut Drawing, Point), words: &str| {
        let width = 54.0 + text::width(words, size, Weight::Regular);
        if x > BORDER && x + width > drawing.width - BORDER {
            (x, y) = (BORDER, y + 1.5 * size);
        }
        let middle = y - text::capital_height(size) / 2.0;
        draw(drawing, [x + 22.0, middle]);
        drawing.text(Text::new(words, size, [x + 54.0, y], Anchor::Start).coloured(INK));
        x += width + 0.8 * size;
    };
    entry(drawing, &|drawing, at| draw_mark(drawing, at, 0.0, true), "agrees");
    entry(drawing, &|drawing, at| draw_mark(drawing, at, 0.0, false), "differs");
    let both = |drawing: &mut Drawing, [x, middle]: Point| {
        draw_mark(drawing, [x - 15.0, middle], -2.0 * ENDS, true);
        draw_mark(drawing, [x + 9.0, middle], 2.0 * ENDS, false);
    };
    entry(drawing, &both, "beyond the axis");
    let swatch = |drawing: &mut Drawing, [x, middle]: Point| {
        let rect = Rect { x: x - 22.0, y: middle - 16.0, width: 44.0, height: 32.0 };
        drawing.convex(rect.corners().to_vec(), BAND);
    };
    entry(drawing, &swatch, "agreement");
    y + 0.3 * size
}
