//! The recommended place as a drawing: the part, its path and what is in the way, as a plan over the map of places and in three
//! dimensions.

use nalgebra::Vector3;

use crate::{
    answer::deflected_pose::deflected_pose,
    figures::{
        Figure, Look, PlanField, PlanFigure, PlanShape, PoseFigure, Solid, Surroundings, amplification::amplification,
    },
    files::words::{position, typographic},
    page::MachineDescription,
    process::Extent,
    questions::placement::{
        COORDINATES, Entry, Found, Metric, PlacementResults, Site, Trace, is_angle,
        report::pictures::{self, Way, cut},
    },
    spatial::Pose,
};

/// Most other places drawn.
const GHOSTS: usize = 4;

/// The plan, or `None` where there is nothing to draw.
pub(super) fn plan(results: &PlacementResults) -> Option<Figure> {
    let study = &results.study;
    let metric = shown(results);
    let number = |value: f64| typographic(&metric.shown(&study.machine, value));
    let best = results.best.as_ref();
    let mut shapes: Vec<PlanShape> = others(results)
        .into_iter()
        .map(|entry| {
            let value = entry.feasible().and_then(|evaluation| evaluation.metrics.get(metric));
            let words = value.map_or_else(|| "not possible".into(), number);
            outline(results, &entry.site, Look::Ghost, format!("{}\n{words}", entry.name))
        })
        .collect();
    shapes.extend(study.table.iter().map(|table| PlanShape {
        look: Look::Ghost,
        points: table.corners().map(|corner| (corner.x, corner.y)).to_vec(),
        label: "table".into(),
    }));
    shapes.extend(study.forbidden.iter().map(|forbidden| PlanShape {
        look: Look::InTheWay,
        points: hull(forbidden.extent.corners().map(|p| (p.x, p.y)).to_vec()),
        label: forbidden.name.clone(),
    }));
    let mut marks = Vec::new();
    if let Some(best) = best {
        shapes.push(outline(results, &best.site, Look::Part, String::new()));
        shapes.extend(room(results, &best.site));
        for (look, way) in [Look::Path, Look::Before, Look::After].into_iter().zip(Way::ALL) {
            shapes.extend(path(results, way).into_iter().map(|points| PlanShape {
                look,
                points: points.iter().map(|p| (p.x, p.y)).collect(),
                label: String::new(),
            }));
        }
        let value = results.entries[best.entry].outcome.as_ref().ok().and_then(|e| e.metrics.get(metric));
        let label = value.map_or_else(|| "best".into(), |value| format!("best\n{}", number(value)));
        marks.push((best.site.0[0], best.site.0[1], label));
    }
    let field = field(results, metric);
    if shapes.is_empty() && field.is_none() {
        return None;
    }
    let quantity = if field.is_some() { pictures::with_unit(results, metric) } else { String::new() };
    Some(Figure::Plan(Box::new(PlanFigure {
        title: best.map_or_else(
            || "No place for the part: plan of the machine".into(),
            |best| typographic(&format!("The part at its best place, {}", where_it_stands(&best.site))),
        ),
        subtitle: match &field {
            Some(_) => {
                format!("{}, seen along −z; grey: if the part's origin stood there", study.machine.short_title())
            }
            None => format!("{}, seen along −z", study.machine.short_title()),
        },
        x_label: "x of the machine [mm]".into(),
        y_label: "y of the machine [mm]".into(),
        quantity,
        field,
        shapes,
        coloured: Vec::new(),
        marks,
        note: [deviations(results), room_words(results)].into_iter().flatten().collect::<Vec<_>>().join("; "),
    })))
}

/// The number that places are drawn with: the worst deflection if the objective has it, or else its first one.
fn shown(results: &PlacementResults) -> Metric {
    let weights = &results.study.objective.weights;
    let has = |wanted: Metric| weights.iter().any(|(metric, _)| *metric == wanted);
    match weights.first() {
        Some((first, _)) if !has(Metric::WorstDeflection) => *first,
        _ => Metric::WorstDeflection,
    }
}

