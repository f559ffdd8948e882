//! A machine in one or two poses, seen from above, right and front.

use super::error::{FigureError, check_drawable};
use super::scene::{Anchor, Point, Rgb, Scene, Stroke, Text};
use super::style::{self, BORDER, CURVES, HATCH, INK, MUTED, PAGE_WIDTH, Sizes, WHITE};
use super::text::{self, Weight};
use crate::machine::Skeleton;

const SIZES: Sizes = Sizes::COLUMN;
/// Direction of view: the eye stands at this azimuth from +x and elevation from the xy plane, in degrees.
const AZIMUTH: f64 = 32.0;
const ELEVATION: f64 = 24.0;
/// Highest drawing.
const TALLEST: f64 = 1150.0;
/// Side of the mark of a drive.
const MARK: f64 = 13.0;
/// Length of a frame's axes as a share of the drawing's diagonal.
const FRAME: f64 = 0.09;
/// Space left and right of the drawing for labels.
const SIDE: f64 = 150.0;

const BOX: Stroke = Stroke { colour: HATCH, width: 2.5, dash: &[10.0, 10.0] };
const RAIL: Stroke = Stroke { colour: HATCH, width: 9.0, dash: &[] };
const GHOST: Stroke = Stroke { colour: HATCH, width: 4.0, dash: &[14.0, 12.0] };
const LINK: Stroke = Stroke { colour: INK, width: 6.0, dash: &[] };
const TOOL: Stroke = Stroke { colour: CURVES[1], width: 9.0, dash: &[] };
const BENT: Stroke = Stroke { colour: CURVES[2], width: 6.0, dash: &[] };

/// A machine as lines: chains, joints, the ways of its slides, frames, the workspace box and named points.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseFigure {
    /// What is shown.
    pub title: String,
    /// The setting.
    pub subtitle: String,
    /// The machine as commanded.
    pub pose: Skeleton,
    /// The same machine displaced, drawn over it; displacements are amplified already.
    pub displaced: Option<Skeleton>,
    /// Ends of the ways of slides, mm.
    pub rails: Vec<[[f64; 3]; 2]>,
    /// Lower and upper corner of the workspace of P, mm; equal where there is none.
    pub workspace: [[f64; 3]; 2],
    /// A remark a reader must not miss, for example the amplification.
    pub note: Option<String>,
}

impl PoseFigure {
    fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let skeletons = std::iter::once(&self.pose).chain(&self.displaced);
        let of = |s: &Skeleton| {
            let links = s.chains.iter().flat_map(|chain| chain.links.iter().flatten().copied());
            let joints = s.chains.iter().flat_map(|chain| chain.joints.iter().map(|joint| joint.position_mm));
            links.chain(joints).chain([s.platform_mm, s.tool_tip_mm]).collect::<Vec<_>>()
        };
        let ends = self.rails.iter().flatten().chain(&self.workspace).copied();
        skeletons.flat_map(of).chain(ends).chain([[0.0; 3]])
    }

    fn has_workspace(&self) -> bool {
        self.workspace[0] != self.workspace[1]
    }
}

/// A parallel projection onto the page.
struct View {
    right: [f64; 3],
    up: [f64; 3],
    scale: f64,
    origin: Point,
    bottom: f64,
    /// Largest extent of what is shown, mm.
    size: f64,
}

