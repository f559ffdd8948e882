//! How far the machined surface is from the part of the drawing, by line, and how much of it is within the tolerances of its tools.

use std::collections::{BTreeMap, BTreeSet};

use kinetostat_removal::{Patch, Split, split};
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::machined::{Machined, NAMES, PROGRAMMED, Side};
use crate::{
    files::words::{millimetres, percent},
    page::SmallTable,
    process::machined::{AgainstPart, GOUGE_MM, MachinedSurface},
    products::program::ProgramJob,
};

/// Lines that are listed.
const LISTED: usize = 10;
/// A program that comes no nearer to its part is probably of another one, mm.
const NEAR_MM: f64 = 1.0;
/// Names of the surfaces that are held against the part, in the order of [`AgainstPart::surfaces`].
const PART_NAMES: [&str; 3] =
    ["against the part, as programmed", "against the part, without compensation", "against the part, as written"];

/// What is left on the part and missing of it: as programmed, without compensation, as written.
#[derive(Debug)]
pub(super) struct PartSides {
    pub sides: [Side; 3],
    /// The worst patch of each line that is out of tolerance as written, the worst line first; material left and missing apart.
    lines: Vec<usize>,
    /// What no move of the program reaches: how high the stock is above the part at most, mm, where (axes of the surface), and the area where that is out of tolerance, mm².
    not_reached: Option<(f64, Vector3<f64>, f64)>,
}

/// What one tool makes, which is a feature of the part.
#[derive(Debug)]
pub(super) struct ToolSides {
    tool: Option<u32>,
    tolerance_mm: Option<f64>,
    sides: [Side; 2],
}

impl ToolSides {
    /// Returns how far the surface as written is off, mm, and its tolerance.
    pub(super) fn judged(&self) -> (Option<f64>, Option<f64>) {
        (Some(self.sides[1].largest()), self.tolerance_mm)
    }
}

/// Returns the tolerance of the surface that the move to point `tag` makes, mm: that of its tool, or else of the process. Without a `tag`, of what no
/// move of the program makes, that of the process. `None` if there is none.
pub(super) fn tolerance_mm(job: &ProgramJob, tag: Option<u32>) -> Option<f64> {
    let own = |tag: u32| job.process.stock.as_ref()?.tolerance_mm(job.path.points()[tag as usize].tool);
    tag.and_then(own).or(job.process.tolerance_mm)
}

impl PartSides {
    /// Returns what is left and missing; `None` if no part is given.
    pub fn new(surface: &MachinedSurface, job: &ProgramJob) -> Option<Self> {
        let part = surface.against_part.as_ref()?;
        let tolerance = |patch: &Patch| tolerance_mm(job, patch.tag);
        let sides = [0, 1, 2].map(|own| Side::new(surface, &part.surfaces[own], &tolerance, &|_| true));
        let mut worst = BTreeMap::<_, (f64, usize)>::new();
        for (k, (patch, distance)) in surface.patches.iter().zip(&part.surfaces[2]).enumerate() {
            let is_out = |own: &f64| own.abs() > tolerance(patch).unwrap_or(GOUGE_MM);
            let Some(distance) = distance.filter(|own| is_out(own) && (patch.tag.is_some() || *own < 0.0)) else {
                continue;
            };
            let maker = surface.makers[1][k].or(patch.tag);
            let segment = maker.map(|own| job.path.points()[own as usize].source.segment);
            let most = worst.entry((segment, distance < 0.0)).or_default();
            if distance.abs() > most.0 {
                *most = (distance.abs(), k);
            }
        }
        let mut lines: Vec<(f64, usize)> = worst.into_values().collect();
        lines.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut not_reached = None::<(f64, Vector3<f64>, f64)>;
        for (patch, above) in part.not_reached.iter().filter(|own| own.1 > tolerance(&own.0).unwrap_or(GOUGE_MM)) {
            let (most, at, area) = not_reached.get_or_insert((0.0, patch.position, 0.0));
            *area += patch.area_mm2();
            if *above > *most {
                (*most, *at) = (*above, patch.position);
            }
        }
        Some(Self { sides, lines: lines.into_iter().map(|own| own.1).collect(), not_reached })
    }

    /// Iterates over names and sides.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &Side)> {
        PART_NAMES.into_iter().zip(&self.sides)
    }
}

impl Machined {
    fn part(&self) -> Option<(&AgainstPart, &PartSides)> {
        self.surface.against_part.as_ref().zip(self.part.as_ref())
    }

