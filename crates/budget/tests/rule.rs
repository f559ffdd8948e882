//! The rule: "within" needs every cause, "out" none.

use kinetostat_budget::{Budget, Cause, Decision, Entry, Mark};
use proptest::prelude::*;

fn known(mm: impl Fn(Cause) -> f64) -> Budget {
    let mut budget = Budget::default();
    for cause in Cause::ALL {
        budget.set(Entry::bound(cause, mm(cause), Mark::Full, "measured"));
    }
    budget
}

#[test]
fn bounds_are_added_to_what_is_judged() {
    let budget = known(|cause| if cause == Cause::Accuracy { 0.25 } else { 0.0 });
    assert_eq!(budget.decide(0.25, 0.5), Decision::Within { used_mm: 0.5 });
    assert_eq!(budget.decide(0.375, 0.5), Decision::Out { used_mm: 0.625 });
    let mut sampled = budget.clone();
    sampled.set(Entry::counted(Cause::Accuracy, Mark::Half, "data sheet").of_mm(0.25));
    assert_eq!(sampled.decide(0.4, 0.5), Decision::Within { used_mm: 0.4 });
}

#[test]
fn what_is_not_asked_about_is_neither_missed_nor_added() {
    let mut budget = Budget::default();
    budget.set(Entry::counted(Cause::Force, Mark::Full, "simulated"));
    budget.set(Entry::bound(Cause::Heat, 9.0, Mark::Half, "assumed"));
    assert_eq!(budget.decide(0.1, 0.2), Decision::Out { used_mm: 9.1 });
    let asked = budget.clone().within(Some(vec![Cause::Force]));
    assert_eq!(asked.decide(0.1, 0.2), Decision::Within { used_mm: 0.1 });
    let both = budget.within(Some(vec![Cause::Force, Cause::Bodies]));
    assert_eq!(both.decide(0.1, 0.2), Decision::NotDecided { used_mm: 0.1, unknown: vec![Cause::Bodies] });
}

#[test]
fn of_two_parts_the_worse_counts_with_the_larger_bound() {
    let mut one = Budget::default();
    one.set(Entry::bound(Cause::Heat, 0.25, Mark::Full, "measured"));
    one.set(Entry::counted(Cause::Force, Mark::Full, "simulated"));
    let mut other = Budget::default();
    other.set(Entry::unknown(Cause::Heat, "nobody"));
    other.set(Entry::bound(Cause::Force, 0.125, Mark::Half, "assumed"));
    for both in [one.clone().worse(other.clone()), other.worse(one)] {
        assert_eq!(both.bounds_mm(), 0.375);
        assert!(both.unknown().contains(&Cause::Heat) && !both.unknown().contains(&Cause::Force));
    }
}

proptest! {
    /// Forgetting a cause never makes "within" of what was not, and never names fewer unknowns.
    #[test]
    fn knowing_less_never_makes_it_better(
        sizes in prop::array::uniform12(prop::option::of(0.0..0.1)),
        counted in prop::array::uniform12(any::<bool>()),
        judged in 0.0..1.0,
        forgotten in 0usize..12,
    ) {
        let mut budget = Budget::default();
        for ((cause, size), is_counted) in Cause::ALL.into_iter().zip(sizes).zip(counted) {
            budget.set(match size {
                None => Entry::unknown(cause, "nobody"),
                Some(_) if is_counted => Entry::counted(cause, Mark::Half, "sampled"),
                Some(mm) => Entry::bound(cause, mm, Mark::Full, "measured"),
            });
        }
        let before = budget.decide(judged, 0.7);
        let mut less = budget.clone();
        less.set(Entry::unknown(Cause::ALL[forgotten], "forgotten"));
        let after = less.decide(judged, 0.7);
        let is_within = |decision: &Decision| matches!(decision, Decision::Within { .. });
        prop_assert!(!is_within(&after));
        prop_assert!(less.unknown().len() >= budget.unknown().len());
        prop_assert!(!is_within(&before) || budget.unknown().is_empty());
    }
}
