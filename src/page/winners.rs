//! Which of several results is best at each place, and by how much.

use super::{common::Common, description::Better, floors::same};

/// What a place says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum At {
    /// Not all results have a number there that is an answer.
    Nothing,
    /// The best and the next best are the same.
    Same,
    /// One is better than all others.
    Best {
        /// Which.
        who: usize,
        /// By which share of the next best.
        lead: f64,
    },
}

/// Places by their winner.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Winners {
    /// By node in common.
    pub at: Vec<At>,
    results: usize,
}

impl Winners {
    /// Of a quantity and group; `None` if neither value is the better one by its nature.
    pub fn new(common: &Common, quantity: usize, group: usize, better: Better, floor: f64) -> Option<Self> {
        let cost = |value: f64| match better {
            Better::Smaller => Some(value),
            Better::Larger => Some(-value),
            Better::Neither => None,
        };
        cost(0.0)?;
        let parts: Vec<&[f64]> = common.parts.iter().map(|part| part.values[quantity][group].as_slice()).collect();
        let mut is_answer = vec![true; common.count()];
        common.parts.iter().flat_map(|part| &part.flags[group]).for_each(|(node, _)| is_answer[*node] = false);
        let at = |node: usize| {
            let values: Vec<f64> = parts.iter().map(|own| own[node]).collect();
            if !is_answer[node] || values.iter().any(|value| !value.is_finite()) {
                return At::Nothing;
            }
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| cost(values[*a]).partial_cmp(&cost(values[*b])).unwrap_or(std::cmp::Ordering::Equal));
            let [best, next] = [values[order[0]], values[order[1]]];
            if same(best, next, floor) {
                return At::Same;
            }
            At::Best { who: order[0], lead: (next - best).abs() / next.abs().max(floor) }
        };
        Some(Self { at: (0..common.count()).map(at).collect(), results: parts.len() })
    }

    /// Places at which all have an answer.
    pub fn counted(&self) -> usize {
        self.at.iter().filter(|at| **at != At::Nothing).count()
    }

    /// Share of these at which `who` is best.
    pub fn share(&self, who: usize) -> f64 {
        self.leads(who).count() as f64 / self.counted().max(1) as f64
    }

    /// Share at which the best two are the same.
    pub fn share_same(&self) -> f64 {
        self.at.iter().filter(|at| **at == At::Same).count() as f64 / self.counted().max(1) as f64
    }

    /// The results, those that are best at most places first.
    pub fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.results).collect();
        order.sort_by_key(|who| std::cmp::Reverse(self.leads(*who).count()));
        order
    }

    /// The lead that `who` has at half of the places where it is best, and more at the others.
    pub fn typical(&self, who: usize) -> Option<f64> {
        let mut leads: Vec<f64> = self.leads(who).map(|(_, lead)| lead).collect();
        leads.sort_by(f64::total_cmp);
        leads.get(leads.len() / 2).copied()
    }

    /// Where `who` is ahead most.
    pub fn most(&self, who: usize) -> Option<usize> {
        self.leads(who).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(node, _)| node)
    }

    fn leads(&self, who: usize) -> impl Iterator<Item = (usize, f64)> {
        self.at.iter().enumerate().filter_map(move |(node, at)| match at {
            At::Best { who: own, lead } if *own == who => Some((node, *lead)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{super::dataset::Dataset, *};

    fn part(values: Vec<f64>, flagged: &[usize]) -> Dataset {
        Dataset {
            axes: vec![(0..values.len()).map(|k| k as f64).collect()],
            names: Vec::new(),
            flags: vec![flagged.iter().map(|node| (*node, 0)).collect()],
            values: vec![vec![values]],
            notes: vec!["lost".into()],
            thinned_from: None,
        }
    }

    #[test]
    fn rounding_and_what_is_not_solved_have_no_winner() {
        let a = part(vec![1.0, 2.0, 2.8e-17, 1.0, 1.0, f64::NAN], &[]);
        let b = part(vec![2.0, 1.5, 5.7e-14, 1.0, 9.0, 1.0], &[4]);
        let common = Common::new(&[a, b]);
        let winners = Winners::new(&common, 0, 0, Better::Smaller, 1e-7).unwrap();
        let best = |who, lead| At::Best { who, lead };
        assert_eq!(winners.at, [best(0, 0.5), best(1, 0.25), At::Same, At::Same, At::Nothing, At::Nothing]);
        assert_eq!((winners.counted(), winners.share(0), winners.share_same()), (4, 0.25, 0.5));
        assert_eq!((winners.most(1), winners.typical(0)), (Some(1), Some(0.5)));
        let larger = Winners::new(&common, 0, 0, Better::Larger, 1e-7).unwrap();
        assert_eq!(larger.at[..2], [best(1, 1.0), best(0, 0.5 / 1.5)]);
        assert_eq!(Winners::new(&common, 0, 0, Better::Neither, 0.0), None);
    }
}
