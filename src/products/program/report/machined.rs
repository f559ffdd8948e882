//! What is left on the part: the surface that a program machines from its stock, without compensation and as written.

use std::collections::BTreeSet;

use kinetostat_removal::Patch;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

use super::{
    Report,
    against::{PartSides, ToolSides, tolerance_mm},
    findings::LINES,
};
use crate::{
    figures::{FaceValue, Figure, LineFigure, LineSeries, PartFigure},
    files::{
        exchange::Surface,
        words::{millimetres, percent},
    },
    input::error::Result,
    page::{
        PartView, Section, SmallTable,
        headline::{KeyNumber, Verdict},
    },
    process::machined::{Course, GOUGE_MM, MachinedSurface},
    products::program::{
        ProgramAsWritten, ProgramJob, VerifiedPart,
        surface::{CourseSpread, SurfaceSpread},
    },
    questions::spread_report::probable_state,
    simulation::{Source, along_path::PathPointResult},
    work::Work,
};

/// Errors of the tool along a program that cuts stock (W, mm), without compensation and as written; `None` without equilibrium.
#[derive(Debug)]
pub(super) struct Courses {
    /// `R_OW`.
    turn: Matrix3<f64>,
    errors: [Vec<Option<Vector3<f64>>>; 2],
    /// How the tool is rotated there, rotation vectors in W, rad.
    rotations: [Vec<Vector3<f64>>; 2],
}

impl Courses {
    /// Begins the courses of `job`; `None` if it cuts no stock.
    pub fn new(job: &ProgramJob) -> Option<Self> {
        job.process.stock.as_ref()?;
        let turn = job.process.placement.place(&job.machine).workpiece().rotation;
        let points = job.path.len();
        let (errors, rotations) =
            ([0, 1].map(|_| Vec::with_capacity(points)), [0, 1].map(|_| Vec::with_capacity(points)));
        Some(Self { turn, errors, rotations })
    }

    /// Adds the points of the next verified part.
    pub fn add(&mut self, verified: &VerifiedPart<'_>) {
        let turned = |error: &Option<Vector3<f64>>| error.map(|error| self.turn.tr_mul(&error));
        self.errors[0].extend(verified.before[Source::All].iter().map(turned));
        self.errors[1].extend(verified.written.iter().map(|answer| turned(&PathPointResult::solved_error(answer))));
        self.rotations[0].extend(verified.rotations_before.iter().map(|own| self.turn.tr_mul(own)));
        self.rotations[1].extend(verified.written.iter().map(|answer| self.turn.tr_mul(&answer.residual_rotation)));
    }

    /// Returns the surface that is left by the program as `written`, called `name`, and its distribution where inputs are uncertain.
    ///
    /// # Errors
    /// As [`StockRemoval::machined`](crate::process::stock::StockRemoval); of `work`.
    pub fn surface(
        self,
        job: &ProgramJob,
        written: &ProgramAsWritten,
        name: &str,
        work: &Work,
    ) -> Result<Option<Machined>> {
        let Some(stock) = &job.process.stock else { return Ok(None) };
        let courses = [0, 1].map(|k| Course { errors_mm: &self.errors[k], rotations: &self.rotations[k] });
        let surface = stock.machined(&job.path, &job.process.placement.place(&job.machine), &courses, name)?;
        let tolerance = |patch: &Patch| tolerance_mm(job, patch.tag);
        let sides = [0, 1].map(|course| Side::new(&surface, &surface.deviations[course], &tolerance, &|_| true));
        let part = PartSides::new(&surface, job);
        let spread = job.surface_spread(&surface, &self.rotations, written, &tolerance, work)?;
        let mut machined = Machined { surface, errors: self.errors, sides, part, tools: Vec::new(), spread };
        machined.tools = machined.tools(job);
        Ok(Some(machined))
    }
}

