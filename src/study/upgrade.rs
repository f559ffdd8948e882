//! Study files of schema 1 rewritten in schema 2: the same study, comments and order kept.

use toml_edit::{DocumentMut, Item, Key, Table, TableLike, Value};

use super::spec::SCHEMA;
use crate::input::error::{Error, Result};

/// What a file becomes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Upgraded {
    /// The text in schema 2.
    Study(String),
    /// It is as files are written now, and why.
    Current(&'static str),
}

/// Rewrites the text of a study file; `origin` names it in errors.
///
/// # Errors
/// A text that is no TOML, or no file of this program.
pub fn upgrade(text: &str, origin: &str) -> Result<Upgraded> {
    let fault = |problem: String| Error::Syntax { file: origin.into(), line: None, key: String::new(), problem };
    let mut document: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| fault(e.message().to_string()))?;
    let version = document.get("schema").and_then(Item::as_integer);
    if !document.contains_key("question") {
        return match version {
            Some(1) => Ok(Upgraded::Current("process and machine files are of schema 1")),
            _ => Err(fault("is neither a study nor a process or machine file: expected the key schema".into())),
        };
    }
    match version {
        Some(1) => {}
        Some(version) if version == i64::from(SCHEMA) => return Ok(Upgraded::Current("it is of schema 2")),
        Some(other) => return Err(fault(format!("schema: expected 1 or {SCHEMA}, got {other}"))),
        None => return Err(fault("schema: missing, expected 1".into())),
    }
    let root = document.as_table_mut();
    if root.contains_key("process") {
        return Err(fault(format!("process: is a key of schema {SCHEMA}, and schema is 1")));
    }
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
    Ok(Upgraded::Study(document.to_string()))
}

/// Entries of a table that can be taken out with the comments above them.
trait Entries {
    fn remove_entry(&mut self, key: &str) -> Option<(Key, Item)>;
}

impl Entries for dyn TableLike + '_ {
    fn remove_entry(&mut self, name: &str) -> Option<(Key, Item)> {
        let key = self.key(name)?.clone();
        Some((key, self.remove(name)?))
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
