//! Study files of schema 1 rewritten in schema 2: the same study, comments and order kept.

use toml_edit::{Decor, DocumentMut, Item, Key, Table, TableLike, Value};

use super::{Overrides, Study, spec::SCHEMA};
use crate::{
    input::{
        Folder,
        error::{Error, Result},
        toml_file,
    },
    machine::spec::MachineSpec,
    process::file::spec::ProcessSpec,
};

/// What a file becomes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Upgraded {
    /// The text in schema 2.
    Study(String),
    /// It is as files are written now, and why.
    Current(&'static str),
}

/// Rewrites the text of a study file that can be run; `origin` names it in errors, files that it names are sought relative
/// to `folder`.
///
/// # Errors
/// As [`Study::from_toml`], of the text as it is: what would not be run is not rewritten.
pub fn upgrade(text: &str, origin: &str, folder: impl Into<Folder>) -> Result<Upgraded> {
    let folder = folder.into();
    if let Some(why) = not_a_study(text) {
        return Ok(Upgraded::Current(why));
    }
    let read = |text: &str| Study::from_toml(text, origin, folder.clone(), &Overrides::default());
    let before = read(text)?;
    let fault = |problem: String| Error::Syntax { file: origin.into(), line: None, key: String::new(), problem };
    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| fault(e.message().to_string()))?;
    if document.get("schema").and_then(Item::as_integer) == Some(i64::from(SCHEMA)) {
        return Ok(Upgraded::Current("it is of schema 2"));
    }
    let root = document.as_table_mut();
    for question in ["workspace_map", "superposition"] {
        move_milling(root, question);
        move_compensate(root, question);
    }
    move_chain_errors(root);
    if let Some((key, name)) = tables(root, "path").and_then(|path| path.remove_entry("process")) {
        root.insert_formatted(&key, name);
    }
    if let Some(Item::Value(schema)) = root.get_mut("schema") {
        let decor = schema.decor().clone();
        *schema = Value::from(i64::from(SCHEMA));
        *schema.decor_mut() = decor;
    }
    let upgraded = with_the_ends_of(text, document.to_string());
    let is_same = read(&upgraded).is_ok_and(|after| format!("{:?}", after.kind) == format!("{:?}", before.kind));
    match is_same {
        true => Ok(Upgraded::Study(upgraded)),
        false => Err(fault("cannot be rewritten so that it says the same; rewrite it by hand".into())),
    }
}

/// Why a file is no study, but one that is written as it was.
fn not_a_study(text: &str) -> Option<&'static str> {
    let is_process = toml_file::parse::<ProcessSpec>(text, "").is_ok_and(|process| process.schema == Some(1));
    let is_machine = || toml_file::parse::<MachineSpec>(text, "").is_ok_and(|machine| machine.schema == 1);
    (is_process || is_machine()).then_some("process and machine files are of schema 1")
}

/// `text` with the marks at its begin and the ends of its lines as `before` has them.
fn with_the_ends_of(before: &str, text: String) -> String {
    let text = if before.contains("\r\n") { text.replace("\r\n", "\n").replace('\n', "\r\n") } else { text };
    let mark = '\u{feff}';
    if before.starts_with(mark) && !text.starts_with(mark) { format!("{mark}{text}") } else { text }
}

/// Entries of a table that can be taken out with the comments above them.
trait Entries {
    fn remove_entry(&mut self, key: &str) -> Option<(Key, Item)>;
}

impl Entries for dyn TableLike + '_ {
    fn remove_entry(&mut self, name: &str) -> Option<(Key, Item)> {
        let (mut key, mut item) = (self.key(name)?.clone(), self.remove(name)?);
        // In braces, entries stand between blanks.
        let is_blank = |decor: &Decor| {
            decor.prefix().and_then(|prefix| prefix.as_str()).is_some_and(|p| p.trim_matches(' ').is_empty())
        };
        if is_blank(key.leaf_decor()) {
            key.leaf_decor_mut().clear();
            if let Some(value) = item.as_value_mut() {
                value.decor_mut().set_prefix(" ");
                if value.decor().suffix().and_then(|suffix| suffix.as_str()).is_some_and(|s| s.trim().is_empty()) {
                    value.decor_mut().set_suffix("");
                }
            }
        }
        Some((key, item))
    }
}

/// The table called `name`, if there is one, written as a table or in braces.
fn tables<'a>(root: &'a mut Table, name: &str) -> Option<&'a mut dyn TableLike> {
    root.get_mut(name)?.as_table_like_mut()
}

/// The table at the end of `path`, made if need be; headers are only written of tables in which something stands. `None`
/// where a value stands in its place.
fn below<'a>(root: &'a mut Table, path: &[&str]) -> Option<&'a mut Table> {
    path.iter().try_fold(root, |table, name| {
        let made = || {
            let mut made = Table::new();
            made.set_implicit(true);
            Item::Table(made)
        };
        table.entry(name).or_insert_with(made).as_table_mut()
    })
}

/// `[milling]` becomes `[process.force.path_frame]`, but for the step between tool angles, which is the question's.
fn move_milling(root: &mut Table, question: &str) -> Option<()> {
    tables(root, question)?;
    let (key, mut milling) = root.remove_entry("milling")?;
    if let Some((step_key, step)) = milling.as_table_like_mut().and_then(|table| table.remove_entry("phi_step_deg")) {
        tables(root, question)?.entry_format(&step_key).or_insert(step);
    }
    let renamed = Key::new("path_frame").with_leaf_decor(key.leaf_decor().clone());
    below(root, &["process", "force"])?.insert_formatted(&renamed, milling);
    Some(())
}

/// `compensate` of a map becomes `target` of `[process.compensate]`.
fn move_compensate(root: &mut Table, question: &str) -> Option<()> {
    let (key, target) = tables(root, question)?.remove_entry("compensate")?;
    let renamed = Key::new("target").with_leaf_decor(key.leaf_decor().clone());
    below(root, &["process", "compensate"])?.insert_formatted(&renamed, target);
    Some(())
}

/// `[[chain_error]]` becomes `[[process.chain_error]]`.
fn move_chain_errors(root: &mut Table) -> Option<()> {
    let (key, errors) = root.remove_entry("chain_error")?;
    below(root, &["process"])?.insert_formatted(&key, errors);
    Some(())
}
