//! The numbers that the paper does not publish, sought from those that it quotes: study 06 with other feet, platforms, drives and
//! errors, and with every reading of what the paper leaves open. Says how many of the 19 quoted numbers can agree at once, and how far the
//! best set is determined.
//!
//! ```sh
//! cargo run --release --example paper_numbers
//! ```

use std::fmt::Write as _;

use argmin::{
    core::{CostFunction, Error, Executor, State},
    solver::neldermead::NelderMead,
};
use kinetostat::{
    Work,
    input::Folder,
    questions::{
        Overrides, Study, StudyKind,
        validation::{self, Relation},
    },
};
use rayon::prelude::*;

const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/06_paper/study.toml");
/// Points of each circle: those of the search, and those of study 06, by which numbers agree or not.
const POINTS: [usize; 2] = [37, 361];

/// How many readings are searched, and how many steps of Nelder–Mead each.
const STAGES: [(usize, u64); 2] = [(32, 60), (8, 200)];

/// What the paper leaves open and cannot be measured by degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reading {
    /// Signs of the errors of the chains x, y and z.
    signs: [f64; 3],
    /// Where the force of eq. (17) points.
    law: Law,
    /// Whether the tool tip is where the deflection is meant, or the platform point.
    at_tool_tip: bool,
    /// Whether circles at Q1 to Q3 are centred there, or moved inward until they touch the corner from within.
    is_centred: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    Printed,
    Rotated,
    AlongFeed,
    AgainstFeed,
}

impl Law {
    const ALL: [Law; 4] = [Law::Printed, Law::Rotated, Law::AlongFeed, Law::AgainstFeed];

    fn keys(self) -> &'static str {
        match self {
            Law::Printed => "radial_force_N = 215.0\ntangential_force_N = -10.0\nlaw = \"paper_eq17\"",
            Law::Rotated => "radial_force_N = 215.0\ntangential_force_N = -10.0\nlaw = \"rotated\"",
            Law::AlongFeed => "radial_force_N = 10.0\ntangential_force_N = 215.0\nlaw = \"rotated\"",
            Law::AgainstFeed => "radial_force_N = -10.0\ntangential_force_N = -215.0\nlaw = \"rotated\"",
        }
    }
}

impl Reading {
    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for bits in 0..8 {
            let signs = std::array::from_fn(|i| if bits >> i & 1 == 0 { 1.0 } else { -1.0 });
            for law in Law::ALL {
                for at_tool_tip in [true, false] {
                    for is_centred in [true, false] {
                        all.push(Self { signs, law, at_tool_tip, is_centred });
                    }
                }
            }
        }
        all
    }

    fn text(&self) -> String {
        let sign = |s: f64| if s > 0.0 { '+' } else { '-' };
        format!(
            "errors {}{}{}, force {}, at the {}, circles {}",
            sign(self.signs[0]),
            sign(self.signs[1]),
            sign(self.signs[2]),
            match self.law {
                Law::Printed => "as printed",
                Law::Rotated => "as a rotation",
                Law::AlongFeed => "along the feed",
                Law::AgainstFeed => "against the feed",
            },
            if self.at_tool_tip { "tool tip" } else { "platform point" },
            if self.is_centred { "centred at the points" } else { "within the corners" },
        )
    }
}

/// Numbers that are sought: name, the value of the preset or of study 06, least and most.
const SOUGHT: [(&str, f64, [f64; 2]); 7] = [
    ("leg.foot.length", 165.0, [60.0, 400.0]),
    ("leg.foot.width", 26.0, [8.0, 80.0]),
    ("leg.foot.height", 20.0, [8.0, 80.0]),
    ("leg.offset.translation.x", 31.0, [5.0, 100.0]),
    ("leg.rail.stiffness", 1e6, [1e3, 1e7]),
    ("size of the errors, degrees", 1.0, [0.5, 1.5]),
    ("diameter of the small circle, mm", 2.0, [1.0, 10.0]),
];
const OF_MACHINE: usize = 5;

/// A number from any coordinate: within its bounds, and on a logarithmic scale.
fn value(k: usize, x: f64) -> f64 {
    let (_, _, [low, high]) = SOUGHT[k];
    low * (high / low).powf(0.5 + 0.5 * x.sin())
}

fn coordinate(k: usize, value: f64) -> f64 {
    let (_, _, [low, high]) = SOUGHT[k];
    (2.0 * (value / low).ln() / (high / low).ln() - 1.0).clamp(-1.0, 1.0).asin()
}