impl View {
    fn fitted(figure: &PoseFigure, top: f64) -> Self {
        let (az, el) = (AZIMUTH.to_radians(), ELEVATION.to_radians());
        let mut view = Self {
            right: [-az.sin(), az.cos(), 0.0],
            up: [-el.sin() * az.cos(), -el.sin() * az.sin(), el.cos()],
            scale: 1.0,
            origin: [0.0, 0.0],
            bottom: top,
            size: 1.0,
        };
        let corners = box_corners(figure.workspace);
        let places: Vec<Point> = figure.points().chain(corners).map(|p| view.place(p)).collect();
        let span = |axis: usize| {
            let values = places.iter().map(|p| p[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((x0, x1), (y0, y1)) = (span(0), span(1));
        view.size = (x1 - x0).max(y1 - y0).max(1e-3);
        let room = PAGE_WIDTH - 2.0 * (BORDER + SIDE);
        view.scale = (room / (x1 - x0).max(1e-3)).min(TALLEST / (y1 - y0).max(1e-3));
        let slack = (room - view.scale * (x1 - x0)) / 2.0;
        view.origin = [BORDER + SIDE + slack - view.scale * x0, top + SIZES.tick - view.scale * y0];
        view.bottom = top + SIZES.tick + view.scale * (y1 - y0);
        view
    }

    fn place(&self, point: [f64; 3]) -> Point {
        let dot = |along: [f64; 3]| (0..3).map(|axis| along[axis] * point[axis]).sum::<f64>();
        [self.origin[0] + self.scale * dot(self.right), self.origin[1] - self.scale * dot(self.up)]
    }

    fn line(&self, scene: &mut Scene, points: &[[f64; 3]], stroke: Stroke) {
        scene.line(points.iter().map(|p| self.place(*p)).collect(), stroke);
    }
}

fn box_corners([low, high]: [[f64; 3]; 2]) -> [[f64; 3]; 8] {
    std::array::from_fn(|k| std::array::from_fn(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }))
}

pub(super) fn scene(figure: &PoseFigure) -> Result<Scene, FigureError> {
    check_drawable(figure.points().flatten(), || "pose figure".into())?;
    if figure.pose.chains.is_empty() {
        return Err(FigureError::Empty { what: "pose figure".into() });
    }
    let (mut scene, top) = style::page(&figure.title, &figure.subtitle, SIZES);
    let view = View::fitted(figure, top);
    if figure.has_workspace() {
        draw_box(&mut scene, &view, figure.workspace);
    }
    for rail in &figure.rails {
        view.line(&mut scene, rail, RAIL);
    }
    match &figure.displaced {
        None => draw_machine(&mut scene, &view, &figure.pose, LINK),
        Some(displaced) => {
            draw_lines(&mut scene, &view, &figure.pose, GHOST, GHOST);
            draw_machine(&mut scene, &view, displaced, BENT);
        }
    }
    draw_frame(&mut scene, &view);
    draw_labels(&mut scene, &view, figure);
    let mut bottom = draw_legend(&mut scene, figure, view.bottom + 1.6 * SIZES.body);
    if let Some(note) = &figure.note {
        for line in text::wrap(note, SIZES.body, Weight::Bold, PAGE_WIDTH - 2.0 * BORDER) {
            bottom += 1.3 * SIZES.body;
            scene.text(Text::new(line, SIZES.body, [BORDER, bottom], Anchor::Start).bold());
        }
    }
    scene.height = bottom + BORDER;
    Ok(scene)
}

fn draw_box(scene: &mut Scene, view: &View, workspace: [[f64; 3]; 2]) {
    let corners = box_corners(workspace);
    for (a, b) in (0..8usize).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit))).filter(|(a, b)| a != b) {
        view.line(scene, &[corners[a], corners[b]], BOX);
    }
}

fn draw_lines(scene: &mut Scene, view: &View, skeleton: &Skeleton, link: Stroke, tool: Stroke) {
    for line in skeleton.chains.iter().flat_map(|chain| &chain.links) {
        view.line(scene, line, link);
    }
    view.line(scene, &[skeleton.platform_mm, skeleton.tool_tip_mm], tool);
}

fn draw_machine(scene: &mut Scene, view: &View, skeleton: &Skeleton, link: Stroke) {
    draw_lines(scene, view, skeleton, link, TOOL);
    for joint in skeleton.chains.iter().flat_map(|chain| &chain.joints) {
        draw_joint(scene, view.place(joint.position_mm), joint.is_drive, link.colour);
    }
    scene.circle(view.place(skeleton.tool_tip_mm), 0.8 * MARK, Stroke { width: 6.0, ..TOOL });
}

/// A filled square for a drive, a ring for a joint without.
fn draw_joint(scene: &mut Scene, [x, y]: Point, is_drive: bool, colour: Rgb) {
    let radius = if is_drive { MARK } else { 0.75 * MARK };
    if is_drive {
        scene.convex(
            vec![
                [x - radius, y - radius],
                [x + radius, y - radius],
                [x + radius, y + radius],
                [x - radius, y + radius],
            ],
            colour,
        );
    } else {
        let corners = (0..20).map(|k| f64::from(k) / 20.0 * std::f64::consts::TAU);
        scene.convex(corners.map(|a| [x + radius * a.cos(), y + radius * a.sin()]).collect(), WHITE);
        scene.circle([x, y], radius, Stroke { colour, width: 4.0, dash: &[] });
    }
}

