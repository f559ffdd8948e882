//! The cheapest way through a lattice of turns and ways to stand, knot after knot: dynamic programming. Of a knot that is passed, two
//! bytes for each node are kept.

use serde::Serialize;

use super::{
    nodes::{Hindrance, Node, Standing},
    turnable::MOST_DRIVES,
};
use crate::process::TurnObjective;

/// Nodes of a knot.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// How much its cost counts.
    pub weight: f64,
    /// Steps by which the turn may change from the knot before.
    pub band: usize,
    /// Time from there, s.
    pub seconds: f64,
    /// Turn by turn, the ways to stand of each.
    pub nodes: Vec<Node>,
}

/// What the lattice is like.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// Ways to stand.
    pub stances: usize,
    /// Turns.
    pub turns: usize,
    /// Whether the last turn neighbours the first.
    pub wraps: bool,
    /// Of each drive, what a full turn of it is, rad; `None` of a slide.
    pub full_turns: Vec<Option<f64>>,
    /// Fastest motion of each drive, rad/s; none if empty.
    pub speeds: Vec<f64>,
}

/// A hinge that moves by a larger share of a full turn from one point to the next is not led there: it has swung about.
const SWUNG: f64 = 0.25;

impl Shape {
    /// Whether the drives may go from `before` to `after` within `seconds`.
    pub fn allows(&self, before: &[f64; MOST_DRIVES], after: &[f64; MOST_DRIVES], seconds: f64) -> bool {
        let way = |k: usize| (after[k] - before[k]).abs();
        let is_led = |(k, turn): (usize, &Option<f64>)| turn.is_none_or(|turn| way(k) <= SWUNG * turn);
        self.full_turns.iter().enumerate().all(is_led)
            && self.speeds.iter().enumerate().all(|(k, most)| way(k) <= most * seconds)
    }

    /// Turns from which `turn` is reached in `steps` steps either way.
    fn near(&self, turn: usize, steps: usize) -> impl Iterator<Item = usize> + use<> {
        let (turns, wraps) = (self.turns, self.wraps);
        let there = move |k: usize| match wraps {
            true => Some((turn + turns - k % turns) % turns),
            false => turn.checked_sub(k),
        };
        let back = move |k: usize| match wraps {
            true => Some((turn + k) % turns),
            false => Some(turn + k).filter(|turn| *turn < turns),
        };
        let is_twice = move |k: usize| k == 0 || (wraps && 2 * k == turns);
        let most = if wraps { steps.min(turns / 2) } else { steps.min(turns - 1) };
        (0..=most).flat_map(move |k| there(k).into_iter().chain(back(k).filter(|_| !is_twice(k))))
    }
}

/// Where a way through the lattice ends, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeadEnd {
    /// Index of the point.
    pub point: usize,
    /// What hinders most turns there; `None` if there are some, but none that is reached from the point before within the band of
    /// turns and the speeds of the drives.
    pub hindrance: Option<Hindrance>,
}

impl DeadEnd {
    /// Word in tables.
    #[must_use]
    pub fn label(&self) -> &'static str {
        self.hindrance.map_or("no_band", Hindrance::label)
    }

    /// In words.
    #[must_use]
    pub fn reason(&self) -> String {
        let why = match self.hindrance {
            Some(Hindrance::Unreachable) => "no turn is within reach",
            Some(Hindrance::Limits) => "the travel of the drives allows no turn",
            Some(Hindrance::Singularity) => "all turns are nearer to a singularity than is allowed",
            Some(Hindrance::NotStable) => "the loaded machine settles at no turn",
            None => "no turn is reached from the point before within the band of turns and the speeds of the drives",
        };
        format!("point {}: {why}", self.point)
    }

    pub(super) fn of(point: usize, nodes: &[Node]) -> Self {
        let count = |hindrance: Hindrance| nodes.iter().filter(|node| **node == Err(hindrance)).count();
        let most = Hindrance::ALL.into_iter().rev().max_by_key(|hindrance| count(*hindrance));
        Self { point, hindrance: most.filter(|_| nodes.iter().all(Result::is_err)) }
    }
}

/// What holding one turn on one way to stand comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Sum of squares of what counts, mm².
    pub squares: f64,
    /// The largest, mm.
    pub worst: f64,
}

/// No node before.
const NONE: u16 = u16::MAX;

/// A walk through the lattice.
#[derive(Debug)]
pub(super) struct Walk {
    shape: Shape,
    objective: TurnObjective,
    /// No node may cost more.
    ceiling_mm: f64,
    /// The cheapest way to each node of the last knot: mm or mm², as the objective says.
    value: Vec<f64>,
    before: Vec<Node>,
    /// Of each knot but the first, the turn before each node.
    back: Vec<u16>,
    /// What holding each turn comes to; `None` where it cannot be held.
    pub held: Vec<Option<Held>>,
    /// The first knot that no way leads to.
    pub dead_end: Option<DeadEnd>,
}