    /// Returns the reference of pictures, which is the part where one is given, as that is what will be measured: in words, and how far the surfaces without compensation
    /// and as written are from it, mm.
    pub fn reference(&self) -> (String, [&[Option<f64>]; 2], [&Side; 2]) {
        if let Some((part, own)) = self.part() {
            let surfaces = [1, 2].map(|course| part.surfaces[course].as_slice());
            return (format!("against the part ({})", part.name), surfaces, [&own.sides[1], &own.sides[2]]);
        }
        let surfaces = [0, 1].map(|course| self.surface.deviations[course].as_slice());
        ("against the surface that the program describes".into(), surfaces, self.sides.each_ref())
    }

    /// Returns all courses by name: against the programmed surface, and against the part.
    pub fn courses(&self) -> Vec<(String, Vec<Option<f64>>)> {
        let part = self.surface.against_part.iter().flat_map(|part| PART_NAMES.iter().zip(&part.surfaces));
        let all = NAMES.iter().zip(&self.surface.deviations).chain(part);
        all.map(|(name, own)| (name.to_string(), own.clone())).chain(self.uncertain_surfaces()).collect()
    }

    /// Returns what each tool made last is off as written, split; a shift in the axes of the workpiece.
    fn splits(&self, job: &ProgramJob) -> Vec<(Option<u32>, Split)> {
        let tool = |patch: &Patch| patch.tag.map(|tag| job.path.points()[tag as usize].tool);
        let tools: BTreeSet<Option<u32>> = self.surface.patches.iter().filter_map(tool).collect();
        let deviations = self.reference().1[1];
        let of = |own: Option<u32>| {
            let made = self.surface.patches.iter().zip(deviations).filter(|(patch, _)| tool(patch) == Some(own));
            let places = made.filter_map(|(patch, mm)| Some((patch.normal, patch.area_mm2(), (*mm)?)));
            let found = split(places)?;
            Some((own, Split { shift_mm: self.surface.axes.tr_mul(&found.shift_mm), ..found }))
        };
        tools.into_iter().filter_map(of).collect()
    }

    /// Returns what each tool made last, if there are several or one has a tolerance of its own.
    pub fn tools(&self, job: &ProgramJob) -> Vec<ToolSides> {
        let tool = |patch: &Patch| patch.tag.map(|tag| job.path.points()[tag as usize].tool);
        let made = self.surface.patches.iter().filter_map(|patch| Some((tool(patch)?, tolerance_mm(job, patch.tag))));
        let tools: BTreeMap<_, _> = made.collect();
        if tools.len() == 1 && tools.values().all(|own| *own == job.process.tolerance_mm) {
            return Vec::new();
        }
        let sides = |(own, tolerance_mm): (Option<u32>, Option<f64>)| {
            let of = |course| Side::new(&self.surface, course, &|_| tolerance_mm, &|patch| tool(patch) == Some(own));
            ToolSides { tool: own, tolerance_mm, sides: self.reference().1.map(of) }
        };
        tools.into_iter().map(sides).collect()
    }

    /// Returns the smallest tolerance of a tool, if any has one, mm: where colours end.
    pub fn least_tolerance_mm(&self, job: &ProgramJob) -> Option<f64> {
        let own = self.tools.iter().filter_map(|own| own.tolerance_mm).min_by(f64::total_cmp);
        own.or(job.process.tolerance_mm)
    }

    /// Returns in a sentence how much of the surface is within tolerance without compensation and as written; empty without a tolerance.
    pub fn within_text(&self, job: &ProgramJob, [before, after]: [&Side; 2]) -> String {
        if after.judged == 0.0 {
            return String::new();
        }
        let what = if after.judged < after.area { "what has a tolerance" } else { "the machined surface" };
        let [before, after] = [before, after].map(|side| percent(side.within / side.judged));
        format!(" {after} of {what} is within {}, {before} without.", self.tolerance_text(job))
    }

    /// Returns what the surface is to be within, in words.
    pub fn tolerance_text(&self, job: &ProgramJob) -> String {
        let least = self.least_tolerance_mm(job);
        let is_one = self.tools.iter().all(|own| own.tolerance_mm == least);
        match least.filter(|_| is_one) {
            Some(tolerance) => format!("{tolerance} mm"),
            None => "the tolerance of the tool that made it".into(),
        }
    }

