//! The colour scale of a map, and the legend (colour bar) that shows it.

use super::axis::{self, Axis, Spacing};
use super::colours::{self, Colours, Shading};
use super::drawing::{Anchor, Drawing, Point, Rect, Rgb, Text};
use super::error::{FigureError, check_drawable};
use super::field::{Picture, Rgba};
use super::style::outline;
use super::text::{self, LINE_PITCH, Weight};

/// Width of the bar as a multiple of the type size.
const BAR: f64 = 1.1;
/// Space between bar and tick labels, and around the quantity.
const GAP: f64 = 12.0;
/// Overlap of the tips with the bar in pixels, so that no seam shows.
const SEAM: f64 = 1.5;
/// Number of colours in the bar.
const SHADES: usize = 128;
/// Default name of hatched cells.
pub(super) const NO_SOLUTION: &str = "no solution";
/// Longest line beside the swatch of hatched cells, as a multiple of the type size.
const LONGEST: f64 = 6.5;
/// Grey of a faint field, and its opacity at both ends of the scale.
const FAINT: u8 = 110;
const FAINTEST: [f64; 2] = [12.0, 150.0];

/// Colour scale from `low` to `high`; values beyond the ends get their colours, and `below` and `above` say whether there are any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    below: bool,
    above: bool,
    colours: Colours,
    shading: Shading,
}

impl Scale {
    /// Returns the scale over `range`, or over all `values` without one; `None` with neither a range nor a value, `Err` for a bad range.
    pub fn new(
        values: impl Iterator<Item = f64>,
        range: Option<(f64, f64)>,
        colours: Colours,
        shading: Shading,
    ) -> Result<Option<Self>, FigureError> {
        let value_range = values.fold(None, |ends: Option<(f64, f64)>, v| match ends {
            Some((low, high)) => Some((low.min(v), high.max(v))),
            None => Some((v, v)),
        });
        let full_turn = (shading == Shading::Cyclic).then_some((0.0, 360.0));
        let Some((low, high)) = range.or(full_turn) else {
            return Ok(value_range.map(|ends| {
                let (low, high) = axis::from_zero(axis::widened(ends.0, ends.1));
                Self { low, high, below: false, above: false, colours, shading }
            }));
        };
        check_drawable([low, high], || "colour range".into())?;
        if low >= high {
            return Err(FigureError::BadRange { low, high });
        }
        let (low, high) = axis::widened(low, high);
        let (least, most) = value_range.unwrap_or((low, high));
        let wraps = shading == Shading::Cyclic;
        let (below, above) = (least < low && !wraps, most > high && !wraps);
        Ok(Some(Self { low, high, below, above, colours, shading }))
    }

    /// Returns how ticks of the scale are spaced.
    fn spacing(self) -> Spacing {
        if self.shading == Shading::Cyclic { Spacing::Angular } else { Spacing::Linear }
    }

    /// Returns the colour of one of [`SHADES`] parts of the bar, from the low end.
    fn shade(self, part: usize) -> Rgba {
        self.colour(self.low + (part as f64 + 0.5) / SHADES as f64 * (self.high - self.low))
    }

    /// Returns the colour of `value`, with its opacity.
    pub fn colour(&self, value: f64) -> Rgba {
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let [r, g, b] = match self.shading {
            Shading::Cyclic => colours::cyclic_colour(value / 360.0),
            Shading::Faint => {
                let [least, most] = FAINTEST;
                return [FAINT, FAINT, FAINT, (least + share * (most - least)).round() as u8];
            }
            Shading::Ordered if self.low < 0.0 && self.high > 0.0 && self.colours != Colours::Grey => {
                colours::diverging_colour(value / self.high.max(-self.low))
            }
            Shading::Ordered => self.colours.colour_at(share),
        };
        [r, g, b, u8::MAX]
    }

    /// Returns the middle of that one of `count` equal parts of the scale in which `value` lies.
    pub(crate) fn level_centre(&self, value: f64, count: f64) -> f64 {
        let share = (value - self.low) / (self.high - self.low);
        let level = (share * count).floor().clamp(0.0, count - 1.0);
        self.low + (level + 0.5) / count * (self.high - self.low)
    }

    /// Returns the opaque colour of `value`, which is an end of the scale.
    fn end_colour(&self, value: f64) -> Rgb {
        let [r, g, b, _] = self.colour(value);
        [r, g, b]
    }
}

