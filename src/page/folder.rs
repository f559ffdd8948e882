//! Result folders read back, and addresses of their files on a page.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use super::{
    description::{Description, SCHEMA},
    kind::PageKind,
    table::Table,
};
use crate::{
    files::Manifest,
    input::{
        check::Check,
        error::{Error, Result},
        file,
    },
};

/// A folder that a run has written.
#[derive(Debug, Clone)]
pub struct ResultFolder {
    /// Path of the folder.
    pub path: PathBuf,
    /// Contents of its `report.json`.
    pub description: Description,
    /// Contents of its `manifest.json`.
    pub manifest: Value,
    /// What pages do with results of its kind.
    pub kind: PageKind,
}

impl ResultFolder {
    /// Reads `report.json` and `manifest.json` of `path`; `kinds` gives what pages do with results of the kind so called. `Err` for what is no
    /// complete result folder of this version of the program.
    pub fn open(path: &Path, kinds: impl Fn(&str) -> PageKind) -> Result<Self> {
        let not_a_result = |problem: String| Error::Argument { argument: path.display().to_string(), problem };
        if !path.is_dir() {
            return Err(not_a_result(
                "is not a folder; expected a result folder as written by `kinetostat run`".into(),
            ));
        }
        for name in ["report.json", "manifest.json"] {
            if !path.join(name).exists() {
                let problem = format!("has no {name}; expected a result folder of `kinetostat run`");
                return Err(not_a_result(problem));
            }
        }
        let file = path.join("manifest.json");
        let manifest: Value = parse_json(&file, &read_text(&file)?)?;
        if manifest["program"] != env!("CARGO_PKG_NAME") {
            let problem = format!("must be \"{}\", got {}", env!("CARGO_PKG_NAME"), manifest["program"]);
            return Check::new(&file.display().to_string()).key("program").fail(problem);
        }
        if Manifest::is_publishing(&manifest) {
            return Err(not_a_result(
                "a run was cut short while it put its results here: some files are of that run, others of the one \
                 before; run the study again"
                    .into(),
            ));
        }
        let file = path.join("report.json");
        let text = read_text(&file)?;
        let SchemaVersion { schema } = parse_json(&file, &text)?;
        if schema != SCHEMA {
            let problem = format!("must be {SCHEMA}, got {schema}; run the study again with this version");
            return Check::new(&file.display().to_string()).key("schema").fail(problem);
        }
        let description: Description = parse_json(&file, &text)?;
        let kind = kinds(&description.kind);
        Ok(Self { path: path.to_path_buf(), description, manifest, kind })
    }

    /// Opens a table of the folder; `Err` when it cannot be read or its name leads out of the folder.
    pub(super) fn table(&self, name: &str) -> Result<Table> {
        Table::open(&self.file_path(name)?)
    }

    /// Reads a text file of the folder; `Err` when it cannot be read or its name leads out of the folder.
    pub(super) fn text(&self, name: &str) -> Result<String> {
        let file = self.file_path(name)?;
        read_text(&file)
    }

    /// Reads the summary of the folder; `Err` when it cannot be read.
    pub(super) fn summary(&self) -> Result<Value> {
        parse_json(&self.path.join("summary.json"), &self.text("summary.json")?)
    }

    /// Returns the path of a file of the folder; `Err` if `name` leads out of it.
    fn file_path(&self, name: &str) -> Result<PathBuf> {
        if Path::new(name).file_name().is_none_or(|file_name| file_name != name) {
            let check = Check::new(&self.path.join("report.json").display().to_string()).key("file");
            return check.fail(format!("must be the name of a file in the folder, got \"{name}\""));
        }
        Ok(self.path.join(name))
    }
}

/// The version in `report.json`, read first to see whether the rest can be read.
#[derive(Deserialize)]
struct SchemaVersion {
    #[serde(default)]
    schema: Value,
}

/// Most bytes of a file other than a table.
const LONGEST: u64 = 256 << 20;

/// Reads a file as text; `Err` if it is too long or is not in UTF-8.
fn read_text(file: &Path) -> Result<String> {
    let fault = |problem: &str| Error::Read { file: file.to_path_buf(), source: std::io::Error::other(problem) };
    String::from_utf8(file::read_bounded(file, LONGEST)?).map_err(|_| fault("is no text in UTF-8"))
}

/// Parses `text` as JSON; `file` names it in errors.
fn parse_json<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|fault| Error::Syntax {
        file: file.display().to_string(),
        line: Some(fault.line()),
        key: String::new(),
        problem: fault.to_string(),
    })
}

/// Returns the URL-encoded relative address of `file` on a page at `page`; relative paths count from the current folder.
pub fn href(page: &Path, file: &Path) -> String {
    let parts: Vec<String> =
        relative_path(page, file).components().map(|part| url_encoded(&part.as_os_str().to_string_lossy())).collect();
    if parts.is_empty() { ".".into() } else { parts.join("/") }
}

/// Returns the relative path of `file` seen from a page at `page`, as text to read.
pub fn relative_display(page: &Path, file: &Path) -> String {
    let relative_path = relative_path(page, file);
    if relative_path.as_os_str().is_empty() { ".".into() } else { relative_path.display().to_string() }
}

/// Returns the relative path from the folder of `page` to `file`.
fn relative_path(page: &Path, file: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (page, file) = (absolute(page), absolute(file));
    let from: Vec<Component<'_>> = page.parent().map(|p| p.components().collect()).unwrap_or_default();
    let to: Vec<Component<'_>> = file.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - shared);
    up.chain(to[shared..].iter().copied()).collect()
}

/// Encodes a file name for use in an address.
fn url_encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(b).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(byte).collect()
}
