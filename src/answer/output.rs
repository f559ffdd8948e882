//! Output of a run: tables, figures, page, summary and manifest, made in a temporary folder and then moved, all of them or none.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::{
    figures::{Colours, Figure, FigureError},
    files::{
        Manifest, OutputFile, StatusCount, Transaction,
        exchange::{self, Format, Table, WrittenRows},
        staging, write_all,
    },
    input::Inputs,
    page::{self, ANSWER, DeflectedPose, Description, MACHINE_AT_HOME, PAGE, PORTRAIT, PageKind, ResultFolder},
};
use crate::{
    input::error::{Error, Result},
    simulation::Failure,
    work::Work,
};

/// Where and how the results of a question are written.
pub struct Run<'a> {
    /// Result folder.
    pub out: &'a Path,
    /// Formats of tables and maps.
    pub formats: &'a [Format],
    /// Which rows of a table of path points are written as CSV.
    pub rows: WrittenRows,
    /// Whether to draw figures.
    pub figures: bool,
    /// The computation: its threads, progress and checkpoint.
    pub work: &'a Work,
}

impl Run<'_> {
    /// Returns whether maps are written as VTK images.
    pub(crate) fn wants_image(&self) -> bool {
        self.formats.contains(&Format::Vti)
    }

    /// Returns the figures that `draw` makes, or none if figures are not wanted.
    pub fn draw_figures(&self, draw: impl FnOnce() -> Vec<(String, Figure)>) -> Vec<(String, Figure)> {
        if self.figures { draw() } else { Vec::new() }
    }
}

/// Files of tables that were written during the computation, and those tables without rows.
pub type Streamed = (Vec<OutputFile>, Vec<(String, Table)>);

/// Results of a question, ready to be written into a folder.
pub struct Output {
    /// Settings that decide the size of the results, for the manifest.
    pub settings: Value,
    /// Number of rows by status.
    pub statuses: Vec<StatusCount>,
    /// Whether there is a result; `None` if unsolved rows decide it: with any, it rests on part of the work, and says so first.
    pub is_answered: Option<bool>,
    /// Tables by name, without the ending that a format gives them.
    pub tables: Vec<(String, Table)>,
    /// Tables that were written during the computation.
    pub streamed: Streamed,
    /// Results as JSON.
    pub summary: Value,
    /// Figures, by file stem.
    pub figures: Vec<(String, Figure)>,
    /// First screen, sections, setting, views and tables of the page; figures, name and question are added.
    pub page: Description,
    /// The machine deflected by the load, if it is drawn.
    pub deflected: Option<DeflectedPose>,
    /// All results in sentences and small tables.
    pub details: String,
    /// Best place of a workpiece, with which a page compares others: its name, coordinates and objective.
    pub best_place: Option<Value>,
}

impl Output {
    /// Makes an output of a summary and a page, without tables and figures.
    pub fn of(settings: Value, statuses: Vec<StatusCount>, summary: Value, page: Description) -> Self {
        Self {
            settings,
            statuses,
            is_answered: None,
            tables: Vec::new(),
            streamed: Default::default(),
            summary,
            figures: Vec::new(),
            page,
            deflected: None,
            details: String::new(),
            best_place: None,
        }
    }

    /// Makes an output that says why there is no result, without tables.
    pub(crate) fn failed(settings: Value, failure: Failure, page: Description) -> Self {
        let Failure { status, reason } = failure;
        let summary = json!({ "schema": 1, "status": status, "reason": reason });
        let statuses = Manifest::count([&*status].into_iter());
        Self { is_answered: Some(false), details: reason, ..Self::of(settings, statuses, summary, page) }
    }

    /// Returns whether everything that was asked has a result.
    pub(crate) fn is_complete(&self) -> bool {
        self.is_answered.unwrap_or_else(|| self.statuses.iter().all(StatusCount::is_solved))
    }

    /// Adds the number of unsolved rows to the first screen and the summary.
    fn note_unsolved_rows(&mut self) {
        let statuses = &self.statuses;
        let unsolved: serde_json::Map<String, Value> =
            statuses.iter().filter(|c| !c.is_solved()).map(|c| (c.status.clone(), json!(c.rows))).collect();
        let rows: usize = statuses.iter().map(|count| count.rows).sum();
        let lost: usize = statuses.iter().filter(|count| !count.is_solved()).map(|count| count.rows).sum();
        let headline = &mut self.page.headline;
        headline.unsolved = StatusCount::unsolved(statuses);
        if lost > 0 {
            let share = lost as f64 / rows as f64;
            headline.verdict = headline.verdict.take().map(|verdict| verdict.with_unsolved(share));
        }
        self.summary["rows"] = json!(rows);
        self.summary["rows_unsolved"] = unsolved.into();
    }