    /// Returns in sentences what is left on the part of the drawing, and missing of it.
    pub fn against_sentences(&self, job: &ProgramJob) -> String {
        let Some((part, own)) = self.part() else { return String::new() };
        // What is less is rounding.
        let of = |found: Option<(f64, usize)>| {
            millimetres(found.map_or(0.0, |own| if own.0 < 1e-5 { 0.0 } else { own.0 }), 4)
        };
        let at = |found: Option<(f64, usize)>| {
            let place = found.filter(|own| own.0 >= GOUGE_MM).and_then(|own| self.place(job, own.1, 1));
            of(found) + &place.map_or_else(String::new, |place| format!(" ({place})"))
        };
        let [programmed, before, after] = &own.sides;
        let mut text = format!(
            "{} the part ({}) up to {} is left and {} missing as written; {} and {} without compensation; {} and {} as programmed.{}\n",
            if job.uncertainty.is_some() { "With nominal numbers, against" } else { "Against" },
            part.name,
            at(after.left),
            at(after.missing),
            of(before.left),
            of(before.missing),
            of(programmed.left),
            of(programmed.missing),
            self.within_text(job, [before, after]),
        );
        if let Some((most, at, area)) = own.not_reached {
            let [x, y, z]: [f64; 3] = self.surface.axes.tr_mul(&at).into();
            text += &format!(
                "No move of the program reaches {area:.0} mm² of the stock above the part: up to {} is left there, most at ({x:.1}, {y:.1}, {z:.1}) mm.\n",
                millimetres(most, 2)
            );
        }
        let nearest = part.surfaces[0].iter().flatten().map(|own| own.abs()).fold(f64::INFINITY, f64::min);
        if nearest > NEAR_MM && nearest.is_finite() {
            let nearest = millimetres(nearest, 2);
            text += &format!(
                "The program comes no nearer to the part than {nearest}: is the part in the frame of the program?\n"
            );
        }
        text
    }

    /// Returns a caution if the program as written gouges the part beyond tolerance; empty otherwise.
    pub fn gouge_text(&self, job: &ProgramJob) -> String {
        let Some((part, own)) = self.part() else { return String::new() };
        let gouge = |patch: &usize| {
            let depth = part.surfaces[2][*patch].filter(|own| *own < 0.0)?;
            let tolerance = tolerance_mm(job, self.surface.patches[*patch].tag)?;
            Some((*patch, tolerance, -depth / tolerance))
        };
        let worst = own.lines.iter().filter_map(gouge).max_by(|a, b| a.2.total_cmp(&b.2));
        let Some((patch, tolerance, _)) = worst else { return String::new() };
        let [programmed, _, written] = [0, 1, 2].map(|own| part.surfaces[own][patch].filter(|own| *own < 0.0));
        let [programmed, written] =
            [programmed, written].map(|own| own.map_or_else(|| "not".into(), |own| millimetres(-own, 4)));
        format!(
            "The program as written gouges the part ({}) by {written} ({}), beyond the tolerance of {tolerance} mm; the surface that it describes is {programmed} within the part there.\n",
            part.name,
            self.line_text(job, patch)
        )
    }

    /// Returns the line that makes a patch as written, or that there is none.
    fn line_text(&self, job: &ProgramJob, patch: usize) -> String {
        self.place(job, patch, 1).unwrap_or_else(|| "where nothing is to be cut".into())
    }