/// The surface that is left on the part.
#[derive(Debug)]
pub(super) struct Machined {
    pub(super) surface: MachinedSurface,
    /// Errors of the tool at all points, W, mm.
    errors: [Vec<Option<Vector3<f64>>>; 2],
    /// Without compensation and as written.
    pub(super) sides: [Side; 2],
    /// Against the part of the drawing, where one is given.
    pub(super) part: Option<PartSides>,
    /// Of each tool, where they differ.
    pub(super) tools: Vec<ToolSides>,
    /// Its distribution where inputs are uncertain: against the part where one is given, else against the programmed surface.
    spread: Option<SurfaceSpread>,
}

/// How far one surface is from another one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Side {
    /// Largest depth of material left and of material missing, mm, with the patch.
    pub left: Option<(f64, usize)>,
    pub missing: Option<(f64, usize)>,
    /// Areas of what was machined, mm²: in all, of unknown deviation, with a tolerance, within it.
    pub area: f64,
    pub unknown: f64,
    pub judged: f64,
    pub within: f64,
}

impl Side {
    /// Returns how far the surface is off at the patches that `counts` takes, by their deviations, mm (`None`: unknown), and tolerances, mm.
    pub fn new(
        surface: &MachinedSurface,
        deviations: &[Option<f64>],
        tolerance_mm: &dyn Fn(&Patch) -> Option<f64>,
        counts: &dyn Fn(&Patch) -> bool,
    ) -> Self {
        let mut side = Self::default();
        for (k, (patch, deviation)) in surface.patches.iter().zip(deviations).enumerate().filter(|own| counts(own.1.0))
        {
            if patch.tag.is_none() {
                // What was there before is not to be cut.
                if let Some(deviation) = deviation.filter(|own| *own < -GOUGE_MM) {
                    side.missing = side.missing.filter(|own| own.0 >= -deviation).or(Some((-deviation, k)));
                }
                continue;
            }
            let area = patch.area_mm2();
            let tolerance_mm = tolerance_mm(patch);
            side.area += area;
            side.judged += tolerance_mm.map_or(0.0, |_| area);
            let Some(deviation) = *deviation else {
                side.unknown += area;
                continue;
            };
            if tolerance_mm.is_some_and(|tolerance| deviation.abs() <= tolerance) {
                side.within += area;
            }
            let [left, missing] = [deviation, -deviation];
            for (own, most) in [(left, &mut side.left), (missing, &mut side.missing)] {
                if own > most.map_or(0.0, |most| most.0) {
                    *most = Some((own, k));
                }
            }
        }
        side
    }

    /// Returns the largest distance to either side, mm.
    pub(super) fn largest(&self) -> f64 {
        [self.left, self.missing].into_iter().flatten().fold(0.0, |most, own| most.max(own.0))
    }
}

/// Names of the courses.
pub(super) const NAMES: [&str; 2] = ["without compensation", "as written"];
/// In place of the number of a course: as the program describes it.
pub(super) const PROGRAMMED: usize = 2;
/// Names of what is at most missing and at most left at each place as written, each with 95 % probability.
const UNCERTAIN: [&str; 2] = ["as written: missing", "as written: left"];

impl Machined {
    /// Returns in sentences what is left and missing on the part.
    pub fn sentences(&self, job: &ProgramJob) -> String {
        let words = |side: &Side| {
            let of = |found: Option<(f64, usize)>| millimetres(found.map_or(0.0, |own| own.0), 4);
            format!("up to {} is left and {} missing", of(side.left), of(side.missing))
        };
        let [before, after] = &self.sides;
        let against = if self.part.is_some() { "Against the programmed surface" } else { "On the part" };
        let mut text = match &self.spread {
            Some(spread) => uncertain_sentences(job, spread, &self.tolerance_text(job)),
            None => {
                let words = format!("{against} {} without compensation; {} as written.", words(before), words(after));
                words + &self.within_text(job, [before, after])
            }
        };
        for (side, name) in self.sides.iter().zip(NAMES).filter(|own| own.0.unknown > 0.0) {
            text += &format!(" Of {} of it nothing is known {name}.", percent(side.unknown / side.area));
        }
        if self.surface.is_coarse || after.area == 0.0 {
            let size = millimetres(self.surface.patch_mm, 1);
            text += &format!(" That is in patches of {size}: what is narrower may not be seen.");
        }
        if job.path.engagements().iter().any(|own| own.bend.is_some()) {
            text += " Distances from the path are from where the tool has to be for its walls, as it bends in itself.";
        }
        text + "\n" + &self.against_sentences(job)
    }

