//! Figure of a machine as lines in one or two poses, seen from above, right and front.

use super::drawing::{Anchor, Drawing, Point, Rect, Rgb, Stroke, Text};
use super::error::{FigureError, check_drawable};
use super::labels::{Occupied, Spot, rect_around};
use super::legend::{self, Sample, line_sample};
use super::plan;
use super::projection::Projection;
use super::shapes::hull;
use super::style::{self, BORDER, CURVES, HATCH, INK, MUTED, Sizes, WHITE};
use super::text::{self, Weight};
use crate::spatial::{BodyOutline, Skeleton};

/// Direction of view: the eye stands at this azimuth from +x and elevation from the xy plane, in degrees.
const AZIMUTH: f64 = 32.0;
const ELEVATION: f64 = 24.0;
/// Highest drawing, in pixels.
const TALLEST: f64 = 1150.0;
/// Half side of the square of a drive, in pixels.
const MARK: f64 = 13.0;
/// Radius in pixels of the symbol of the largest mass, and the smallest radius.
const MASS: [f64; 2] = [24.0, 7.0];
/// Half the width of a spring in pixels, and its turns.
const COIL: f64 = 9.0;
const TURNS: usize = 7;
/// Length of a frame's axes as a share of the drawing's diagonal.
const FRAME: f64 = 0.09;
/// Space left and right of the drawing for labels, in pixels.
const SIDE: f64 = 150.0;

const BOX: Stroke = Stroke { colour: HATCH, width: 2.5, dash: &[10.0, 10.0] };
const RAIL: Stroke = Stroke { colour: HATCH, width: 9.0, dash: &[] };
const GHOST: Stroke = Stroke { colour: HATCH, width: 4.0, dash: &[14.0, 12.0] };
const LINK: Stroke = Stroke { colour: INK, width: 6.0, dash: &[] };
const TOOL: Stroke = Stroke { colour: CURVES[1], width: 9.0, dash: &[] };
const PART: Stroke = Stroke { colour: plan::PART[0], width: 4.5, dash: &[] };
const PATH: Stroke = Stroke { colour: INK, width: 3.5, dash: &[] };
const OBSTACLE: Stroke = Stroke { colour: plan::OBSTACLE, width: 4.5, dash: &[] };
const STANDING: Stroke = Stroke { colour: plan::OBSTACLE, width: 3.0, dash: &[] };
const MOVING: Stroke = Stroke { colour: HATCH, width: 3.0, dash: &[] };
const BENT: Stroke = Stroke { colour: CURVES[2], width: 6.0, dash: &[] };

/// A machine as lines: chains, joints, springs, masses, guideways, frames, workspace box and named points; positions in frame O.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseFigure {
    /// What is shown.
    pub title: String,
    /// Conditions of the drawing.
    pub subtitle: String,
    /// The machine as commanded (unloaded).
    pub pose: Skeleton,
    /// The loaded machine in equilibrium, drawn over it; its displacements are amplified already.
    pub displaced: Option<Skeleton>,
    /// Ends of the guideways of prismatic joints, mm.
    pub rails: Vec<[[f64; 3]; 2]>,
    /// Lower and upper corner of the workspace of P, mm; equal if there is none.
    pub workspace: [[f64; 3]; 2],
    /// Part, obstacles and tool paths around the machine.
    pub surroundings: Surroundings,
    /// Remark a reader must not miss, for example the amplification.
    pub note: Option<String>,
}

/// A box at any orientation, with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Its name.
    pub name: String,
    /// Corner k lies at the high end along the first, second and third axis where bits 0, 1 and 2 of k are set, mm.
    pub corners: [[f64; 3]; 8],
}

/// Part, obstacles and tool paths in frame O, drawn around a machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surroundings {
    /// Box around the space that the part takes.
    pub part: Option<Solid>,
    /// Boxes that the part must stay out of.
    pub obstacles: Vec<Solid>,
    /// Bodies of the machine and around it.
    pub bodies: Vec<BodyOutline>,
    /// The line between bodies that come nearest, mm, and its words.
    pub nearest: Option<([[f64; 3]; 2], String)>,
    /// Paths of the tool, mm.
    pub paths: Vec<Vec<[f64; 3]>>,
    /// Paths of the tool without compensation, mm; deviations are amplified already.
    pub before: Vec<Vec<[f64; 3]>>,
    /// Paths of the tool with compensation, mm; deviations are amplified already.
    pub after: Vec<Vec<[f64; 3]>>,
}