/// The legend of a map: a colour bar, and a hatched swatch if cells have no value. Type sizes are in pixels.
pub(super) struct ColourBar<'a> {
    pub scale: Option<Scale>,
    pub quantity: &'a str,
    /// Name of hatched cells, if there are any.
    pub missing: Option<&'a str>,
    pub size: f64,
    pub tick_size: f64,
}

impl ColourBar<'_> {
    /// Returns the axis with the ticks of a bar of `length` pixels.
    fn axis(&self, scale: Scale, length: f64) -> Axis {
        Axis::vertical(scale.low, scale.high, scale.spacing(), length, 1.3 * self.tick_size)
    }

    /// Returns the width of the bar in pixels.
    fn thickness(&self) -> f64 {
        BAR * self.size
    }

    /// Returns the height of the bar alone in a legend of this `height`, in pixels.
    fn bar_height(&self, height: f64) -> f64 {
        if self.missing.is_some() { height - self.swatch_height() - 0.7 * self.thickness() } else { height }
    }

    /// Returns the name of hatched cells, wrapped into lines.
    fn missing_lines(&self) -> Vec<String> {
        text::wrap(self.missing.unwrap_or_default(), self.tick_size, Weight::Regular, LONGEST * self.tick_size)
    }

    /// Returns the height in pixels of the swatch of hatched cells with its name.
    fn swatch_height(&self) -> f64 {
        self.thickness().max(self.missing_lines().len() as f64 * LINE_PITCH * self.tick_size)
    }

    /// Returns the quantity, with the power of ten of the labels, in lines no longer than `length` pixels.
    fn quantity_lines(&self, axis: &Axis, length: f64) -> Vec<String> {
        let quantity = axis::label_with_power(self.quantity, axis.ticks.exponent);
        text::wrap_balanced(&quantity, self.size, Weight::Regular, length)
    }

    /// Returns the width in pixels of the legend when it is `height` pixels high.
    pub fn width(&self, height: f64) -> f64 {
        let length = self.bar_height(height);
        let bar = self.scale.map_or(0.0, |scale| {
            let axis = self.axis(scale, length);
            let numbers = axis::label_width(&axis.ticks, self.tick_size);
            let quantity = self.quantity_lines(&axis, length).len() as f64 * LINE_PITCH * self.size;
            self.thickness() + 3.0 * GAP + numbers + quantity
        });
        let lines = self.missing_lines();
        let text = lines.iter().map(|line| text::width(line, self.tick_size, Weight::Regular)).fold(0.0, f64::max);
        if self.missing.is_some() { bar.max(self.thickness() + GAP + text) } else { bar }
    }

    /// Draws the legend with its upper left corner at (`x`, `y`), `height` pixels high.
    pub fn draw(&self, drawing: &mut Drawing, x: f64, y: f64, height: f64) {
        let side = self.thickness();
        if self.missing.is_some() {
            self.draw_swatch(drawing, Rect { x, y: y + height - self.swatch_height(), width: side, height: side });
        }
        if let Some(scale) = self.scale {
            self.draw_bar(drawing, scale, Rect { x, y, width: side, height: self.bar_height(height) });
        }
    }

    /// Draws the legend with its upper left corner at (`x`, `y`), `width` pixels wide, the bar lying; returns its lower end.
    pub fn draw_across(&self, drawing: &mut Drawing, x: f64, mut y: f64, width: f64) -> f64 {
        let side = self.thickness();
        if let Some(scale) = self.scale {
            // Drawn upright at the origin, and laid down.
            let tip = 0.8 * side;
            let [below, above] = [scale.below, scale.above].map(|has_tip| if has_tip { tip } else { 0.0 });
            let upright = Rect { x: 0.0, y: above, width: side, height: width - above - below };
            let place = |[across, down]: Point| [x + width - down, y + across];
            let rect = Rect { x: x + below, y, width: upright.height, height: side };
            let edges: Vec<f64> = (0..=SHADES).map(|k| k as f64).collect();
            drawing.picture(Picture::new(rect.frame(), &edges, &[0.0, 1.0], |column, _| Some(scale.shade(column))));
            draw_outline(drawing, scale, upright, tip, place);
            let axis = Axis::horizontal(scale.low, scale.high, scale.spacing(), rect.width, self.tick_size);
            for (value, label) in axis.ticks.values.iter().zip(&axis.ticks.labels) {
                let at = rect.x + rect.width * axis.fraction(*value);
                drawing.line(vec![[at, rect.bottom() - 7.0], [at, rect.bottom() + 5.0]], axis::tick_stroke());
                let half = 0.5 * text::width(label, self.tick_size, Weight::Regular);
                let at = [at.clamp(x + half, x + width - half), rect.bottom() + GAP + self.tick_size];
                drawing.text(Text::new(label, self.tick_size, at, Anchor::Middle));
            }
            y = rect.bottom() + GAP + self.tick_size;
            for line in self.quantity_lines(&axis, width) {
                y += LINE_PITCH * self.size;
                drawing.text(Text::new(line, self.size, [x + 0.5 * width, y], Anchor::Middle));
            }
            y += 0.6 * self.size;
        }
        if self.missing.is_some() {
            self.draw_swatch(drawing, Rect { x, y, width: side, height: side });
            y += self.swatch_height() + 0.4 * self.size;
        }
        y
    }

    /// Draws a hatched square at `rect` and the name of hatched cells beside it.
    fn draw_swatch(&self, drawing: &mut Drawing, rect: Rect) {
        drawing.picture(Picture::new(rect.frame(), &[0.0, 1.0], &[0.0, 1.0], |_, _| None));
        drawing.outline(&rect.corners(), outline());
        for (row, line) in self.missing_lines().into_iter().enumerate() {
            let baseline = rect.centre()[1] + text::capital_height(self.tick_size) / 2.0;
            let at = [rect.right() + GAP, baseline + row as f64 * LINE_PITCH * self.tick_size];
            drawing.text(Text::new(line, self.tick_size, at, Anchor::Start));
        }
    }

    /// Draws the bar within `area`, with pointed tips where values lie beyond its ends.
    fn draw_bar(&self, drawing: &mut Drawing, scale: Scale, area: Rect) {
        let tip = 0.8 * area.width;
        let mut rect = area;
        if scale.above {
            rect.y += tip;
            rect.height -= tip;
        }
        if scale.below {
            rect.height -= tip;
        }
        let edges: Vec<f64> = (0..=SHADES).map(|k| k as f64).collect();
        drawing.picture(Picture::new(rect.frame(), &[0.0, 1.0], &edges, |_, row| Some(scale.shade(row))));
        draw_outline(drawing, scale, rect, tip, |at| at);
        self.draw_numbers(drawing, scale, rect, area);
    }

    /// Draws ticks and their labels right of the bar `rect`, and beside them the quantity, centred on `area`.
    fn draw_numbers(&self, drawing: &mut Drawing, scale: Scale, rect: Rect, area: Rect) {
        let axis = self.axis(scale, rect.height);
        for (value, label) in axis.ticks.values.iter().zip(&axis.ticks.labels) {
            let y = rect.bottom() - rect.height * axis.fraction(*value);
            drawing.line(vec![[rect.right() - 7.0, y], [rect.right() + 5.0, y]], axis::tick_stroke());
            let at = [rect.right() + GAP, y + text::capital_height(self.tick_size) / 2.0];
            drawing.text(Text::new(label, self.tick_size, at, Anchor::Start));
        }
        let numbers = axis::label_width(&axis.ticks, self.tick_size);
        let mut x = rect.right() + 2.0 * GAP + numbers + 0.8 * self.size;
        for line in self.quantity_lines(&axis, area.height) {
            drawing.text(Text::new(line, self.size, [x, area.centre()[1]], Anchor::Middle).upward());
            x += LINE_PITCH * self.size;
        }
    }
}

