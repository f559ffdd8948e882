//! Where a path cuts and no law of its process knows the force.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::{
    Process, VerdictForce,
    cutting::{BY_END, CuttingLaw, is_drilling},
};
use crate::{
    FOR_PAGES,
    process::{CutPath, UnknownForce},
    toolpath::PathPoint,
};

impl Process {
    /// Returns why no law knows the force, or all of it, on the way to point number `k` of `path`; `None` where it is known, or nothing is cut.
    #[must_use]
    pub fn unknown_force(&self, path: &CutPath, k: usize) -> Option<UnknownForce> {
        let point = path.points()[k];
        match path.engagements().get(k) {
            Some(engaged) => engaged.unknown.filter(|_| point.cutting),
            None => is_drilling(self.way_of_side(&point)?).then_some(UnknownForce::End),
        }
    }

    /// Returns how much of the force on `path` is known.
    #[must_use]
    pub fn known_force(&self, path: &CutPath) -> KnownForce {
        let is_cut =
            |k: usize| path.points()[k].cutting && path.engagements().get(k).is_none_or(|own| own.removed_mm2 > 0.0);
        let (mut knows, mut lacks) = (false, false);
        for k in (0..path.len()).filter(|k| is_cut(*k)) {
            let why = self.unknown_force(path, k);
            knows |= matches!(why, None | Some(UnknownForce::EndOnRamp));
            lacks |= why.is_some() || self.lacks_end_force(path, k);
        }
        match (knows, lacks) {
            (false, true) => KnownForce::Nowhere,
            (true, true) => KnownForce::Partly,
            (_, false) => KnownForce::Everywhere,
        }
    }

    /// Whether the force on the way to point number `k` of `path` is that of the side of a milling tool alone, while its end may cut, too.
    #[must_use]
    pub fn lacks_end_force(&self, path: &CutPath, k: usize) -> bool {
        let ramps = |way: Vector3<f64>| way.z > BY_END && !is_drilling(way);
        path.engagements().is_empty() && self.way_of_side(&path.points()[k]).is_some_and(ramps)
    }

    /// Returns the direction of motion, in axes of the tool, of a point that cuts by a law of the side of a milling tool; `None` of any other.
    fn way_of_side(&self, point: &PathPoint) -> Option<Vector3<f64>> {
        let law = self.own_forces.law_at(point).unwrap_or(&self.cutting);
        if !point.cutting || !matches!(law, CuttingLaw::SlotMilling(_) | CuttingLaw::EndMilling(_)) {
            return None;
        }
        let placed = self.placement.place(&self.machine);
        let turned = point.orientation.map_or(placed, |orientation| placed.with_tool_orientation(&orientation));
        Some(turned.tool_axes().tr_mul(&point.tangent))
    }

    /// Returns sentences about where `path` cuts and the force is not known, and is therefore not compensated; empty where it is known. Moves are
    /// called by the lines that `line_name` gives, by their number where it returns `None`.
    #[must_use]
    pub fn unknown_force_text(&self, path: &CutPath, line_name: &dyn Fn(usize) -> Option<String>) -> String {
        let mut moves: BTreeMap<Option<UnknownForce>, Vec<usize>> = BTreeMap::new();
        for (k, point) in path.points().iter().enumerate() {
            let unknown = self.unknown_force(path, k);
            if unknown.is_none() && !self.lacks_end_force(path, k) {
                continue;
            }
            let own = moves.entry(unknown).or_default();
            if own.last() != Some(&point.source.segment) {
                own.push(point.source.segment);
            }
        }
        let sentence = |(why, moves): (Option<UnknownForce>, Vec<usize>)| {
            let mut names: Vec<String> =
                moves.iter().map(|own| line_name(*own).unwrap_or_else(|| format!("move {}", own + 1))).collect();
            names.dedup();
            let more = names.len().saturating_sub(NAMED);
            names.truncate(NAMED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let lines = names.join(", ") + &more;
            match why {
                Some(UnknownForce::EndOnRamp) | None => format!(
                    "On ramps only the force of the side of the tool is known and compensated: what its end teeth receive is in no law ({lines}).\n"
                ),
                Some(why) => format!(
                    "No force is known and none is compensated, only what else moves the tool, where {} ({lines}).\n",
                    why.text()
                ),
            }
        };
        // What is not compensated at all comes first.
        let last = moves.remove(&None).map(|own| (None, own));
        moves.into_iter().chain(last).map(sentence).collect()
    }
}

/// What must be known of the force on a path before anything computed with it, in sentences; empty where there is nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForceText {
    /// [`Process::unknown_force_text`].
    pub unknown: String,
    /// How much of it is known.
    pub known: KnownForce,
    /// Which force within a turn of the spindle counts, and whether that is right; not said on pages.
    pub of_turn: String,
}

impl ForceText {
    /// Returns what must be known of the force on `path` by the laws of `process`. Moves are called by the lines that `line_name` gives, by their
    /// number where it returns `None`.
    #[must_use]
    pub fn of(process: &Process, path: &CutPath, line_name: &dyn Fn(usize) -> Option<String>) -> Self {
        let of_turn = sentence(|| VerdictForce::of(process, path));
        Self { unknown: process.unknown_force_text(path, line_name), known: process.known_force(path), of_turn }
    }

    /// Returns which force within a turn counts where `process` has one cut and no path, in a sentence; empty without one, and on pages.
    #[must_use]
    pub fn of_cut(process: &Process) -> String {
        sentence(|| VerdictForce::of_cut(process))
    }
}

/// Returns what `found` says of the force that counts, if anything; nothing on pages.
fn sentence(found: impl Fn() -> Option<VerdictForce>) -> String {
    let found = if FOR_PAGES { None } else { found() };
    found.map_or_else(String::new, |own| own.sentence())
}

/// How much of the force on a path its laws know.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum KnownForce {
    /// All of it, or nothing is cut.
    #[default]
    Everywhere,
    /// Not at all points, or not all of it.
    Partly,
    /// Nothing, wherever it cuts.
    Nowhere,
}

/// Most lines that are named.
const NAMED: usize = 8;

impl UnknownForce {
    /// Returns in words where that is.
    fn text(self) -> &'static str {
        match self {
            UnknownForce::End | UnknownForce::EndOnRamp => {
                "the end of a milling tool goes down into material: its end teeth are in no law"
            }
            UnknownForce::PartlySolid => {
                "a drill is not in solid material all around, as its point enters or leaves, or in a hole that is there: its law is of solid \
                 drilling, and only one of its lips (kienzle) knows a part of them"
            }
            UnknownForce::Aside => "a drill goes through material other than along its axis",
        }
    }

    /// Returns its name in files.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            UnknownForce::End => "end_of_milling_tool",
            UnknownForce::EndOnRamp => "end_of_milling_tool_on_ramp",
            UnknownForce::PartlySolid => "drill_partly_in_solid",
            UnknownForce::Aside => "drill_aside",
        }
    }
}
