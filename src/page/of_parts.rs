//! What a comparison of parts rests on: no result is better by what nobody knows of it, and none that is out of tolerance is taken for its smaller deflection.

use kinetostat_budget::{Cause, Mark};

use super::{
    folder::ResultFolder,
    headline::{Headline, State, Verdict},
};
use crate::files::words::{join_words, millimetres};

/// One of the compared results.
struct Part<'a> {
    letter: String,
    own: &'a Headline,
}

impl Part<'_> {
    fn unknown(&self) -> impl Iterator<Item = Cause> {
        self.own.causes.iter().filter(|own| own.mark == Mark::Hollow).map(|own| own.cause)
    }

    fn bounds_mm(&self) -> f64 {
        self.own.causes.iter().filter(|own| !own.counted).filter_map(|own| own.mm).sum()
    }

    fn is_within(&self) -> bool {
        self.own.verdict.as_ref().is_some_and(|own| own.state == State::Good)
    }
}

fn joined(words: &[impl AsRef<str>]) -> String {
    join_words(&words.iter().map(AsRef::as_ref).collect::<Vec<_>>())
}

/// Holds what `headline` says of numbers that were computed against what each of the `folders` rests on; of results that judge no part nothing is changed.
/// `by_own_tolerance` says whether each is held to the tolerance of its study.
pub fn hold_to_causes(headline: &mut Headline, folders: &[ResultFolder], letters: &[char], by_own_tolerance: bool) {
    let parts = folders.iter().zip(letters);
    let parts: Vec<Part<'_>> =
        parts.map(|(folder, letter)| Part { letter: letter.to_string(), own: &folder.description.headline }).collect();
    if parts.iter().all(|own| own.own.causes.is_empty()) {
        return;
    }
    let is_unknown = |part: &Part<'_>, cause: &Cause| part.unknown().any(|own| own == *cause);
    let asks = |cause: &Cause| parts.iter().all(|part| part.own.causes.iter().any(|own| own.cause == *cause));
    let lacks = |cause: &Cause| parts.iter().filter(|own| is_unknown(own, cause)).count();
    // Of what one of them does not ask about nothing is compared.
    let is_apart = |cause: &Cause| asks(cause) && (1..parts.len()).contains(&lacks(cause));
    let apart: Vec<Cause> = Cause::BY_SIZE.into_iter().filter(is_apart).collect();
    let lacking: Vec<&str> = parts
        .iter()
        .filter(|part| apart.iter().any(|cause| is_unknown(part, cause)))
        .map(|part| part.letter.as_str())
        .collect();
    let within: Vec<&str> = parts.iter().filter(|own| own.is_within()).map(|own| own.letter.as_str()).collect();
    let told = match (apart.as_slice(), lacking.as_slice()) {
        ([], _) if by_own_tolerance && (1..parts.len()).contains(&within.len()) => {
            headline.next = Some(format!("take {}.", within.join(" or ")));
            let words = format!("{} alone within tolerance", joined(&within));
            Some(headline.unless(State::Good, words, COMPUTED))
        }
        ([], _) => None,
        (causes, of) => {
            let names = joined(&causes.iter().map(|own| own.words()).collect::<Vec<_>>());
            headline.next = Some(format!("find out about {names} of {}, and compare again.", joined(of)));
            let words = match (causes, of) {
                ([cause], [only]) => format!("Not decided: {} of {only} unknown", cause.words()),
                (_, [only]) => format!("Not decided: {} causes of {only} unknown", causes.len()),
                _ => "Not decided: different causes are unknown".into(),
            };
            Some(headline.unless(State::NotDecided, words, COMPUTED))
        }
    };
    let each = parts.iter().filter_map(|part| Some(format!("{}: {}", part.letter, part.own.verdict.as_ref()?.words)));
    let mut cautions = vec![format!("Judged each by itself. {}.", each.collect::<Vec<_>>().join("; "))];
    cautions.extend(told.as_ref().map(|words| format!("By {COMPUTED} alone: {words}.")));
    let bounds: Vec<f64> = parts.iter().map(Part::bounds_mm).collect();
    let is_same = |bounds: &[f64]| bounds.windows(2).all(|pair| pair[0] == pair[1]);
    if !is_same(&bounds) {
        let each: Vec<String> =
            parts.iter().zip(&bounds).map(|(part, mm)| format!("{} in {}", millimetres(*mm, 3), part.letter)).collect();
        cautions.push(format!("Bounds that are added to a number are in none that is compared: {}.", joined(&each)));
    }
    let is_open = parts.iter().any(|own| own.unknown().next().is_some());
    if is_open {
        headline.marks.push("of what is computed: some causes are unknown".into());
    }
    let none_is_within = by_own_tolerance && within.is_empty();
    match &mut headline.verdict {
        Some(Verdict { state: state @ State::Good, .. })
            if told.is_none() && (none_is_within || is_open || !is_same(&bounds)) =>
        {
            *state = State::Partly;
        }
        _ => {}
    }
    headline.cautions.splice(0..0, cautions);
}

/// What a comparison holds against each other.
const COMPUTED: &str = "what is computed";