    /// Returns the tables of lines out of tolerance and of tools.
    pub fn against_tables(&self, job: &ProgramJob) -> Vec<SmallTable> {
        let signed = |own: Option<f64>| {
            let sign = |own: f64| if own < 0.0 { "\u{2212}" } else { "" };
            own.map_or_else(|| "–".into(), |own| sign(own).to_string() + &millimetres(own.abs(), 4))
        };
        let tolerance = |own: Option<f64>| own.map_or_else(|| "–".into(), |own| format!("{own} mm"));
        let lines = self.part().filter(|own| !own.1.lines.is_empty()).map(|(part, own)| {
            let row = |patch: &usize| {
                let [programmed, before, after] = [0, 1, 2].map(|own| part.surfaces[own][*patch]);
                let [after, before, programmed] = [after, before, programmed].map(signed);
                let allowed = tolerance(tolerance_mm(job, self.surface.patches[*patch].tag));
                vec![self.line_text(job, *patch), after, before, programmed, allowed]
            };
            let (listed, count) = (own.lines.len().min(LISTED), own.lines.len());
            let caption = format!("Lines out of tolerance against the part as written, the worst {listed} of {count}: left (+), missing (\u{2212})");
            let header = ["where", "as written", "without compensation", "as programmed", "tolerance"];
            SmallTable { caption, header: header.map(String::from).into(), rows: own.lines[..listed].iter().map(row).collect() }
        });
        let row = |own: &ToolSides| {
            let share = |side: &Side| match side.judged {
                0.0 => "–".into(),
                judged => percent(side.within / judged),
            };
            let most = |found: Option<(f64, usize)>| {
                found.map_or_else(
                    || "–".into(),
                    |(mm, patch)| format!("{}, {}", millimetres(mm, 4), self.line_text(job, patch)),
                )
            };
            let [before, after] = &own.sides;
            let tool = own.tool.map_or_else(|| "–".into(), |own| own.to_string());
            let area = format!("{:.0} mm²", after.area);
            vec![
                tool,
                tolerance(own.tolerance_mm),
                area,
                share(before),
                share(after),
                most(after.left),
                most(after.missing),
            ]
        };
        let header = ["tool", "tolerance", "area", "within before", "as written", "most left", "most missing"];
        let tools = (!self.tools.is_empty()).then(|| SmallTable {
            caption: format!("What each tool made last, {}", self.reference().0),
            header: header.map(String::from).into(),
            rows: self.tools.iter().map(row).collect(),
        });
        let signed = |own: f64| signed(Some(if own.abs() < 5e-5 { 0.0 } else { own }));
        let row = |(tool, own): &(Option<u32>, Split)| {
            let tool = tool.map_or_else(|| "–".into(), |own| own.to_string());
            let [x, y, z]: [f64; 3] = own.shift_mm.into();
            vec![tool, signed(own.offset_mm), signed(x), signed(y), signed(z), millimetres(own.form_mm, 4)]
        };
        let splits = self.splits(job);
        let header = ["tool", "size: offset along the normal", "location: x", "y", "z", "form"];
        let features = (!splits.is_empty()).then(|| SmallTable {
            caption: format!(
                "What each tool made last is off as written, {}: its size, its location after the datum of the program (W), and its form from lowest to highest",
                self.reference().0
            ),
            header: header.map(String::from).into(),
            rows: splits.iter().map(row).collect(),
        });
        lines.into_iter().chain(tools).chain(features).collect()
    }

    /// Adds what is known against the part and of each tool to the JSON of the surface.
    pub fn add_against(&self, job: &ProgramJob, report: &mut Value) {
        let named = |names: &[(&str, usize)], sides: &[Side]| -> Value {
            let own = |((name, course), side): (&(&str, usize), &Side)| {
                (name.to_string(), self.side_json(job, side, *course))
            };
            names.iter().zip(sides).map(own).collect()
        };
        let courses = [("without_compensation", 0), ("as_written", 1)];
        if let Some((part, own)) = self.part() {
            let line = |patch: &usize| {
                let [programmed, before, written] = [0, 1, 2].map(|own| part.surfaces[own][*patch]);
                let mut line = self.patch_json(job, Some((written.unwrap_or(0.0), *patch)), 1);
                (line["without_compensation_mm"], line["as_programmed_mm"]) = (json!(before), json!(programmed));
                line["tolerance_mm"] = json!(tolerance_mm(job, self.surface.patches[*patch].tag));
                line
            };
            let mut against = named(&[("as_programmed", PROGRAMMED), courses[0], courses[1]], &own.sides);
            (against["part"], against["lines_out_of_tolerance"]) = (json!(part.name), json!(own.lines.len()));
            against["worst_lines"] = own.lines.iter().take(LISTED).map(line).collect();
            against["not_reached"] = own.not_reached.map_or(Value::Null, |(most, at, area)| {
                let [x, y, z]: [f64; 3] = self.surface.axes.tr_mul(&at).into();
                json!({ "mm": most, "position_mm": [x, y, z], "area_mm2": area })
            });
            report["against_part"] = against;
        }
        let feature = |(tool, own): &(Option<u32>, Split)| {
            let shift: [f64; 3] = own.shift_mm.into();
            json!({ "tool": tool, "size_offset_mm": own.offset_mm, "location_mm": shift, "form_mm": own.form_mm })
        };
        report["features"] = self.splits(job).iter().map(feature).collect();
        if !self.tools.is_empty() {
            let tool = |own: &ToolSides| {
                let mut tool = named(&courses, &own.sides);
                (tool["tool"], tool["tolerance_mm"]) = (json!(own.tool), json!(own.tolerance_mm));
                tool
            };
            report["by_tool"] = self.tools.iter().map(tool).collect();
        }
    }
}
