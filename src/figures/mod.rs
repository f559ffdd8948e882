//! Figures of the results: plain data in, SVG or PNG bytes out.
//!
//! Each kind of figure lays itself out as a scene of lines, shapes, texts and images in floating-point
//! pixels; `svg` writes it, and `png` has plotters draw it. The same data give the same bytes.

mod agreement;
mod alt;
pub(crate) mod amplification;
pub mod axis;
mod colour_bar;
mod colours;
mod curves;
mod error;
pub mod field;
pub mod labels;
mod legend;
mod lines;
mod panels;
mod plan;
pub mod png;
mod pose;
pub mod scene;
pub mod shapes;
mod slices;
mod style;
pub mod svg;
pub mod text;
mod theme;
mod volume;

pub use agreement::{AgreementFigure, AgreementRow, Meant};
pub use colours::{Colours, Shading, around_zero, of_turn};
pub use error::FigureError;
pub use lines::{LineFigure, LineSeries};
pub use panels::{CurvePanel, PanelCurve, PanelFigure};
pub use plan::{Look, PlanField, PlanFigure, PlanShape};
pub use pose::{PoseFigure, Solid, Surroundings};
pub use slices::{Mark2, SliceFigure, SlicePanel};
pub use volume::{Mark3, VolumeFigure};

/// One figure of any kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Figure {
    /// Coloured maps over planes, one or more side by side.
    Slices(SliceFigure),
    /// Coloured outside of a box, seen in three dimensions.
    Volume(VolumeFigure),
    /// Curves over two axes.
    Lines(LineFigure),
    /// Such curves in panels side by side.
    Panels(PanelFigure),
    /// Shapes over equal axes and a map.
    Plan(Box<PlanFigure>),
    /// Quoted numbers against ours.
    Agreement(AgreementFigure),
    /// A machine as lines.
    Pose(Box<PoseFigure>),
}

impl Figure {
    /// The figure as an SVG document, 1600 px wide, with maps in `colours`; texts are outlines with their words as
    /// labels.
    ///
    /// # Errors
    /// When the data contradict each other or cannot be drawn; see [`FigureError`].
    pub fn svg(&self, colours: Colours) -> Result<String, FigureError> {
        svg::svg(&self.scene(colours)?)
    }

    /// The figure as a PNG file, 1600 px wide.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn png(&self, colours: Colours) -> Result<Vec<u8>, FigureError> {
        png::png(&self.scene(colours)?)
    }

    /// The document of [`Figure::svg`], as a page shows it: in dark colours where the page is dark.
    pub(crate) fn for_page(svg: &str) -> String {
        svg::for_page(svg)
    }

    /// The figure as it is laid out, before it is written.
    ///
    /// # Errors
    /// When the data contradict each other or cannot be drawn; see [`FigureError`].
    pub fn scene(&self, colours: Colours) -> Result<scene::Scene, FigureError> {
        match self {
            Self::Slices(figure) => slices::scene(figure, colours),
            Self::Volume(figure) => volume::scene(figure, colours),
            Self::Lines(figure) => lines::scene(figure),
            Self::Panels(figure) => panels::scene(figure),
            Self::Plan(figure) => plan::scene(figure, colours),
            Self::Agreement(figure) => agreement::scene(figure),
            Self::Pose(figure) => pose::scene(figure),
        }
    }
}
