//! Checks the cutting forces of a process file.

use std::collections::BTreeMap;

use super::{
    force_spec::{CoefficientsSpec, ForceSpec, PathFrameSpec, SlotMillingSpec, TableSpec},
    tool_force::{drilling, end_milling},
};
use crate::{
    input::{
        Folder, Inputs,
        check::Check,
        error::{Error, Result},
    },
    process::{
        MillingForce,
        cutting::{CuttingLaw, EdgeForce, OwnForces, PathFrame, SlotMilling, WrenchTable},
    },
};

/// Most teeth accepted.
const MAX_TEETH: u32 = 100;

/// Checks the cutting forces of single tools (by number) and features (by text); returns them with the files that they come from.
pub(super) fn own_forces(
    of_tool: &BTreeMap<String, ForceSpec>,
    of_feature: &BTreeMap<String, ForceSpec>,
    has_stock: bool,
    folder: &Folder,
    top: &Check,
) -> Result<(OwnForces, Inputs)> {
    let (mut forces, mut inputs) = (OwnForces::default(), Inputs::default());
    for (name, spec) in of_tool {
        let check = top.key("force_of_tool").key(name);
        let Ok(tool) = name.parse() else {
            return check.fail("is no tool: expected the number of a tool, as after T in a program".into());
        };
        let (law, files) = required_force(spec, has_stock, folder, &check)?;
        if forces.by_tool.insert(tool, law).is_some() {
            return check.fail(format!("is tool {tool} again, which has a force already"));
        }
        inputs = inputs.and(files);
    }
    for (text, spec) in of_feature {
        let check = top.key("force_of_feature").key(&format!("{text:?}"));
        if text.trim() != text || text.is_empty() {
            return check.fail("is no text: expected one without blanks around it".into());
        }
        if let Some((same, _)) = forces.by_feature.iter().find(|(other, _)| other.eq_ignore_ascii_case(text)) {
            return check.fail(format!("is the same as \"{same}\": upper and lower case are not told apart"));
        }
        let (law, files) = required_force(spec, has_stock, folder, &check)?;
        forces.by_feature.push((text.clone(), law));
        inputs = inputs.and(files);
    }
    Ok((forces, inputs))
}

/// Checks a cutting force like [`cutting_law`], and fails if there is none.
fn required_force(spec: &ForceSpec, has_stock: bool, folder: &Folder, check: &Check) -> Result<(CuttingLaw, Inputs)> {
    match cutting_law(spec, has_stock, folder, check)? {
        (CuttingLaw::None, _) => {
            check.fail("has no force: expected a table such as path_frame or drilling in it".into())
        }
        found => Ok(found),
    }
}

/// Checks a cutting force, of which at most one law may be given; returns the law, whose engagement follows from the stock where there is one, and the text of the
/// wrench table if it has one.
pub(super) fn cutting_law(
    spec: &ForceSpec,
    has_stock: bool,
    folder: &Folder,
    check: &Check,
) -> Result<(CuttingLaw, Inputs)> {
    let given = [
        ("path_frame", spec.path_frame.is_some()),
        ("table", spec.table.is_some()),
        ("slot_milling", spec.slot_milling.is_some()),
        ("end_milling", spec.end_milling.is_some()),
        ("drilling", spec.drilling.is_some()),
        ("from_path", spec.from_path),
    ];
    let given: Vec<_> = given.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
    if given.len() > 1 {
        let problem = format!(
            "give one of path_frame, table, slot_milling, end_milling, drilling and from_path, or none; got {}",
            given.join(", ")
        );
        return check.fail(problem);
    }
    if let Some(key) = given.first().filter(|key| has_stock && !["end_milling", "drilling"].contains(key)) {
        let problem = "is given where [stock] is, from which the force follows: expected end_milling or drilling";
        return check.key(key).fail(problem.into());
    }
    let law = match spec {
        ForceSpec { path_frame: Some(spec), .. } => path_frame(spec, &check.key("path_frame"))?,
        ForceSpec { slot_milling: Some(spec), .. } => slot_milling(spec, &check.key("slot_milling"))?,
        #[cfg(not(target_family = "wasm"))]
        ForceSpec { end_milling: Some(spec), .. } if has_stock => {
            super::tool_force::engaged_milling(spec, &check.key("end_milling"))?
        }
        ForceSpec { end_milling: Some(spec), .. } => end_milling(spec, &check.key("end_milling"))?,
        ForceSpec { drilling: Some(spec), .. } => match drilling(spec, &check.key("drilling"))? {
            CuttingLaw::Drilling(own) if has_stock => CuttingLaw::EngagedDrilling(own),
            own => own,
        },
        ForceSpec { table: Some(spec), .. } => return wrench_table(spec, folder, &check.key("table")),
        ForceSpec { from_path: true, .. } => CuttingLaw::FromPath,
        _ => CuttingLaw::None,
    };
    Ok((law, Inputs::default()))
}