    /// Returns the index of the point whose move makes the surface at a patch on a course, for [`PROGRAMMED`] as programmed; `None` where no move of
    /// the program does.
    pub(super) fn maker(&self, patch: usize, course: usize) -> Option<u32> {
        match self.surface.makers.get(course) {
            Some(makers) => makers[patch].or(self.surface.patches[patch].tag),
            None => self.surface.patches[patch].tag,
        }
    }

    /// Returns the first sentence: how far the surface is off as written and without compensation.
    pub fn first_sentence(&self) -> String {
        let [before, after] = self.largest_mm().map(|own| millimetres(own, 3));
        let how = if self.spread.is_some() { "within" } else { "up to" };
        let sure = if self.spread.is_some() { " with 95 %" } else { " off" };
        format!("Machined surface: {how} {after}{sure}, {before} without compensation.")
    }

    /// Returns how far the surface is off without compensation and as written, with 95 % probability where inputs are uncertain, mm.
    fn largest_mm(&self) -> [f64; 2] {
        match &self.spread {
            Some(spread) => {
                spread.courses.each_ref().map(|own| own.worst_mm.unwrap_or(own.most_mm[0].max(own.most_mm[1])))
            }
            None => self.reference().2.map(Side::largest),
        }
    }

    /// Returns how far the surface is off without compensation and as written, as key numbers.
    pub fn numbers(&self, job: &ProgramJob) -> [KeyNumber; 2] {
        let sides = self.reference().2;
        let sure = if self.spread.is_some() { "not exceeded with 95 % probability" } else { "largest distance" };
        let tolerance_mm = self.least_tolerance_mm(job);
        [0, 1].map(|course| {
            let against = match &self.spread {
                Some(own) => own.courses[course]
                    .within
                    .map(|within| format!("all within tolerance in {} of {} draws", within[0], own.draws)),
                None => (sides[course].judged > 0.0).then(|| {
                    format!(
                        "{} of it within {}",
                        percent(sides[course].within / sides[course].judged),
                        self.tolerance_text(job)
                    )
                }),
            };
            let size = self.largest_mm()[course];
            let what = format!("off on the machined surface {}: {sure}", NAMES[course]);
            KeyNumber::new(&millimetres(size, 3), what, against.unwrap_or_default()).held_to(tolerance_mm, size)
        })
    }

    /// Returns how far the surface as written is off, mm, with the tolerance of that: of each tool where these differ and inputs are nominal.
    pub fn judged(&self, job: &ProgramJob) -> Vec<(Option<f64>, Option<f64>)> {
        // Of a surface of which nothing is seen the path of the tool is judged.
        if self.sides[1].area == 0.0 {
            return Vec::new();
        }
        let largest = self.spread.as_ref().map_or(Some(self.largest_mm()[1]), |own| own.courses[1].worst_mm);
        let whole = (largest, self.least_tolerance_mm(job));
        match self.tools.as_slice() {
            [_, _, ..] if self.spread.is_none() => self.tools.iter().map(ToolSides::judged).collect(),
            _ => whole.1.map(|_| whole).into_iter().collect(),
        }
    }

    /// Returns the verdict on the surface as written; `None` where it has no tolerance.
    pub fn verdict(&self, job: &ProgramJob) -> Option<Verdict> {
        let side = self.reference().2[1];
        match &self.spread {
            Some(own) => own.courses[1].within.map(|within| probable_state(within[0] as f64 / own.draws as f64)),
            None => (side.judged > 0.0).then(|| {
                Verdict::of_share(Some(side.within / side.judged), self.least_tolerance_mm(job), "the surface")
            }),
        }
    }