impl Walk {
    /// A walk that has passed nothing. `worst` objectives are solved twice: first for the least largest cost, then with that as
    /// `ceiling_mm` for the least sum of squares.
    pub fn new(shape: Shape, objective: TurnObjective, ceiling_mm: f64) -> Self {
        let held = vec![Some(Held { squares: 0.0, worst: 0.0 }); shape.turns * shape.stances];
        let (value, before, back) = (Vec::new(), Vec::new(), Vec::new());
        Self { shape, objective, ceiling_mm, value, before, back, held, dead_end: None }
    }

    /// Goes on to the knot at `point`.
    pub fn step(&mut self, point: usize, layer: Layer) {
        let Layer { weight, band, seconds, nodes } = layer;
        let counted = |standing: &Standing| if weight > 0.0 { standing.cost_mm } else { 0.0 };
        let is_first = self.before.is_empty();
        let own: Vec<Option<&Standing>> =
            nodes.iter().map(|node| node.as_ref().ok().filter(|at| counted(at) <= self.ceiling_mm)).collect();
        self.hold(&nodes, weight, seconds, is_first);
        let (mut value, mut back) = (vec![f64::INFINITY; nodes.len()], vec![NONE; nodes.len()]);
        for (node, at) in own.iter().enumerate() {
            let Some(at) = at else { continue };
            let reached = if is_first { Some((0.0, NONE)) } else { self.reach(node, at, band, seconds) };
            let Some((so_far, from)) = reached else { continue };
            value[node] = match self.objective {
                TurnObjective::Rms => so_far + weight * at.cost_mm * at.cost_mm,
                TurnObjective::Worst => f64::max(so_far, counted(at)),
            };
            back[node] = from;
        }
        if self.dead_end.is_none() && value.iter().all(|value| value.is_infinite()) {
            self.dead_end = Some(DeadEnd::of(point, &nodes));
        }
        if !is_first {
            self.back.extend(back);
        }
        (self.value, self.before) = (value, nodes);
    }

    /// The cheapest way to a node at which the machine stands as in `at`, and the turn that it comes from.
    fn reach(&self, node: usize, at: &Standing, band: usize, seconds: f64) -> Option<(f64, u16)> {
        let (turn, stance) = (node / self.shape.stances, node % self.shape.stances);
        let mut cheapest: Option<(f64, u16)> = None;
        for from in self.shape.near(turn, band) {
            let before = from * self.shape.stances + stance;
            let so_far = self.value[before];
            if so_far.is_finite()
                && cheapest.is_none_or(|(least, _)| so_far < least)
                && let Ok(standing) = &self.before[before]
                && self.shape.allows(&standing.drives, &at.drives, seconds)
            {
                cheapest = Some((so_far, from as u16));
            }
        }
        cheapest
    }

    fn hold(&mut self, nodes: &[Node], weight: f64, seconds: f64, is_first: bool) {
        for (k, (held, node)) in self.held.iter_mut().zip(nodes).enumerate() {
            let is_led = |at: &Standing| match self.before.get(k) {
                Some(Ok(before)) => self.shape.allows(&before.drives, &at.drives, seconds),
                _ => is_first,
            };
            *held = match (*held, node) {
                (Some(held), Ok(at)) if is_led(at) => Some(Held {
                    squares: held.squares + weight * at.cost_mm * at.cost_mm,
                    worst: if weight > 0.0 { held.worst.max(at.cost_mm) } else { held.worst },
                }),
                _ => None,
            };
        }
    }

    /// The cheapest way: what it comes to, the turn at each knot, and the way to stand.
    pub fn cheapest(&self) -> Option<(f64, Vec<usize>, usize)> {
        let nodes = self.value.len();
        let (mut node, value) = least(self.value.iter().copied())?;
        let stance = node % self.shape.stances;
        let mut turns = vec![node / self.shape.stances];
        for layer in self.back.chunks_exact(nodes).rev() {
            let from = layer[node] as usize;
            turns.push(from);
            node = from * self.shape.stances + stance;
        }
        turns.reverse();
        Some((value, turns, stance))
    }

