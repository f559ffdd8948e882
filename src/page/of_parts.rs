//! What a comparison of parts rests on: no result is better by what nobody knows of it, and none that is out of tolerance is taken for its smaller deflection.

use kinetostat_budget::{Cause, Entry, Mark};

use super::{
    folder::ResultFolder,
    headline::{Headline, State, Verdict},
    record::tolerance_mm,
};
use crate::{
    files::words::{join_text, millimetres},
    input::error::Result,
};

/// What a comparison holds against each other.
const COMPUTED: &str = "what is computed";
/// Bounds that differ by a larger share of the tolerance may turn round what is better.
const BOUNDS_ALIKE: f64 = 0.01;

/// One of the compared results.
struct Part<'a> {
    letter: String,
    verdict: Option<&'a Verdict>,
    causes: &'a [Entry],
    tolerance_mm: Option<f64>,
}

impl Part<'_> {
    fn is(&self, state: State) -> bool {
        self.verdict.is_some_and(|own| own.state == state)
    }

    fn asks_about(&self) -> impl Iterator<Item = Cause> {
        self.causes.iter().map(|own| own.cause)
    }

    fn unknown(&self) -> Vec<Cause> {
        let hollow = |cause: &Cause| self.causes.iter().any(|own| own.cause == *cause && own.mark == Mark::Hollow);
        Cause::BY_SIZE.into_iter().filter(hollow).collect()
    }

    fn bounds_mm(&self) -> f64 {
        self.causes.iter().filter(|own| !own.counted).filter_map(|own| own.mm).sum()
    }
}

/// A verdict on parts, in place of one on what is computed.
struct Decision {
    verdict: Verdict,
    /// What replaces the sentence on what is computed; that stays, with its condition, if `None`.
    sentence: Option<String>,
    next: String,
}

fn joined(words: &[impl AsRef<str>]) -> String {
    join_text(&words.iter().map(AsRef::as_ref).collect::<Vec<_>>())
}

