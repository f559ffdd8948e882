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

use crate::{
    figures::Figure,
    files::{
        Foreign, OutputFile,
        exchange::{Column, Format, StreamedTable},
        may_replace,
        write::{Step, prepare_beside, staging_beside},
    },
    input::{
        error::{Error, Result},
        file,
    },
    page::{Description, ResultFolder, page_with},
    toolpath::gcode::CalledFile,
};

/// A longer file is no report, bytes.
const LONGEST: u64 = 16 << 20;

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
        let found = file::bounded(&report, LONGEST).ok().and_then(|text| serde_json::from_slice(&text).ok());
        let found: Value = found.unwrap_or_default();
        let is_ours = found["program"] == env!("CARGO_PKG_NAME");
        may_replace(&report, foreign, || is_ours)?;
        if is_ours {
            files.former = found["files"].as_array().cloned().unwrap_or_default();
        }
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

    /// Finds out whether a `file` that the program calls may be beside it: as it is there, or written.
    ///
    /// # Errors
    /// It has the name of one of the program's own files, or would replace an input, or what is no former result.
    pub fn may_call(&self, file: &CalledFile) -> Result<()> {
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

    /// A folder beside the program in which files are made; its folder is made if need be.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn staging(&self) -> Result<TempDir> {
        staging_beside(&self.out)
    }

    /// The table of points, empty so far, in the folder `made` for it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn points(&self, made: &Path, columns: &[Column]) -> Result<StreamedTable> {
        StreamedTable::new(made, &self.named(POINTS), columns, &[Format::Csv])
    }

    /// The file name of the table of points.
    pub fn points_name(&self) -> String {
        format!("{}.csv", self.named(POINTS))
    }

    /// Writes the program, the files it calls that are not there yet, its points and its report, which also gets what a later command knows the files by, and the page
    /// that `description` describes, with `figures`. `made` is a folder for what is under way. The page.
    ///
    /// # Errors
    /// They cannot be written; what is there then is known as ours.
    pub fn write(
        &self,
        (program, called, points, mut report): (Vec<u8>, &[CalledFile], Vec<OutputFile>, Value),
        made: &Path,
        (description, figures): (Description, &[(String, Figure)]),
    ) -> Result<PathBuf> {
        report["program"] = json!(env!("CARGO_PKG_NAME"));
        report["version"] = json!(env!("CARGO_PKG_VERSION"));
        let page = self.page(&points, &report, made, (description, figures))?;
        let mut files: Vec<OutputFile> = points;
        let called = called.iter().filter(|file| !self.is_there(file));
        files.extend(called.map(|file| OutputFile::new(&file.name, file.bytes.as_slice())));
        files.push(OutputFile::new(self.named(""), program));
        files.push(OutputFile::new(self.named(PAGE), page));
        self.replace(files, report)?.into_iter().try_for_each(Step::take)?;
        Ok(self.out.with_file_name(self.named(PAGE)))
    }

    /// Makes `files`, of which the program and the page are the last, and the report of them; the changes by which they then take their places.
    fn replace(&self, mut files: Vec<OutputFile>, report: Value) -> Result<Vec<Step>> {
        let fault = |source| Error::Write { file: self.out.clone(), source };
        let entry = |file: &OutputFile| Ok(json!({ "name": file.name, "sha256": hash(file.reader()?)? }));
        let entries = files.iter().map(entry).collect::<IoResult<Vec<Value>>>().map_err(fault)?;
        let page = files.pop();
        let unfinished = OutputFile::new(self.named(PAGE), UNFINISHED);
        // If this is cut short, the next command finds here whose the files are, the former and the new ones.
        let both = [self.former.as_slice(), &entries, &[entry(&unfinished).map_err(fault)?]].concat();
        let report_with = |files: &[Value], is_unfinished: bool| {
            let mut report = report.clone();
            report["files"] = json!(files);
            if is_unfinished {
                report["unfinished"] = json!(true);
            }
            OutputFile::new(self.named(REPORT), format!("{report:#}\n"))
        };
        let place = |file| Step::place_beside(&self.out, file);
        let mut steps = vec![place(report_with(&both, true))?, place(unfinished)?, Step::Remove(self.out.clone())];
        // The program behind what it calls and what tells of it.
        for file in files {
            steps.push(place(file)?);
        }
        steps.extend(page.map(place).transpose()?);
        steps.push(place(report_with(&entries, false))?);
        Ok(steps)
    }

    /// The page, made from a copy of the points in the folder `made`.
    fn page(
        &self,
        points: &[OutputFile],
        report: &Value,
        made: &Path,
        (description, figures): (Description, &[(String, Figure)]),
    ) -> Result<String> {
        for file in points {
            let path = made.join(&file.name);
            let copied = file.reader().and_then(|mut from| std::io::copy(&mut from, &mut File::create(&path)?));
            copied.map_err(|source| Error::Write { file: path, source })?;
        }
        let manifest = json!({ "program": report["program"], "version": report["version"] });
        let folder = ResultFolder { path: made.to_path_buf(), description, manifest };
        page_with(&folder, figures, &made.join(self.named(PAGE)))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn files(of: &str) -> Vec<OutputFile> {
        let file = |name: &str| OutputFile::new(name, format!("{name} of {of}"));
        vec![file("part.nc.points.csv"), file("sub.nc"), file("part.nc"), file("part.nc.html")]
    }

    fn write(files: Vec<OutputFile>, out: &Path, steps: usize) -> usize {
        let prepared = ProgramFiles::prepare(out, Foreign::KeptUnlessForced).unwrap();
        let all = prepared.replace(files, json!({ "program": env!("CARGO_PKG_NAME") })).unwrap();
        let count = all.len();
        all.into_iter().take(steps).for_each(|step| step.take().unwrap());
        count
    }

    #[test]
    fn what_is_cut_short_leaves_no_program_beside_files_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("part.nc");
        let count = write(files("one"), &out, usize::MAX);
        let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap_or_default();
        let sets = |names: &[&str]| -> Vec<bool> { names.iter().map(|name| text(name).ends_with("two")).collect() };
        for steps in 0..=count {
            write(files("one"), &out, usize::MAX);
            write(files("two"), &out, steps);
            let of_two = sets(&["part.nc.points.csv", "sub.nc", "part.nc", "part.nc.html"]);
            let report: Value = serde_json::from_str(&text("part.nc.report.json")).unwrap();
            let is_whole = of_two.iter().all(|is| *is) || !of_two.iter().any(|is| *is) && !text("part.nc").is_empty();
            let is_said = text("part.nc.html").contains("was stopped");
            assert!(is_whole || is_said, "{steps}: {of_two:?}");
            assert!(text("part.nc").is_empty() || of_two[0] == of_two[2] && of_two[1] == of_two[2], "{steps}");
            assert_eq!(report["unfinished"] == true, (1..count).contains(&steps), "{steps}");
            // The next command knows all of them, and nothing else remains.
            write(files("one"), &out, usize::MAX);
            assert_eq!(sets(&["part.nc.points.csv", "sub.nc", "part.nc", "part.nc.html"]), [false; 4]);
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
        }
    }
}
