//! What is left on the part: the surface that a program machines from its stock, without compensation and as written.

use std::collections::BTreeSet;

use kinetostat_removal::Patch;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

use super::{Report, findings::LINES};
use crate::{
    figures::{FaceValue, Figure, LineFigure, LineSeries, PartFigure},
    files::{
        OutputFile,
        words::{millimetres, percent, probability},
    },
    input::error::Result,
    page::{PartView, Section, SmallTable},
    process::{machined::MachinedSurface, uncertainty::Draws},
    products::program::{
        ProgramAsWritten, ProgramJob, ProvedPart,
        surface::{Recut, SurfaceSpread},
    },
    simulation::{Source, along_path::PathPointResult},
    work::Work,
};

/// Errors of the tool along a program that cuts stock (W, mm), without compensation and as written; `None` without equilibrium.
#[derive(Debug)]
pub(super) struct Courses {
    /// `R_OW`.
    turn: Matrix3<f64>,
    errors: [Vec<Option<Vector3<f64>>>; 2],
}

impl Courses {
    /// Begins the courses of `job`; `None` if it cuts no stock.
    pub fn new(job: &ProgramJob) -> Option<Self> {
        job.process.stock.as_ref()?;
        let turn = job.process.placement.place(&job.machine).workpiece().rotation;
        Some(Self { turn, errors: [0, 1].map(|_| Vec::with_capacity(job.path.len())) })
    }

    /// Adds the points of the next proved part.
    pub fn add(&mut self, proved: &ProvedPart<'_>) {
        let turned = |error: &Option<Vector3<f64>>| error.map(|error| self.turn.tr_mul(&error));
        self.errors[0].extend(proved.before[Source::All].iter().map(turned));
        self.errors[1].extend(proved.written.iter().map(|answer| turned(&PathPointResult::solved_error(answer))));
    }

    /// Returns the surface that is left by the program as `written`, called `name`, and its distribution where inputs are uncertain.
    ///
    /// # Errors
    /// As [`StockRemoval::machined`](crate::process::stock::StockRemoval); of `work`.
    pub fn surface(
        self,
        job: &ProgramJob,
        (written, name): (&ProgramAsWritten, &str),
        work: &Work,
    ) -> Result<Option<Machined>> {
        let Some(stock) = &job.process.stock else { return Ok(None) };
        let surface = stock.machined(&job.path, (&job.machine, &job.process.placement), &self.errors, name)?;
        let sides = [0, 1].map(|course| Side::new(&surface, course, job.process.tolerance_mm));
        let spread = job.surface_spread(&surface, written, work)?;
        Ok(Some(Machined { surface, errors: self.errors, sides, spread }))
    }
}

/// The surface that is left on the part.
#[derive(Debug)]
pub(super) struct Machined {
    surface: MachinedSurface,
    /// Errors of the tool at all points, W, mm.
    errors: [Vec<Option<Vector3<f64>>>; 2],
    /// Without compensation and as written.
    sides: [Side; 2],
    /// Where inputs are uncertain.
    spread: Option<SurfaceSpread>,
}

/// How far one surface is from the programmed one.
#[derive(Debug, Clone, Default, PartialEq)]
struct Side {
    /// Largest depth of material left and of material missing, mm, with the patch.
    left: Option<(f64, usize)>,
    missing: Option<(f64, usize)>,
    /// Areas of what was machined, mm²: in all, of unknown deviation, within the tolerance.
    area: f64,
    unknown: f64,
    within: f64,
}