/// Decides by what the verdict of each part rests on; `None` where what is computed decides.
fn decide(parts: &[Part<'_>], computed: Option<State>) -> Option<Decision> {
    let letters_of = |state: State| -> Vec<&str> {
        parts.iter().filter(|own| own.is(state)).map(|own| own.letter.as_str()).collect()
    };
    let (within, out) = (letters_of(State::Good), letters_of(State::Bad));
    let is_same = |with: &dyn Fn(&Part<'_>, &Part<'_>) -> bool| parts.windows(2).all(|pair| with(&pair[0], &pair[1]));
    let asks_the_same = is_same(&|a, b| a.asks_about().eq(b.asks_about()));
    let unknown: Vec<Vec<Cause>> = parts.iter().map(Part::unknown).collect();
    let bounds = parts.iter().map(Part::bounds_mm);
    let apart_mm = bounds.clone().fold(0.0, f64::max) - bounds.fold(f64::INFINITY, f64::min);
    let tolerance = parts.iter().filter_map(|own| own.tolerance_mm).reduce(f64::min);
    let has_one_tolerance = is_same(&|a, b| a.tolerance_mm == b.tolerance_mm);
    let bounds_differ = apart_mm > tolerance.map_or(0.0, |mm| BOUNDS_ALIKE * mm);
    let differs = !asks_the_same || unknown.windows(2).any(|pair| pair[0] != pair[1]) || bounds_differ;
    let decision = |state, words: String, sentence: Option<String>, next: String| {
        Some(Decision { verdict: Verdict::new(state, words), sentence, next })
    };
    if differs && out.len() == parts.len() {
        let next = "cut none of them; make what each names as its largest part smaller, and compare again.";
        return decision(State::Bad, "None is within tolerance".into(), None, next.into());
    }
    let is_alone = !within.is_empty() && !out.is_empty() && within.len() + out.len() == parts.len();
    if is_alone && asks_the_same && has_one_tolerance {
        let words = format!("{} alone within tolerance", joined(&within));
        let sentence = format!("With all that is known, {} alone fits.", joined(&within));
        return decision(State::Good, words, Some(sentence), format!("take {}.", within.join(" or ")));
    }
    if !asks_the_same {
        let next = "ask about the same causes in each ([verdict] of its process file), and compare again.";
        return decision(State::NotDecided, "Not decided: different causes are asked about".into(), None, next.into());
    }
    if is_alone && !has_one_tolerance {
        let next = "compare parts that are held to the same tolerance.";
        return decision(State::NotDecided, "Not decided: each has its own tolerance".into(), None, next.into());
    }
    // Of each the causes that are known of another.
    let lacks = parts.iter().zip(&unknown).filter_map(|(part, own)| {
        let is_known = |cause: &&Cause| unknown.iter().any(|other| !other.contains(cause));
        let own: Vec<&str> = own.iter().filter(is_known).map(|cause| cause.text()).collect();
        (!own.is_empty()).then_some((part, own))
    });
    let lacks: Vec<(&Part<'_>, Vec<&str>)> = lacks.collect();
    let named: Vec<String> = lacks.iter().map(|(part, own)| format!("{} of {}", joined(own), part.letter)).collect();
    let words = match lacks.as_slice() {
        [] if bounds_differ => {
            let words = format!("Not decided: bounds differ by {}", millimetres(apart_mm, 3));
            let next = "compare what each takes of its tolerance, bounds included.";
            return decision(State::NotDecided, words, None, next.into());
        }
        [] if within.len() == parts.len() && computed == Some(State::Bad) => {
            let next = "take any of them: each is within its tolerance by its own verdict.";
            return decision(State::Partly, "All within tolerance, each by itself".into(), None, next.into());
        }
        [] => return None,
        [(part, own)] => match own.as_slice() {
            [cause] => format!("Not decided: {cause} of {} unknown", part.letter),
            _ => format!("Not decided: {} causes of {} unknown", own.len(), part.letter),
        },
        _ => "Not decided: different causes are unknown".into(),
    };
    decision(State::NotDecided, words, None, format!("find out about {}, and compare again.", joined(&named)))
}

/// Holds what `headline` says of numbers that were computed against what the verdict of each of the `folders` rests on; of results that judge no part nothing
/// is changed.
///
/// # Errors
/// The record of a folder cannot be read.
pub fn hold_to_causes<'a>(headline: &mut Headline, folders: &'a [ResultFolder], letters: &[char]) -> Result<()> {
    let part = |(folder, letter): (&'a ResultFolder, &char)| {
        let Headline { verdict, causes, .. } = &folder.description.headline;
        Ok(Part { letter: letter.to_string(), verdict: verdict.as_ref(), causes, tolerance_mm: tolerance_mm(folder)? })
    };
    let parts = folders.iter().zip(letters).map(part).collect::<Result<Vec<Part<'a>>>>()?;
    if parts.iter().all(|own| own.causes.is_empty()) {
        return Ok(());
    }
    let each = parts
        .iter()
        .map(|own| format!("{}: {}", own.letter, own.verdict.map_or("not judged", |own| own.words.as_str())));
    let mut cautions = vec![format!("Judged each by itself. {}.", each.collect::<Vec<_>>().join("; "))];
    let is_open = parts.iter().any(|own| !own.unknown().is_empty());
    if is_open {
        headline.marks.push("of what is computed: some causes are unknown".into());
    }
    let has_one_within = parts.iter().any(|own| own.is(State::Good));
    match decide(&parts, headline.verdict.as_ref().map(|own| own.state)) {
        Some(Decision { verdict, sentence, next }) => {
            let computed = headline.sentence.clone();
            let text = headline.unless(verdict.state, verdict.words, COMPUTED);
            cautions.extend((!text.is_empty()).then(|| format!("By {COMPUTED} alone: {text}.")));
            if let Some(sentence) = sentence {
                cautions.push(format!("By {COMPUTED} alone: {computed}"));
                headline.sentence = sentence;
            }
            headline.next = Some(next);
        }
        None => {
            if let Some(own) = headline.verdict.as_mut().filter(|own| own.state == State::Good)
                && (is_open || !has_one_within)
            {
                own.state = State::Partly;
            }
            if !has_one_within {
                headline.next = headline.next.take().map(|next| format!("cut none of them yet; {next}"));
            }
        }
    }
    let bounds: Vec<String> =
        parts.iter().map(|own| format!("{} in {}", millimetres(own.bounds_mm(), 3), own.letter)).collect();
    if parts.windows(2).any(|pair| pair[0].bounds_mm() != pair[1].bounds_mm()) {
        cautions.push(format!("Bounds, in none of these numbers: {}.", joined(&bounds)));
    }
    headline.cautions.splice(0..0, cautions);
    Ok(())
}
