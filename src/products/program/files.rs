//! A compensated program, its points, its report and its page, replaced only where they are as a command before left them. The report says
//! what that is. A command that is cut short while they are replaced leaves no program beside files of another, and a page that says so.

use std::{
    fs::File,
    io::{Error as IoError, Read, Result as IoResult},
    path::{Path, PathBuf},
};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use super::{
    Asked, Compensated, ProgramJob, Proved, ProvedPart, Receiver, Refused,
    report::{self, Findings, Report, blocks_text, program_columns, program_json, program_table, use_text},
};
use crate::{
    compensation::BoundedPath,
    figures::Figure,
    files::{
        Foreign, OutputFile, Transaction,
        exchange::{Format, StreamedTable},
        may_replace, prepare_beside, record_in, staging_beside, write_all,
    },
    input::{
        error::{Error, Result},
        file,
    },
    machine::Machine,
    page::{Description, ResultFolder, headline::Headline, page_with},
    process::Process,
    redundancy,
    simulation::Sent,
    toolpath::gcode::CalledFile,
    work::Work,
};

/// A program that is written, and what there is to say of it.
#[derive(Debug)]
pub struct Told {
    /// The answer at a glance.
    pub headline: Headline,
    /// What was proved; the program itself stands in its file.
    pub proved: Proved,
    /// The machine that it commands.
    pub machine: Machine,
    /// The process.
    pub process: Process,
    /// What the rotation about the tool axis brings, in sentences and a table, if the best one was sought.
    pub gamma: Option<String>,
    /// What its blocks ask of a control, in sentences.
    pub blocks: String,
    /// How it is used, in sentences.
    pub used: String,
    /// Its page.
    pub page: PathBuf,
}

/// What became of a program that was to be written into files.
#[derive(Debug)]
pub enum Left {
    /// It is there.
    Written(Box<Told>),
    /// There is none, and what was there before stays.
    Refused(Box<ProgramJob>, Refused),
}

/// Compensates `job`, the program called `name`, as `asked`, with each source apart, and leaves it in `files`.
///
/// # Errors
/// As [`ProgramJob::compensate`]; files that cannot be written: what is there then is known as ours.
pub fn compensate_into(job: ProgramJob, asked: &Asked, files: &ProgramFiles, name: &str, work: &Work) -> Result<Left> {
    // The columns of the points need it.
    let asked = Asked { sources_apart: true, ..asked.clone() };
    let mut kept = Kept { job: &job, files, under_way: None };
    let found = job.compensate(&asked, &mut kept, work)?;
    let under_way = kept.under_way;
    let mut proved = match found {
        Compensated::Proved(proved) => *proved,
        Compensated::Refused(refused) => return Ok(Left::Refused(Box::new(job), refused)),
    };
    let UnderWay { made, points, findings } = under_way.map_or_else(|| UnderWay::new(&job, files), Ok)?;
    let report = Report { job: &job, name, proved: &proved, findings: &findings };
    let (headline, figures) = (report::headline(&report), report::figures(&report));
    let page = report::page(&report, headline.clone(), &files.points_name());
    let mut json = program_json(&report);
    let turn = &job.process.redundancy;
    if let Some(found) = &job.redundancy {
        json["redundancy"] = redundancy::report::json(found, turn);
    }
    let gamma = job.redundancy.as_ref().map(|found| redundancy::report::text(found, turn));
    let (blocks, used) = (blocks_text(&job, proved.written.blocks.as_ref()), use_text(&report));
    let (machine, process) = (job.machine.clone(), job.process.clone());
    // A page takes memory; nothing more is asked of the points.
    proved.written.sent = Sent { positions: Vec::new(), orientations: None };
    drop((job, findings));
    let bytes = std::mem::take(&mut proved.written.bytes);
    let page = files.write((bytes, proved.written.called(), points.finish()?, json), made.path(), (page, &figures))?;
    Ok(Left::Written(Box::new(Told { headline, proved, machine, process, gamma, blocks, used, page })))
}

