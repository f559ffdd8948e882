//! Figures of the results in one style: plain data in, SVG or PNG bytes out.
//!
//! Each kind of figure lays itself out as a drawing of lines, shapes, texts and images in floating-point
//! pixels; `svg` writes it, and `png` has plotters draw it. The same data give the same bytes.

mod agreement;
mod alt;
pub(crate) mod amplification;
pub mod axis;
mod budget;
mod colour_bar;
mod colours;
mod curves;
pub mod drawing;
mod error;
pub mod field;
pub mod labels;
mod legend;
mod lines;
mod panels;
mod part;
mod plan;
pub mod png;
mod pose;
mod projection;
pub mod shapes;
mod slices;
mod style;
pub mod svg;
pub mod text;
mod theme;
mod volume;

use style::Sizes;

pub use agreement::{AgreementFigure, AgreementRow, Criterion};
pub use budget::{BudgetBar, BudgetFigure, BudgetRow};
pub use colours::{Colours, Shading, cyclic_colour, diverging_colour};
pub use error::FigureError;
pub use lines::{LineFigure, LineSeries};
pub use panels::{CurvePanel, PanelCurve, PanelFigure};
pub use part::{FaceValue, PartFigure};
pub use plan::{Look, PlanField, PlanFigure, PlanShape};
pub use pose::{PoseFigure, Solid, Surroundings};
pub use slices::{Limit, PlaneMark, SliceFigure, SlicePanel};
pub use volume::{SpaceMark, VolumeFigure};

/// One figure of any kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// Colour maps of one quantity over planes, one or more side by side.
    Slices(SliceFigure),
    /// The outer faces of a box in the workspace, coloured by a quantity and seen in three dimensions.
    Volume(VolumeFigure),
    /// Curves in one pair of axes.
    Lines(LineFigure),
    /// The same curves in several panels side by side.
    Panels(PanelFigure),
    /// Outlines of part, obstacles and paths in a plane, on axes of equal scale, optionally over a colour map.
    Plan(Box<PlanFigure>),
    /// Published numbers compared with computed ones.
    Agreement(AgreementFigure),
    /// What causes of error take of a tolerance.
    Budget(BudgetFigure),
    /// A machine drawn as lines in one or two poses.
    Pose(Box<PoseFigure>),
    /// The surface of a part, coloured by a quantity.
    Part(Box<PartFigure>),
}

impl Figure {
    /// Returns the figure as an SVG document, 1600 px wide, with maps in `colours`; texts are outlines with their words as labels. `Err`
    /// when the data contradict each other or cannot be drawn; see [`FigureError`].
    pub fn svg(&self, colours: Colours) -> Result<String, FigureError> {
        svg::svg(&self.drawing(colours)?)
    }

    /// Returns the bytes of the figure as a PNG file, 1600 px wide, with maps in `colours`; `Err` as [`Figure::svg`].
    pub fn png(&self, colours: Colours) -> Result<Vec<u8>, FigureError> {
        png::png(&self.drawing(colours)?)
    }

    /// Returns the figure for the width of a telephone, 1100 px, one panel in a row, with maps in `colours`: SVG and the bytes of a PNG file; `Err` as [`Figure::svg`].
    pub fn portrait(&self, colours: Colours) -> Result<(String, Vec<u8>), FigureError> {
        let drawing = self.laid_out(colours, Sizes::PORTRAIT)?;
        Ok((svg::svg(&drawing)?, png::png(&drawing)?))
    }

    /// Returns the SVG document `svg` with a style that turns its colours dark where the page that shows it is dark.
    pub(crate) fn with_dark_theme(svg: &str) -> String {
        svg::with_dark_theme(svg)
    }

    /// Lays the figure out as a drawing, with maps in `colours`; `Err` when its data contradict each other or cannot be drawn.
    pub fn drawing(&self, colours: Colours) -> Result<drawing::Drawing, FigureError> {
        self.laid_out(colours, Sizes::FIGURE)
    }

    /// Lays the figure out as [`Figure::drawing`], in `sizes`.
    fn laid_out(&self, colours: Colours, sizes: Sizes) -> Result<drawing::Drawing, FigureError> {
        match self {
            Self::Slices(figure) => slices::drawing(figure, colours, sizes),
            Self::Volume(figure) => volume::drawing(figure, colours, sizes),
            Self::Lines(figure) => lines::drawing(figure, sizes),
            Self::Panels(figure) => panels::drawing(figure, sizes),
            Self::Plan(figure) => plan::drawing(figure, colours, sizes),
            Self::Agreement(figure) => agreement::drawing(figure, sizes),
            Self::Budget(figure) => budget::drawing(figure, sizes),
            Self::Pose(figure) => pose::drawing(figure, sizes),
            Self::Part(figure) => part::drawing(figure, colours, sizes),
        }
    }
}
