//! The lattice of turns about the tool's axis: the cheapest way through it against all ways, and what becomes of ties.

use kinetostat::{
    process::RedundancyObjective,
    redundancy::{
        Infeasible,
        internals::{Knot, MAX_DRIVES, NodeState, Shape, Walk},
    },
};
use proptest::prelude::*;

use crate::support::cases::cases;

const BRANCHES: usize = 2;

/// A knot and its nodes, turn by turn, the branches of each.
#[derive(Debug, Clone)]
struct Layer {
    weight: f64,
    band: usize,
    seconds: f64,
    nodes: Vec<Result<NodeState, Infeasible>>,
}

fn layer(gammas: usize) -> impl Strategy<Value = Layer> {
    let node = prop_oneof![
        1 => Just(Err(Infeasible::Limits)),
        4 => (0.0..1.0f64, 0.0..2.0f64).prop_map(|(cost_mm, drive)| {
            let mut drives = [0.0; MAX_DRIVES];
            drives[0] = drive;
            Ok(NodeState { drives, cost_mm })
        }),
    ];
    let nodes = prop::collection::vec(node, gammas * BRANCHES);
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
    let ways = shape.gammas.pow(layers.len() as u32);
    for branch in 0..BRANCHES {
        'ways: for way in 0..ways {
            let turn = |k: usize| way / shape.gammas.pow(k as u32) % shape.gammas;
            let (mut squares, mut worst, mut before) = (0.0, 0.0f64, None);
            for (k, layer) in layers.iter().enumerate() {
                let Ok(at) = &layer.nodes[turn(k) * BRANCHES + branch] else { continue 'ways };
                if let Some((last, drives)) = before {
                    let apart = turn(k).abs_diff(last);
                    let apart = if shape.is_cyclic { apart.min(shape.gammas - apart) } else { apart };
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

fn walked(layers: &[Layer], shape: &Shape, objective: RedundancyObjective, ceiling_mm: f64) -> Walk {
    let mut walk = Walk::new(shape.clone(), objective, ceiling_mm);
    for (k, layer) in layers.iter().enumerate() {
        let Layer { weight, band, seconds, ref nodes } = *layer;
        walk.step(&Knot { point: k, weight, band, seconds }, nodes.clone());
    }
    walk
}

/// Nodes all of whose turns cost the same but for noise, and a step down from the third turn on.
fn indifferent(gammas: usize, k: usize, step: f64) -> Layer {
    let noise = |turn: usize| 1e-13 * ((7 * turn + 3 * k) % 5) as f64;
    let cost = |turn: usize| 0.5 + noise(turn) - if turn >= 3 { step } else { 0.0 };
    let node = |turn: usize| Ok(NodeState { drives: [0.0; MAX_DRIVES], cost_mm: cost(turn) });
    let nodes = (0..gammas * BRANCHES).map(|node_of| node(node_of / BRANCHES)).collect();
    Layer { weight: if k == 2 { 0.0 } else { 1.0 }, band: gammas, seconds: 1.0, nodes }
}

#[test]
fn a_tie_goes_to_as_programmed_and_then_to_the_least_motion() {
    let gammas = 8;
    let shape = Shape { branches: BRANCHES, gammas, is_cyclic: true, programmed: Some((1, 1)), ..Shape::default() };
    for objective in [RedundancyObjective::Rms, RedundancyObjective::Worst] {
        for (step, expected) in [(0.0, 1), (1e-10, 1), (1e-6, 3)] {
            let layers: Vec<Layer> = (0..6).map(|k| indifferent(gammas, k, step)).collect();
            let walk = walked(&layers, &shape, objective, f64::INFINITY);
            assert_eq!(walk.best_constant(), Some((expected, 1)), "{objective:?} {step}");
            // A way may turn for less than a tie, if it need not turn back: what is found is held against the best constant γ.
            if objective == RedundancyObjective::Rms && step != 1e-10 {
                let (_, way, branch) = walk.cheapest().unwrap();
                assert_eq!((way, branch), (vec![expected; 6], 1), "{step}");
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(128))]

    #[test]
    fn the_cheapest_way_is_that_of_all_ways(
        gammas in 3..6usize,
        is_cyclic: bool,
        layers in prop::collection::vec(layer(5), 5),
    ) {
        let layers: Vec<Layer> = layers
            .into_iter()
            .map(|layer| Layer { nodes: layer.nodes[..gammas * BRANCHES].to_vec(), ..layer })
            .collect();
        let shape = Shape {
            branches: BRANCHES,
            gammas,
            is_cyclic,
            full_turns: vec![Some(5.0)],
            speeds: vec![1.0],
            programmed: None,
        };
        let all = all_ways(&layers, &shape);
        let rms = walked(&layers, &shape, RedundancyObjective::Rms, f64::INFINITY);
        let worst = walked(&layers, &shape, RedundancyObjective::Worst, f64::INFINITY);
        prop_assert_eq!(all.is_none(), rms.cheapest().is_none());
        prop_assert_eq!(all.is_none(), rms.dead_end.is_some());
        if let Some((squares, (largest, of_largest))) = all {
            prop_assert!((rms.cheapest().unwrap().0 - squares).abs() < 1e-12);
            prop_assert_eq!(worst.cheapest().unwrap().0, largest);
            let second = walked(&layers, &shape, RedundancyObjective::Rms, largest);
            prop_assert!((second.cheapest().unwrap().0 - of_largest).abs() < 1e-12);
        }
    }
}
