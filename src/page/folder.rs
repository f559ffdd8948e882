//! A result folder, read back, and addresses of its files on a page.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use super::{
    description::{Description, SCHEMA},
    table::Table,
};
use crate::{
    files::Manifest,
    input::{
        error::{Error, Result},
        file,
    },
};

/// A folder that a run has written.
#[derive(Debug, Clone)]
pub struct ResultFolder {
    /// Where it is.
    pub path: PathBuf,
    /// What it holds, in words.
    pub description: Description,
    /// Its manifest.
    pub manifest: Value,
}

impl ResultFolder {
    /// Reads `report.json` and `manifest.json` of `path`.
    ///
    /// # Errors
    /// `path` is not a result folder, or one of another version of this program, or its files are of two runs.
    pub fn open(path: &Path) -> Result<Self> {
        let not_a_result = |problem: String| Error::Argument { argument: path.display().to_string(), problem };
        if !path.is_dir() {
            return Err(not_a_result(
                "is not a folder; expected a result folder as written by `kinetostat run`".into(),
            ));
        }
        for name in ["report.json", "manifest.json"] {
            if !path.join(name).exists() {
                let problem =
                    format!("has no {name}; expected a result folder as written by this version of `kinetostat run`");
                return Err(not_a_result(problem));
            }
        }
        let file = path.join("manifest.json");
        let manifest: Value = json(&file, &read(&file)?)?;
        if manifest["program"] != env!("CARGO_PKG_NAME") {
            let problem = format!("must be \"{}\", got {}", env!("CARGO_PKG_NAME"), manifest["program"]);
            return Err(Error::Value { file: file.display().to_string(), key: "program".into(), problem });
        }
        if Manifest::is_publishing(&manifest) {
            return Err(not_a_result(
                "a run was cut short while it put its results here: some files are of that run, others of the one \
                 before; run the study again"
                    .into(),
            ));
        }
        let file = path.join("report.json");
        let text = read(&file)?;
        let Written { schema } = json(&file, &text)?;
        if schema != SCHEMA {
            let problem = format!("must be {SCHEMA}, got {schema}; run the study again with this version");
            return Err(Error::Value { file: file.display().to_string(), key: "schema".into(), problem });
        }
        Ok(Self { path: path.to_path_buf(), description: json(&file, &text)?, manifest })
    }

    /// A table of the folder.
    ///
    /// # Errors
    /// It cannot be read, or its name leads out of the folder.
    pub(super) fn table(&self, name: &str) -> Result<Table> {
        Table::open(&self.file(name)?)
    }

    /// A text file of the folder.
    ///
    /// # Errors
    /// As [`ResultFolder::table`].
    pub(super) fn text(&self, name: &str) -> Result<String> {
        let file = self.file(name)?;
        read(&file)
    }

    fn file(&self, name: &str) -> Result<PathBuf> {
        if Path::new(name).file_name().is_none_or(|own| own != name) {
            return Err(Error::Value {
                file: self.path.join("report.json").display().to_string(),
                key: "file".into(),
                problem: format!("must be the name of a file in the folder, got \"{name}\""),
            });
        }
        Ok(self.path.join(name))
    }
}

/// What says whether the rest of `report.json` can be read.
#[derive(Deserialize)]
struct Written {
    #[serde(default)]
    schema: Value,
}

/// Most bytes of a file other than a table.
const LONGEST: u64 = 256 << 20;

fn read(file: &Path) -> Result<String> {
    let fault = |problem: &str| Error::Read { file: file.to_path_buf(), source: std::io::Error::other(problem) };
    String::from_utf8(file::bounded(file, LONGEST)?).map_err(|_| fault("is no text in UTF-8"))
}

/// The content of `file`, whose text is given.
fn json<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|fault| Error::Syntax {
        file: file.display().to_string(),
        line: Some(fault.line()),
        key: String::new(),
        problem: fault.to_string(),
    })
}

/// Address of `file` on a page that lies at `page`, both relative to the present folder or absolute.
pub fn href(page: &Path, file: &Path) -> String {
    let parts: Vec<String> =
        way(page, file).components().map(|part| encoded(&part.as_os_str().to_string_lossy())).collect();
    if parts.is_empty() { ".".into() } else { parts.join("/") }
}

/// The way of [`href`] in words: nothing is encoded.
pub fn relative(page: &Path, file: &Path) -> String {
    let way = way(page, file);
    if way.as_os_str().is_empty() { ".".into() } else { way.display().to_string() }
}

fn way(page: &Path, file: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (page, file) = (absolute(page), absolute(file));
    let from: Vec<Component<'_>> = page.parent().map(|p| p.components().collect()).unwrap_or_default();
    let to: Vec<Component<'_>> = file.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - shared);
    up.chain(to[shared..].iter().copied()).collect()
}

/// A file name in an address.
fn encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(b).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(byte).collect()
}
