//! Writes a compensated program with its table of points, report and page, and replaces only files that an earlier command left. The report
//! lists these files. A command that is cut short while it replaces them leaves no program beside files of another, and a page that says so.

use std::{
    fs::File,
    io::{Error as IoError, Read, Result as IoResult},
    path::{Path, PathBuf},
};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::{
    CompensateOptions, Compensated, NotWritten, PartSink, ProgramJob, VerifiedPart, VerifiedProgram,
    report::{self, Findings, PROGRAM_RANKS, Report, program_columns, program_json, program_table, use_text},
};
use crate::{
    answer::clearance::CLEARANCE,
    compensation::BoundedPath,
    figures::Figure,
    files::{
        Foreign, OutputFile, OutputLock, Staging, Transaction, check_may_replace,
        exchange::{Format, KeptRows, StreamedTable, WrittenRows, csv},
        prepare_beside, read_record, staging_beside, write_all,
    },
    input::{
        error::{Error, Result},
        file, to_hex,
    },
    page::{Description, PageKind, ResultFolder, headline::Headline, page_with},
    process::KnownForce,
    questions::path::report::facts_text,
    redundancy,
    simulation::clearance::MachineCell,
    toolpath::{CommandedPath, gcode::CalledFile},
    work::Work,
};

/// What was found of a program that stands in its files.
#[derive(Debug)]
pub struct ProgramResults {
    /// Main sentence, numbers and cautions.
    pub headline: Headline,
    /// Simulated passes and residual errors; the program's bytes are only in its file.
    pub verified: VerifiedProgram,
    /// Whether limits of its feed are exceeded, though the feed is as slow as it may be.
    pub exceeds_feed_limits: bool,
    /// Whether bodies hit along the program, or come nearer than is wanted.
    pub hits: bool,
    /// Whether no motion of the program counts as cutting, or the force of none is known.
    pub knows_no_force: bool,
    /// The process, a line for each fact.
    pub facts: String,
    /// Effect of the rotation about the tool axis, as sentences and a table, if the best γ was sought.
    pub gamma: Option<String>,
    /// Its feeds, limits, errors and how sure they are, and what its blocks demand of a control, in sentences.
    pub findings: String,
    /// How to use it, in sentences.
    pub used: String,
    /// Which rows its table of points has, if not all, in a sentence.
    pub rows: Option<String>,
    /// Path of its page.
    pub page: PathBuf,
}

/// Whether the program was written into files.
#[derive(Debug)]
pub enum ProgramOutcome {
    /// It was written.
    Written(Box<ProgramResults>),
    /// No program was written, and earlier files stay.
    Refused(Box<ProgramJob>, NotWritten),
}