impl Surroundings {
    /// Yields the part and the obstacles.
    fn solids(&self) -> impl Iterator<Item = &Solid> {
        self.part.iter().chain(&self.obstacles)
    }

    /// Yields all corners of boxes and points of paths, mm.
    fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let lines = [&self.paths, &self.before, &self.after];
        let bodies = self.bodies.iter().flat_map(|body| body.shapes_mm.iter().flatten().copied());
        self.solids()
            .flat_map(|solid| solid.corners)
            .chain(bodies)
            .chain(lines.into_iter().flatten().flatten().copied())
    }
}

impl PoseFigure {
    /// Yields every point that must fit into the drawing, the origin of O included, mm.
    fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let skeletons = std::iter::once(&self.pose).chain(&self.displaced);
        let of = |s: &Skeleton| {
            let links = s.chains.iter().flat_map(|chain| chain.links.iter().flatten().copied());
            let joints = s.chains.iter().flat_map(|chain| chain.joints.iter().map(|joint| joint.position_mm));
            let springs = s.springs().flatten().copied();
            let masses = s.masses().map(|mass| mass.position_mm);
            let ends = [s.platform_mm, s.tool_tip_mm];
            links.chain(joints).chain(springs).chain(masses).chain(ends).collect::<Vec<_>>()
        };
        let ends = self.rails.iter().flatten().chain(&self.workspace).copied();
        skeletons.flat_map(of).chain(ends).chain(self.surroundings.points()).chain([[0.0; 3]])
    }

    /// Returns whether there is a workspace box to draw.
    fn has_workspace(&self) -> bool {
        self.workspace[0] != self.workspace[1]
    }

    /// Returns the stroke of a box: that of obstacles or that of the part.
    fn solid_stroke(&self, solid: &Solid) -> Stroke {
        if self.surroundings.obstacles.contains(solid) { OBSTACLE } else { PART }
    }

    /// Returns the largest mass of the machine in kg; 0 without masses.
    fn largest_mass(&self) -> f64 {
        self.pose.masses().fold(0.0, |most, mass| most.max(mass.kilograms))
    }
}

/// Where the machine stands on the page.
struct View {
    projection: Projection,
    top: f64,
    bottom: f64,
    /// Largest extent of what is drawn, mm.
    size: f64,
    sizes: Sizes,
}

impl View {
    /// Returns the projection that fits the whole figure between the page's borders, below `top`.
    fn fitted(figure: &PoseFigure, top: f64, sizes: Sizes) -> Self {
        let mut projection = Projection::new(AZIMUTH, ELEVATION);
        let corners = box_corners(figure.workspace);
        let [(x0, x1), (y0, y1)] = projection.ranges(figure.points().chain(corners));
        let room = sizes.width - 2.0 * (BORDER + SIDE);
        let scale = (room / (x1 - x0).max(1e-3)).min(TALLEST / (y1 - y0).max(1e-3));
        let slack = (room - scale * (x1 - x0)) / 2.0;
        projection.scale = scale;
        projection.origin = [BORDER + SIDE + slack - scale * x0, top + sizes.tick - scale * y0];
        let bottom = top + sizes.tick + scale * (y1 - y0);
        Self { projection, top, bottom, size: (x1 - x0).max(y1 - y0).max(1e-3), sizes }
    }

    /// Projects a point in O (mm) onto the page.
    fn project(&self, point: [f64; 3]) -> Point {
        self.projection.project(point)
    }

    /// Returns the border of a convex shape with these points in O (mm) on the page.
    fn silhouette(&self, points: &[[f64; 3]]) -> Vec<Point> {
        let projected = points.iter().map(|point| self.project(*point).into()).collect();
        hull(projected).into_iter().map(Into::into).collect()
    }

