//! Colour maps: which colour stands for which value of a map.

use std::sync::LazyLock;

use colorgrad::{BlendMode, Color, Gradient, GradientBuilder, LinearGradient};
use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

use super::drawing::Rgb;

/// Sequential colour maps, from the smallest to the largest value. Lightness rises steadily, so that a grey print keeps the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colours {
    /// Perceptually uniform, from dark violet over green to yellow.
    #[default]
    Viridis,
    /// Perceptually uniform, from dark blue over grey to yellow; looks nearly the same to readers with and without colour vision.
    ///
    /// Source: J. R. Nuñez, C. R. Anderton, R. S. Renslow, PLoS ONE 13(7), 2018.
    Cividis,
    /// From dark to light grey in even steps of lightness, apart from the ink of lines and the white of paper.
    Grey,
}

impl Colours {
    /// All colour maps.
    pub const ALL: [Colours; 3] = [Colours::Viridis, Colours::Cividis, Colours::Grey];

    /// Returns the name of the colour map.
    pub fn label(self) -> &'static str {
        match self {
            Colours::Viridis => "viridis",
            Colours::Cividis => "cividis",
            Colours::Grey => "grey",
        }
    }
}

/// How the values of a map are shown as colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// By size, from the smallest to the largest; where values lie on both sides of zero, from blue over white at zero to red.
    #[default]
    Ordered,
    /// As angles in degrees, on a closed circle of colours: 0° and 360° have the same one.
    Cyclic,
    /// In transparent grey, more opaque for larger values: a background.
    Faint,
}

/// Light at 0 and at 1, over blue to dark and back over red; the stations of `twilight` of Matplotlib (public domain).
static CYCLIC: LazyLock<LinearGradient> = LazyLock::new(|| {
    let stations = [
        [226, 217, 226],
        [158, 187, 201],
        [103, 133, 190],
        [94, 67, 165],
        [47, 20, 54],
        [125, 32, 79],
        [178, 93, 80],
        [204, 158, 142],
        [226, 217, 226],
    ];
    let colours = stations.map(|[r, g, b]| Color::from_rgba8(r, g, b, 255));
    let gradient = GradientBuilder::new().colors(&colours).mode(BlendMode::Oklab).build();
    gradient.unwrap_or_else(|e| unreachable!("nine colours make a gradient: {e}"))
});

/// Returns the colour of an angle on the cyclic colour map; `share` is the angle in turns, and whole turns do not count.
pub fn cyclic_colour(share: f64) -> Rgb {
    rgb(&CYCLIC.at((share - share.floor()) as f32))
}

/// Returns the colour of a value on a scale from −1 to 1 around zero: blue at −1, white at 0, red at 1.
pub fn diverging_colour(share: f64) -> Rgb {
    rgb(&colorgrad::preset::rd_bu().at((0.5 - 0.5 * share.clamp(-1.0, 1.0)) as f32))
}

static GREY: LazyLock<LinearGradient> = LazyLock::new(|| {
    let ends = [Color::from_rgba8(38, 38, 38, 255), Color::from_rgba8(240, 240, 240, 255)];
    let gradient = GradientBuilder::new().colors(&ends).mode(BlendMode::Oklab).build();
    gradient.unwrap_or_else(|e| unreachable!("two colours make a gradient: {e}"))
});

impl Colours {
    /// Returns the colour at a fraction 0..1 of the scale; fractions outside get the end colours.
    pub fn colour_at(self, fraction: f64) -> Rgb {
        let fraction = fraction.clamp(0.0, 1.0);
        match self {
            Colours::Viridis => {
                let RGBColor(r, g, b) = ViridisRGB.get_color(fraction);
                [r, g, b]
            }
            Colours::Cividis => rgb(&colorgrad::preset::cividis().at(fraction as f32)),
            Colours::Grey => rgb(&GREY.at(fraction as f32)),
        }
    }
}

/// Returns the channels of a colour, without its opacity.
fn rgb(colour: &Color) -> Rgb {
    let [r, g, b, _] = colour.to_rgba8();
    [r, g, b]
}
