//! What every run leaves: tables, figures, page, summary and manifest, made in a temporary folder and then moved, all
//! of them or none.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::{
    figures::{Colours, Figure, FigureError},
    files::{
        Manifest, OutputFile, StatusCount, Transaction,
        exchange::{self, Format, Table},
        staging, write_all,
    },
    input::Inputs,
    page::{self, DeflectedPose, Description, MACHINE_AT_HOME, PAGE, ResultFolder},
};
use crate::{
    input::error::{Error, Result},
    simulation::Failure,
    work::Work,
};

/// A question being answered into a folder.
pub struct Run<'a> {
    /// The folder.
    pub out: &'a Path,
    /// Formats of tables and maps.
    pub formats: &'a [Format],
    /// Whether figures are drawn.
    pub figures: bool,
    /// What its computation goes on in.
    pub work: &'a Work,
}

impl Run<'_> {
    /// Whether maps are wanted as images.
    pub(crate) fn wants_image(&self) -> bool {
        self.formats.contains(&Format::Vti)
    }

    /// The figures that `draw` makes, if any are to be drawn.
    pub fn drawn(&self, draw: impl FnOnce() -> Vec<(String, Figure)>) -> Vec<(String, Figure)> {
        if self.figures { draw() } else { Vec::new() }
    }
}

/// Files of tables that were written while they were computed, and those tables without rows.
pub type Streamed = (Vec<OutputFile>, Vec<(String, Table)>);

/// What an answer leaves in its folder, and what it says.
pub struct Output {
    /// What decides the size of the results.
    pub settings: Value,
    /// How many rows ended how.
    pub statuses: Vec<StatusCount>,
    /// Whether there is an answer, where rows that are not solved do not decide it. Where they do (`None`), an answer rests on
    /// part of the work if there are any, and then says so first.
    pub is_answered: Option<bool>,
    /// Tables by name, without the ending that a format gives them.
    pub tables: Vec<(String, Table)>,
    /// Files of tables that were written while they were computed, and those tables without rows.
    pub streamed: Streamed,
    /// The answer for programs.
    pub summary: Value,
    /// Figures by name.
    pub figures: Vec<(String, Figure)>,
    /// First screen, sections, setting, views and tables of the page; figures, name and question are filled in.
    pub page: Description,
    /// The machine bent by the load, if it is drawn.
    pub bent: Option<DeflectedPose>,
    /// Everything the answer says, in sentences and small tables.
    pub details: String,
    /// The best place of a workpiece, as a page compares others with it: its name, its coordinates and the objective there.
    pub best_place: Option<Value>,
}

