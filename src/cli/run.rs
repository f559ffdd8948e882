//! `kinetostat run`: computes a study and writes its tables and figures.

use std::{io::IsTerminal, path::PathBuf, time::Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use kinetostat::{
    error::{Error, Result},
    report::{Manifest, OutputFile, figures::Figure, prepare, workspace_map as map_report, write_all},
    study::{Overrides, Study, StudyKind, workspace_map},
};
use rayon::prelude::*;
use serde_json::json;

use super::{Ending, print};

/// Compute a study: its tables, figures and a summary of its answer.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat run studies/01_workspace_map
  kinetostat run studies/01_workspace_map --grid 21            (21 points along each axis)
  kinetostat run studies/01_workspace_map --grid 5,5,3 --out /tmp/quick --threads 1")]
pub struct RunArguments {
    /// Study folder (with a study.toml), or a study file
    study: PathBuf,
    /// Grid points along x,y,z, or one number for all, instead of the study's
    #[arg(long, value_parser = grid, allow_hyphen_values = true)]
    grid: Option<[usize; 3]>,
    /// Folder for the results [default: results/<name of the study's folder>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Threads [default: all processors]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Write tables only
    #[arg(long)]
    no_figures: bool,
}

fn grid(text: &str) -> std::result::Result<[usize; 3], String> {
    let parse = |part: &str| part.trim().parse::<usize>().map_err(|_| format!("\"{part}\" is not a count"));
    match text.split(',').map(parse).collect::<std::result::Result<Vec<_>, _>>()?.as_slice() {
        [n] => Ok([*n; 3]),
        [x, y, z] => Ok([*x, *y, *z]),
        other => Err(format!("expected one count or three, got {}", other.len())),
    }
}

pub fn run(arguments: &RunArguments) -> Result<Ending> {
    let study = Study::open(&arguments.study, &Overrides { grid: arguments.grid })?;
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::Argument { argument: "--threads".into(), problem: e.to_string() })?;
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from("results").join(&study.name));
    prepare(&out)?;
    print(&format!("{}\n\n", study.question))?;
    match &study.kind {
        StudyKind::WorkspaceMap(map) => pool.install(|| run_map(arguments, &study, map, &out)),
    }
}

fn run_map(
    arguments: &RunArguments,
    study: &Study,
    map_study: &workspace_map::WorkspaceMapStudy,
    out: &std::path::Path,
) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress_bar(map_study.grid.len());
    let map = workspace_map::run(map_study, &|| bar.inc(1));
    bar.finish_and_clear();
    let wall_time_s = started.elapsed().as_secs_f64();
    let statuses =
        map.points.iter().flat_map(|point| &point.effects).map(|e| e.as_ref().map_or_else(|f| f.status, |_| "solved"));
    let manifest = Manifest {
        program: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        study: study.name.clone(),
        input_sha256: Manifest::hash(&study.fingerprint),
        seed: None,
        settings: json!({ "grid": map_study.grid.counts(), "tool_angles": map_study.phis.len() }),
        statuses: Manifest::count(statuses),
        threads: rayon::current_num_threads(),
        wall_time_s,
    };
    let table = map_report::csv(&map)
        .map_err(|e| Error::Write { file: out.join("map.csv"), source: std::io::Error::other(e) })?;
    let summary = map_report::summary_json(&map);
    let mut files = vec![
        OutputFile::new("map.csv", table),
        OutputFile::new("summary.json", format!("{summary:#}\n")),
        OutputFile::new("manifest.json", manifest.to_json()),
    ];
    if !arguments.no_figures {
        files.extend(drawn(map_report::figures(&map))?);
    }
    let written = write_all(out, &files)?;
    let mut closing = format!("{}\n", map_report::summary_text(&map));
    closing += &format!("{} points in {:.1} s. Written to {}:\n", map.points.len(), wall_time_s, out.display());
    for path in &written {
        closing += &format!("  {}\n", path.file_name().unwrap_or_default().to_string_lossy());
    }
    print(&closing)?;
    let complete = manifest.statuses.iter().all(|count| count.status == "solved");
    Ok(if complete { Ending::Complete } else { Ending::SomeUnsolved })
}

/// Each figure as SVG and PNG.
fn drawn(figures: Vec<(String, Figure)>) -> Result<Vec<OutputFile>> {
    let drawn = figures.par_iter().map(|(name, figure)| {
        let fault =
            |e: kinetostat::report::figures::FigureError| Error::Figure { name: name.clone(), problem: e.to_string() };
        Ok([
            OutputFile::new(format!("{name}.svg"), figure.svg().map_err(fault)?),
            OutputFile::new(format!("{name}.png"), figure.png().map_err(fault)?),
        ])
    });
    Ok(drawn.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// A bar with rate and time left on a terminal, nothing in a pipe.
fn progress_bar(points: usize) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(points as u64), target);
    let template = "{bar:40} {pos}/{len} points, {per_sec}, {eta} left";
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