    /// Returns in words the place in the program whose move makes the surface at a patch on a course; `None` where no move of the program does.
    pub(super) fn place(&self, job: &ProgramJob, patch: usize, course: usize) -> Option<String> {
        self.maker(patch, course).map(|point| job.place_text(point as usize))
    }

    /// Returns largest values and shares as JSON.
    pub fn json(&self, job: &ProgramJob) -> Value {
        let [before, after] = [0, 1].map(|course| self.side_json(job, &self.sides[course], course));
        let mut report =
            json!({ "against": "programmed envelope", "without_compensation": before, "as_written": after });
        self.add_against(job, &mut report);
        if let Some(spread) = &self.spread {
            let [before, after] = spread.courses.each_ref().map(|own| distribution_json(job, own, spread.draws));
            let against = if self.part.is_some() { "part" } else { "programmed envelope" };
            report["distribution"] = json!({ "against": against, "draws": spread.draws, "without_compensation": before, "as_written": after });
        }
        report
    }

    /// Returns a depth with its place as JSON.
    pub(super) fn patch_json(&self, job: &ProgramJob, found: Option<(f64, usize)>, course: usize) -> Value {
        let position = found.map(|own| self.surface.axes.tr_mul(&self.surface.patches[own.1].position));
        let maker = found.and_then(|own| self.maker(own.1, course));
        json!({
            "mm": found.map_or(0.0, |own| own.0),
            "point": maker,
            "line": maker.and_then(|own| job.file.line_of(job.path.points()[own as usize].source.segment)),
            "position_mm": position.map(|own| [own.x, own.y, own.z]),
        })
    }

    pub(super) fn side_json(&self, job: &ProgramJob, side: &Side, course: usize) -> Value {
        json!({
            "most_left": self.patch_json(job, side.left, course),
            "most_missing": self.patch_json(job, side.missing, course),
            "area_mm2": side.area,
            "area_within_tolerance_mm2": (side.judged > 0.0).then_some(side.within),
            "area_unknown_mm2": side.unknown,
        })
    }

    /// Returns the section of the page on the part.
    pub fn section(&self, report: &Report<'_>) -> Section {
        let row = |((name, side), course): ((&str, &Side), usize)| {
            let of = |found: Option<(f64, usize)>| found.map_or_else(|| "–".into(), |own| millimetres(own.0, 4));
            let place = |found: Option<(f64, usize)>| {
                found.and_then(|own| self.place(report.job, own.1, course)).unwrap_or_else(|| "–".into())
            };
            vec![name.into(), of(side.left), place(side.left), of(side.missing), place(side.missing)]
        };
        let table = SmallTable {
            caption:
                "Material left and missing on the machined surface: along its normal, to the nearest point of a part"
                    .into(),
            header: ["", "most left", "where", "most missing", "where"].map(String::from).into(),
            rows: NAMES
                .into_iter()
                .zip(&self.sides)
                .zip([0, 1])
                .chain(self.part.iter().flat_map(PartSides::named).zip([PROGRAMMED, 0, 1]))
                .map(row)
                .chain(self.spread.iter().flat_map(|own| [0, 1].map(|course| self.p95_row(own, course))))
                .collect(),
        };
        let uncertain = self.spread.iter().flat_map(|own| uncertain_tables(report.job, own));
        Section::new("What is left on the part?", "how far the machined surface is off, and where")
            .text(&self.sentences(report.job))
            .text(
                "The surface is that of the tool as it goes from point to point, so that what an earlier pass took away stays gone. The tool is rotated as the machine deflects. Run-out and vibration are not in \
                 it, nor what should be cut through and is not; bending of the tool itself is where the process file says how it sticks out.\n",
            )
            .small_tables([table].into_iter().chain(uncertain).chain(self.against_tables(report.job)))
            .explorers([VIEW])
            .figures(&[DEVIATIONS])
    }

