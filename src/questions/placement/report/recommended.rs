//! Drawings of the recommended place: the part, its path and the obstacles, as a plan over the map of places and in 3-D.

use nalgebra::Vector3;

use crate::{
    answer::{clearance, deflected_pose::deflected_pose, machine::described},
    figures::{
        Figure, Look, PlanField, PlanFigure, PlanShape, PoseFigure, Solid, Surroundings, amplification::amplification,
        shapes::hull,
    },
    files::words::{position, typographic},
    process::{Extent, file::tables::cell::PART},
    questions::placement::{
        COORDINATES, End, Entry, Metric, Origin, PlacementResults, Site, Trace, is_angle,
        report::{
            headline::{distance_text, rounded_down},
            pictures::{self, PathVersion, cutting_pieces},
        },
        site::{printed_text, unit_suffix},
    },
    simulation::clearance::PathClearance,
    spatial::Pose,
};

/// Largest number of other places drawn.
const OTHERS: usize = 4;

/// Draws the plan of the recommended place; `None` where there is nothing to draw.
pub(super) fn plan_figure(results: &PlacementResults) -> Option<Figure> {
    let study = &results.study;
    let metric = drawn_metric(results);
    let best = results.best.as_ref();
    let mut shapes = Vec::new();
    shapes.extend(study.table.iter().map(|table| PlanShape {
        look: Look::Ghost,
        points: table.corners().map(|corner| (corner.x, corner.y)).to_vec(),
        label: "table".into(),
    }));
    shapes.extend(study.forbidden.iter().map(|forbidden| PlanShape {
        look: Look::Obstacle,
        points: hull(forbidden.extent.corners().map(|p| (p.x, p.y)).to_vec()),
        label: forbidden.name.clone(),
    }));
    let mut marks = Vec::new();
    if let Some(best) = best {
        let corners = workpiece_corners(&study.extent, &study.workpiece_pose(&best.site));
        let points = hull(corners.map(|p| (p.x, p.y)).to_vec());
        shapes.push(PlanShape { look: Look::Part, points, label: String::new() });
        shapes.extend(standing_bodies(results, &best.site));
        shapes.extend(margin_shape(results, &best.site));
        for (look, version) in [Look::Path, Look::Before, Look::After].into_iter().zip(PathVersion::ALL) {
            shapes.extend(drawn_paths(results, version).into_iter().map(|points| PlanShape {
                look,
                points: points.iter().map(|p| (p.x, p.y)).collect(),
                label: String::new(),
            }));
        }
        shapes.extend(nearest_line(results));
        marks.push((best.site.0[0], best.site.0[1], String::new()));
    }
    let places = nearby_named_places(results).into_iter().map(|entry| {
        let words = distance_text(study, entry).map_or_else(|| "not possible".into(), |words| typographic(&words));
        let at = (entry.site.0[0], entry.site.0[1]);
        PlanShape { look: Look::Place, points: vec![at], label: format!("{}: {words}", entry.name) }
    });
    shapes.extend(places);
    let field = sweep_slice(results, metric);
    if shapes.is_empty() && field.is_none() {
        return None;
    }
    let quantity = if field.is_some() { pictures::with_unit(results, metric) } else { String::new() };
    Some(Figure::Plan(Box::new(PlanFigure {
        title: best.map_or_else(
            || "No place for the part: plan of the machine".into(),
            |best| {
                let drawn = deviation_note(results).map_or_else(String::new, |note| format!(", {note}"));
                let value = distance_text(study, &results.entries[best.entry]);
                let value = value.map_or_else(String::new, |value| format!(" ({value})"));
                typographic(&format!("The part at its best place{value}, {}{drawn}", height_and_angles(&best.site)))
            },
        ),
        subtitle: match &field {
            Some(_) => format!(
                "{}, seen along −z; grey: if the part's origin stood there{}",
                study.machine.name,
                plane_text(results)
            ),
            None => format!("{}, seen along −z", study.machine.name),
        },
        x_label: "x of the machine [mm]".into(),
        y_label: "y of the machine [mm]".into(),
        quantity,
        field,
        shapes,
        coloured: Vec::new(),
        marks,
        note: margin_note(results).unwrap_or_default(),
    })))
}