/// The height of a place and its turn, where it has one.
fn where_it_stands(site: &Site) -> String {
    let shown = site.shown();
    let turns = (3..COORDINATES.len()).filter(|&i| shown[i] != 0.0);
    let turns: Vec<String> = turns.map(|i| format!(", {} {:.0}°", COORDINATES[i], shown[i])).collect();
    format!("z = {:.1} mm{}", shown[2], turns.concat())
}

/// Named places near the bounds, other than the best.
fn others(results: &PlacementResults) -> Vec<&Entry> {
    let best = results.best.as_ref().map(|best| best.entry);
    let named = results.entries.iter().enumerate().filter(|(index, _)| Some(*index) != best).map(|(_, entry)| entry);
    named.filter(|entry| entry.found == Found::Named && pictures::is_near(results, &entry.site)).take(GHOSTS).collect()
}

/// The outline of the part at a place, seen along −z.
fn outline(results: &PlacementResults, site: &Site, look: Look, label: String) -> PlanShape {
    let corners = corners(&results.study.extent, &results.study.workpiece(site));
    PlanShape { look, points: hull(corners.map(|p| (p.x, p.y)).to_vec()), label }
}

fn corners(extent: &Extent, workpiece: &Pose) -> [Vector3<f64>; 8] {
    extent.corners().map(|corner| workpiece.transform(corner))
}