    /// Returns the picture of the part before and after, and how its deviations are distributed over its area.
    pub fn figures(&self, job: &ProgramJob) -> Vec<(String, Figure)> {
        let surface = &self.surface;
        let end = self.end_mm(job);
        let (reference, nominal, _) = self.reference();
        let uncertain = self.uncertain_surfaces();
        let view = |course: usize| {
            let (name, deviations) = match uncertain.get(course) {
                Some((name, own)) => (name.as_str(), &own[..]),
                None => (NAMES[course], nominal[course]),
            };
            let face = |(patch, deviation): (&Patch, &Option<f64>)| match (patch.tag, deviation) {
                (None, Some(gouge)) if *gouge < -GOUGE_MM => FaceValue::Value(*gouge),
                (None, _) => FaceValue::Skin,
                (_, None) => FaceValue::Unknown,
                (_, Some(deviation)) => FaceValue::Value(*deviation),
            };
            let title = format!("{name}\n{}", self.range_text(course));
            (title, surface.patches.iter().zip(deviations).map(face).collect())
        };
        let corners = |patch: &Patch| patch.corners.map(|corner| corner.into());
        let part = PartFigure {
            title: "What is left on the part".into(),
            subtitle: format!(
                "{}, seen from the spindle; red: material is left, blue: it is missing",
                job.machine.name
            ),
            quantity: "material left [mm]".into(),
            faces: surface.patches.iter().map(corners).collect(),
            views: vec![view(0), view(1)],
            range: (-end, end),
            note: format!(
                "{reference}{}; grey: not cut by the program{}",
                if self.spread.is_some() { ", each place with 95 % probability" } else { "" },
                self.least_tolerance_mm(job).map_or_else(String::new, |own| {
                    let smallest = if self.tools.is_empty() { "" } else { "smallest " };
                    format!("; the scale ends at the {smallest}tolerance, {own} mm")
                })
            ),
        };
        vec![("answer".into(), Figure::Part(Box::new(part))), (DEVIATIONS.into(), self.histogram(job, end))]
    }

    /// Returns the interactive view of the part: a click tells the line, the engagement, the force and the errors of the tool where it made a face.
    pub fn view(&self, job: &ProgramJob) -> PartView {
        let surface = &self.surface;
        let makers: Vec<Option<u32>> = (0..surface.patches.len()).map(|k| self.maker(k, 1)).collect();
        let tags: BTreeSet<u32> = makers.iter().copied().flatten().collect();
        let tags: Vec<u32> = tags.into_iter().collect();
        let made = |k: usize| tags.binary_search(&makers[k]?).ok();
        let column = |label: &str, unit: &str, value: &dyn Fn(usize) -> Option<f64>| {
            (label.to_string(), unit.to_string(), tags.iter().map(|tag| value(*tag as usize)).collect())
        };
        let engaged = |k: usize| job.path.engagements().get(k);
        let error = |course: usize| move |k: usize| self.errors[course][k].map(|own| own.norm());
        PartView {
            title: VIEW.into(),
            corners_mm: [0, 1, 2]
                .map(|axis| surface.patches.iter().flat_map(|patch| patch.corners.map(|own| own[axis])).collect()),
            made: (0..makers.len()).map(made).collect(),
            courses: self.courses(),
            end_mm: self.end_mm(job),
            places: tags.iter().map(|tag| job.place_text(*tag as usize)).collect(),
            columns: vec![
                column("largest depth", "mm", &|k| Some(engaged(k)?.depth_mm)),
                column("largest width", "mm", &|k| Some(engaged(k)?.width_mm)),
                column("regions of height", "", &|k| Some(engaged(k)?.regions as f64)),
                column("cutting force", "N", &|k| Some(job.path.points()[k].load?.force_N.norm())),
                column("tool off without compensation", "mm", &error(0)),
                column("tool off as written", "mm", &error(1)),
            ],
        }
    }

    /// Returns how much is at most missing and at most left at each patch as written, each with 95 % probability, mm, by name; nothing where inputs are exact.
    pub(super) fn uncertain_surfaces(&self) -> Vec<(String, Vec<Option<f64>>)> {
        let of = |own: &SurfaceSpread, end: usize| {
            let ranges = own.courses[1].ranges_mm.iter();
            (UNCERTAIN[end].to_string(), ranges.map(|range| range.map(|own| own[end])).collect())
        };
        self.spread.iter().flat_map(|own| [of(own, 0), of(own, 1)]).collect()
    }