/// How many of the quoted numbers agree, and by how much the others do not: 0 where all do, at most 1 for each.
struct Met {
    agreeing: usize,
    misfit: f64,
    compared: Vec<(String, String, f64, bool)>,
}

fn meet(text: &str, reading: &Reading, values: &[f64], points: usize) -> Option<Met> {
    let mut process = format!(
        "schema = 1\n[placement]\nreference = \"platform_point\"\n[force.path_frame]\naxial_force_N = -25.0\n{}\n",
        reading.law.keys()
    );
    if !reading.at_tool_tip {
        process += "[compensate]\ntarget = \"platform_point\"\n";
    }
    for (chain, sign) in ["x", "y", "z"].iter().zip(reading.signs) {
        let turn = sign * values[OF_MACHINE];
        write!(process, "[[chain_error]]\nchain = \"{chain}\"\nturn_about_drive_axis_deg = {turn:?}\n").ok()?;
    }
    let mut study: toml::Table = text.parse().ok()?;
    let validation = study.get_mut("validation")?.as_table_mut()?;
    validation.get_mut("variant")?.as_array_mut()?.truncate(1);
    validation.remove("figure");
    for case in validation.get_mut("case")?.as_array_mut()? {
        let name = case["name"].as_str()?.to_string();
        let circle = case["circle"].as_table_mut()?;
        let inside = |x: f64, y: f64, z: f64| toml::Value::try_from([x, y, z]).ok();
        let inward = match (name.as_str(), reading.is_centred) {
            ("small circle at Q1", _) => {
                circle.insert("diameter_mm".into(), values[OF_MACHINE + 1].into());
                None
            }
            ("Q1", false) => inside(101.35, 101.35, 126.35),
            ("Q2" | "Q3", false) => {
                let machine = kinetostat::Machine::named("orthoglide").ok()?;
                let q = machine.points.iter().find(|point| point.name == name)?.position;
                inside(q.x - 25.0 * q.x.signum(), q.y - 25.0 * q.y.signum(), q.z)
            }
            _ => None,
        };
        if let Some(centre) = inward {
            circle.remove("centre_point");
            circle.insert("centre_mm".into(), centre);
        }
    }
    let folder = Folder::in_memory([("process.toml".to_string(), process.into_bytes())]);
    let parameters = SOUGHT[..OF_MACHINE].iter().zip(values).map(|((name, ..), value)| (name.to_string(), *value));
    let overrides = Overrides { points: Some(points), parameters: parameters.collect(), ..Overrides::default() };
    let study = Study::from_toml(&study.to_string(), "study.toml", folder, &overrides).ok()?;
    let StudyKind::Validation(study, _) = study.kind else { return None };
    let results = validation::run(&study, &Work::default()).ok()?;
    let mut met = Met { agreeing: 0, misfit: 0.0, compared: Vec::new() };
    for (quoted, compared) in study.quoted.iter().zip(&results.compared) {
        let ours = *compared.ours.first()?.as_ref().ok()?;
        let scale = quoted.agreement * if quoted.value == 0.0 { 1.0 } else { quoted.value.abs() };
        let off = match quoted.relation {
            Relation::About => ((ours - quoted.value).abs() / scale - 1.0).max(0.0),
            Relation::AtLeast => ((quoted.value - ours) / scale).max(0.0),
            Relation::AtMost => ((ours - quoted.value) / scale).max(0.0),
        };
        met.agreeing += usize::from(compared.agrees);
        met.misfit += off / (1.0 + off);
        met.compared.push((quoted.source.clone(), study.cases[quoted.case].clone(), ours, compared.agrees));
    }
    Some(met)
}

/// What Nelder–Mead makes small.
struct Search<'a> {
    text: &'a str,
    reading: &'a Reading,
}

impl CostFunction for Search<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(meet(self.text, self.reading, &values(x), POINTS[0]).map_or(100.0, |met| met.misfit))
    }
}

fn values(x: &[f64]) -> Vec<f64> {
    x.iter().enumerate().map(|(k, &x)| value(k, x)).collect()
}

/// The best place from `start`, and the misfit there.
fn search(text: &str, reading: &Reading, start: &[f64], iterations: u64) -> (Vec<f64>, f64) {
    let corner = |k: usize| {
        let mut x = start.to_vec();
        x[k] += if x[k] > 0.0 { -0.3 } else { 0.3 };
        x
    };
    let simplex = std::iter::once(start.to_vec()).chain((0..start.len()).map(corner)).collect();
    let run = Executor::new(Search { text, reading }, NelderMead::new(simplex))
        .configure(|state| state.max_iters(iterations))
        .run();
    let found = run.ok().and_then(|run| Some((run.state().get_best_param()?.clone(), run.state().get_best_cost())));
    found.unwrap_or_else(|| (start.to_vec(), f64::INFINITY))
}