/// The corners in turn of the smallest convex polygon around `points` (Andrew's monotone chain).
pub fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup();
    let turn = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let half = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for point in points {
            while chain.len() > 1 && turn(chain[chain.len() - 2], chain[chain.len() - 1], point) <= 0.0 {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    if points.len() < 3 {
        return points;
    }
    let (mut lower, upper) = (half(&mut points.iter().copied()), half(&mut points.iter().rev().copied()));
    lower.extend(upper);
    lower
}

/// The traces at the best place.
fn at_best(results: &PlacementResults) -> impl Iterator<Item = &Trace> {
    let best = results.best.as_ref().map(|best| &results.entries[best.entry].name);
    results.traces.iter().filter(move |trace| Some(&trace.place) == best)
}

/// How many times as large errors are drawn.
fn factor(results: &PlacementResults) -> f64 {
    let wanted: Vec<Vector3<f64>> = at_best(results).flat_map(|trace| trace.wanted.iter().copied()).collect();
    let errors = at_best(results).flat_map(|trace| trace.before.iter().flatten());
    amplification(&wanted, errors.map(Vector3::norm).fold(0.0, f64::max))
}

/// The paths of all features at the best place, or where the tool goes along them, in pieces where it cuts.
fn path(results: &PlacementResults, way: Way) -> Vec<Vec<Vector3<f64>>> {
    let factor = factor(results);
    let along = |trace: &Trace| cut(trace, |k| Some(trace.wanted[k] + factor * way.error(trace, k)?));
    at_best(results).flat_map(along).filter(|piece| piece.len() > 1).collect()
}

/// Whatever is not farther along x and y from the best place than this is rounding, mm.
const NO_ROOM_MM: f64 = 1e-3;

/// How far the part may be moved before it matters, as a shape around the best place; along its diagonals nothing was computed.
fn room(results: &PlacementResults, site: &Site) -> Option<PlanShape> {
    let way = |coordinate: usize, direction: f64| {
        let found = results.flatness.iter().find(|room| room.coordinate == coordinate && room.direction == direction);
        found.map_or(0.0, |room| room.distance)
    };
    let ways = [way(0, -1.0), way(1, -1.0), way(0, 1.0), way(1, 1.0)];
    let [x, y, ..] = site.0;
    ways.iter().any(|way| *way > NO_ROOM_MM).then(|| PlanShape {
        look: Look::Room,
        points: vec![(x - ways[0], y), (x, y - ways[1]), (x + ways[2], y), (x, y + ways[3])],
        label: String::new(),
    })
}

/// How large deviations are drawn, where there are any.
fn deviations(results: &PlacementResults) -> Option<String> {
    let factor = factor(results);
    let has_errors = at_best(results).any(|trace| trace.before.iter().any(Option::is_some));
    has_errors.then(|| format!("deviations drawn {factor} times as large"))
}

/// The same in words, coordinate by coordinate.
fn room_words(results: &PlacementResults) -> Option<String> {
    let mut parts: Vec<String> = Vec::new();
    for (i, name) in COORDINATES.iter().enumerate() {
        let (scale, unit) = if is_angle(i) { (1f64.to_degrees(), "°") } else { (1.0, "\u{a0}mm") };
        let way = |direction: f64| {
            let mut rooms = results.flatness.iter();
            let room = rooms.find(|room| room.coordinate == i && room.direction == direction)?;
            let sign = if direction < 0.0 { '−' } else { '+' };
            Some(match format!("{:.1}", room.distance * scale).as_str() {
                "0.0" => "0".to_string(),
                length => format!("{sign}{length}"),
            })
        };
        if let (Some(down), Some(up)) = (way(-1.0), way(1.0)) {
            parts.push(format!("{name}\u{a0}{down}…{up}{unit}"));
        }
    }
    match parts.as_slice() {
        [] => None,
        parts => Some(format!("margin until it is 5 % worse (orange): {}", parts.join(", "))),
    }
}

/// The slice of the sweep nearest to the best place.
fn field(results: &PlacementResults, metric: Metric) -> Option<PlanField> {
    let study = &results.study;
    let [xs, ys, ..] = &study.grid.axes;
    if xs.len() < 2 || ys.len() < 2 {
        return None;
    }
    let base = pictures::at_best(results);
    let value = |x: usize, y: usize| {
        let mut node = base;
        (node[0], node[1]) = (x, y);
        results.cells[study.grid.index(node)].metrics()?.get(metric)
    };
    let nodes = (0..ys.len()).flat_map(|y| (0..xs.len()).map(move |x| (x, y)));
    Some(PlanField {
        x: xs.clone(),
        y: ys.clone(),
        values: nodes.map(|(x, y)| value(x, y)).collect(),
        missing: pictures::IMPOSSIBLE.into(),
    })
}

/// The machine at the recommended place, where the tool is farthest from the path, with the part, its path and what is in
/// the way; `None` without a place or a pose.
pub(super) fn in_space(results: &PlacementResults) -> Option<Figure> {
    let study = &results.study;
    let best = results.best.as_ref()?;
    let entry = &results.entries[best.entry];
    let trace = results.traces.iter().find(|trace| trace.place == entry.name)?;
    let size = |k: usize| trace.before[k].map_or(-1.0, |error| error.norm());
    let farthest = (0..trace.before.len()).reduce(|a, b| if size(b) > size(a) { b } else { a })?;
    let job = &study.features[trace.feature];
    let machine = job.machine();
    let turn = entry.turns[trace.feature].unwrap_or_default();
    let tasks = job.tasks_turned(&entry.site, turn).ok()?;
    let bent = deflected_pose(machine, &job.errors, tasks.get(farthest)?, String::new())?;
    let described = MachineDescription::new(machine);
    let solid = |name: String, corners: [Vector3<f64>; 8]| Solid { name, corners: corners.map(Into::into) };
    let in_the_way = study.forbidden.iter().map(|forbidden| solid(forbidden.name.clone(), forbidden.extent.corners()));
    let lines = |way| path(results, way).into_iter().map(|piece| piece.into_iter().map(Into::into).collect()).collect();
    let [x, y, z]: [f64; 3] = entry.site.position_mm().into();
    Some(Figure::Pose(Box::new(PoseFigure {
        title: "The machine and the part at its best place".into(),
        subtitle: format!(
            "{}, {}; where the tool is farthest from its path",
            study.machine.short_title(),
            position(x, y, z)
        ),
        pose: bent.commanded,
        displaced: None,
        rails: described.rails,
        workspace: described.workspace_mm,
        around: Surroundings {
            part: Some(solid("part".into(), corners(&study.extent, &study.workpiece(&best.site)))),
            in_the_way: in_the_way.collect(),
            paths: lines(Way::Wanted),
            before: lines(Way::Before),
            after: lines(Way::After),
        },
        note: deviations(results),
    })))
}