/// Checks the constant force in a path frame (N) and returns its law.
fn path_frame(spec: &PathFrameSpec, check: &Check) -> Result<CuttingLaw> {
    let PathFrameSpec { radial_force, tangential_force, axial_force, law } = *spec;
    let force = MillingForce { radial: radial_force, tangential: tangential_force, axial: axial_force, law };
    Ok(CuttingLaw::PathFrame(PathFrame { force: force.checked(check)? }))
}

impl MillingForce {
    /// Returns the same force if its components, the keys below `check`, are of sensible size.
    pub(crate) fn checked(self, check: &Check) -> Result<Self> {
        check.key("radial_force_N").finite_scalar(self.radial)?;
        check.key("tangential_force_N").finite_scalar(self.tangential)?;
        check.key("axial_force_N").finite_scalar(self.axial)?;
        Ok(self)
    }
}

/// Checks the parameters of slot milling and returns its law.
fn slot_milling(spec: &SlotMillingSpec, check: &Check) -> Result<CuttingLaw> {
    let [tangential, radial, axial] = coefficients(&spec.coefficients(), check)?;
    Ok(CuttingLaw::SlotMilling(SlotMilling {
        tangential,
        radial,
        axial,
        teeth: teeth(spec.teeth, check)?,
        depth_mm: check.key("axial_depth_mm").positive(spec.axial_depth_mm)?,
        feed_per_tooth_mm: check.key("feed_per_tooth_mm").optional_positive(spec.feed_per_tooth_mm)?,
        spindle: spec.spindle.turn(),
    }))
}

/// Checks cutting coefficients; returns the tangential, radial and axial ones (N/mm² and N/mm), in this order.
pub(super) fn coefficients(spec: &CoefficientsSpec, check: &Check) -> Result<[EdgeForce; 3]> {
    let force = |name: &str, cutting: f64, edge: f64| -> Result<EdgeForce> {
        Ok(EdgeForce {
            cutting: check.key(&format!("{name}_cutting_N_per_mm2")).finite_scalar(cutting)?,
            edge: check.key(&format!("{name}_edge_N_per_mm")).finite_scalar(edge)?,
        })
    };
    Ok([
        force("tangential", spec.tangential_cutting, spec.tangential_edge)?,
        force("radial", spec.radial_cutting, spec.radial_edge)?,
        force("axial", spec.axial_cutting, spec.axial_edge)?,
    ])
}

/// Returns the number of teeth; fails if it is not from 1 to [`MAX_TEETH`].
pub(super) fn teeth(teeth: u32, check: &Check) -> Result<u32> {
    match (1..=MAX_TEETH).contains(&teeth) {
        true => Ok(teeth),
        false => check.key("teeth").fail(format!("must be from 1 to {MAX_TEETH}, got {teeth}")),
    }
}

/// Reads the wrench table from its file in `folder`; returns its law and the text of the file.
fn wrench_table(spec: &TableSpec, folder: &Folder, check: &Check) -> Result<(CuttingLaw, Inputs)> {
    if !folder.has_file(&spec.file) {
        return check.key("file").fail(format!("\"{}\" is not a file in the folder of the process file", spec.file));
    }
    let text = folder.bytes(&spec.file)?;
    let table = WrenchTable::read(&text, &folder.path(&spec.file).display().to_string()).map_err(|error| {
        Error::Syntax { file: error.file, line: Some(error.line), key: String::new(), problem: error.fault.to_string() }
    })?;
    Ok((CuttingLaw::Table(table), Inputs::of(&spec.file, String::from_utf8_lossy(&text))))
}
