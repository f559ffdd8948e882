//! Checks the force of an end mill or a drill in a process file: its geometry, and coefficients given or of a material.

use std::f64::consts::FRAC_PI_2;

use super::{
    force::{coefficients, teeth},
    force_spec::{CutSpec, DrillingSpec, EndMillingSpec, KienzleSpec, MeanOrPeakSpec},
};
use crate::{
    input::{check::Check, error::Result},
    process::cutting::{
        CutDirection, CuttingLaw, Drilling, DrillingLaw, EdgeForce, EdgeLaw, EndMilling, Kienzle, MeanOrPeak,
        materials::{self, Coefficients},
    },
};

/// Point angle of a drill if none is given, degrees.
const POINT_ANGLE_DEG: f64 = 118.0;
/// q of [`DrillingLaw::Kienzle`] if none is given.
const THRUST_RATIO: f64 = 0.5;

/// Checks the parameters of milling whose engagement is found from the stock, which leaves the coefficients, and returns its law.
#[cfg(not(target_family = "wasm"))]
pub(super) fn engaged_milling(spec: &EndMillingSpec, check: &Check) -> Result<CuttingLaw> {
    let given = [
        ("diameter_mm", spec.diameter_mm.is_some(), "stands in [tools]"),
        ("teeth", spec.teeth.is_some(), "stands in [tools]"),
        ("axial_depth_mm", spec.axial_depth_mm.is_some(), "is found from the stock"),
        ("radial_width_mm", spec.radial_width_mm.is_some(), "is found from the stock"),
        ("cut", spec.cut.is_some(), "is found from the stock"),
        ("load", spec.load != MeanOrPeakSpec::Mean, "is the mean where the engagement is found from the stock"),
    ];
    if let Some((key, _, why)) = given.into_iter().find(|(_, given, _)| *given) {
        return check.key(key).fail(format!("{why}: expected no such key"));
    }
    Ok(CuttingLaw::EngagedMilling(crate::process::cutting::EngagedMilling {
        edge: edge_law(spec, check)?,
        feed_per_tooth_mm: check.key("feed_per_tooth_mm").optional_positive(spec.feed_per_tooth_mm)?,
        spindle: spec.spindle.turn(),
    }))
}

/// Checks the parameters of milling with the side of an end mill and returns its law.
pub(super) fn end_milling(spec: &EndMillingSpec, check: &Check) -> Result<CuttingLaw> {
    let required = |key: &str, given: Option<f64>| match given {
        Some(given) => check.key(key).positive(given),
        None => check.key(key).fail("missing: expected mm, or a [stock] from which the engagement follows".into()),
    };
    let diameter_mm = required("diameter_mm", spec.diameter_mm)?;
    let width_mm = required("radial_width_mm", spec.radial_width_mm)?;
    if width_mm > diameter_mm {
        let problem = format!("must be at most diameter_mm, which is {diameter_mm}, got {width_mm}");
        return check.key("radial_width_mm").fail(problem);
    }
    let direction = match spec.cut {
        Some(CutSpec::Up) => CutDirection::Up,
        Some(CutSpec::Down) => CutDirection::Down,
        None if width_mm == diameter_mm => CutDirection::Up,
        None => {
            let problem = "missing: expected \"up\" or \"down\", since the cut is narrower than the cutter";
            return check.key("cut").fail(problem.into());
        }
    };
    Ok(CuttingLaw::EndMilling(EndMilling {
        edge: edge_law(spec, check)?,
        diameter_mm,
        teeth: match spec.teeth {
            Some(given) => teeth(given, check)?,
            None => return check.key("teeth").fail("missing: expected their number".into()),
        },
        depth_mm: required("axial_depth_mm", spec.axial_depth_mm)?,
        width_mm,
        direction,
        feed_per_tooth_mm: check.key("feed_per_tooth_mm").optional_positive(spec.feed_per_tooth_mm)?,
        spindle: spec.spindle.turn(),
        over_turn: match spec.load {
            MeanOrPeakSpec::Mean => MeanOrPeak::Mean,
            MeanOrPeakSpec::Peak => MeanOrPeak::Peak,
        },
    }))
}

/// Returns the edge law of an end mill from the coefficients, Kienzle's law or material given; fails unless exactly one of them is.
fn edge_law(spec: &EndMillingSpec, check: &Check) -> Result<EdgeLaw> {
    let linear = |[tangential, radial, axial]: [EdgeForce; 3]| {
        if spec.radial_ratio.is_some() || spec.axial_ratio.is_some() {
            let key = if spec.radial_ratio.is_some() { "radial_ratio" } else { "axial_ratio" };
            let problem = "belongs to Kienzle's law: these coefficients have a radial and an axial force of their own";
            return check.key(key).fail(problem.into());
        }
        Ok(EdgeLaw::Linear { tangential, radial, axial })
    };
    match (&spec.coefficients, &spec.kienzle, &spec.material) {
        (Some(given), None, None) => linear(coefficients(given, &check.key("coefficients"))?),
        (None, Some(given), None) => kienzle_edge(kienzle(given, &check.key("kienzle"))?, spec, check),
        (None, None, Some(name)) => match material_coefficients(name, "milling", &check.key("material"))? {
            Coefficients::Milling { tangential, radial, axial } => linear([tangential, radial, axial]),
            Coefficients::Kienzle(law) => kienzle_edge(law, spec, check),
            Coefficients::Drilling(_) => wrong_operation("drilling", name, "milling", &check.key("material")),
        },
        (a, b, c) => {
            let given = [("coefficients", a.is_some()), ("kienzle", b.is_some()), ("material", c.is_some())];
            not_exactly_one(given, check)
        }
    }
}