/// Returns the metric that places are coloured by: the worst deflection if the objective has it, else the first metric of the objective.
fn drawn_metric(results: &PlacementResults) -> Metric {
    let weights = &results.study.objective.weights;
    let has = |sought: Metric| weights.iter().any(|(metric, _)| *metric == sought);
    match weights.first() {
        Some((first, _)) if !has(Metric::WorstDeflection) => *first,
        _ => Metric::WorstDeflection,
    }
}

/// Describes height and angles of a place.
fn height_and_angles(site: &Site) -> String {
    let shown = site.shown();
    let angles = (3..COORDINATES.len()).filter(|&i| shown[i] != 0.0);
    let angles: Vec<String> = angles.map(|i| format!(", {} {}°", COORDINATES[i], printed_text(shown[i]))).collect();
    format!("z = {} mm{}", printed_text(shown[2]), angles.concat())
}

/// Returns the named places near the bounds, other than the best.
fn nearby_named_places(results: &PlacementResults) -> Vec<&Entry> {
    let best = results.best.as_ref().map(|best| best.entry);
    let named = results.entries.iter().enumerate().filter(|(index, _)| Some(*index) != best).map(|(_, entry)| entry);
    named.filter(|entry| entry.found == Origin::Named && pictures::is_near(results, &entry.site)).take(OTHERS).collect()
}

/// Returns the corners of the workpiece's box `extent` (W, mm) at the pose `X_OW` `workpiece`; O, mm.
fn workpiece_corners(extent: &Extent, workpiece: &Pose) -> [Vector3<f64>; 8] {
    extent.corners().map(|corner| workpiece.transform(corner))
}

/// Returns the outlines of what stands around the part or moves with it, seen along −z, with the part at `site`.
fn standing_bodies(results: &PlacementResults, site: &Site) -> Vec<PlanShape> {
    let jobs = &results.study.features;
    let Some((job, cell)) = jobs.iter().find_map(|job| Some((job, job.bodies.as_ref()?))) else { return Vec::new() };
    let placement = site.placement(job.feature.reference);
    let bodies = cell.outlines(&cell.machine().home, &placement).into_iter().filter(|body| !body.is_moving);
    // The machine's own foot may be far away, and the part is drawn.
    let of_machine: Vec<&str> = cell.machine().listed_bodies().map(|(_, body)| body.name.as_str()).collect();
    let bodies = bodies.filter(|body| body.name != PART && !of_machine.contains(&body.name.as_str()));
    let outline = |(number, points): (usize, &Vec<[f64; 3]>), name: &str| PlanShape {
        look: Look::Body,
        points: hull(points.iter().map(|p| (p[0], p[1])).collect()),
        label: if number == 0 { name.into() } else { String::new() },
    };
    bodies
        .flat_map(|body| body.shapes_mm.iter().enumerate().map(|own| outline(own, &body.name)).collect::<Vec<_>>())
        .collect()
}

/// Returns how near bodies come along the feature of the best place along which they come nearest, its index, and where the part stands then; `None` where
/// nothing was looked at.
fn nearest_feature(results: &PlacementResults) -> Option<(usize, &Site, &PathClearance)> {
    let least = |own: &PathClearance| Some(own.nearest.as_ref()?.distance_mm);
    let known = results.clearance.iter().enumerate().filter_map(|(f, own)| own.as_ref().map(|own| (f, &own.0, &own.1)));
    let near = known.filter_map(|own| Some((least(own.2)?, own)));
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|own| own.1)
}

/// Draws the machine at the best place where bodies come nearest; `None` where nothing was looked at.
pub(super) fn clearance_figure(results: &PlacementResults) -> Option<(String, Figure)> {
    let (f, site, own) = nearest_feature(results)?;
    let job = &results.study.features[f];
    let placement = site.placement(job.feature.reference);
    clearance::figure(job.bodies.as_ref()?, &placement, Some(own))
}