    /// Returns the row of a table of what is left and missing on a course with 95 % probability.
    fn p95_row(&self, spread: &SurfaceSpread, course: usize) -> Vec<String> {
        let [left, missing] = spread.courses[course].most_mm.map(|own| millimetres(own, 4));
        let against = if self.part.is_some() { "against the part, " } else { "" };
        vec![format!("{against}{}, with 95 %", NAMES[course]), left, "anywhere".into(), missing, "anywhere".into()]
    }

    /// Returns where the colours end, mm: at the tolerance, as what is out of it has the strongest, or at the largest deviation.
    fn end_mm(&self, job: &ProgramJob) -> f64 {
        let largest = self.reference().2.into_iter().map(Side::largest).fold(1e-3, f64::max);
        self.least_tolerance_mm(job).unwrap_or(largest)
    }

    fn range_text(&self, course: usize) -> String {
        let Side { left, missing, .. } = self.reference().2[course];
        let [left, missing] = [left, missing].map(|own| own.map_or(0.0, |own| own.0));
        match &self.spread {
            None => format!("\u{2212}{missing:.3} to +{left:.3} mm"),
            Some(spread) => format!("\u{2264} {:.3} mm, 95 %", spread.courses[1].most_mm[1 - course]),
        }
    }

    /// Returns the distribution of deviations over the machined area.
    fn histogram(&self, job: &ProgramJob, end: f64) -> Figure {
        let (reference, deviations, sides) = self.reference();
        let series = NAMES.iter().enumerate().map(|(course, name)| {
            let mut shares = [0.0; BINS];
            let bin = 2.0 * end / BINS as f64;
            for (patch, deviation) in self.surface.patches.iter().zip(deviations[course]) {
                if let (Some(_), Some(deviation)) = (patch.tag, deviation) {
                    let at = ((deviation + end) / bin).clamp(0.0, BINS as f64 - 1.0) as usize;
                    shares[at] += 100.0 * patch.area_mm2() / sides[course].area.max(f64::MIN_POSITIVE);
                }
            }
            let steps = shares.iter().enumerate().flat_map(|(at, share)| {
                let from = -end + at as f64 * bin;
                [(from, *share), (from + bin, *share)]
            });
            LineSeries::new(*name, steps.collect(), course == 0)
        });
        let labels = ["material left [mm]", "share of the machined area [%]"];
        let subtitle =
            format!("{}, {reference}, bins of {}", job.machine.name, millimetres(2.0 * end / BINS as f64, 4));
        Figure::Lines(LineFigure::new("How the deviation is spread over the part", subtitle, labels, series.collect()))
    }

    /// Returns the part for other programs: faces in W with their deviations, mm, the line that makes them as written (0 on the skin of the stock), and whether the deviations are
    /// known.
    pub fn exported(&self, job: &ProgramJob) -> Surface {
        let surface = &self.surface;
        let nominal = NAMES.iter().zip(&surface.deviations);
        let nominal = nominal.map(|(name, own)| (format!("{}_mm", name.replace(' ', "_")), own));
        let part = surface.against_part.iter().flat_map(|own| NAMES.iter().zip(&own.surfaces[1..]));
        let part = part.map(|(name, own)| (format!("against_part_{}_mm", name.replace(' ', "_")), own));
        let uncertain = self.uncertain_surfaces();
        let quantiles = ["as_written_p05_mm", "as_written_p95_mm"].map(String::from);
        let quantiles = quantiles.into_iter().zip(uncertain.iter().map(|own| &own.1));
        let line = |k: usize| {
            let segment = self.maker(k, 1).map(|tag| job.path.points()[tag as usize].source.segment);
            segment.and_then(|segment| job.file.line_of(segment)).unwrap_or(0) as i32
        };
        let corner = |own: &Vector3<f64>| surface.axes.tr_mul(own).map(|own| own as f32).into();
        let patches = 0..surface.patches.len();
        Surface {
            comment: "deviation from the programmed surface along its normal, mm, positive where material is left"
                .into(),
            faces: surface.patches.iter().map(|patch| patch.corners.each_ref().map(corner)).collect(),
            columns: nominal.chain(part).chain(quantiles).map(|(name, own)| (name, own.clone())).collect(),
            lines: patches.clone().map(line).collect(),
            known: patches.map(|k| surface.deviations.iter().all(|own| own[k].is_some())).collect(),
        }
    }
}

