//! Figure of what a verdict rests on: what each cause of error takes of the tolerance, and which nobody knows.

use super::axis::{self, Axis, Plot, Spacing};
use super::drawing::{Anchor, Drawing, Rect, Rgb, Stroke, Text};
use super::error::{FigureError, check_drawable};
use super::style::{self, BORDER, CURVES, GRID, HATCH, MUTED, Sizes, outline};
use super::text::{self, Weight};

/// Height of a row, and of its bar, as multiples of the type size.
const ROW: f64 = 1.42;
const BAR: f64 = 0.8;
const GAP: f64 = 24.0;
/// Widest column of labels and of words, as shares of the page.
const WIDEST: [f64; 2] = [0.3, 0.3];
/// The same on the width of a telephone.
const WIDEST_OF_PORTRAIT: [f64; 2] = [0.33, 0.3];
/// Distance of the lines that hatch what nobody knows.
const HATCHED: f64 = 22.0;
/// Colour of what goes away if a cause is perfectly known.
const REST: Rgb = [205, 213, 222];
/// Colour of the tolerance.
const TOLERANCE: Rgb = CURVES[1];

/// What is drawn of a cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BudgetBar {
    /// A length, mm.
    Length(f64),
    /// What is left of a total if the cause were perfectly known, and the total, mm.
    IfKnown([f64; 2]),
    /// Nobody knows it.
    Unknown,
}

/// A cause of error.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetRow {
    /// Its mark and name.
    pub label: String,
    /// Its bar.
    pub bar: BudgetBar,
    /// Numbers beside the bar.
    pub words: String,
}

/// Causes of error, one bar each, over one axis in millimetres.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetFigure {
    /// What it shows.
    pub title: String,
    /// What the bars are.
    pub subtitle: String,
    /// The tolerance, drawn as a line, mm.
    pub tolerance_mm: Option<f64>,
    /// The causes, in the order shown.
    pub rows: Vec<BudgetRow>,
}

impl BudgetFigure {
    /// Returns all lengths, mm.
    pub(super) fn lengths(&self) -> impl Iterator<Item = f64> {
        let of_row = |row: &BudgetRow| match row.bar {
            BudgetBar::Length(mm) => vec![mm],
            BudgetBar::IfKnown(both) => both.to_vec(),
            BudgetBar::Unknown => Vec::new(),
        };
        self.rows.iter().flat_map(of_row).chain(self.tolerance_mm)
    }
}

/// Lays the figure out; `Err` when it has no rows or a length cannot be drawn.
pub(super) fn drawing(figure: &BudgetFigure, sizes: Sizes) -> Result<Drawing, FigureError> {
    if figure.rows.is_empty() {
        return Err(FigureError::Empty { what: "figure of a budget".into() });
    }
    check_drawable(figure.lengths(), || "budget".into())?;
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let (size, room) = (sizes.body, sizes.width - 2.0 * BORDER);
    let widest = if sizes.is_portrait() { WIDEST_OF_PORTRAIT } else { WIDEST };
    let lines = |content: &str, share: f64| text::wrap(content, size, Weight::Regular, share * room);
    let cells: Vec<[Vec<String>; 2]> =
        figure.rows.iter().map(|row| [lines(&row.label, widest[0]), lines(&row.words, widest[1])]).collect();
    let width = |column: usize| {
        let all = cells.iter().flat_map(|cell| &cell[column]);
        all.map(|line| text::width(line, size, Weight::Regular)).fold(0.0, f64::max)
    };
    let (left, right) = (BORDER + width(0) + GAP, sizes.width - BORDER - width(1) - GAP);
    let heights: Vec<f64> =
        cells.iter().map(|cell| cell.iter().map(Vec::len).max().unwrap_or(1) as f64 * ROW * size).collect();
    let rect = Rect { x: left, y: top, width: right - left, height: heights.iter().sum() };
    let most = figure.lengths().fold(0.0, f64::max);
    let most = if most > 0.0 { 1.12 * most } else { 1.0 };
    let plot = Plot {
        rect,
        x: Axis::horizontal(0.0, most, Spacing::Linear, rect.width, sizes.tick),
        y: Axis::vertical(0.0, 1.0, Spacing::Linear, 1.0, sizes.tick),
    };
    let x_of = |mm: f64| plot.page_point(mm, 0.0)[0];
    let mut y = top;
    for ((row, [label, words]), height) in figure.rows.iter().zip(&cells).zip(&heights) {
        drawing.line(vec![[BORDER, y], [sizes.width - BORDER, y]], Stroke { colour: GRID, width: 2.0, dash: &[] });
        for (lines, x) in [(label, BORDER), (words, right + GAP)] {
            for (k, line) in lines.iter().enumerate() {
                let baseline = y + (k as f64 + 0.5) * ROW * size + text::capital_height(size) / 2.0;
                drawing.text(Text::new(line, size, [x, baseline], Anchor::Start));
            }
        }
        let between = |from: f64, to: f64| {
            let (from, inset) = (x_of(from), 0.5 * (ROW - BAR) * size);
            Rect { x: from, y: y + inset, width: x_of(to) - from, height: BAR * size }
        };
        match row.bar {
            BudgetBar::Length(mm) => drawing.convex(between(0.0, mm).corners().to_vec(), CURVES[0]),
            BudgetBar::IfKnown([left, total]) => {
                drawing.convex(between(0.0, left.min(total)).corners().to_vec(), CURVES[0]);
                drawing.convex(between(left.min(total), total).corners().to_vec(), REST);
            }
            BudgetBar::Unknown => hatch(&mut drawing, between(0.0, most)),
        }
        y += height;
    }
    if let Some(tolerance) = figure.tolerance_mm {
        let x = x_of(tolerance);
        let stroke = Stroke { colour: TOLERANCE, width: 5.0, dash: &[14.0, 8.0] };
        drawing.line(vec![[x, rect.y], [x, rect.bottom()]], stroke);
    }
    drawing.outline(&rect.corners(), outline());
    plot.draw_x_axis(&mut drawing, "mm", size, sizes.tick);
    let below = rect.bottom() + axis::depth_below(sizes.tick) + 2.6 * size;
    drawing.height = legend(&mut drawing, figure, below, size) + BORDER;
    Ok(drawing)
}