    /// Draws the projection of a polyline in O (mm).
    fn draw_line(&self, drawing: &mut Drawing, points: &[[f64; 3]], stroke: Stroke) {
        drawing.line(points.iter().map(|p| self.project(*p)).collect(), stroke);
    }
}

/// Returns the stroke of a body: one that moves with the machine or one that stands.
fn body_stroke(body: &BodyOutline) -> Stroke {
    if body.is_moving { MOVING } else { STANDING }
}

/// Returns the corners of the upright box between `low` and `high`, in the order of [`Solid::corners`].
fn box_corners([low, high]: [[f64; 3]; 2]) -> [[f64; 3]; 8] {
    std::array::from_fn(|k| std::array::from_fn(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }))
}

/// Lays the figure out; `Err` when there is no chain or a point cannot be drawn.
pub(super) fn drawing(figure: &PoseFigure, sizes: Sizes) -> Result<Drawing, FigureError> {
    check_drawable(figure.points().flatten(), || "pose figure".into())?;
    if figure.pose.chains.is_empty() {
        return Err(FigureError::Empty { what: "pose figure".into() });
    }
    let (mut drawing, top) = style::page_with_heading(&figure.title, &figure.subtitle, sizes);
    let view = View::fitted(figure, top, sizes);
    if figure.has_workspace() {
        box_edges(box_corners(figure.workspace)).for_each(|edge| view.draw_line(&mut drawing, &edge, BOX));
    }
    for rail in &figure.rails {
        view.draw_line(&mut drawing, rail, RAIL);
    }
    for solid in figure.surroundings.solids() {
        box_edges(solid.corners).for_each(|edge| view.draw_line(&mut drawing, &edge, figure.solid_stroke(solid)));
    }
    for body in &figure.surroundings.bodies {
        for shape in &body.shapes_mm {
            drawing.outline(&view.silhouette(shape), body_stroke(body));
        }
    }
    match &figure.displaced {
        None => draw_machine(&mut drawing, &view, &figure.pose, LINK, figure.largest_mass()),
        Some(displaced) => {
            draw_lines(&mut drawing, &view, &figure.pose, GHOST, GHOST);
            draw_machine(&mut drawing, &view, displaced, BENT, figure.largest_mass());
        }
    }
    let Surroundings { paths, before, after, .. } = &figure.surroundings;
    for (lines, stroke) in [(paths, PATH), (before, legend::BEFORE), (after, legend::AFTER)] {
        lines.iter().for_each(|path| view.draw_line(&mut drawing, path, stroke));
    }
    if let Some((line, _)) = &figure.surroundings.nearest {
        view.draw_line(&mut drawing, line, plan::NEAREST);
    }
    let mut occupied = occupied_areas(&view, figure);
    draw_frame(&mut drawing, &view, &mut occupied);
    draw_labels(&mut drawing, &view, figure, occupied);
    let lowest = view.bottom.max(drawing.lowest());
    let mut bottom = legend::draw(&mut drawing, legend_samples(figure), sizes.tick, lowest + 1.6 * sizes.body);
    bottom = style::draw_note(&mut drawing, figure.note.as_deref().unwrap_or_default(), bottom, sizes.body);
    drawing.height = bottom + BORDER;
    Ok(drawing)
}

/// Yields the edges of a box with these corners, as pairs of ends.
fn box_edges(corners: [[f64; 3]; 8]) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let pairs = (0..8usize).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit))).filter(|(a, b)| a != b);
    pairs.map(move |(a, b)| [corners[a], corners[b]])
}

/// Draws the links of the machine with stroke `link` and its tool, from P to T, with stroke `tool`.
fn draw_lines(drawing: &mut Drawing, view: &View, skeleton: &Skeleton, link: Stroke, tool: Stroke) {
    for line in skeleton.chains.iter().flat_map(|chain| &chain.links) {
        view.draw_line(drawing, line, link);
    }
    for rod in telescopic_legs(skeleton) {
        view.draw_line(drawing, &rod, link);
    }
    view.draw_line(drawing, &[skeleton.platform_mm, skeleton.tool_tip_mm], tool);
}