/// Compensates `job`, the program called `name`, as `asked`, with each error source simulated alone, and writes the results into `files`.
///
/// # Errors
/// As [`ProgramJob::compensate`]; files that cannot be written: what is there then is known as ours.
pub fn compensate_into(
    job: ProgramJob,
    asked: &CompensateOptions,
    files: &ProgramFiles,
    name: &str,
    work: &Work,
) -> Result<ProgramOutcome> {
    // What is wrong with bodies is said before anything is computed.
    let cell = MachineCell::of(&job.machine, job.process.cell.as_ref())?;
    // The columns of the points need it.
    let asked = CompensateOptions { sources_apart: true, ..asked.clone() };
    let mut receiver = FileReceiver { job: &job, files, under_way: None };
    let found = job.compensate(&asked, &mut receiver, work)?;
    let under_way = receiver.under_way;
    let verified = match found {
        Compensated::Verified(verified) => *verified,
        Compensated::Refused(refused) => return Ok(ProgramOutcome::Refused(Box::new(job), refused)),
    };
    let UnfinishedFiles { made, points, findings } = under_way.map_or_else(|| UnfinishedFiles::new(&job, files), Ok)?;
    let (mut points, rows) = points.finish()?;
    let mut findings = findings;
    findings.find_machined(&job, &verified.written, name, work)?;
    findings.find_clearance(&job, cell.as_deref(), work)?;
    if let Some(part) = findings.part(&job) {
        points.push(part.ply(files.file_named(PART)));
        let fault = |source| Error::Write { file: files.out.with_file_name(files.file_named(PART_VTK)), source };
        points.extend(part.vtp(files.file_named(PART_VTK)).map_err(fault)?);
    }
    let report = Report { job: &job, name, verified: &verified, findings: &findings };
    let (headline, mut figures) = (report::headline(&report), report::figures(&report));
    figures.extend(cell.as_deref().and_then(|cell| findings.clearance_figure(&job, cell)));
    // What is hit is seen first.
    for (name, _) in figures.iter_mut().filter(|_| findings.hits()) {
        match name.as_str() {
            CLEARANCE => *name = "answer".into(),
            "answer" => *name = "paths_seen".into(),
            _ => {}
        }
    }
    let table = report::budget_table(&report);
    let fault = |error| Error::Write {
        file: files.out.with_file_name(files.file_named(CAUSES)),
        source: IoError::other(error),
    };
    points.push(OutputFile::new(files.file_named(CAUSES), csv(&table).map_err(fault)?));
    let tables = [files.points_name(), files.file_named(CAUSES)];
    let page = report::page(&report, headline.clone(), &tables, rows.as_deref());
    let mut json = program_json(&report);
    json["headline"] = json!(page.headline);
    if let Some(rows) = &rows {
        json["points_table"] = json!(rows);
    }
    let settings = &job.process.redundancy;
    if let Some(found) = &job.redundancy {
        json["redundancy"] = redundancy::report::json(found, settings);
    }
    points.extend(files.called(verified.written.callees()));
    let mut results = ProgramResults {
        headline,
        exceeds_feed_limits: job.feed.as_ref().is_some_and(|feed| !feed.exceeded.is_empty()),
        hits: findings.hits(),
        knows_no_force: job.cuts_nowhere() || job.process.known_force(&job.path) == KnownForce::Nowhere,
        facts: facts_text(&job.process.facts()),
        gamma: job.redundancy.as_ref().map(|found| redundancy::report::text(found, settings)),
        findings: report::findings_text(&report),
        used: use_text(&report),
        rows,
        page: PathBuf::new(),
        verified,
    };
    // A page takes memory; nothing more is asked of the points.
    results.verified.written.sent = CommandedPath { positions: Vec::new(), orientations: None };
    drop((job, findings));
    let bytes = std::mem::take(&mut results.verified.written.bytes);
    results.page = files.write(bytes, points, json, made.path(), page, &figures)?;
    Ok(ProgramOutcome::Written(Box::new(results)))
}

/// Receives the verified parts and writes their points into files.
struct FileReceiver<'a> {
    job: &'a ProgramJob,
    files: &'a ProgramFiles,
    /// Files being made; `None` before the first part.
    under_way: Option<UnfinishedFiles>,
}

/// Files being made in a temporary folder, and the findings for the report.
struct UnfinishedFiles {
    /// The temporary folder, beside the program.
    made: Staging,
    points: StreamedTable,
    findings: Findings,
}

impl UnfinishedFiles {
    /// Creates the temporary folder and begins the table of points.
    fn new(job: &ProgramJob, files: &ProgramFiles) -> Result<Self> {
        let made = staging_beside(&files.out)?;
        let columns = program_columns(job);
        let kept = KeptRows::new(&columns, job.path.len(), 1, &PROGRAM_RANKS, files.rows);
        let name = files.file_named(POINTS);
        let points = StreamedTable::new(made.path(), &name, &columns, &[Format::Csv], kept)?;
        Ok(Self { made, points, findings: Findings::new(job)? })
    }
}

impl PartSink for FileReceiver<'_> {
    /// Checks that a called file may be written beside the program.
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        self.files.may_call(file)
    }

    /// Adds the points of a part to the findings and to the table.
    fn take(&mut self, verified: &VerifiedPart<'_>, bounded: Option<&BoundedPath>) -> Result<()> {
        let UnfinishedFiles { points, findings, .. } = match &mut self.under_way {
            Some(under_way) => under_way,
            none => none.insert(UnfinishedFiles::new(self.job, self.files)?),
        };
        findings.add(self.job, verified);
        points.add(&program_table(self.job, verified, bounded))
    }
}