impl Output {
    /// An answer of a summary and a page, without tables and figures.
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
            bent: None,
            details: String::new(),
            best_place: None,
        }
    }

    /// That there is no answer, and why, without tables.
    pub(crate) fn failed(settings: Value, failure: Failure, page: Description) -> Self {
        let Failure { status, reason } = failure;
        let summary = json!({ "schema": 1, "status": status, "reason": reason });
        let statuses = Manifest::count([&*status].into_iter());
        Self { is_answered: Some(false), details: reason, ..Self::of(settings, statuses, summary, page) }
    }

    /// Whether everything that was asked is answered.
    pub(crate) fn is_complete(&self) -> bool {
        self.is_answered.unwrap_or_else(|| self.statuses.iter().all(StatusCount::is_solved))
    }

    /// Says, before the answer and in its summary, how many rows it does not rest on.
    fn say_unsolved(&mut self) {
        let statuses = &self.statuses;
        let unsolved: serde_json::Map<String, Value> =
            statuses.iter().filter(|c| !c.is_solved()).map(|c| (c.status.clone(), json!(c.rows))).collect();
        self.page.headline.unsolved = StatusCount::unsolved(statuses);
        self.summary["rows"] = json!(statuses.iter().map(|count| count.rows).sum::<usize>());
        self.summary["rows_unsolved"] = unsolved.into();
    }

    /// Writes everything into the folder of `run`, with a manifest that says what it was made from. The files written, manifest last.
    ///
    /// # Errors
    /// A figure, a page or a file that cannot be made; then nothing has taken the place of another.
    pub(crate) fn write(&mut self, run: &Run<'_>, colours: Colours, inputs: &Inputs) -> Result<Vec<PathBuf>> {
        if self.is_answered.is_none() {
            self.say_unsolved();
        }
        let Run { out, formats, .. } = *run;
        self.tables
            .extend(self.figures.iter().filter_map(|(name, figure)| Some((format!("{name}_data"), figure.data()?))));
        self.draw_machine();
        self.page.colours = (colours != Colours::default()).then(|| colours.label().into());
        // Pages show CSV tables.
        let has_page = formats.contains(&Format::Csv);
        let (mut files, described) = std::mem::take(&mut self.streamed);
        files.extend(exchange::files(out, &self.tables, &described, formats)?);
        if has_page {
            files.push(OutputFile::new("report.json", self.page.clone().with_figures(&self.figures).to_json()));
        }
        files.push(OutputFile::new("summary.json", format!("{:#}\n", self.summary)));
        files.extend(drawn(std::mem::take(&mut self.figures), colours)?);
        let names = files.iter().map(|file| file.name.clone()).chain(has_page.then(|| PAGE.into()));
        let (settings, statuses) = (self.settings.clone(), self.statuses.clone());
        let manifest = Manifest::new(&self.page.name, inputs, (settings, statuses), names.collect());
        Manifest::may_write(out, manifest.files.iter().map(String::as_str))?;
        // Everything is made before the first file takes the place of another.
        let made = staging(out)?;
        files.push(OutputFile::new(Manifest::FILE, manifest.to_json()));
        write_all(made.path(), files)?;
        // The page is made from what has been written, as `kinetostat report` makes it again.
        if has_page {
            let page = page::page(&ResultFolder::open(made.path())?, &made.path().join(PAGE))?;
            write_all(made.path(), vec![OutputFile::new(PAGE, page)])?;
        }
        take_their_places(&manifest, made.path(), out)
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
}

/// Moves all files of `manifest` from the folder `made` into the result folder, and removes what the run before left there,
/// which would be taken for results of this one. From the first change on, a manifest names all that is there and will be.
fn take_their_places(manifest: &Manifest, made: &Path, out: &Path) -> Result<Vec<PathBuf>> {
    let files = &manifest.files;
    let former: Vec<String> = Manifest::files_in(out).into_iter().filter(|name| !files.contains(name)).collect();
    // If this is cut short, a later run finds here what there is to remove, and no page is made of two runs.
    let files_of_both = [files.as_slice(), &former].concat();
    let both = Manifest { files: files_of_both, publishing: true, ..manifest.clone() };
    let mut changes = Transaction::within(out)?;
    changes.place(OutputFile::new(Manifest::FILE, both.to_json()))?;
    files.iter().for_each(|name| changes.place_made(made, name));
    former.iter().for_each(|name| changes.remove(name));
    changes.place_made(made, Manifest::FILE);
    changes.commit()?;
    Ok(files.iter().map(String::as_str).chain([Manifest::FILE]).map(|name| out.join(name)).collect())
}

/// Each figure as SVG and PNG.
fn drawn(figures: Vec<(String, Figure)>, colours: Colours) -> Result<Vec<OutputFile>> {
    let drawn = figures.par_iter().map(|(name, figure)| {
        let fault = |e: FigureError| Error::Figure { name: name.clone(), problem: e.to_string() };
        Ok([
            OutputFile::new(format!("{name}.svg"), figure.svg(colours).map_err(fault)?),
            OutputFile::new(format!("{name}.png"), figure.png(colours).map_err(fault)?),
        ])
    });
    Ok(drawn.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}