/// Yields lines from the joint before each prismatic joint to the prismatic joint: legs that extend with the prismatic joint.
fn telescopic_legs(skeleton: &Skeleton) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let pairs = skeleton.chains.iter().flat_map(|chain| chain.joints.windows(2));
    pairs.filter(|pair| pair[1].slides).map(|pair| [pair[0].position_mm, pair[1].position_mm])
}

/// Draws a machine: links, tool, springs, masses and joints.
fn draw_machine(drawing: &mut Drawing, view: &View, skeleton: &Skeleton, link: Stroke, largest_mass: f64) {
    draw_lines(drawing, view, skeleton, link, TOOL);
    for spring in skeleton.springs() {
        if let [from, to] = spring.as_slice() {
            draw_spring(drawing, view.project(*from), view.project(*to), link.colour);
        }
    }
    for mass in skeleton.masses() {
        draw_mass(drawing, view.project(mass.position_mm), libm::cbrt(mass.kilograms / largest_mass), link.colour);
    }
    for joint in skeleton.chains.iter().flat_map(|chain| &chain.joints) {
        draw_joint(drawing, view.project(joint.position_mm), joint.is_drive, link.colour);
    }
    drawing.circle(view.project(skeleton.tool_tip_mm), 0.8 * MARK, Stroke { width: 6.0, ..TOOL });
}

