//! Plausible masses of a URDF: missing ones, placeholders and absurd ones are left out and noted.

use super::{
    read::{Inertial, Robot},
    source::{note_names, quoted},
    tree::Tree,
};

/// A plausible mass, kg, and its centre in the link's frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mass {
    pub kg: f64,
    pub centre: [f64; 3],
}

/// So many equal masses are no coincidence.
const EQUAL_MASSES: usize = 3;
/// Machines weigh between these, in kg over the square of the reach in m: a light arm of 1 m and a foundry robot are far within.
const MIN_KG_PER_M2: f64 = 0.2;
const MAX_KG_PER_M2: f64 = 5000.0;

/// Returns the mass of each of `robot.links`, in their order, and notes what is left out: `None` where it is missing or not plausible for a chain
/// that reaches at most `reach_bound_m`, and of all links where their sum is not. A bound of 0 leaves sum and centres unchecked.
pub(super) fn plausible_masses(
    robot: &Robot,
    tree: &Tree,
    reach_bound_m: f64,
    notes: &mut Vec<String>,
) -> Vec<Option<Mass>> {
    let mut masses: Vec<Option<Mass>> =
        (0..robot.links.len()).map(|link| link_mass(robot, tree, link, reach_bound_m, notes)).collect();
    note_missing(robot, notes);
    if let Some(problem) = all_implausible(&masses, reach_bound_m) {
        notes.push(problem);
        masses.fill(None);
    }
    masses
}

/// Returns the mass of the link with index `link` if it is plausible for a chain of `length` (m); notes what is wrong with it otherwise.
fn link_mass(robot: &Robot, tree: &Tree, link: usize, length: f64, notes: &mut Vec<String>) -> Option<Mass> {
    let Inertial { mass, centre } = robot.links[link].inertial.as_ref()?;
    let name = quoted(&robot.links[link].name);
    let Some(kg) = *mass else {
        notes.push(format!("mass of link {name}: not used, its inertial has no mass"));
        return None;
    };
    if kg <= 0.0 {
        notes.push(format!("mass of link {name}: not used, {kg:?} kg is none"));
        return None;
    }
    if centre.is_none() {
        notes.push(format!("mass of link {name}: its centre is not given, taken at the origin of the link's frame"));
    }
    let centre = centre.unwrap_or_default();
    let link_length = tree.carries[link].iter().map(|&joint| norm(robot.joints[joint].origin.xyz)).fold(0.0, f64::max);
    let farthest = link_length + 0.5 * length;
    if length > 0.0 && norm(centre) > farthest {
        notes.push(format!(
            "mass of link {name}: not used, its centre is {:.3} m from the link's frame, expected at most {farthest:.3} m (the \
             link's length and half of the chain's)",
            norm(centre)
        ));
        return None;
    }
    Some(Mass { kg, centre })
}

/// Returns the length of a vector.
fn norm([x, y, z]: [f64; 3]) -> f64 {
    libm::hypot(libm::hypot(x, y), z)
}

/// Notes links without an inertial element, separately those with a shape and those that are only frames.
fn note_missing(robot: &Robot, notes: &mut Vec<String>) {
    let without = |shaped: bool| {
        let links = robot.links.iter().filter(move |link| link.inertial.is_none() && link.shapes.is_empty() != shaped);
        links.map(|link| link.name.as_str())
    };
    note_names(notes, "links without mass though they have a shape", without(true));
    note_names(notes, "links without mass and shape, taken as frames", without(false));
}

/// Returns why none of the masses is plausible for a chain of `length` (m): all equal, or an absurd total; `None` if they are plausible.
fn all_implausible(masses: &[Option<Mass>], length: f64) -> Option<String> {
    let kg: Vec<f64> = masses.iter().flatten().map(|mass| mass.kg).collect();
    let first = *kg.first()?;
    let total: f64 = kg.iter().sum();
    #[allow(clippy::float_cmp)]
    let are_equal = kg.iter().all(|&other| other == first);
    if are_equal && (kg.len() >= EQUAL_MASSES || kg.len() > 1 && first == 1.0) {
        return Some(format!("masses: none used, all {} are {first:?} kg, a placeholder", kg.len()));
    }
    let (least, most) = (MIN_KG_PER_M2 * length * length, MAX_KG_PER_M2 * length * length);
    (length > 0.0 && !(least..=most).contains(&total)).then(|| {
        format!(
            "masses: none used, {total} kg in all is absurd for a chain {length:.3} m long, expected {least:.3} to {most:.0} kg"
        )
    })
}
