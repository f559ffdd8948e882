//! `kinetostat run`: computes a study and writes its tables, figures and page.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use clap::Args;
use kinetostat::{
    error::{Error, Result},
    report::{
        Manifest, OutputFile,
        exchange::{self, Image, Table},
        figures::{Colours, Figure},
        file_stem,
        page::{self, Description, MACHINE_AT_HOME, ResultFolder},
        path as path_report, placement as placement_report, prepare, remove, superposition as superposition_report,
        validation as validation_report, workspace_map as map_report, write_all,
    },
    study::{
        Overrides, Study, StudyKind,
        deflected_pose::{self, DeflectedPose},
        path_study::{self, PathStudy},
        placement::{self, Event, PlacementStudy, Watch},
        superposition::{self, SuperpositionStudy},
        validation::{self, ValidationStudy},
        workspace_map::{self, WorkspaceMapStudy},
    },
};
use rayon::prelude::*;
use serde_json::json;

use super::{
    Ending,
    output_choice::{ColourMap, Format},
    print, progress,
    report::PAGE,
};

/// Compute a study: its tables, figures, a summary of its answer and a page that shows them.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  kinetostat run studies/01_workspace_map
  kinetostat run studies/*                                     (all of them, one after another)
  kinetostat run studies/01_workspace_map --grid 21            (21 points along each axis)
  kinetostat run studies/01_workspace_map --grid 5,5,3 --out /tmp/quick --threads 1
  kinetostat run studies/01_workspace_map --format csv,parquet,vti --colours cividis

Beside its tables a result folder has summary.json and manifest.json. csv-metadata.json describes the columns of CSV files,
map.vti.json the arrays and status numbers of map.vti.")]
pub struct RunArguments {
    /// Study folders (with a study.toml), or study files
    #[arg(required = true)]
    studies: Vec<PathBuf>,
    /// Grid points along x,y,z, or one number for all, instead of the study's
    #[arg(long, value_parser = grid, allow_hyphen_values = true)]
    grid: Option<[usize; 3]>,
    /// Points along the circle of a path study, instead of the study's
    #[arg(long)]
    points: Option<usize>,
    /// Folder for the results of a single study [default: results/<name of the study's folder>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Threads [default: all processors]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Write tables and the page only
    #[arg(long)]
    no_figures: bool,
    /// Formats of tables and maps, separated by commas; without csv there is no page
    #[arg(long, value_enum, value_delimiter = ',', default_value = "csv")]
    format: Vec<Format>,
    /// Colours of maps in figures
    #[arg(long, value_enum, default_value = "viridis")]
    colours: ColourMap,
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
    if let (Some(out), [_, _, ..]) = (&arguments.out, arguments.studies.as_slice()) {
        let problem = format!("{} can hold the results of one study, got {}", out.display(), arguments.studies.len());
        return Err(Error::Argument { argument: "--out".into(), problem });
    }
    let overrides = Overrides { grid: arguments.grid, points: arguments.points };
    let studies: Vec<Study> =
        arguments.studies.iter().map(|path| Study::open(path, &overrides)).collect::<Result<_>>()?;
    for (i, study) in studies.iter().enumerate() {
        if studies[..i].iter().any(|other| other.name == study.name) {
            let problem = format!("two studies are called \"{}\" and would share a result folder", study.name);
            return Err(Error::Argument { argument: arguments.studies[i].display().to_string(), problem });
        }
        check_formats(arguments, study)?;
    }
    let mut ending = Ending::Complete;
    for study in &studies {
        if run_study(arguments, study)? == Ending::SomeUnsolved {
            ending = Ending::SomeUnsolved;
        }
    }
    Ok(ending)
}

/// Only maps can be images.
fn check_formats(arguments: &RunArguments, study: &Study) -> Result<()> {
    let has_map = matches!(study.kind, StudyKind::WorkspaceMap(_) | StudyKind::Superposition(_));
    if !has_map && arguments.format.iter().all(|format| matches!(format, Format::Vti)) {
        let problem = format!("study {} has no map over the workspace; expected csv or parquet, too", study.name);
        return Err(Error::Argument { argument: "--format vti".into(), problem });
    }
    Ok(())
}

fn run_study(arguments: &RunArguments, study: &Study) -> Result<Ending> {
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::Argument { argument: "--threads".into(), problem: e.to_string() })?;
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from("results").join(&study.name));
    prepare(&out)?;
    print(&format!("{}\n\n", study.question))?;
    pool.install(|| match &study.kind {
        StudyKind::WorkspaceMap(map) => run_map(arguments, study, map, &out),
        StudyKind::Path(path) => run_path(arguments, study, path, &out),
        StudyKind::Placement(placement) => run_placement(arguments, study, placement, &out),
        StudyKind::Superposition(sought) => run_superposition(arguments, study, sought, &out),
        StudyKind::Validation(validation) => run_validation(arguments, study, validation, &out),
    })
}

fn run_map(arguments: &RunArguments, study: &Study, map_study: &WorkspaceMapStudy, out: &Path) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress(map_study.grid.len(), "points");
    let map = workspace_map::run(map_study, &|| bar.inc(1));
    bar.finish_and_clear();
    let statuses =
        map.points.iter().flat_map(|point| &point.effects).map(|e| e.as_ref().map_or_else(|f| f.status, |_| "solved"));
    let output = Output {
        study,
        out,
        manifest: manifest(
            study,
            json!({ "grid": map_study.grid.counts(), "tool_angles": map_study.phis.len() }),
            Manifest::count(statuses),
            started,
        ),
        tables: vec![("map".into(), map_report::table(&map))],
        map: Some(map_report::image(&map)),
        summary: map_report::summary_json(&map),
        figures: if arguments.no_figures { Vec::new() } else { map_report::figures(&map) },
        page: map_report::page(&map).with_answer(&map_report::summary_text(&map)),
        bent: if arguments.no_figures { None } else { deflected_pose::of_map(map_study) },
        closing: map_report::summary_text(&map),
    };
    output.write(arguments)
}

fn run_path(arguments: &RunArguments, study: &Study, path_study: &PathStudy, out: &Path) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress(path_study.stations.len() * path_study::passes(path_study), "points");
    let results = path_study::run(path_study, &|| bar.inc(1));
    bar.finish_and_clear();
    let compensated = results.sources.iter().flat_map(|source| &source.compensated);
    let statuses = compensated.map(|answer| answer.compensation.status.label());
    let times: serde_json::Map<String, serde_json::Value> =
        results.methods.iter().map(|m| (m.method.label(), json!(m.seconds_per_point * 1e6))).collect();
    let output = Output {
        study,
        out,
        manifest: manifest(
            study,
            json!({ "points": path_study.stations.len(), "microseconds_per_point": times }),
            Manifest::count(statuses),
            started,
        ),
        tables: vec![
            ("points".into(), path_report::points_table(&results)),
            ("methods".into(), path_report::methods_table(&results)),
        ],
        map: None,
        summary: path_report::summary_json(&results),
        figures: if arguments.no_figures { Vec::new() } else { path_report::figures(&results) },
        page: path_report::page(&results).with_answer(&path_report::summary_text(&results)),
        bent: if arguments.no_figures { None } else { deflected_pose::of_path(&results) },
        closing: format!("{}\n{}", path_report::summary_text(&results), path_report::methods_text(&results)),
    };
    output.write(arguments)
}

fn run_placement(arguments: &RunArguments, study: &Study, sought: &PlacementStudy, out: &Path) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress(sought.grid.len(), "places");
    let watched = bar.clone();
    let watch: Watch = Arc::new(move |event: &Event| match event {
        Event::Place => watched.inc(1),
        Event::Iteration { best } => watched.set_message(format!("refining, best {best:.6}")),
    });
    let results = placement::run(sought, &watch);
    bar.finish_and_clear();
    let statuses = results.cells.iter().map(placement_report::cell_status);
    let search = &sought.search;
    let settings = json!({
        "grid": sought.grid.counts(),
        "starts": search.starts,
        "max_iterations": search.max_iterations,
        "tolerance": search.tolerance,
        "coarse_to_fine": search.coarse_to_fine,
    });
    let entries = &results.entries;
    let mut tables = vec![
        ("candidates".to_string(), placement_report::candidates_table(sought, entries)),
        ("sweep".into(), placement_report::sweep_table(&results)),
        ("refinements".into(), placement_report::refinements_table(&results)),
    ];
    if !sought.objective.pareto.is_empty() {
        tables.push(("pareto".into(), placement_report::front_table(&results)));
    }
    let closing =
        format!("{}\n{}", placement_report::entries_table(sought, entries), placement_report::summary_text(&results));
    let output = Output {
        study,
        out,
        manifest: manifest(study, settings, Manifest::count(statuses), started),
        tables,
        map: None,
        summary: placement_report::summary_json(&results),
        figures: if arguments.no_figures { Vec::new() } else { placement_report::figures(&results) },
        page: placement_report::page(&results).with_answer(&placement_report::summary_text(&results)),
        bent: None,
        closing,
    };
    output.write(arguments)?;
    // Places where the workpiece cannot be cut are an answer; that there is no other is a failure.
    Ok(if results.best.is_some() { Ending::Complete } else { Ending::SomeUnsolved })
}

fn run_superposition(
    arguments: &RunArguments,
    study: &Study,
    sought: &SuperpositionStudy,
    out: &Path,
) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress(sought.grid.len() + sought.locations.len(), "points");
    let results = superposition::run(sought, &|| bar.inc(1));
    bar.finish_and_clear();
    let map = results.points.iter().map(|point| point.departures.as_ref().map_or_else(|f| f.status, |_| "solved"));
    let of_location = |found: &superposition::LocationResult| {
        let departures = found.departures.as_ref().map_or_else(|f| f.status, |_| "solved");
        [departures, found.ablation.as_ref().map_or_else(|f| f.status, |_| "solved")]
    };
    let statuses = map.chain(results.locations.iter().flat_map(of_location));
    let settings = json!({
        "grid": sought.grid.counts(),
        "tool_angles": sought.phis.len(),
        "tolerance_mm": sought.tolerance,
        "scales": sought.scales,
        "largest_factor": sought.largest_factor,
    });
    let output = Output {
        study,
        out,
        manifest: manifest(study, settings, Manifest::count(statuses), started),
        tables: vec![
            ("map".into(), superposition_report::map_table(&results)),
            ("safe_load".into(), superposition_report::safe_load_table(&results)),
            ("locations".into(), superposition_report::locations_table(&results)),
            ("largest_factors".into(), superposition_report::largest_factors_table(&results)),
            ("scaling".into(), superposition_report::scaling_table(&results)),
            ("slopes".into(), superposition_report::slopes_table(&results)),
            ("ablation".into(), superposition_report::ablation_table(&results)),
        ],
        map: Some(superposition_report::image(&results)),
        summary: superposition_report::summary_json(&results),
        figures: if arguments.no_figures { Vec::new() } else { superposition_report::figures(&results) },
        page: superposition_report::page(&results).with_answer(&superposition_report::summary_text(&results)),
        bent: None,
        closing: superposition_report::summary_text(&results),
    };
    output.write(arguments)
}

fn run_validation(arguments: &RunArguments, study: &Study, asked: &ValidationStudy, out: &Path) -> Result<Ending> {
    let started = Instant::now();
    let bar = progress(validation::work(asked), "points");
    let results = validation::run(asked, &|| bar.inc(1));
    bar.finish_and_clear();
    let answers = results.paths.iter().flat_map(|path| &path.sources).flat_map(|source| &source.compensated);
    let compared = results.compared.iter().flat_map(|compared| &compared.ours);
    let compared = compared.map(|ours| if ours.is_ok() { "solved" } else { "not_solved" });
    let statuses = answers.map(|answer| answer.compensation.status.label()).chain(compared);
    let points: Vec<usize> = results.paths.iter().map(|path| path.study.stations.len()).collect();
    let mut tables = vec![
        ("summary".to_string(), validation_report::quoted_table(&results)),
        ("variants".to_string(), validation_report::variants_table(&results)),
    ];
    for (name, path) in asked.cases.iter().zip(&results.paths) {
        tables.push((format!("points_{}", file_stem(name)), path_report::points_table(path)));
    }
    let output = Output {
        study,
        out,
        manifest: manifest(study, json!({ "points": points }), Manifest::count(statuses), started),
        tables,
        map: None,
        summary: validation_report::summary_json(&results),
        figures: if arguments.no_figures { Vec::new() } else { validation_report::figures(&results) },
        page: validation_report::page(&results).with_answer(&validation_report::summary_text(&results)),
        bent: None,
        closing: format!(
            "{}\n{}",
            validation_report::summary_table(&results),
            validation_report::summary_text(&results)
        ),
    };
    output.write(arguments)
}

fn manifest(
    study: &Study,
    settings: serde_json::Value,
    statuses: Vec<kinetostat::report::StatusCount>,
    started: Instant,
) -> Manifest {
    Manifest {
        program: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        study: study.name.clone(),
        input_sha256: Manifest::hash(&study.fingerprint),
        seed: None,
        settings,
        statuses,
        files: Vec::new(),
        threads: rayon::current_num_threads(),
        wall_time_s: started.elapsed().as_secs_f64(),
    }
}

/// What a study leaves in its result folder and on the screen.
struct Output<'a> {
    study: &'a Study,
    out: &'a Path,
    manifest: Manifest,
    /// Tables by name, without the ending that a format gives them.
    tables: Vec<(String, Table)>,
    /// The maps among them.
    map: Option<Image>,
    summary: serde_json::Value,
    figures: Vec<(String, Figure)>,
    /// Setting, answer, views and tables of the page; figures, name and question are filled in.
    page: Description,
    /// The machine bent by the load, if it is drawn.
    bent: Option<DeflectedPose>,
    closing: String,
}

impl Output<'_> {
    fn write(mut self, arguments: &RunArguments) -> Result<Ending> {
        self.tables
            .extend(self.figures.iter().filter_map(|(name, figure)| Some((format!("{name}_data"), figure.data()?))));
        self.draw_machine();
        let formats: Vec<exchange::Format> = arguments.format.iter().map(|format| (*format).into()).collect();
        // Pages show CSV tables.
        let has_page = formats.contains(&exchange::Format::Csv);
        let mut files = exchange::files(self.out, &self.tables, self.map.as_ref(), &formats)?;
        if has_page {
            files.push(OutputFile::new("report.json", self.description().to_json()));
        }
        files.push(OutputFile::new("summary.json", format!("{:#}\n", self.summary)));
        files.extend(drawn(std::mem::take(&mut self.figures), arguments.colours.into())?);
        let former = Manifest::files_in(self.out);
        self.manifest.files = files.iter().map(|file| file.name.clone()).collect();
        self.manifest.files.extend(has_page.then(|| PAGE.to_string()));
        files.push(OutputFile::new(Manifest::FILE, self.manifest.to_json()));
        let mut written = write_all(self.out, &files)?;
        // What the run before left here would be taken for results of this one.
        for name in former.iter().filter(|name| !self.manifest.files.contains(name)) {
            remove(&self.out.join(name))?;
        }
        // The page is made from what has been written, as `kinetostat report` makes it again.
        if has_page {
            let page = page::page(&ResultFolder::open(self.out)?, &self.out.join(PAGE))?;
            written.extend(write_all(self.out, &[OutputFile::new(PAGE, page)])?);
        }
        let mut closing = format!("{}\n", self.closing);
        closing +=
            &format!("{} in {:.1} s. Written to {}:\n", self.study.name, self.manifest.wall_time_s, self.out.display());
        for path in &written {
            closing += &format!("  {}\n", path.file_name().unwrap_or_default().to_string_lossy());
        }
        if self.map.is_none() && formats.contains(&exchange::Format::Vti) {
            closing += "No .vti: this kind of study has no map over the workspace.\n";
        }
        print(&closing)?;
        let complete =
            self.manifest.statuses.iter().all(|count| matches!(count.status.as_str(), "solved" | "converged"));
        Ok(if complete { Ending::Complete } else { Ending::SomeUnsolved })
    }

    /// Adds the machine at home and bent to the figures, if there are any.
    fn draw_machine(&mut self) {
        let machine = &self.page.machine;
        if !self.figures.is_empty() {
            self.figures.push((MACHINE_AT_HOME.into(), machine.figure()));
        }
        if let Some(bent) = &self.bent {
            self.figures.push(("machine_bent".into(), machine.bent_figure(bent)));
        }
    }

    fn description(&self) -> Description {
        let named =
            Description { name: self.study.name.clone(), question: self.study.question.clone(), ..self.page.clone() };
        named.with_figures(&self.figures)
    }
}

/// Each figure as SVG and PNG.
fn drawn(figures: Vec<(String, Figure)>, colours: Colours) -> Result<Vec<OutputFile>> {
    let drawn = figures.par_iter().map(|(name, figure)| {
        let fault =
            |e: kinetostat::report::figures::FigureError| Error::Figure { name: name.clone(), problem: e.to_string() };
        Ok([
            OutputFile::new(format!("{name}.svg"), figure.svg(colours).map_err(fault)?),
            OutputFile::new(format!("{name}.png"), figure.png(colours).map_err(fault)?),
        ])
    });
    Ok(drawn.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}
