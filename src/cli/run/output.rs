//! What every run leaves: tables, figures, page and manifest, and the words on the screen.

use std::path::{Path, PathBuf};

use kinetostat::{
    input::error::{Error, Result},
    report::{
        Manifest, OutputFile, StatusCount,
        exchange::{self, Table},
        figures::{Colours, Figure, FigureError},
        page::{self, DeflectedPose, Description, MACHINE_AT_HOME, ResultFolder},
        publish, remove, staging, write_all,
    },
};
use rayon::prelude::*;
use serde_json::json;

use super::Run;
use crate::cli::{Ending, report::PAGE};

/// What a study leaves in its result folder and on the screen.
pub struct Output<'a> {
    pub run: &'a Run<'a>,
    pub manifest: Manifest,
    /// Tables by name, without the ending that a format gives them.
    pub tables: Vec<(String, Table)>,
    /// Files of tables that were written while they were computed, and those tables without rows.
    pub streamed: (Vec<OutputFile>, Vec<(String, Table)>),
    pub summary: serde_json::Value,
    pub figures: Vec<(String, Figure)>,
    /// Setting, answer, views and tables of the page; figures, name and question are filled in.
    pub page: Description,
    /// The machine bent by the load, if it is drawn.
    pub bent: Option<DeflectedPose>,
    pub closing: String,
}

impl Output<'_> {
    /// Says first, in the answer, its summary and on the screen, how many rows it does not rest on.
    pub fn with_unsolved(mut self) -> Self {
        let statuses = &self.manifest.statuses;
        let unsolved: serde_json::Map<String, serde_json::Value> =
            statuses.iter().filter(|c| !c.is_solved()).map(|c| (c.status.clone(), json!(c.rows))).collect();
        if let Some(sentence) = StatusCount::unsolved(statuses) {
            self.page.answer.insert(0, sentence.clone());
            self.closing.insert_str(0, &format!("{sentence}\n"));
        }
        self.summary["rows"] = json!(statuses.iter().map(|count| count.rows).sum::<usize>());
        self.summary["rows_unsolved"] = unsolved.into();
        self
    }

    pub fn write(mut self) -> Result<Ending> {
        let Run { arguments, study, out, ref progress, .. } = *self.run;
        let seconds = self.run.started.elapsed().as_secs_f64();
        progress.end();
        self.tables
            .extend(self.figures.iter().filter_map(|(name, figure)| Some((format!("{name}_data"), figure.data()?))));
        self.draw_machine();
        let formats = self.run.formats();
        // Pages show CSV tables.
        let has_page = formats.contains(&exchange::Format::Csv);
        let (mut files, described) = std::mem::take(&mut self.streamed);
        files.extend(exchange::files(out, &self.tables, &described, &formats)?);
        if has_page {
            files.push(OutputFile::new("report.json", self.description().to_json()));
        }
        files.push(OutputFile::new("summary.json", format!("{:#}\n", self.summary)));
        files.extend(drawn(std::mem::take(&mut self.figures), arguments.colours.into())?);
        self.manifest.files = files.iter().map(|file| file.name.clone()).collect();
        self.manifest.files.extend(has_page.then(|| PAGE.to_string()));
        Manifest::may_write(out, self.manifest.files.iter().map(String::as_str))?;
        // Everything is made before the first file takes the place of another.
        let made = staging(out)?;
        files.push(OutputFile::new(Manifest::FILE, self.manifest.to_json()));
        write_all(made.path(), files)?;
        // The page is made from what has been written, as `kinetostat report` makes it again.
        if has_page {
            let page = page::page(&ResultFolder::open(made.path())?, &made.path().join(PAGE))?;
            write_all(made.path(), vec![OutputFile::new(PAGE, page)])?;
        }
        let written = self.publish(made.path())?;
        let mut closing = format!("{}\n", self.closing);
        closing += &format!("{} in {seconds:.1} s. Written to {}:\n", study.name, out.display());
        for path in &written {
            closing += &format!("  {}\n", path.file_name().unwrap_or_default().to_string_lossy());
        }
        let has_image = self.manifest.files.iter().any(|name| name.ends_with(".vti"));
        if !has_image && formats.contains(&exchange::Format::Vti) {
            closing += "No .vti: this kind of study has no map over the workspace.\n";
        }
        arguments.reporting.print(&closing)?;
        self.tell(&written, seconds);
        let complete = self.manifest.statuses.iter().all(StatusCount::is_solved);
        Ok(if complete { Ending::Complete } else { Ending::SomeUnsolved })
    }

    /// Moves all files from the folder `made` into the result folder, and removes what the run before left there, which
    /// would be taken for results of this one.
    fn publish(&self, made: &Path) -> Result<Vec<PathBuf>> {
        let (out, files) = (self.run.out, &self.manifest.files);
        let former: Vec<String> = Manifest::files_in(out).into_iter().filter(|name| !files.contains(name)).collect();
        // If this is cut short, a later run finds here what there is to remove, and no page is made of two runs.
        let files_of_both = [files.as_slice(), &former].concat();
        let both = Manifest { files: files_of_both, publishing: true, ..self.manifest.clone() };
        write_all(out, vec![OutputFile::new(Manifest::FILE, both.to_json())])?;
        let mut written = files.iter().map(|name| publish(made, out, name)).collect::<Result<Vec<_>>>()?;
        former.iter().try_for_each(|name| remove(&out.join(name)))?;
        written.push(publish(made, out, Manifest::FILE)?);
        Ok(written)
    }

    /// The end of the run for the log and for programs that watch.
    fn tell(&self, written: &[PathBuf], seconds: f64) {
        let Run { study, out, ref progress, .. } = *self.run;
        let statuses = &self.manifest.statuses;
        let counts: Vec<String> = statuses.iter().map(|count| format!("{} {}", count.rows, count.status)).collect();
        log::info!(
            "{}: {} in {seconds:.1} s, {} files written to {}",
            study.name,
            counts.join(", "),
            written.len(),
            out.display()
        );
        progress.line(json!({
            "event": "finished",
            "study": study.name,
            "statuses": statuses,
            "wall_time_s": seconds,
            "threads": rayon::current_num_threads(),
            "folder": out,
        }));
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
        let study = self.run.study;
        let named = Description { name: study.name.clone(), question: study.question.clone(), ..self.page.clone() };
        named.with_figures(&self.figures)
    }
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