/// The files that a compensated program is written into.
#[derive(Debug)]
pub struct ProgramFiles {
    out: PathBuf,
    name: String,
    /// Names and hashes of files of this name that an earlier command wrote, from its report.
    former: Vec<Value>,
    foreign: Foreign,
    /// Which points its table has.
    rows: WrittenRows,
    _lock: OutputLock,
}

impl ProgramFiles {
    /// Checks that the program `out` and its companions (points, causes, report, page) may be written; writes nothing yet.
    ///
    /// # Errors
    /// A file cannot be written, would replace an input, or would replace what is no earlier result, unless `foreign` allows that.
    pub fn prepare(out: &Path, foreign: Foreign) -> Result<Self> {
        let (name, lock) = prepare_beside(out)?;
        let mut files = Self {
            out: out.to_path_buf(),
            name: name.into(),
            former: Vec::new(),
            foreign,
            rows: WrittenRows::default(),
            _lock: lock,
        };
        let report = out.with_file_name(files.file_named(REPORT));
        let found = read_record(&report);
        check_may_replace(&report, foreign, || found.is_some())?;
        files.former = found.and_then(|found| found["files"].as_array().cloned()).unwrap_or_default();
        let own = OWN.map(|suffix| files.file_named(suffix));
        for name in own.into_iter().chain([files.points_name()]) {
            check_may_replace(&out.with_file_name(&name), foreign, || files.is_former(&name))?;
        }
        Ok(files)
    }

    /// Sets which rows the table of points has.
    #[must_use]
    pub fn with_rows(self, rows: WrittenRows) -> Self {
        Self { rows, ..self }
    }

    /// Returns whether the file called `name` beside the program is unchanged since an earlier command wrote it.
    fn is_former(&self, name: &str) -> bool {
        let is_ours = |hash: String| self.former.contains(&json!({ "name": name, "sha256": hash }));
        File::open(self.out.with_file_name(name)).and_then(hash).is_ok_and(is_ours)
    }

