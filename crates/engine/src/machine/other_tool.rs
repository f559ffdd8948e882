//! A machine with another tool than its file has: what a process changes about it.

use nalgebra::Vector3;

use super::{
    Machine, Model,
    spec::{MachineSpec, OtherToolSpec, ToolSpec},
};
use crate::input::{
    check::Check,
    error::{Error, Result},
};

/// Keys of a machine file with a tool, and of a process with another.
const KEYS: [(&str, &str); 4] = [
    ("platform.tool_tip_mm", "tip_mm"),
    ("platform.tool_axis", "axis"),
    ("platform.tool.", ""),
    ("material.", "material."),
];

impl Machine {
    /// This machine with `tool` in place of its own; `check` locates the tool's table in the process file, for errors.
    ///
    /// # Errors
    /// Values that make no tool; a tip elsewhere or another axis without what bends there, where the machine's own tool bends.
    pub fn with_tool(&self, tool: &OtherToolSpec, check: &Check) -> Result<Machine> {
        let check_stationary = check.key("stationary");
        let mut spec = match (tool.stationary, tool.tip_mm, tool.axis) {
            (false, ..) if tool.without_weight => {
                return check.key("without_weight").fail("is for a stationary tool: expected stationary = true".into());
            }
            (false, ..) => MachineSpec::clone(self.definition.spec()),
            (true, Some(tip_mm), Some(_)) => self.seen_from_part(tip_mm, tool.without_weight, &check_stationary)?,
            (true, ..) => return check_stationary.fail("expected tip_mm and axis beside it, in O".into()),
        };
        for (name, material) in &tool.material {
            if spec.material.insert(name.clone(), material.clone()).is_some() {
                return check
                    .key("material")
                    .key(name)
                    .fail("is a material of the machine file: choose another name".into());
            }
        }
        let (is_elsewhere, bends) =
            (tool.tip_mm.is_some() || tool.axis.is_some(), tool.compliance.is_some() || tool.cutter.is_some());
        if is_elsewhere && !bends && spec.platform.tool.is_some() {
            let problem = "the machine file's tool is elastic, and the process has another tool: give the cutter or compliance_mm_rad_N of that tool as well";
            return check.fail(problem.into());
        }
        if let (false, Some(tip_mm)) = (tool.stationary, tool.tip_mm) {
            spec.platform.tool_tip_mm = tip_mm;
        }
        spec.platform.tool_axis = tool.axis.or(spec.platform.tool_axis);
        if bends {
            spec.platform.tool = Some(ToolSpec { compliance: tool.compliance.clone(), cutter: tool.cutter.clone() });
        }
        self.rebuild_from(spec).or_else(|error| match &error {
            Error::Value { key, problem, .. } => match process_key(key) {
                Some(key) => check.key(&key).fail(problem.clone()),
                None => Err(error),
            },
            _ => Err(error),
        })
    }
}

impl Model {
    /// Describes the tool: its tip in platform axes and its stiffness across its axis.
    pub fn tool_text(&self) -> String {
        self.tool_words_at(self.tool_tip, "platform")
    }

    /// Describes the tool as [`Model::tool_text`] does, with its tip at `tip` (mm) of what is called `frame`.
    pub fn tool_words_at(&self, tip: Vector3<f64>, frame: &str) -> String {
        let tip = format!("tip at ({}, {}, {}) mm of the {frame}", tip.x, tip.y, tip.z);
        match &self.tool_compliance {
            None => format!("{tip}, rigid"),
            Some(compliance) => {
                let across = compliance[(0, 0)].max(compliance[(1, 1)]);
                format!("{tip}, {:.0} N/mm across its axis", 1.0 / across)
            }
        }
    }
}

/// Key in the tool table of a process that corresponds to `key` of the machine file; `None` if there is none.
fn process_key(key: &str) -> Option<String> {
    KEYS.iter().find_map(|(machine, process)| key.strip_prefix(machine).map(|rest| format!("{process}{rest}")))
}