/// Returns the line between the bodies that come nearest along the paths at the best place, with its length; `None` where it is not known.
fn nearest_line(results: &PlacementResults) -> Option<PlanShape> {
    let (_, _, own) = nearest_feature(results)?;
    let nearest = own.nearest.as_ref().filter(|nearest| !nearest.is_assumed)?;
    let points = nearest.points_mm.map(|[x, y, _]| (x, y)).to_vec();
    Some(PlanShape { look: Look::Nearest, points, label: clearance::nearest_words(own)? })
}

/// Returns the traces at the best place, one for each feature; none without a best place.
fn traces_at_best_place(results: &PlacementResults) -> impl Iterator<Item = &Trace> {
    let place = results.best.as_ref().map(|best| &results.entries[best.entry].name);
    results.traces.iter().filter(move |trace| Some(&trace.place) == place)
}

/// Returns the factor by which position errors are magnified in drawings.
fn error_magnification(results: &PlacementResults) -> f64 {
    let wanted: Vec<Vector3<f64>> =
        traces_at_best_place(results).flat_map(|trace| trace.wanted.iter().copied()).collect();
    let errors = traces_at_best_place(results).flat_map(|trace| trace.before.iter().flatten());
    amplification(&wanted, errors.map(Vector3::norm).fold(0.0, f64::max))
}

/// Returns the paths of all features at the best place in this version, deviations magnified, in pieces where the tool cuts; O, mm.
fn drawn_paths(results: &PlacementResults, version: PathVersion) -> Vec<Vec<Vector3<f64>>> {
    let factor = error_magnification(results);
    let along = |trace: &Trace| cutting_pieces(trace, |k| Some(trace.wanted[k] + factor * version.error(trace, k)?));
    traces_at_best_place(results).flat_map(along).filter(|piece| piece.len() > 1).collect()
}

/// Margins along x and y below this are rounding, mm.
const NO_ROOM_MM: f64 = 1e-3;

/// Returns the margins along ±x and ±y as a quadrilateral around the best place, as no others were computed; `None` if all are rounding.
fn margin_shape(results: &PlacementResults, site: &Site) -> Option<PlanShape> {
    let margin_along = |coordinate: usize, direction: f64| {
        let margin = results.flatness.iter().find(|room| room.coordinate == coordinate && room.direction == direction);
        margin.map_or(0.0, |room| room.distance)
    };
    let margins = [margin_along(0, -1.0), margin_along(1, -1.0), margin_along(0, 1.0), margin_along(1, 1.0)];
    let [x, y, ..] = site.0;
    margins.iter().any(|margin| *margin > NO_ROOM_MM).then(|| PlanShape {
        look: Look::Room,
        points: vec![(x - margins[0], y), (x, y - margins[1]), (x + margins[2], y), (x, y + margins[3])],
        label: String::new(),
    })
}

/// Returns the words for the factor by which deviations are magnified; `None` if none are drawn.
fn deviation_note(results: &PlacementResults) -> Option<String> {
    let factor = error_magnification(results);
    let has_errors = traces_at_best_place(results).any(|trace| trace.before.iter().any(Option::is_some));
    has_errors.then(|| format!("deviations ×{factor}"))
}

/// Returns the margins in words, coordinate by coordinate; `None` without any.
fn margin_note(results: &PlacementResults) -> Option<String> {
    let mut parts: Vec<String> = Vec::new();
    for (i, name) in COORDINATES.iter().enumerate() {
        let (scale, unit) = if is_angle(i) { (1f64.to_degrees(), "°") } else { (1.0, "\u{a0}mm") };
        let margin_words = |direction: f64| {
            let mut margins = results.flatness.iter();
            let margin = margins.find(|margin| margin.coordinate == i && margin.direction == direction)?;
            let sign = if direction < 0.0 { '−' } else { '+' };
            Some(match format!("{:.1}", rounded_down(margin.distance * scale)).as_str() {
                "0.0" => "0".to_string(),
                length => format!("{sign}{length}"),
            })
        };
        if let (Some(down), Some(up)) = (margin_words(-1.0), margin_words(1.0)) {
            if [&down, &up].iter().all(|way| *way == "0") {
                parts.push(format!("{name}\u{a0}not at all"));
                continue;
            }
            parts.push(format!("{name}\u{a0}{down}…{up}{unit}"));
        }
    }
    let is_bounded = results.flatness.iter().any(|margin| margin.end == End::Bound);
    let until = if is_bounded { "5 % worse, not possible or outside the search" } else { "5 % worse or not possible" };
    (!parts.is_empty()).then(|| format!("may move until {until} (orange): {}", parts.join(", ")))
}