/// Combines Kienzle's law with the ratios of radial and axial force, of which the radial one is required.
fn kienzle_edge(tangential: Kienzle, spec: &EndMillingSpec, check: &Check) -> Result<EdgeLaw> {
    let Some(radial_ratio) = spec.radial_ratio else {
        let problem = "missing: expected the radial force as a share of the tangential one, since Kienzle's law has the \
                       tangential one alone";
        return check.key("radial_ratio").fail(problem.into());
    };
    Ok(EdgeLaw::Kienzle {
        tangential,
        tangential_share: 1.0,
        radial_ratio: check.key("radial_ratio").finite_scalar(radial_ratio)?,
        axial_ratio: check.key("axial_ratio").finite_scalar(spec.axial_ratio.unwrap_or(0.0))?,
    })
}

/// Checks the parameters of drilling and returns its law.
pub(super) fn drilling(spec: &DrillingSpec, check: &Check) -> Result<CuttingLaw> {
    let constant = |k: f64| {
        let unused = [("point_angle_deg", spec.point_angle_deg), ("thrust_ratio", spec.thrust_ratio)];
        match unused.iter().find(|(_, given)| given.is_some()) {
            Some((key, _)) => {
                check.key(key).fail("belongs to Kienzle's law: a material constant has no use for it".into())
            }
            None => Ok(DrillingLaw::MaterialConstant(k)),
        }
    };
    let law = match (&spec.kienzle, spec.material_constant, &spec.material) {
        (Some(given), None, None) => kienzle_drilling_law(kienzle(given, &check.key("kienzle"))?, spec, check)?,
        (None, Some(given), None) => constant(check.key("material_constant").positive(given)?)?,
        (None, None, Some(name)) => match material_coefficients(name, "drilling", &check.key("material"))? {
            Coefficients::Drilling(k) => constant(k)?,
            Coefficients::Kienzle(law) => kienzle_drilling_law(law, spec, check)?,
            Coefficients::Milling { .. } => {
                return wrong_operation("milling", name, "drilling", &check.key("material"));
            }
        },
        (a, b, c) => {
            let given = [("kienzle", a.is_some()), ("material_constant", b.is_some()), ("material", c.is_some())];
            return not_exactly_one(given, check);
        }
    };
    Ok(CuttingLaw::Drilling(Drilling {
        law,
        diameter_mm: check.key("diameter_mm").positive(spec.diameter_mm)?,
        feed_per_rev_mm: check.key("feed_per_rev_mm").optional_positive(spec.feed_per_rev_mm)?,
        spindle: spec.spindle.turn(),
    }))
}

/// Checks and returns Kienzle's law of a drill: force law of a lip, point angle (converted from degrees to rad; 118° if not given, 30 to 180°
/// allowed), thrust ratio (0.5 if not given).
fn kienzle_drilling_law(lip_law: Kienzle, spec: &DrillingSpec, check: &Check) -> Result<DrillingLaw> {
    let point_angle_deg = spec.point_angle_deg.unwrap_or(POINT_ANGLE_DEG);
    if !(30.0..=180.0).contains(&point_angle_deg) {
        return check.key("point_angle_deg").fail(format!("must be from 30 to 180, got {point_angle_deg}"));
    }
    Ok(DrillingLaw::Kienzle {
        lip: lip_law,
        point_angle: FRAC_PI_2 * point_angle_deg / 90.0,
        thrust_ratio: check.key("thrust_ratio").positive(spec.thrust_ratio.unwrap_or(THRUST_RATIO))?,
    })
}

/// Checks and returns the coefficients of Kienzle's law: specific force (N/mm²) above 0, exponent from 0 to below 1.
fn kienzle(spec: &KienzleSpec, check: &Check) -> Result<Kienzle> {
    if !(0.0..1.0).contains(&spec.exponent) {
        return check.key("exponent").fail(format!("must be from 0 to below 1, got {:?}", spec.exponent));
    }
    let specific_force = check.key("specific_force_N_per_mm2").positive(spec.specific_force)?;
    Ok(Kienzle { specific_force, exponent: spec.exponent })
}

/// Returns the coefficients of the material `name`; fails if there is none, with those for `operation`, milling or drilling.
fn material_coefficients(name: &str, operation: &str, check: &Check) -> Result<Coefficients> {
    let all = materials::all()?;
    if let Some(found) = all.iter().find(|material| material.name == name) {
        return Ok(found.coefficients);
    }
    let suitable = all.iter().filter(|material| match material.coefficients {
        Coefficients::Milling { .. } => operation == "milling",
        Coefficients::Drilling(_) => operation == "drilling",
        Coefficients::Kienzle(_) => true,
    });
    let names = suitable.map(|material| material.name.as_str()).collect::<Vec<_>>().join("; ");
    check.fail(format!("no material is called \"{name}\"; for {operation} there are: {names}"))
}

/// Returns the error that the material `name` has coefficients for `has` (milling or drilling), not for `work`.
fn wrong_operation<T>(has: &str, name: &str, work: &str, check: &Check) -> Result<T> {
    check.fail(format!("of \"{name}\" there are numbers for {has}, not for {work}"))
}

/// Returns the error that not exactly one of three keys is given; each comes with whether it is.
fn not_exactly_one<T>(keys: [(&str, bool); 3], check: &Check) -> Result<T> {
    let [a, b, c] = keys.map(|(key, _)| key);
    let given: Vec<&str> = keys.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
    let got = if given.is_empty() { "none".into() } else { given.join(", ") };
    check.fail(format!("give one of {a}, {b} and {c}; got {got}"))
}