/// The last value of number `k` at which the `numbers` still agree, moved alone up or down by this `sign`: doubled steps, then halved ones, down to 1 %.
fn end_of_agreement(numbers: &[f64], k: usize, sign: f64, agree: impl Fn(&[f64]) -> bool) -> f64 {
    let (_, _, [low, high]) = SOUGHT[k];
    let moved = |by: f64| (numbers[k] * (sign * by).exp()).clamp(low, high);
    let agrees = |by: f64| {
        let mut other = numbers.to_vec();
        other[k] = moved(by);
        agree(&other)
    };
    let (mut inside, mut step) = (0.0, 0.01);
    while moved(inside) != moved(inside + step) && agrees(inside + step) {
        inside += step;
        step *= 2.0;
    }
    while step > 0.01 {
        step /= 2.0;
        if agrees(inside + step) {
            inside += step;
        }
    }
    moved(inside)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(STUDY).map_err(|error| format!("{STUDY}: {error}"))?;
    let preset: Vec<f64> = SOUGHT.iter().enumerate().map(|(k, (_, value, _))| coordinate(k, *value)).collect();
    let first = Reading { signs: [1.0, -1.0, 1.0], law: Law::Printed, at_tool_tip: true, is_centred: true };
    let as_is = meet(&text, &first, &values(&preset), POINTS[1]).ok_or("study 06 has no answer")?;
    println!("As study 06 has it: {} of {} agree.", as_is.agreeing, as_is.compared.len());

    // Every reading with the numbers of study 06, then the nearest ones searched on, fewer and farther each time.
    let readings = Reading::all();
    let mut found: Vec<(Reading, Vec<f64>, f64)> = readings
        .par_iter()
        .map(|reading| {
            let misfit = meet(&text, reading, &values(&preset), POINTS[0]).map_or(f64::INFINITY, |met| met.misfit);
            (*reading, preset.clone(), misfit)
        })
        .collect();
    for (kept, iterations) in STAGES {
        found.sort_by(|a, b| a.2.total_cmp(&b.2));
        found.truncate(kept);
        eprintln!("{} readings are searched, {iterations} steps each; misfit {:.3} so far", found.len(), found[0].2);
        found = found
            .par_iter()
            .map(|(reading, x, _)| {
                let (x, misfit) = search(&text, reading, x, iterations);
                (*reading, x, misfit)
            })
            .collect();
    }
    println!(
        "{} readings, of which the nearest {} were searched, and of these {}.",
        readings.len(),
        STAGES[0].0,
        STAGES[1].0
    );
    let mut best: Vec<(Reading, Vec<f64>, Met)> = found
        .into_par_iter()
        .filter_map(|(reading, x, _)| {
            let met = meet(&text, &reading, &values(&x), POINTS[1])?;
            Some((reading, x, met))
        })
        .collect();
    best.sort_by(|a, b| b.2.agreeing.cmp(&a.2.agreeing).then(a.2.misfit.total_cmp(&b.2.misfit)));

    println!("\nagreeing  misfit  reading");
    for (reading, _, met) in &best {
        println!("{:8}  {:6.3}  {}", met.agreeing, met.misfit, reading.text());
    }

    let (reading, x, met) = best.first().ok_or("nothing was found")?;
    println!("\nThe best set ({}): {} of {} agree.", reading.text(), met.agreeing, met.compared.len());
    let end = |&(k, sign): &(usize, f64)| {
        let agree = |numbers: &[f64]| {
            meet(&text, reading, numbers, POINTS[1]).is_some_and(|other| other.agreeing >= met.agreeing)
        };
        end_of_agreement(&values(x), k, sign, agree)
    };
    let ends: Vec<(usize, f64)> = (0..SOUGHT.len()).flat_map(|k| [(k, -1.0), (k, 1.0)]).collect();
    let ends: Vec<f64> = ends.par_iter().map(end).collect();
    for (k, (name, before, _)) in SOUGHT.iter().enumerate() {
        println!(
            "  {name}: {:.4} (study 06: {before}); as many agree from {:.4} to {:.4}",
            value(k, x[k]),
            ends[2 * k],
            ends[2 * k + 1]
        );
    }
    println!();
    for (source, case, ours, agrees) in &met.compared {
        println!("  {} {ours:12.4}  {source} ({case})", if *agrees { "yes" } else { "no " });
    }
    Ok(())
}
