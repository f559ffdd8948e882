//! Title and subtitle above every figure.

use super::scene::{Anchor, Scene, Text};
use super::style::{BORDER, MUTED, PAGE_WIDTH, Sizes};
use super::text::{self, LINE_PITCH, Weight};

/// An empty page with title and subtitle, and the y below them.
pub(super) fn page(title: &str, subtitle: &str, sizes: Sizes) -> (Scene, f64) {
    let mut scene = Scene { title: title.to_owned(), width: PAGE_WIDTH, ..Scene::default() };
    let mut y = BORDER;
    for (line, size) in lines(title, sizes.title, Weight::Bold) {
        y += sizes.title;
        scene.text(Text::new(line, size, [BORDER, y], Anchor::Start).bold());
        y += (LINE_PITCH - 1.0) * sizes.title;
    }
    y = paragraph(&mut scene, subtitle, y + 0.1 * sizes.body, sizes.body);
    (scene, y + 0.4 * sizes.body)
}

/// Wrapped muted text across the page from `y` on; returns the y below it.
pub(super) fn paragraph(scene: &mut Scene, content: &str, mut y: f64, body: f64) -> f64 {
    for (line, size) in lines(content, body, Weight::Regular) {
        y += body;
        scene.text(Text::new(line, size, [BORDER, y], Anchor::Start).coloured(MUTED));
        y += (LINE_PITCH - 1.0) * body;
    }
    y
}

/// Smallest share of its type size at which a text is rather set in one line than broken into several.
const TIGHTEST: f64 = 0.84;

/// Lines across the page, each with the type size at which it fits.
fn lines(content: &str, size: f64, weight: Weight) -> Vec<(String, f64)> {
    let limit = PAGE_WIDTH - 2.0 * BORDER;
    let tight = TIGHTEST * size;
    let broken = if text::width(content, tight, weight) <= limit {
        text::wrap(content, tight, weight, limit)
    } else {
        text::balanced(content, size, weight, limit)
    };
    broken.into_iter().map(|line| (line.clone(), text::fitting_size(&line, size, weight, limit))).collect()
}
