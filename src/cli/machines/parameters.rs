//! `kinetostat machines NAME --parameters`: the numbers of a machine by name.

use comfy_table::CellAlignment;
use kinetostat::{
    files::text_table::text_table,
    input::error::Result,
    machine::{Geometry, Grade, Parameter},
};
use serde_json::json;

use crate::cli::{print, print_json};

/// Lists the numbers of the machine called so, or of this file.
pub fn list(name: &str, as_json: bool) -> Result<()> {
    let geometry = Geometry::named_or_file(name)?;
    let parameters = geometry.parameters();
    if as_json {
        return print_json(&json!({ "machine": geometry.kinematics().name, "parameters": parameters }));
    }
    let has_intervals = parameters.iter().any(|own| own.interval.is_some());
    let columns = if has_intervals { 5 } else { 4 };
    let mut table = text_table(["name", "value", "unit", "grade", "95 % interval"].into_iter().take(columns), columns);
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for Parameter { name, value, unit, grade, interval, .. } in parameters {
        let value = value.map_or_else(|| "unknown".into(), |value| format!("{value:?}"));
        let grade = grade.map_or("", Grade::label);
        let interval = interval.map_or(String::new(), |[low, high]| format!("{low:?} to {high:?}"));
        table.add_row([name, value, unit.to_string(), grade.into(), interval].into_iter().take(columns));
    }
    print(&format!("{table}\n"))
}