/// Draws a filled square for a drive, a ring for a passive joint.
fn draw_joint(drawing: &mut Drawing, [x, y]: Point, is_drive: bool, colour: Rgb) {
    let radius = if is_drive { MARK } else { 0.75 * MARK };
    if is_drive {
        drawing.convex(
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
        drawing.convex(corners.map(|a| [x + radius * libm::cos(a), y + radius * libm::sin(a)]).collect(), WHITE);
        drawing.circle([x, y], radius, Stroke { colour, width: 4.0, dash: &[] });
    }
}

/// Draws a spring as a zigzag between two straight ends.
fn draw_spring(drawing: &mut Drawing, from: Point, to: Point, colour: Rgb) {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = libm::hypot(dx, dy).max(1.0);
    let [nx, ny] = [-dy / length * COIL, dx / length * COIL];
    let turn = |k: usize| {
        let share = 0.15 + 0.7 * (k as f64 + 0.5) / TURNS as f64;
        let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        [from[0] + share * dx + side * nx, from[1] + share * dy + side * ny]
    };
    let along = |share: f64| [from[0] + share * dx, from[1] + share * dy];
    let mut points = vec![from, along(0.15)];
    points.extend((0..TURNS).map(turn));
    points.extend([along(0.85), to]);
    drawing.line(points, Stroke { colour, width: 3.5, dash: &[] });
}

/// Returns the radius in pixels of the symbol of a mass of relative `size` (1: the largest).
fn mass_radius(size: f64) -> f64 {
    (MASS[0] * size).max(MASS[1])
}

/// Draws the symbol of a centre of gravity, a disc in quarters, with the relative `size` (1: the largest).
fn draw_mass(drawing: &mut Drawing, [x, y]: Point, size: f64, colour: Rgb) {
    let radius = mass_radius(size);
    let at = |k: usize| {
        let angle = k as f64 / 40.0 * std::f64::consts::TAU;
        [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
    };
    drawing.convex((0..40).map(at).collect(), WHITE);
    for first in [0, 20] {
        drawing.convex(std::iter::once([x, y]).chain((first..=first + 10).map(at)).collect(), colour);
    }
    drawing.circle([x, y], radius, Stroke { colour, width: 2.5, dash: &[] });
}

/// Draws the axes of frame O as three arrows with their names.
fn draw_frame(drawing: &mut Drawing, view: &View, occupied: &mut Occupied) {
    let mut names = Vec::new();
    for (axis, (name, colour)) in [("x", CURVES[1]), ("y", CURVES[3]), ("z", CURVES[2])].into_iter().enumerate() {
        let mut along = [0.0; 3];
        along[axis] = FRAME * view.size;
        let (start, end) = (view.project([0.0; 3]), view.project(along));
        drawing.line(vec![start, end], Stroke { colour, width: 5.0, dash: &[] });
        let [dx, dy] = [end[0] - start[0], end[1] - start[1]];
        let reach = libm::hypot(dx, dy).max(1.0);
        let [ux, uy] = [dx / reach * 18.0, dy / reach * 18.0];
        let tip = [end[0] + ux, end[1] + uy];
        drawing
            .convex(vec![tip, [end[0] - 0.5 * uy, end[1] + 0.5 * ux], [end[0] + 0.5 * uy, end[1] - 0.5 * ux]], colour);
        occupied.marks.extend([rect_around(end, [14.0; 2])]);
        occupied.add_line(&[start, end], 6.0);
        names.push((name, colour, end));
    }
    for (name, colour, end) in names {
        draw_label(drawing, view, occupied, end, name, colour);
    }
}

/// Returns what labels keep clear of: marks of joints and masses and, if possible, the lines of the machine.
fn occupied_areas(view: &View, figure: &PoseFigure) -> Occupied {
    let mut occupied = Occupied::default();
    for skeleton in std::iter::once(&figure.pose).chain(&figure.displaced) {
        let tool = [skeleton.platform_mm, skeleton.tool_tip_mm];
        for line in skeleton.chains.iter().flat_map(|chain| &chain.links).map(Vec::as_slice).chain([&tool[..]]) {
            let points: Vec<Point> = line.iter().map(|p| view.project(*p)).collect();
            occupied.add_line(&points, 8.0);
        }
    }
    for rod in std::iter::once(&figure.pose).chain(&figure.displaced).flat_map(telescopic_legs) {
        occupied.add_line(&rod.map(|p| view.project(p)), 8.0);
    }
    for edge in figure.surroundings.solids().flat_map(|solid| box_edges(solid.corners)) {
        occupied.add_line(&edge.map(|p| view.project(p)), 8.0);
    }
    for line in &figure.rails {
        occupied.add_line(&line.map(|p| view.project(p)), 9.0);
    }
    let shown = figure.displaced.as_ref().unwrap_or(&figure.pose);
    let joints = shown.chains.iter().flat_map(|chain| &chain.joints);
    occupied.marks.extend(joints.map(|joint| rect_around(view.project(joint.position_mm), [MARK; 2])));
    let size = |kilograms: f64| mass_radius(libm::cbrt(kilograms / figure.largest_mass()));
    let masses = shown.masses().map(|mass| rect_around(view.project(mass.position_mm), [size(mass.kilograms); 2]));
    occupied.marks.extend(masses);
    occupied.marks.push(rect_around(view.project(shown.tool_tip_mm), [MARK; 2]));
    occupied
}

/// Draws the names of the chains at their first joints, of boxes, and of the tool tip.
fn draw_labels(drawing: &mut Drawing, view: &View, figure: &PoseFigure, mut occupied: Occupied) {
    let shown = figure.displaced.as_ref().unwrap_or(&figure.pose);
    let tip = view.project(shown.tool_tip_mm);
    draw_label(drawing, view, &mut occupied, tip, "tool tip T", INK);
    for solid in figure.surroundings.solids() {
        let corners = solid.corners.map(|corner| view.project(corner));
        let top = corners.into_iter().reduce(|a, b| if b[1] < a[1] { b } else { a }).unwrap_or_default();
        draw_label(drawing, view, &mut occupied, top, &solid.name, figure.solid_stroke(solid).colour);
    }
    if let Some(([from, to], words)) = &figure.surroundings.nearest {
        let middle = std::array::from_fn(|i| 0.5 * (from[i] + to[i]));
        draw_label(drawing, view, &mut occupied, view.project(middle), words, plan::NEAREST.colour);
    }
    for body in figure.surroundings.bodies.iter().filter(|body| !body.is_moving) {
        let corners = body.shapes_mm.iter().flatten().map(|corner| view.project(*corner));
        let top = corners.reduce(|a, b| if b[1] < a[1] { b } else { a }).unwrap_or_default();
        draw_label(drawing, view, &mut occupied, top, &body.name, STANDING.colour);
    }
    for chain in &shown.chains {
        let Some(first) = chain.joints.first() else { continue };
        let at = view.project(first.position_mm);
        draw_label(drawing, view, &mut occupied, at, &format!("chain {}", chain.name), INK);
    }
}

/// Places and draws a label beside the point `at` on the page.
fn draw_label(drawing: &mut Drawing, view: &View, occupied: &mut Occupied, at: Point, words: &str, colour: Rgb) {
    let half = [
        text::width(words, view.sizes.tick, Weight::Bold) / 2.0 + 0.12 * view.sizes.tick,
        text::capital_height(view.sizes.tick) / 2.0 + 0.12 * view.sizes.tick,
    ];
    let page = Rect {
        x: BORDER,
        y: view.top,
        width: view.sizes.width - 2.0 * BORDER,
        height: view.bottom - view.top + view.sizes.tick,
    };
    let Spot { rect, leader } = occupied.place_label(at, MARK, half, page);
    if let Some(leader) = leader {
        drawing.line(leader.to_vec(), Stroke { colour: MUTED, width: 2.0, dash: &[] });
    }
    let place = [rect.centre()[0], rect.centre()[1] + text::capital_height(view.sizes.tick) / 2.0];
    drawing.text(Text::new(words, view.sizes.tick, place, Anchor::Middle).bold().coloured(colour).with_halo());
}

/// Returns the legend entries for what the figure shows.
fn legend_samples(figure: &PoseFigure) -> Vec<Sample<'_>> {
    let colour = if figure.displaced.is_some() { BENT.colour } else { LINK.colour };
    let joint = move |is_drive| {
        Box::new(move |drawing: &mut Drawing, [x, y]: Point| draw_joint(drawing, [x + 35.0, y], is_drive, colour))
    };
    let mut samples: Vec<Sample<'_>> = Vec::new();
    if figure.displaced.is_some() {
        samples.push((line_sample(GHOST), "as commanded"));
        samples.push((line_sample(BENT), "in equilibrium"));
    }
    samples.push((joint(true), "drive"));
    if figure.pose.chains.iter().flat_map(|chain| &chain.joints).any(|joint| !joint.is_drive) {
        samples.push((joint(false), "passive joint"));
    }
    samples.push((line_sample(TOOL), "tool, P to T"));
    if figure.pose.springs().next().is_some() {
        let draw = move |drawing: &mut Drawing, [x, y]: Point| draw_spring(drawing, [x, y], [x + 70.0, y], colour);
        samples.push((Box::new(draw), "spring"));
    }
    if figure.largest_mass() > 0.0 {
        let draw = move |drawing: &mut Drawing, [x, y]: Point| draw_mass(drawing, [x + 35.0, y], 0.6, colour);
        samples.push((Box::new(draw), "mass (diameter: cube root)"));
    }
    if !figure.rails.is_empty() {
        samples.push((line_sample(RAIL), "way of a prismatic joint"));
    }
    if figure.surroundings.part.is_some() {
        samples.push((line_sample(PART), "space of the part"));
    }
    for (is_moving, words) in [(true, "body of machine or tool"), (false, "body that stands")] {
        if let Some(body) = figure.surroundings.bodies.iter().find(|body| body.is_moving == is_moving) {
            samples.push((line_sample(body_stroke(body)), words));
        }
    }
    if figure.surroundings.nearest.is_some() {
        samples.push((line_sample(plan::NEAREST), "least distance of bodies"));
    }
    if !figure.surroundings.paths.is_empty() {
        samples.push((line_sample(PATH), "path"));
    }
    if !figure.surroundings.before.is_empty() {
        samples.push((line_sample(legend::BEFORE), legend::BEFORE_WORDS));
    }
    if !figure.surroundings.after.is_empty() {
        samples.push((line_sample(legend::AFTER), legend::AFTER_WORDS));
    }
    if figure.has_workspace() {
        samples.push((line_sample(BOX), "workspace of P"));
    }
    samples
}