/// What is proved, on its way into files.
struct Kept<'a> {
    job: &'a ProgramJob,
    files: &'a ProgramFiles,
    /// From the first part on.
    under_way: Option<UnderWay>,
}

struct UnderWay {
    /// A folder beside the program in which files are made.
    made: TempDir,
    points: StreamedTable,
    findings: Findings,
}

impl UnderWay {
    fn new(job: &ProgramJob, files: &ProgramFiles) -> Result<Self> {
        let made = staging_beside(&files.out)?;
        let points = StreamedTable::new(made.path(), &files.named(POINTS), &program_columns(job), &[Format::Csv])?;
        Ok(Self { made, points, findings: Findings::new(job)? })
    }
}

impl Receiver for Kept<'_> {
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        self.files.may_call(file)
    }

    fn take(&mut self, proved: &ProvedPart<'_>, bounded: Option<&BoundedPath>) -> Result<()> {
        let UnderWay { points, findings, .. } = match &mut self.under_way {
            Some(under_way) => under_way,
            none => none.insert(UnderWay::new(self.job, self.files)?),
        };
        findings.add(self.job, proved);
        points.add(&program_table(self.job, proved, bounded))
    }
}

/// Where a program is to be written.
#[derive(Debug)]
pub struct ProgramFiles {
    out: PathBuf,
    name: String,
    /// Files of this name that a command before wrote, as its report lists them.
    former: Vec<Value>,
    foreign: Foreign,
}

impl ProgramFiles {
    /// The program `out` and its three companions. Nothing is written yet.
    ///
    /// # Errors
    /// They cannot be written, would replace an input, or what is no former result unless `foreign` says so.
    pub fn prepare(out: &Path, foreign: Foreign) -> Result<Self> {
        let name = prepare_beside(out)?.to_string();
        let mut files = Self { out: out.to_path_buf(), name, former: Vec::new(), foreign };
        let report = out.with_file_name(files.named(REPORT));
        let found = record_in(&report);
        may_replace(&report, foreign, || found.is_some())?;
        files.former = found.and_then(|found| found["files"].as_array().cloned()).unwrap_or_default();
        for name in [files.named(""), files.points_name(), files.named(PAGE)] {
            may_replace(&out.with_file_name(&name), foreign, || files.is_former(&name))?;
        }
        Ok(files)
    }

    /// Whether the file called `name` beside the program is as a command before left it.
    fn is_former(&self, name: &str) -> bool {
        let is_ours = |hash: String| self.former.contains(&json!({ "name": name, "sha256": hash }));
        File::open(self.out.with_file_name(name)).and_then(hash).is_ok_and(is_ours)
    }

    /// Finds out whether a `file` that the program calls may be beside it, as it is there or written: it does not have the name of one of the
    /// program's own files, nor would it replace an input, or what is no former result.
    fn may_call(&self, file: &CalledFile) -> Result<()> {
        let path = self.out.with_file_name(&file.name);
        let own = [self.named(""), self.points_name(), self.named(REPORT), self.named(PAGE)];
        if own.contains(&file.name) {
            let source = IoError::other("is the name of another result; expected another name of the program");
            return Err(Error::Write { file: path, source });
        }
        if self.is_there(file) { Ok(()) } else { may_replace(&path, self.foreign, || self.is_former(&file.name)) }
    }

    /// Whether a `file` that the program calls is beside it as it is to be, and is not ours.
    fn is_there(&self, file: &CalledFile) -> bool {
        let there = file::bounded(&self.out.with_file_name(&file.name), file.bytes.len() as u64);
        there.is_ok_and(|there| there == file.bytes) && !self.is_former(&file.name)
    }

    /// The file name of the table of points.
    fn points_name(&self) -> String {
        format!("{}.csv", self.named(POINTS))
    }