/// Describes the plane of the sweep that is drawn, where it is not that of the best place.
fn plane_text(results: &PlacementResults) -> String {
    let Some(best) = &results.best else { return String::new() };
    let drawn =
        Site(std::array::from_fn(|i| results.study.grid.axes[i][pictures::best_grid_position(results)[i]])).shown();
    let others = (2..COORDINATES.len()).filter(|&i| (drawn[i] - best.site.shown()[i]).abs() > 1e-6);
    let text = |i: usize| typographic(&format!(", {} {}{}", COORDINATES[i], printed_text(drawn[i]), unit_suffix(i)));
    others.map(text).collect()
}

/// Returns `metric` over x and y in the slice of the sweep nearest to the best place; `None` if the sweep has only one x or only one y.
fn sweep_slice(results: &PlacementResults, metric: Metric) -> Option<PlanField> {
    let study = &results.study;
    let [xs, ys, ..] = &study.grid.axes;
    if xs.len() < 2 || ys.len() < 2 {
        return None;
    }
    let base = pictures::best_grid_position(results);
    let value = |x: usize, y: usize| {
        let mut node = base;
        (node[0], node[1]) = (x, y);
        pictures::metrics_at(results, node)?.get(metric)
    };
    let nodes = (0..ys.len()).flat_map(|y| (0..xs.len()).map(move |x| (x, y)));
    Some(PlanField {
        x: xs.clone(),
        y: ys.clone(),
        values: nodes.map(|(x, y)| value(x, y)).collect(),
        missing: pictures::IMPOSSIBLE.into(),
    })
}

/// Draws the machine in 3-D at the recommended place, at the point of all features where the uncompensated tool is farthest from its path;
/// `None` without a place or a pose.
pub(super) fn pose_figure(results: &PlacementResults) -> Option<Figure> {
    let study = &results.study;
    let best = results.best.as_ref()?;
    let entry = &results.entries[best.entry];
    let points = traces_at_best_place(results).flat_map(|trace| (0..trace.before.len()).map(move |k| (trace, k)));
    let deviation_mm = |(trace, k): (&Trace, usize)| trace.before[k].map_or(-1.0, |error| error.norm());
    let (trace, farthest) = points.reduce(|a, b| if deviation_mm(b) > deviation_mm(a) { b } else { a })?;
    let job = &study.features[trace.feature];
    let machine = job.machine();
    let gamma = entry.gammas[trace.feature].unwrap_or_default();
    let tasks = job.tasks_at_gamma(&entry.site, gamma).ok()?;
    let deflected = deflected_pose(machine, &job.tracked.errors, tasks.get(farthest)?, String::new())?;
    let described = described(machine);
    let solid = |name: String, corners: [Vector3<f64>; 8]| Solid { name, corners: corners.map(Into::into) };
    let obstacles = study.forbidden.iter().map(|forbidden| solid(forbidden.name.clone(), forbidden.extent.corners()));
    let lines =
        |way| drawn_paths(results, way).into_iter().map(|piece| piece.into_iter().map(Into::into).collect()).collect();
    let [x, y, z]: [f64; 3] = entry.site.position_mm().into();
    Some(Figure::Pose(Box::new(PoseFigure {
        title: "The machine and the part at its best place".into(),
        subtitle: format!("{}, {}; where the tool is farthest from its path", study.machine.name, position(x, y, z)),
        pose: deflected.commanded,
        displaced: None,
        rails: described.rails,
        workspace: described.workspace_mm,
        surroundings: Surroundings {
            part: Some(solid("part".into(), workpiece_corners(&study.extent, &study.workpiece_pose(&best.site)))),
            obstacles: obstacles.collect(),
            paths: lines(PathVersion::Wanted),
            before: lines(PathVersion::Before),
            after: lines(PathVersion::After),
            ..Surroundings::default()
        },
        note: deviation_note(results),
    })))
}