/// Title of the interactive view.
const VIEW: &str = "The machined part";
/// Name of the figure of the distribution.
const DEVIATIONS: &str = "deviations";
/// Bins of the distribution.
const BINS: usize = 40;

/// Returns in sentences how sure it is what is left on the part, which is to be `within` its tolerance.
fn uncertain_sentences(job: &ProgramJob, spread: &SurfaceSpread, within: &str) -> String {
    let [before, after] = spread.courses.each_ref().map(|own| own.most_mm.map(|own| millimetres(own, 3)));
    let mut text = format!(
        "On the part as written, with 95 % probability at most {} is left anywhere, and at most {} missing ({} and {} without compensation), in {} draws.",
        after[0], after[1], before[0], before[1], spread.draws
    );
    if let [Some(before), Some(after)] = spread.courses.each_ref().map(|own| own.within) {
        text += &format!(
            " All of its surface is within {within} in {} of them ({} without compensation); nothing is missing by more in {}.",
            after[0], before[0], after[1]
        );
    }
    if let [(segment, count), ..] = spread.courses[1].gouges[..]
        && let Some(line) = job.file.line_name(segment)
    {
        text += &format!(" The likeliest to take too much is {line}: in {count}.");
    }
    let failed = spread.courses[1].failed;
    if failed > 0 {
        text += &format!(
            " In {failed} of them the machine has no equilibrium somewhere (in the first: {}): these count as out of tolerance, and in none of the distances.",
            spread.courses[1].first_failure.as_deref().unwrap_or_default().trim_end_matches('.')
        );
    }
    text
}

/// Returns the lines that may take more than the tolerance from the part, the likeliest first, as a table; `None` without such.
fn uncertain_tables(job: &ProgramJob, spread: &SurfaceSpread) -> Option<SmallTable> {
    let [before, after] = &spread.courses;
    let row = |(segment, count): &(usize, usize)| {
        let without = before.gouges.iter().find(|own| own.0 == *segment).map_or(0, |own| own.1);
        let of_draws = |count: usize| format!("{count} of {}", spread.draws);
        Some(vec![job.file.line_name(*segment)?, job.file.line_text(*segment)?, of_draws(*count), of_draws(without)])
    };
    let rows: Vec<_> = after.gouges.iter().filter_map(row).take(LINES).collect();
    let header = ["line", "text", "as written", "without compensation"].map(String::from).into();
    let caption = "In how many draws a line takes more than the tolerance too much from the part".into();
    (!rows.is_empty()).then_some(SmallTable { caption, header, rows })
}

/// Returns what is known of the distribution of a surface as JSON.
fn distribution_json(job: &ProgramJob, own: &CourseSpread, draws: usize) -> Value {
    let [left, missing] = own.most_mm;
    let share = |count: usize| count as f64 / draws as f64;
    let gouge =
        |(segment, count): &(usize, usize)| json!({ "line": job.file.line_of(*segment), "probability": share(*count) });
    json!({
        "failed_draws": own.failed,
        "first_failure": own.first_failure,
        "most_left_p95_mm": left,
        "most_missing_p95_mm": missing,
        "within_tolerance_probability": own.within.map(|own| share(own[0])),
        "nothing_missing_beyond_tolerance_probability": own.within.map(|own| share(own[1])),
        "gouge_probabilities": own.gouges.iter().map(gouge).collect::<Vec<_>>(),
    })
}