    /// Checks that a `file` that the program calls may stand beside it, as it is there or written: it has the name of none of the program's
    /// own files and replaces neither an input nor what is no earlier result.
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        let path = self.out.with_file_name(&file.name);
        let own = OWN.map(|suffix| self.file_named(suffix));
        let reserved = [own.as_slice(), &[self.points_name(), self.file_named(REPORT)]].concat();
        if reserved.contains(&file.name) {
            let source = IoError::other("is the name of another result; expected another name of the program");
            return Err(Error::Write { file: path, source });
        }
        if self.is_there(file) { Ok(()) } else { check_may_replace(&path, self.foreign, || self.is_former(&file.name)) }
    }

    /// Returns whether a called `file` is beside the program with the same bytes and was not written by an earlier command.
    fn is_there(&self, file: &CalledFile) -> bool {
        let bytes_there = file::read_bounded(&self.out.with_file_name(&file.name), file.bytes.len() as u64);
        bytes_there.is_ok_and(|bytes_there| bytes_there == file.bytes) && !self.is_former(&file.name)
    }

    /// Returns the file name of the table of points.
    fn points_name(&self) -> String {
        format!("{}.csv", self.file_named(POINTS))
    }

    /// Returns the files to write of those that the program calls: the ones that are not there.
    fn called<'a>(&'a self, called: &'a [CalledFile]) -> impl Iterator<Item = OutputFile> + 'a {
        let missing = called.iter().filter(|file| !self.is_there(file));
        missing.map(|file| OutputFile::new(&file.name, file.bytes.as_slice()))
    }

    /// Writes the program, the `files` beside it, the report and the page of `description` and `figures`, by way of the folder `made`. Returns
    /// the path of the page.
    fn write(
        &self,
        program: Vec<u8>,
        mut files: Vec<OutputFile>,
        mut report: Value,
        made: &Path,
        description: Description,
        figures: &[(String, Figure)],
    ) -> Result<PathBuf> {
        let manifest = json!({ "program": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") });
        (report["program"], report["version"]) = (manifest["program"].clone(), manifest["version"].clone());
        files.push(OutputFile::new(self.file_named(""), program));
        let mut names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
        write_all(made, files).map_err(|error| self.with_final_path(error))?;
        let folder = ResultFolder { path: made.to_path_buf(), description, manifest, kind: PageKind::PLAIN };
        let page = page_with(&folder, figures, &made.join(self.file_named(PAGE)))?;
        names.push(self.file_named(PAGE));
        let page = vec![OutputFile::new(self.file_named(PAGE), page)];
        write_all(made, page).map_err(|error| self.with_final_path(error))?;
        self.prepare_replacement(made, &names, &report)?.commit()?;
        Ok(self.out.with_file_name(self.file_named(PAGE)))
    }

    /// Returns `error` with the path of the final file in place of the temporary one.
    fn with_final_path(&self, error: Error) -> Error {
        match error {
            Error::Write { file, source } => {
                let file = file.file_name().map_or_else(|| self.out.clone(), |name| self.out.with_file_name(name));
                Error::Write { file, source }
            }
            other => other,
        }
    }

    /// Returns the transaction that moves the files `names` from the folder `made` to their places, program and page last, and writes the report.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn prepare_replacement(&self, made: &Path, names: &[String], report: &Value) -> Result<Transaction> {
        let entry = |name: &str, hash: IoResult<String>| match hash {
            Ok(hash) => Ok(json!({ "name": name, "sha256": hash })),
            Err(source) => Err(Error::Write { file: self.out.clone(), source }),
        };
        let made_entry = |name: &String| entry(name, File::open(made.join(name)).and_then(hash));
        let entries = names.iter().map(made_entry).collect::<Result<Vec<Value>>>()?;
        let unfinished = entry(&self.file_named(PAGE), hash(UNFINISHED.as_bytes()))?;
        // If this is cut short, the next command finds here whose the files are, the former and the new ones.
        let both = [self.former.as_slice(), &entries, &[unfinished]].concat();
        let report_with = |files: &[Value], is_unfinished: bool| {
            let mut report = report.clone();
            report["files"] = json!(files);
            if is_unfinished {
                report["unfinished"] = json!(true);
            }
            OutputFile::new(self.file_named(REPORT), format!("{report:#}\n"))
        };
        let mut changes = Transaction::beside(&self.out)?;
        changes.place(report_with(&both, true))?;
        changes.place(OutputFile::new(self.file_named(PAGE), UNFINISHED))?;
        changes.remove(&self.file_named(""));
        // A surface of the program before is not of this one.
        let left = [PART, PART_VTK].map(|suffix| self.file_named(suffix)).into_iter();
        left.filter(|name| !names.contains(name) && self.is_former(name)).for_each(|name| changes.remove(&name));
        // The program behind what it calls and what tells of it.
        names.iter().for_each(|name| changes.place_made(made, name));
        changes.place(report_with(&entries, false))?;
        Ok(changes)
    }

    /// Returns the program's file name with `suffix` appended.
    fn file_named(&self, suffix: &str) -> String {
        format!("{}{suffix}", self.name)
    }
}

/// Name of the table of points, without the ending that its format gives it.
const POINTS: &str = ".points";
/// What the verdict rests on.
const CAUSES: &str = ".budget.csv";
const REPORT: &str = ".report.json";
/// The machined surface, where stock is cut.
const PART: &str = ".part.ply";
const PART_VTK: &str = ".part.vtp";
const PAGE: &str = ".html";
/// What is written beside the table of points and the report.
const OWN: [&str; 5] = ["", CAUSES, PART, PART_VTK, PAGE];
/// Page shown while files are being replaced.
const UNFINISHED: &str = "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
<title>Not finished</title>\n<h1>Not finished</h1>\n<p>kinetostat compensate is writing this program and the files beside it. If the command no longer runs, \
it was stopped, and these files may be of two programs: do not cut with them. Run the command again.</p>\n</html>\n";

/// Returns the SHA-256 of `bytes` in hexadecimal.
fn hash(mut bytes: impl Read) -> IoResult<String> {
    let (mut hasher, mut part) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match bytes.read(&mut part)? {
            0 => return Ok(to_hex(&hasher.finalize())),
            length => hasher.update(&part[..length]),
        }
    }
}
