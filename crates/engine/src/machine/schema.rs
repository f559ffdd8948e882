//! JSON Schema of machine files, for editors that complete and check them.

use schemars::{Schema, generate::SchemaSettings, transform::RecursiveTransform};
use serde_json::Value;

use super::spec::MachineSpec;

/// JSON Schema (draft 7, which editors of TOML know) of machine files, made from the types that read them.
pub fn file_schema() -> Schema {
    let settings = SchemaSettings::draft07().with_transform(RecursiveTransform(without_null));
    let mut schema = settings.into_generator().into_root_schema_for::<MachineSpec>();
    schema.insert("title".into(), "Machine file of kinetostat".into());
    schema
}

/// Removes null types and number formats from a schema: TOML has no null, and an optional key is one that is not required.
fn without_null(schema: &mut Schema) {
    schema.remove("format");
    if let Some(Value::Array(kinds)) = schema.get_mut("type") {
        kinds.retain(|kind| kind != "null");
        if let [kind] = kinds.as_slice() {
            let kind = kind.clone();
            schema.insert("type".into(), kind);
        }
    }
    if let Some(Value::Array(mut ways)) = schema.remove("anyOf") {
        ways.retain(|way| way["type"] != "null");
        let key = if ways.len() == 1 { "allOf" } else { "anyOf" };
        schema.insert(key.into(), ways.into());
    }
}