impl Side {
    fn new(surface: &MachinedSurface, course: usize, tolerance_mm: Option<f64>) -> Self {
        let mut side = Self::default();
        for (k, (patch, deviation)) in surface.patches.iter().zip(&surface.deviations[course]).enumerate() {
            if patch.tag.is_none() {
                // What was there before is not to be cut.
                if let Some(deviation) = deviation.filter(|own| *own < -GOUGE_MM) {
                    side.missing = side.missing.filter(|own| own.0 >= -deviation).or(Some((-deviation, k)));
                }
                continue;
            }
            let area = patch.area_mm2();
            side.area += area;
            let Some(deviation) = *deviation else {
                side.unknown += area;
                continue;
            };
            if deviation.abs() <= tolerance_mm.unwrap_or(f64::INFINITY) {
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
    fn largest(&self) -> f64 {
        [self.left, self.missing].into_iter().flatten().fold(0.0, |most, own| most.max(own.0))
    }
}

/// Less is rounding where nothing was to be cut, mm.
const GOUGE_MM: f64 = 1e-3;
/// Names of the courses.
const NAMES: [&str; 2] = ["without compensation", "as written"];
/// Name of the surface that is so far off as with 95 % probability it is not farther.
const P95_NAME: &str = "as written, with 95 %";

impl Machined {
    /// Returns in sentences what is left and missing on the part.
    pub fn sentences(&self, job: &ProgramJob) -> String {
        let words = |side: &Side| {
            let of = |found: Option<(f64, usize)>| millimetres(found.map_or(0.0, |own| own.0), 4);
            format!("up to {} is left and {} missing", of(side.left), of(side.missing))
        };
        let [before, after] = &self.sides;
        let nominal = if self.spread.is_some() { "With nominal numbers" } else { "On the part" };
        let mut text = self.spread.as_ref().map_or_else(String::new, |own| uncertain_sentences(job, own));
        text += &format!("{nominal}, {} without compensation; {} as written.", words(before), words(after));
        if let Some(tolerance) = job.process.tolerance_mm {
            let share = |side: &Side| percent(side.within / side.area.max(f64::MIN_POSITIVE));
            text += &format!(
                " {} of the machined surface is within {tolerance} mm, {} without.",
                share(after),
                share(before)
            );
        }
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
        text + "\n"
    }

    /// Returns the place in the program whose move made the surface at a patch on a course, in words.
    fn place(&self, job: &ProgramJob, (patch, course): (usize, usize)) -> Option<String> {
        self.surface.makers[course][patch].map(|maker| job.place_words(maker.point as usize))
    }

    /// Returns largest values and shares as JSON.
    pub fn json(&self, job: &ProgramJob) -> Value {
        let line = |segment: usize| job.file.line_of(segment);
        let side = |course: usize| {
            let side = &self.sides[course];
            let of = |found: Option<(f64, usize)>| {
                let position = found.map(|own| self.surface.axes.tr_mul(&self.surface.patches[own.1].position));
                let maker = found.and_then(|own| Some(self.surface.makers[course][own.1]?.point));
                json!({
                    "mm": found.map_or(0.0, |own| own.0),
                    "point": maker,
                    "line": maker.and_then(|own| line(job.path.points()[own as usize].source.segment)),
                    "position_mm": position.map(|own| [own.x, own.y, own.z]),
                })
            };
            let mut json = json!({
                "most_left": of(side.left),
                "most_missing": of(side.missing),
                "area_mm2": side.area,
                "area_within_tolerance_mm2": job.process.tolerance_mm.map(|_| side.within),
                "area_unknown_mm2": side.unknown,
            });
            if let Some(spread) = &self.spread {
                let own = &spread.courses[course];
                let [left, missing] = own.most_p95_mm();
                let gouge = |(segment, share): &(usize, f64)| json!({ "line": line(*segment), "probability": share });
                let recut = |own: &Recut| json!({ "estimated_mm": own.estimated_mm, "cut_mm": own.cut_mm });
                json["distribution"] = json!({
                    "most_left_p95_mm": left,
                    "most_missing_p95_mm": missing,
                    "within_tolerance_probability": own.within.map(|own| own[0]),
                    "nothing_missing_beyond_tolerance_probability": own.within.map(|own| own[1]),
                    "gouge_probabilities": own.gouges.iter().map(gouge).collect::<Vec<_>>(),
                    "cut_again": own.recuts.iter().map(recut).collect::<Vec<_>>(),
                });
            }
            json
        };
        json!({ "against": "programmed envelope", "without_compensation": side(0), "as_written": side(1) })
    }

    /// Returns the section of the page on the part.
    pub fn section(&self, report: &Report<'_>) -> Section {
        let row = |course: usize| {
            let side = &self.sides[course];
            let of = |found: Option<(f64, usize)>| found.map_or_else(|| "–".into(), |own| millimetres(own.0, 4));
            let place = |found: Option<(f64, usize)>| {
                found.and_then(|own| self.place(report.job, (own.1, course))).unwrap_or_else(|| "–".into())
            };
            vec![NAMES[course].into(), of(side.left), place(side.left), of(side.missing), place(side.missing)]
        };
        let table = SmallTable {
            caption: "Material left and missing on the machined surface, along its normal".into(),
            header: ["", "most left", "where", "most missing", "where"].map(String::from).into(),
            rows: [0, 1].map(row).into_iter().chain(self.spread.iter().map(p95_row)).collect(),
        };
        let uncertain = self.spread.iter().flat_map(|own| uncertain_tables(report.job, own));
        Section::new("What is left on the part?", "deviation of the machined surface from the programmed one")
            .text(&self.sentences(report.job))
            .text(
                "The surface is that of the tool as it goes from point to point, so that what an earlier pass took away stays gone. Tilt of the tool, run-out and vibration are not in \
                 it, nor what should be cut through and is not; bending of the tool itself is where the process file says how it sticks out.\n",
            )
            .text(&self.spread.as_ref().map_or_else(String::new, recut_words))
            .small_tables([table].into_iter().chain(uncertain))
            .explorers([VIEW])
            .figures(&[DEVIATIONS])
    }

    /// Returns the picture of the part before and after, and how its deviations are distributed over its area.
    pub fn figures(&self, job: &ProgramJob) -> Vec<(String, Figure)> {
        let surface = &self.surface;
        let end = self.end_mm(job);
        let view = |(course, (name, deviations)): (usize, (String, Vec<Option<f64>>))| {
            let face = |(patch, deviation): (&Patch, &Option<f64>)| match (patch.tag, deviation) {
                (None, Some(gouge)) if *gouge < -GOUGE_MM => FaceValue::Value(*gouge),
                (None, _) => FaceValue::Skin,
                (_, None) => FaceValue::Unknown,
                (_, Some(deviation)) => FaceValue::Value(*deviation),
            };
            let title = format!("{name}\n{}", self.range_words(course));
            (title, surface.patches.iter().zip(&deviations).map(face).collect())
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
            views: self.courses().into_iter().enumerate().map(view).collect(),
            range: (-end, end),
            note: format!(
                "against the surface that the program describes; grey: not cut by it{}",
                job.process
                    .tolerance_mm
                    .map_or_else(String::new, |own| format!("; the scale ends at the tolerance, {own} mm"))
            ),
        };
        vec![("answer".into(), Figure::Part(Box::new(part))), (DEVIATIONS.into(), self.histogram(job, end))]
    }

    /// Returns the interactive view of the part: a click tells the line, the engagement, the force and the errors of the tool where it made a face.
    pub fn view(&self, job: &ProgramJob) -> PartView {
        let surface = &self.surface;
        let tags: BTreeSet<u32> = surface.patches.iter().filter_map(|patch| patch.tag).collect();
        let tags: Vec<u32> = tags.into_iter().collect();
        let made = |patch: &Patch| tags.binary_search(&patch.tag?).ok();
        let column = |label: &str, unit: &str, value: &dyn Fn(usize) -> Option<f64>| {
            (label.to_string(), unit.to_string(), tags.iter().map(|tag| value(*tag as usize)).collect())
        };
        let engaged = |k: usize| job.path.engagements().get(k);
        let error = |course: usize| move |k: usize| self.errors[course][k].map(|own| own.norm());
        PartView {
            title: VIEW.into(),
            corners_mm: [0, 1, 2]
                .map(|axis| surface.patches.iter().flat_map(|patch| patch.corners.map(|own| own[axis])).collect()),
            made: surface.patches.iter().map(made).collect(),
            courses: self.courses(),
            end_mm: self.end_mm(job),
            places: tags.iter().map(|tag| job.place_words(*tag as usize)).collect(),
            columns: vec![
                column("depth", "mm", &|k| Some(engaged(k)?.depth_mm)),
                column("width", "mm", &|k| Some(engaged(k)?.width_mm)),
                column("cutting force", "N", &|k| Some(job.path.points()[k].load?.force_N.norm())),
                column("tool off without compensation", "mm", &error(0)),
                column("as written", "mm", &error(1)),
            ],
        }
    }

    /// Returns the surfaces that are shown, by name, with how far each patch is off.
    fn courses(&self) -> Vec<(String, Vec<Option<f64>>)> {
        let nominal = NAMES.iter().zip(&self.surface.deviations).map(|(name, own)| (name.to_string(), own.clone()));
        let signed = |(deviation, p95): (&Option<f64>, &Option<f64>)| Some(p95.as_ref()?.copysign((*deviation)?));
        let p95 = self.spread.iter().map(|own| {
            let all = self.surface.deviations[1].iter().zip(&own.courses[1].p95_mm);
            (P95_NAME.to_string(), all.map(signed).collect())
        });
        nominal.chain(p95).collect()
    }

    /// Returns where the colours end, mm: at the tolerance, as what is out of it has the strongest, or at the largest deviation.
    fn end_mm(&self, job: &ProgramJob) -> f64 {
        let largest = self.sides.iter().map(Side::largest).fold(1e-3, f64::max);
        job.process.tolerance_mm.unwrap_or(largest)
    }

    fn range_words(&self, course: usize) -> String {
        let of = |found: &Option<(f64, usize)>| found.map_or(0.0, |own| own.0);
        let nominal = self.sides.get(course).map(|side| [of(&side.left), of(&side.missing)]);
        let p95 = || self.spread.as_ref().map(|own| own.courses[1].most_p95_mm());
        let [left, missing] = nominal.or_else(p95).unwrap_or_default();
        format!("\u{2212}{missing:.3} to +{left:.3} mm")
    }

    /// Returns the distribution of deviations over the machined area.
    fn histogram(&self, job: &ProgramJob, end: f64) -> Figure {
        let series = NAMES.iter().enumerate().map(|(course, name)| {
            let mut shares = [0.0; BINS];
            let bin = 2.0 * end / BINS as f64;
            for (patch, deviation) in self.surface.patches.iter().zip(&self.surface.deviations[course]) {
                if let (Some(_), Some(deviation)) = (patch.tag, deviation) {
                    let at = ((deviation + end) / bin).clamp(0.0, BINS as f64 - 1.0) as usize;
                    shares[at] += 100.0 * patch.area_mm2() / self.sides[course].area.max(f64::MIN_POSITIVE);
                }
            }
            let steps = shares.iter().enumerate().flat_map(|(at, share)| {
                let from = -end + at as f64 * bin;
                [(from, *share), (from + bin, *share)]
            });
            LineSeries::new(*name, steps.collect(), course == 0)
        });
        let labels = ["material left along the normal [mm]", "share of the machined area [%]"];
        let subtitle = format!("{}, bins of {}", job.machine.name, millimetres(2.0 * end / BINS as f64, 4));
        Figure::Lines(LineFigure::new("How the deviation is spread over the part", subtitle, labels, series.collect()))
    }

    /// Returns the part as a PLY file called `name`: faces in W with the deviations of their corners, mm the line that made them (0 on the skin of the stock), and whether
    /// the deviation is known: where not, it is 0.
    pub fn ply(&self, job: &ProgramJob, name: String) -> OutputFile {
        let surface = &self.surface;
        let count = surface.patches.len();
        let p95 = self.spread.as_ref().map(|own| &own.courses[1].p95_mm);
        let p95_property = if p95.is_some() { "property float as_written_p95_mm\n" } else { "" };
        let mut bytes = Vec::with_capacity(count * (4 * 29 + 17) + 512);
        let header = format!(
            "ply\nformat binary_little_endian 1.0\ncomment deviation from the programmed surface along its normal, mm, positive where material is left\n\
             element vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty float without_compensation_mm\n\
             property float as_written_mm\n{p95_property}property int line\nproperty uchar known\nelement face {count}\nproperty list uchar int vertex_indices\nend_header\n",
            4 * count
        );
        bytes.extend(header.as_bytes());
        for (k, patch) in surface.patches.iter().enumerate() {
            let segment = patch.tag.map(|tag| job.path.points()[tag as usize].source.segment);
            let line = segment.and_then(|segment| job.file.line_of(segment)).unwrap_or(0) as i32;
            let deviations = [0, 1].map(|course| surface.deviations[course][k]);
            let is_known = deviations.iter().all(Option::is_some);
            let values = deviations.into_iter().chain(p95.map(|own| own[k]));
            let values: Vec<f32> = values.map(|own| own.unwrap_or(0.0) as f32).collect();
            for corner in &patch.corners {
                let corner = surface.axes.tr_mul(corner);
                for own in corner.iter().map(|own| *own as f32).chain(values.iter().copied()) {
                    bytes.extend(own.to_le_bytes());
                }
                bytes.extend(line.to_le_bytes());
                bytes.push(is_known.into());
            }
        }
        for k in 0..count as i32 {
            bytes.push(4);
            (0..4).for_each(|corner| bytes.extend((4 * k + corner).to_le_bytes()));
        }
        OutputFile::new(name, bytes)
    }
}

/// Title of the interactive view.
const VIEW: &str = "The machined part";
/// Name of the figure of the distribution.
const DEVIATIONS: &str = "deviations";
/// Bins of the distribution.
const BINS: usize = 40;

/// Returns in sentences how sure it is what is left on the part.
fn uncertain_sentences(job: &ProgramJob, spread: &SurfaceSpread) -> String {
    let [before, after] =
        spread.courses.each_ref().map(|own| own.most_p95_mm().map(|own| millimetres(own.max(0.0), 3)));
    let mut text = format!(
        "On the part as written, with 95 % probability at most {} is left anywhere, and at most {} missing ({} and {} without compensation).",
        after[0], after[1], before[0], before[1]
    );
    let sure = |share: f64| probability(share, Draws::COUNT);
    if let (Some(tolerance), [Some(before), Some(after)]) =
        (job.process.tolerance_mm, spread.courses.each_ref().map(|own| own.within))
    {
        text += &format!(
            " All of its surface is within {tolerance} mm with {} probability ({} without); nothing is missing by more with {}.",
            sure(after[0]),
            sure(before[0]),
            sure(after[1])
        );
    }
    if let [(segment, share), ..] = spread.courses[1].gouges[..]
        && let Some(line) = job.file.line_name(segment)
    {
        text += &format!(" The likeliest to take too much is {line}: {}.", sure(share));
    }
    text += &match spread.most_beyond() {
        Some((beyond, true)) => {
            format!(
                " That is an estimate: where the stock was cut again as in a draw, up to {} more was off.",
                millimetres(beyond, 3)
            )
        }
        None => {
            " That is an estimate that could not be confirmed, as in a draw the machine has no equilibrium somewhere."
                .into()
        }
        Some(_) => String::new(),
    };
    text + " "
}

/// Returns the row of a table of what is left and missing with 95 % probability.
fn p95_row(spread: &SurfaceSpread) -> Vec<String> {
    let [left, missing] = spread.courses[1].most_p95_mm().map(|own| millimetres(own.max(0.0), 4));
    vec![P95_NAME.into(), left, "anywhere".into(), missing, "anywhere".into()]
}

/// Returns what the estimate of the surface rests on, in sentences.
fn recut_words(spread: &SurfaceSpread) -> String {
    let recuts = spread.courses.iter().flat_map(|own| &own.recuts).count();
    let held = match spread.most_beyond() {
        Some((beyond, _)) => {
            format!("the largest distance from the programmed surface was at most {} larger", millimetres(beyond, 3))
        }
        None => "in one of them at least the machine has no equilibrium somewhere".into(),
    };
    format!(
        "Distributions are estimates: each place of the nominal surface goes with the move that makes it; what is left may be less, as passes beside take some of it. In {recuts} draws the stock was cut again, as the engine says that the tool \
         goes: {held}.\n"
    )
}

/// Returns the lines that may take more than the tolerance from the part, the likeliest first, as a table; none without such.
fn uncertain_tables(job: &ProgramJob, spread: &SurfaceSpread) -> Option<SmallTable> {
    let tolerance = job.process.tolerance_mm?;
    let [before, after] = &spread.courses;
    let row = |(segment, share): &(usize, f64)| {
        let without = before.gouges.iter().find(|own| own.0 == *segment).map_or(0.0, |own| own.1);
        let sure = |share: f64| probability(share, Draws::COUNT);
        Some(vec![job.file.line_name(*segment)?, job.file.line_text(*segment)?, sure(*share), sure(without)])
    };
    let rows: Vec<_> = after.gouges.iter().filter_map(row).take(LINES).collect();
    let header = ["line", "text", "as written", "without compensation"].map(String::from).into();
    let caption = format!("Probability that a line takes more than {tolerance} mm too much from the part");
    (!rows.is_empty()).then_some(SmallTable { caption, header, rows })
}