    /// Writes all files into the folder of `run`, with a page as of `kind` and a manifest of what they were made from, and returns their paths, the
    /// manifest last. `Err` if a figure, page or file cannot be made; then no file is replaced.
    pub(crate) fn write(
        &mut self,
        run: &Run<'_>,
        kind: PageKind,
        colours: Colours,
        inputs: &Inputs,
    ) -> Result<Vec<PathBuf>> {
        if self.is_answered.is_none() {
            self.note_unsolved_rows();
        }
        let Run { out, formats, .. } = *run;
        self.tables
            .extend(self.figures.iter().filter_map(|(name, figure)| Some((format!("{name}_data"), figure.data()?))));
        self.add_machine_figures();
        self.page.colours = (colours != Colours::default()).then(|| colours.label().into());
        // Pages show CSV tables.
        let has_page = formats.contains(&Format::Csv);
        let (mut files, streamed_tables) = std::mem::take(&mut self.streamed);
        for (stem, note) in streamed_tables.iter().filter_map(|(stem, table)| Some((stem, table.note()?))) {
            let file = format!("{stem}.csv");
            for table in self.page.tables.iter_mut().filter(|table| table.file == file) {
                table.kept = Some(note.into());
            }
        }
        files.extend(exchange::files(out, &self.tables, &streamed_tables, formats)?);
        run.work.check()?;
        if has_page {
            files.push(OutputFile::new("report.json", self.page.clone().with_figures(&self.figures).to_json()));
        }
        files.push(OutputFile::new("summary.json", format!("{:#}\n", self.summary)));
        files.extend(figure_files(std::mem::take(&mut self.figures), colours, run.work)?);
        let names = files.iter().map(|file| file.name.clone()).chain(has_page.then(|| PAGE.into()));
        let (settings, statuses) = (self.settings.clone(), self.statuses.clone());
        let manifest = Manifest::new(&self.page.name, inputs, settings, statuses, names.collect());
        Manifest::check_may_write(out, manifest.files.iter().map(String::as_str))?;
        // Everything is made before the first file takes the place of another.
        let temporary = staging(out)?;
        files.push(OutputFile::new(Manifest::FILE, manifest.to_json()));
        write_all(temporary.path(), files)?;
        run.work.check()?;
        // The page is made from what has been written, as `kinetostat report` makes it again.
        if has_page {
            let folder = ResultFolder::open(temporary.path(), |_| kind)?;
            let page = page::page(&folder, &temporary.path().join(PAGE))?;
            write_all(temporary.path(), vec![OutputFile::new(PAGE, page)])?;
        }
        run.work.check()?;
        publish(&manifest, temporary.path(), out)
    }

    /// Adds the machine at home, and deflected, to the figures, if there are any.
    fn add_machine_figures(&mut self) {
        let machine = &self.page.machine;
        if !self.figures.is_empty() {
            self.figures.push((MACHINE_AT_HOME.into(), machine.figure()));
        }
        if let Some(deflected) = &self.deflected {
            self.figures.push(("machine_deflected".into(), machine.deflected_figure(deflected)));
        }
    }
}

/// Moves the files of `manifest` from the folder `temporary` to `out`, and removes those of the former run there; returns their paths. From
/// the first change on, a manifest names all files that are there and will be.
fn publish(manifest: &Manifest, temporary: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    let files = &manifest.files;
    let former: Vec<String> = Manifest::previous_files(out).into_iter().filter(|name| !files.contains(name)).collect();
    // If this is cut short, a later run finds here what there is to remove, and no page is made of two runs.
    let files_of_both = [files.as_slice(), &former].concat();
    let both = Manifest { files: files_of_both, publishing: true, ..manifest.clone() };
    let mut changes = Transaction::within(out)?;
    changes.place(OutputFile::new(Manifest::FILE, both.to_json()))?;
    files.iter().for_each(|name| changes.place_made(temporary, name));
    former.iter().for_each(|name| changes.remove(name));
    changes.place_made(temporary, Manifest::FILE);
    changes.commit()?;
    Ok(files.iter().map(String::as_str).chain([Manifest::FILE]).map(|name| out.join(name)).collect())
}

/// Returns each figure as SVG and PNG file, and that of the answer for the width of a telephone, too; `Err` if one cannot be drawn, or the work was stopped.
fn figure_files(figures: Vec<(String, Figure)>, colours: Colours, work: &Work) -> Result<Vec<OutputFile>> {
    let drawn = figures.par_iter().map(|(name, figure)| {
        work.check()?;
        let fault = |e: FigureError| Error::Figure { name: name.clone(), problem: e.to_string() };
        let mut files = vec![
            OutputFile::new(format!("{name}.svg"), figure.svg(colours).map_err(fault)?),
            OutputFile::new(format!("{name}.png"), figure.png(colours).map_err(fault)?),
        ];
        if name == ANSWER {
            let (svg, png) = figure.portrait(colours).map_err(fault)?;
            files.push(OutputFile::new(format!("{PORTRAIT}.svg"), svg));
            files.push(OutputFile::new(format!("{PORTRAIT}.png"), png));
        }
        Ok(files)
    });
    Ok(drawn.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}
