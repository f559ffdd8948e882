//! How near the bodies of a machine come to one another.

use serde::Serialize;

use super::Place;
use crate::{
    input::error::Result,
    machine::{Configuration, Machine},
};

/// Bodies of a machine, and which of them come nearest.
#[derive(Debug, Clone, Default, Serialize)]
pub struct BodiesFound {
    /// Names of the bodies.
    pub names: Vec<String>,
    /// Number of pairs that are to be apart.
    pub pairs: usize,
    /// The pair that is nearest at home.
    pub at_home: Option<NearestPair>,
    /// The pair that is nearest at home, named points and corners of the workspace, and where; places between are not looked at.
    pub anywhere: Option<(String, NearestPair)>,
}

/// The two bodies that are nearest in a state.
#[derive(Debug, Clone, Serialize)]
pub struct NearestPair {
    /// Their names.
    pub names: [String; 2],
    /// At most their distance, mm; where they overlap, minus a depth.
    pub distance_mm: f64,
    /// Whether a shape of one is only assumed, so that no distance is known.
    pub is_assumed: bool,
}

impl NearestPair {
    /// Describes it: "forearm and pedestal overlap by 12.0 mm".
    #[must_use]
    pub fn text(&self) -> String {
        let [a, b] = &self.names;
        match self.distance_mm {
            own if own < 0.0 => format!("{a} and {b} overlap by {:.1} mm", -own),
            _ if self.is_assumed => format!("{a} and {b} are apart, as far as their assumed shapes say"),
            own => format!("{a} and {b} are {own:.1} mm apart"),
        }
    }
}

/// Looks at the bodies of `machine` at home and at those of `places` that it reaches; `None` without bodies.
///
/// # Errors
/// A mesh that cannot be read, is open or inside out.
pub fn bodies_found(machine: &Machine, places: &[Place]) -> Result<Option<BodiesFound>> {
    if !machine.has_bodies() {
        return Ok(None);
    }
    let cell = machine.cell()?;
    let mut poses = Vec::new();
    let mut nearest = |at: &Configuration| {
        machine.frame_poses(at, &mut poses);
        let own = cell.nearest(&poses)?;
        let bodies = own.pair.map(|index| &cell.bodies()[index]);
        Some(NearestPair {
            names: bodies.map(|body| body.name.clone()),
            distance_mm: own.distance_mm,
            is_assumed: bodies.iter().any(|body| !body.grade.clears()),
        })
    };
    let at_home = nearest(&machine.home);
    let mut anywhere: Option<(String, NearestPair)> = None;
    for (name, position, _) in places {
        let found = machine.inverse_kinematics_at(*position).ok().and_then(|at| nearest(&at));
        if let Some(own) =
            found.filter(|own| anywhere.as_ref().is_none_or(|(_, known)| own.distance_mm < known.distance_mm))
        {
            anywhere = Some((name.clone(), own));
        }
    }
    let names = cell.bodies().iter().map(|body| body.name.clone()).collect();
    Ok(Some(BodiesFound { names, pairs: cell.pairs().len(), at_home, anywhere }))
}

impl BodiesFound {
    /// Returns a warning for bodies that overlap, where they must not.
    pub(super) fn warning(&self) -> Option<String> {
        let (place, pair) = match (&self.at_home, &self.anywhere) {
            (Some(pair), _) if pair.distance_mm < 0.0 => ("home", pair),
            (_, Some((place, pair))) if pair.distance_mm < 0.0 => (place.as_str(), pair),
            _ => return None,
        };
        let [a, b] = &pair.names;
        Some(format!(
            "bodies: at {place} {}; is a shape too large or in a wrong place? If they may touch, may_touch = [[\"{a}\", \"{b}\"]] says so",
            pair.text()
        ))
    }
}