    /// The turn and way to stand that are best held all along.
    pub fn best_held(&self) -> Option<(usize, usize)> {
        let squares = |held: &Option<Held>| held.map_or(f64::INFINITY, |held| held.squares);
        let most = match self.objective {
            TurnObjective::Rms => f64::INFINITY,
            TurnObjective::Worst => self.held.iter().flatten().map(|held| held.worst).fold(f64::INFINITY, f64::min),
        };
        let costs = self.held.iter().map(|held| squares(&held.filter(|held| held.worst <= most)));
        let (node, _) = least(costs)?;
        Some((node / self.shape.stances, node % self.shape.stances))
    }
}

/// The first of the least finite values.
fn least(values: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    values.enumerate().filter(|(_, value)| value.is_finite()).reduce(|a, b| if b.1 < a.1 { b } else { a })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STANCES: usize = 2;

    fn layer(turns: usize) -> impl Strategy<Value = Layer> {
        let node = prop_oneof![
            1 => Just(Err(Hindrance::Limits)),
            4 => (0.0..1.0f64, 0.0..2.0f64).prop_map(|(cost_mm, drive)| {
                let mut drives = [0.0; MOST_DRIVES];
                drives[0] = drive;
                Ok(Standing { drives, cost_mm })
            }),
        ];
        let nodes = prop::collection::vec(node, turns * STANCES);
        (0..3usize, 0..4usize, nodes).prop_map(|(weight, band, nodes)| Layer {
            weight: weight as f64,
            band,
            seconds: 1.0,
            nodes,
        })
    }

    /// Goes all ways through `layers`: least sum of squares and least largest cost, with the sum of squares that goes with it.
    fn all_ways(layers: &[Layer], shape: &Shape) -> Option<(f64, (f64, f64))> {
        let mut found: Option<(f64, (f64, f64))> = None;
        let ways = shape.turns.pow(layers.len() as u32);
        for stance in 0..STANCES {
            'ways: for way in 0..ways {
                let turn = |k: usize| way / shape.turns.pow(k as u32) % shape.turns;
                let (mut squares, mut worst, mut before) = (0.0, 0.0f64, None);
                for (k, layer) in layers.iter().enumerate() {
                    let Ok(at) = &layer.nodes[turn(k) * STANCES + stance] else { continue 'ways };
                    if let Some((last, drives)) = before {
                        let apart = turn(k).abs_diff(last);
                        let apart = if shape.wraps { apart.min(shape.turns - apart) } else { apart };
                        if apart > layer.band || !shape.allows(&drives, &at.drives, layer.seconds) {
                            continue 'ways;
                        }
                    }
                    squares += layer.weight * at.cost_mm * at.cost_mm;
                    worst = worst.max(if layer.weight > 0.0 { at.cost_mm } else { 0.0 });
                    before = Some((turn(k), at.drives));
                }
                let (least, (least_worst, of_worst)) = found.unwrap_or((f64::INFINITY, (f64::INFINITY, f64::INFINITY)));
                let is_less = worst < least_worst || (worst == least_worst && squares < of_worst);
                found = Some((least.min(squares), if is_less { (worst, squares) } else { (least_worst, of_worst) }));
            }
        }
        found
    }

    fn walked(layers: &[Layer], shape: &Shape, objective: TurnObjective, ceiling_mm: f64) -> Walk {
        let mut walk = Walk::new(shape.clone(), objective, ceiling_mm);
        for (k, layer) in layers.iter().enumerate() {
            walk.step(k, layer.clone());
        }
        walk
    }

    proptest! {
        #![proptest_config(crate::cases::cases(128))]

        #[test]
        fn the_cheapest_way_is_that_of_all_ways(
            turns in 3..6usize,
            wraps: bool,
            layers in prop::collection::vec(layer(5), 5),
        ) {
            let layers: Vec<Layer> = layers
                .into_iter()
                .map(|layer| Layer { nodes: layer.nodes[..turns * STANCES].to_vec(), ..layer })
                .collect();
            let shape = Shape {
                stances: STANCES,
                turns,
                wraps,
                full_turns: vec![Some(5.0)],
                speeds: vec![1.0],
            };
            let all = all_ways(&layers, &shape);
            let rms = walked(&layers, &shape, TurnObjective::Rms, f64::INFINITY);
            let worst = walked(&layers, &shape, TurnObjective::Worst, f64::INFINITY);
            prop_assert_eq!(all.is_none(), rms.cheapest().is_none());
            prop_assert_eq!(all.is_none(), rms.dead_end.is_some());
            if let Some((squares, (largest, of_largest))) = all {
                prop_assert!((rms.cheapest().unwrap().0 - squares).abs() < 1e-12);
                prop_assert_eq!(worst.cheapest().unwrap().0, largest);
                let second = walked(&layers, &shape, TurnObjective::Rms, largest);
                prop_assert!((second.cheapest().unwrap().0 - of_largest).abs() < 1e-12);
            }
        }
    }
}
