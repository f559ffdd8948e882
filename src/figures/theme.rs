//! Colours of figures on a dark page.

use super::agreement::BAND;
use super::drawing::Rgb;
use super::plan::{OBSTACLE, PART, ROOM};
use super::style::{CURVES, GRID, HATCH, INK, MUTED, WHITE};

/// Colours of figures on a light page, each with its replacement on a dark page. Colours of maps stay.
pub(super) const DARK: [(Rgb, Rgb); 18] = [
    (WHITE, [20, 23, 27]),
    (INK, [236, 239, 243]),
    (MUTED, [170, 178, 190]),
    (GRID, [52, 58, 66]),
    (HATCH, [130, 138, 148]),
    (CURVES[0], [244, 246, 248]),
    (CURVES[1], [255, 138, 66]),
    (CURVES[2], [96, 176, 236]),
    (CURVES[3], [69, 207, 159]),
    (CURVES[4], [231, 155, 203]),
    (CURVES[5], [240, 180, 60]),
    (CURVES[6], [130, 205, 245]),
    (PART[0], [140, 192, 242]),
    (PART[1], [30, 52, 76]),
    (ROOM[0], [255, 154, 85]),
    (ROOM[1], [84, 48, 18]),
    (OBSTACLE, [255, 120, 100]),
    (BAND, [30, 62, 50]),
];