/// Hatches `rect`.
fn hatch(drawing: &mut Drawing, rect: Rect) {
    let stroke = Stroke { colour: HATCH, width: 3.0, dash: &[] };
    let count = ((rect.width + rect.height) / HATCHED).ceil() as usize;
    for k in 0..count {
        let x = rect.x - rect.height + (k as f64 + 0.5) * HATCHED;
        let from = ((rect.x - x) / rect.height).max(0.0);
        let to = ((rect.right() - x) / rect.height).min(1.0);
        if from < to {
            let at = |share: f64| [x + share * rect.height, rect.bottom() - share * rect.height];
            drawing.line(vec![at(from), at(to)], stroke);
        }
    }
    drawing.outline(&rect.corners(), Stroke { colour: HATCH, width: 2.0, dash: &[] });
}

/// Draws what bars and line mean with its baseline at `y`, and returns its lower end.
fn legend(drawing: &mut Drawing, figure: &BudgetFigure, y: f64, size: f64) -> f64 {
    let (mut x, mut y) = (BORDER, y);
    let mut entry = |drawing: &mut Drawing, draw: &dyn Fn(&mut Drawing, Rect), words: &str| {
        let width = 64.0 + text::width(words, size, Weight::Regular);
        if x > BORDER && x + width > drawing.width - BORDER {
            (x, y) = (BORDER, y + 1.5 * size);
        }
        let middle = y - text::capital_height(size) / 2.0;
        draw(drawing, Rect { x, y: middle - 16.0, width: 48.0, height: 32.0 });
        drawing.text(Text::new(words, size, [x + 64.0, y], Anchor::Start).coloured(MUTED));
        x += width + 0.8 * size;
    };
    let filled = |colour: Rgb| move |drawing: &mut Drawing, rect: Rect| drawing.convex(rect.corners().to_vec(), colour);
    let any = |is: &dyn Fn(&BudgetBar) -> bool| figure.rows.iter().any(|row| is(&row.bar));
    if any(&|bar| matches!(bar, BudgetBar::IfKnown(_))) {
        entry(drawing, &filled(CURVES[0]), "left if this were perfectly known");
        entry(drawing, &filled(REST), "what it takes");
    }
    if any(&|bar| *bar == BudgetBar::Unknown) {
        entry(drawing, &|drawing, rect| hatch(drawing, rect), "nobody knows how much");
    }
    if figure.tolerance_mm.is_some() {
        let line = |drawing: &mut Drawing, rect: Rect| {
            let stroke = Stroke { colour: TOLERANCE, width: 5.0, dash: &[14.0, 8.0] };
            drawing.line(vec![[rect.x, rect.centre()[1]], [rect.right(), rect.centre()[1]]], stroke);
        };
        entry(drawing, &line, "tolerance");
    }
    y + 0.3 * size
}