/// Draws the outline of the bar `rect`, and a filled tip at each end beyond which there are values; `place` says where its points are on the page.
fn draw_outline(drawing: &mut Drawing, scale: Scale, rect: Rect, tip: f64, place: impl Fn(Point) -> Point) {
    let [left_top, right_top, right_bottom, left_bottom] = rect.corners();
    let lower = |[x, y]: Point, by: f64| [x, y + by];
    let middle = rect.centre()[0];
    let mut rim = vec![left_top];
    if scale.above {
        let top = [middle, rect.y - tip];
        let base = [lower(right_top, SEAM), lower(left_top, SEAM)];
        let corners = [left_top, top, right_top, base[0], base[1]];
        drawing.convex(corners.map(&place).to_vec(), scale.end_colour(scale.high));
        rim.push(top);
    }
    rim.extend([right_top, right_bottom]);
    if scale.below {
        let bottom = [middle, rect.bottom() + tip];
        let base = [lower(left_bottom, -SEAM), lower(right_bottom, -SEAM)];
        let corners = [right_bottom, bottom, left_bottom, base[0], base[1]];
        drawing.convex(corners.map(&place).to_vec(), scale.end_colour(scale.low));
        rim.push(bottom);
    }
    rim.push(left_bottom);
    drawing.outline(&rim.into_iter().map(place).collect::<Vec<_>>(), outline());
}