    /// Writes the program, the files it calls that are not there yet, its points and its report, which also gets what a later command knows
    /// the files by, and the page that `description` describes, with `figures`. All are made in the folder `made`. The page.
    fn write(
        &self,
        (program, called, mut files, mut report): (Vec<u8>, &[CalledFile], Vec<OutputFile>, Value),
        made: &Path,
        (description, figures): (Description, &[(String, Figure)]),
    ) -> Result<PathBuf> {
        let manifest = json!({ "program": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") });
        (report["program"], report["version"]) = (manifest["program"].clone(), manifest["version"].clone());
        let called = called.iter().filter(|file| !self.is_there(file));
        files.extend(called.map(|file| OutputFile::new(&file.name, file.bytes.as_slice())));
        files.push(OutputFile::new(self.named(""), program));
        let mut names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
        write_all(made, files).map_err(|error| self.in_its_place(error))?;
        let folder = ResultFolder { path: made.to_path_buf(), description, manifest };
        let page = page_with(&folder, figures, &made.join(self.named(PAGE)))?;
        names.push(self.named(PAGE));
        let page = vec![OutputFile::new(self.named(PAGE), page)];
        write_all(made, page).map_err(|error| self.in_its_place(error))?;
        self.replace(made, &names, &report)?.commit()?;
        Ok(self.out.with_file_name(self.named(PAGE)))
    }

    /// An `error` of a file that is made elsewhere, told of the file that it was to become.
    fn in_its_place(&self, error: Error) -> Error {
        match error {
            Error::Write { file, source } => {
                let file = file.file_name().map_or_else(|| self.out.clone(), |name| self.out.with_file_name(name));
                Error::Write { file, source }
            }
            other => other,
        }
    }

    /// The changes by which files of these `names` in the folder `made`, the program and the page the last, and their report take their places.
    ///
    /// # Errors
    /// A file cannot be read, or written.
    pub fn replace(&self, made: &Path, names: &[String], report: &Value) -> Result<Transaction> {
        let entry = |name: &str, hash: IoResult<String>| match hash {
            Ok(hash) => Ok(json!({ "name": name, "sha256": hash })),
            Err(source) => Err(Error::Write { file: self.out.clone(), source }),
        };
        let made_entry = |name: &String| entry(name, File::open(made.join(name)).and_then(hash));
        let entries = names.iter().map(made_entry).collect::<Result<Vec<Value>>>()?;
        let unfinished = entry(&self.named(PAGE), hash(UNFINISHED.as_bytes()))?;
        // If this is cut short, the next command finds here whose the files are, the former and the new ones.
        let both = [self.former.as_slice(), &entries, &[unfinished]].concat();
        let report_with = |files: &[Value], is_unfinished: bool| {
            let mut report = report.clone();
            report["files"] = json!(files);
            if is_unfinished {
                report["unfinished"] = json!(true);
            }
            OutputFile::new(self.named(REPORT), format!("{report:#}\n"))
        };
        let mut changes = Transaction::beside(&self.out)?;
        changes.place(report_with(&both, true))?;
        changes.place(OutputFile::new(self.named(PAGE), UNFINISHED))?;
        changes.remove(&self.named(""));
        // The program behind what it calls and what tells of it.
        names.iter().for_each(|name| changes.place_made(made, name));
        changes.place(report_with(&entries, false))?;
        Ok(changes)
    }

    fn named(&self, suffix: &str) -> String {
        format!("{}{suffix}", self.name)
    }
}

/// Name of the table of points, without the ending that its format gives it.
const POINTS: &str = ".points";
const REPORT: &str = ".report.json";
const PAGE: &str = ".html";
/// The page while files are replaced.
const UNFINISHED: &str = "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
<title>Not finished</title>\n<h1>Not finished</h1>\n<p>kinetostat compensate is writing this program and the files beside it. If it no longer runs, it \
was stopped, and these files may be of two programs: do not cut with them. Run the command again.</p>\n</html>\n";

/// SHA-256, hexadecimal.
fn hash(mut bytes: impl Read) -> IoResult<String> {
    let (mut hasher, mut part) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match bytes.read(&mut part)? {
            0 => return Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()),
            length => hasher.update(&part[..length]),
        }
    }
}