/// Frame O: three arrows with their names.
fn draw_frame(scene: &mut Scene, view: &View) {
    for (axis, (name, colour)) in [("x", CURVES[1]), ("y", CURVES[3]), ("z", CURVES[2])].into_iter().enumerate() {
        let mut along = [0.0; 3];
        along[axis] = FRAME * view.size;
        let (start, end) = (view.place([0.0; 3]), view.place(along));
        let stroke = Stroke { colour, width: 5.0, dash: &[] };
        scene.line(vec![start, end], stroke);
        let [dx, dy] = [end[0] - start[0], end[1] - start[1]];
        let reach = dx.hypot(dy).max(1.0);
        let [ux, uy] = [dx / reach * 18.0, dy / reach * 18.0];
        let tip = [end[0] + ux, end[1] + uy];
        scene.convex(vec![tip, [end[0] - 0.5 * uy, end[1] + 0.5 * ux], [end[0] + 0.5 * uy, end[1] - 0.5 * ux]], colour);
        let at = [end[0] + 2.0 * ux, end[1] + 2.0 * uy + text::capital_height(SIZES.tick) / 2.0];
        scene.text(Text::new(name, SIZES.tick, at, Anchor::Middle).bold().coloured(colour).with_halo());
    }
}

/// Names of the chains at their first joints, and of the tool tip.
fn draw_labels(scene: &mut Scene, view: &View, figure: &PoseFigure) {
    let shown = figure.displaced.as_ref().unwrap_or(&figure.pose);
    let centre = view.place(shown.platform_mm);
    for chain in &shown.chains {
        let Some(first) = chain.joints.first() else { continue };
        let at = view.place(first.position_mm);
        let away = [at[0] - centre[0], at[1] - centre[1]];
        let reach = away[0].hypot(away[1]).max(1.0);
        let label = format!("chain {}", chain.name);
        let half_width = text::width(&label, SIZES.tick, Weight::Bold) / 2.0;
        let shift = MARK + 0.8 * SIZES.tick;
        let x = at[0] + away[0] / reach * (shift + half_width * 0.4);
        let x = x.clamp(BORDER + half_width, PAGE_WIDTH - BORDER - half_width);
        let y = at[1] + if away[1] > 0.0 { shift + 0.4 * SIZES.tick } else { -shift };
        scene.text(Text::new(label, SIZES.tick, [x, y], Anchor::Middle).bold().with_halo());
    }
    let tip = view.place(shown.tool_tip_mm);
    scene.text(Text::new("tool tip T", SIZES.tick, [tip[0] + 2.0 * MARK, tip[1]], Anchor::Start).bold().with_halo());
}

/// One entry of the legend: how it is drawn at a place, and its words.
type Sample<'a> = (Box<dyn Fn(&mut Scene, Point) + 'a>, &'static str);

fn samples(figure: &PoseFigure) -> Vec<Sample<'_>> {
    let colour = if figure.displaced.is_some() { BENT.colour } else { LINK.colour };
    let joint = move |is_drive| {
        Box::new(move |scene: &mut Scene, [x, y]: Point| draw_joint(scene, [x + 35.0, y], is_drive, colour))
    };
    let line = |stroke: Stroke| {
        Box::new(move |scene: &mut Scene, [x, y]: Point| scene.line(vec![[x, y], [x + 70.0, y]], stroke))
    };
    let mut samples: Vec<Sample<'_>> = Vec::new();
    if figure.displaced.is_some() {
        samples.push((line(GHOST), "as commanded"));
        samples.push((line(BENT), "as it settles"));
    }
    samples.push((joint(true), "drive"));
    samples.push((joint(false), "passive joint"));
    samples.push((line(TOOL), "tool, P to T"));
    if !figure.rails.is_empty() {
        samples.push((line(RAIL), "way of a slide"));
    }
    if figure.has_workspace() {
        samples.push((line(BOX), "workspace of P"));
    }
    samples
}

fn draw_legend(scene: &mut Scene, figure: &PoseFigure, top: f64) -> f64 {
    let (mut x, mut y) = (BORDER, top);
    for (draw, words) in samples(figure) {
        let width = 86.0 + text::width(words, SIZES.tick, Weight::Regular);
        if x > BORDER && x + width > PAGE_WIDTH - BORDER {
            x = BORDER;
            y += 1.5 * SIZES.tick;
        }
        draw(scene, [x, y - text::capital_height(SIZES.tick) / 2.0]);
        scene.text(Text::new(words, SIZES.tick, [x + 86.0, y], Anchor::Start).coloured(MUTED));
        x += width + 1.1 * SIZES.tick;
    }
    y + 0.4 * SIZES.tick
}
