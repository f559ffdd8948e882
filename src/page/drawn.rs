//! Results with uncertain inputs side by side, draw by draw: with which probability one is better than another.

use serde_json::{Value, json};

use super::{
    folder::ResultFolder,
    headline::{Headline, KeyNumber, State, Verdict},
    kind::DrawsTable,
    sentences::three_digits,
    verdict::FirstScreen,
};
use crate::{
    files::words::{counted, millimetres, or_dash, probability},
    input::error::Result,
    process::uncertainty::P95,
    simulation::{
        ROUNDING_MM,
        spread_along::{is_larger, share_larger},
    },
};

/// The largest distance from the path without compensation and with it: key in the summary, words.
const DISTANCES: [[&str; 2]; 2] = [["plain", "without compensation"], ["compensated", "compensated"]];

/// The draws of a result along a path.
struct Draws {
    uncertainty: Value,
    points: Value,
    /// The largest distance in each draw, mm, infinite without equilibrium, in the order of [`DISTANCES`]; no draws where it is known in none.
    sizes: [Vec<f64>; 2],
}

impl Draws {
    /// Reads the draws of `folder`, of which this is the summary.
    fn read(folder: &ResultFolder, own: &DrawsTable, summary: &Value) -> Result<Self> {
        let (table, mut sizes, mut wrong) = (folder.table(own.file)?, [Vec::new(), Vec::new()], None);
        let columns = [table.column(own.distances[0])?, table.column(own.distances[1])?];
        table.each_row(|row| {
            for (column, sizes) in columns.iter().zip(&mut sizes) {
                match row.get(*column).unwrap_or_default() {
                    "" => sizes.push(f64::INFINITY),
                    cell => match cell.parse::<f64>() {
                        Ok(size) if size >= 0.0 => sizes.push(size),
                        _ => wrong = wrong.take().or_else(|| Some(table.not_a_number(row, *column))),
                    },
                }
            }
        })?;
        if let Some(error) = wrong {
            return Err(error);
        }
        let known = sizes.map(|own| if own.iter().any(|size| size.is_finite()) { own } else { Vec::new() });
        Ok(Self { uncertainty: summary["uncertainty"].clone(), points: summary["points"].clone(), sizes: known })
    }

    /// The distribution of the largest distance `which` of [`DISTANCES`].
    fn largest(&self, which: usize) -> &Value {
        &self.uncertainty["largest"][DISTANCES[which][0]]
    }

    /// The 95 % quantile of that, in words.
    fn p95_text(&self, which: usize) -> String {
        self.p95_mm(which).map_or_else(|| "unknown".into(), |p95| millimetres(p95, 3))
    }

    /// The 95 % quantile of that, mm; `None` where too many draws have no equilibrium.
    fn p95_mm(&self, which: usize) -> Option<f64> {
        self.largest(which)["spread"]["p95_mm"].as_f64()
    }

    /// Why the draws with the same number are not of the same machine and force in `other`; `None` where they are.
    fn differs(&self, other: &Self) -> Option<String> {
        let of = |own: &Self, key: &str| own.uncertainty[key].clone();
        let names = |own: &Self| -> Vec<Value> {
            own.uncertainty["parameters"].as_array().into_iter().flatten().map(|own| own["names"].clone()).collect()
        };
        let differ = |key: &str, text: &str| {
            let [a, b] = [of(self, key), of(other, key)];
            (a != b).then(|| format!("their {text} differ ({a} and {b})"))
        };
        let parameters = || (names(self) != names(other)).then(|| "their uncertain parameters differ".into());
        differ("seed", "seeds")
            .or_else(|| differ("draws", "numbers of draws"))
            .or_else(parameters)
            .or_else(|| differ("force_of_tools", "tools with a force each"))
    }
}

/// Probability that `sizes` is smaller than `than` by more than what is alike: draw by draw where they are the `same` draws, else over all pairs.
fn share_smaller(sizes: &[f64], than: &[f64], same: bool) -> f64 {
    let larger = |size: &f64| than.iter().filter(|than| is_larger(**than, *size, 0.0)).count();
    match same {
        true => share_larger(than, sizes, 0.0),
        false => sizes.iter().map(larger).sum::<usize>() as f64 / (sizes.len() * than.len()) as f64,
    }
}

/// From which ratio on two 95 % quantiles differ: twice what 4096 draws can say of them.
pub(super) const P95_APART: f64 = 1.02;

/// Whether the 95 % quantile `p95` is surely smaller than `other`, mm; one that does not exist is the larger.
fn is_safer(p95: Option<f64>, other: Option<f64>) -> bool {
    p95.is_some_and(|p95| other.is_none_or(|other| other > p95 * P95_APART + ROUNDING_MM))
}

/// Returns the first screen with what draws say before what nominal numbers say.
pub(super) fn before_nominal(mut drawn: Headline, nominal: Option<FirstScreen>) -> FirstScreen {
    let FirstScreen { headline, checks } = nominal.unwrap_or_default();
    drawn.numbers.extend(headline.numbers);
    drawn.numbers.truncate(3);
    drawn
        .cautions
        .extend((!headline.sentence.is_empty()).then(|| format!("With nominal numbers: {}", headline.sentence)));
    drawn.cautions.extend(headline.cautions);
    drawn.verdict = drawn.verdict.or(headline.verdict);
    drawn.next = drawn.next.or(headline.next);
    FirstScreen { headline: drawn, checks }
}

/// Holds the draws of `folders`, which sentences call by these `names` and then by letter, against those of the first; only a sentence on what is compared where no draws are kept, or inputs of one are exact. `None`
/// where all inputs are exact.
pub(super) fn compare_draws(
    folders: &[ResultFolder],
    names: &[String],
) -> Result<Option<std::result::Result<Headline, String>>> {
    let letters: Vec<char> = ('A'..).take(folders.len()).collect();
    let summaries: Vec<Value> = folders.iter().map(ResultFolder::summary).collect::<Result<_>>()?;
    let is_exact = |summary: &Value| summary["uncertainty"].is_null();
    let Some(exact) = summaries.iter().position(is_exact) else {
        let has_draws = |folder: &ResultFolder, own: &DrawsTable| {
            folder.manifest["files"].as_array().is_some_and(|files| files.contains(&json!(own.file)))
        };
        let kept = folders.first().and_then(|first| first.kind.draws);
        let Some(kept) = kept.filter(|own| folders.iter().all(|folder| has_draws(folder, own))) else {
            let text = "Draws are not kept of these results: quantiles and probabilities are compared as they stand, each by itself, and with which \
                         probability one result is better than another is not known.";
            return Ok(Some(Err(text.into())));
        };
        let read = |(own, summary)| Draws::read(own, &kept, summary);
        let draws: Vec<Draws> = folders.iter().zip(&summaries).map(read).collect::<Result<_>>()?;
        return Ok(Some(Ok(verdict(&draws, &letters, names))));
    };
    let text = format!("{} takes its inputs as exact: only nominal numbers are compared.", letters[exact]);
    Ok((!summaries.iter().all(is_exact)).then_some(Err(text)))
}

/// Returns the verdict on two results, what to do next, and two sentences: which is better with these probabilities that each is, and by how much.
fn told_apart(
    draws: &[Draws],
    which: usize,
    [better, worse]: [usize; 2],
    [most, least]: [f64; 2],
    letters: &[char],
    names: &[String],
) -> (Verdict, String, [String; 2]) {
    let (text, count) = (DISTANCES[which][1], draws[0].sizes[which].len());
    let called = |who: usize| format!("{} ({})", letters[who], names[who]);
    let [name, other_name] = [better, worse].map(|who| letters[who]);
    let [p95, other_p95] = [better, worse].map(|who| draws[who].p95_text(which));
    let [sure, unsure] = [most, least].map(|share| probability(share, count));
    let smaller = format!(
        "the largest distance from the path, {text}, is smaller by more than 0.5 % in {name} with {sure} probability, in {other_name} with {unsure}"
    );
    // Of machines that are alike in most draws the worse ones may differ: what one can rely on is then the finding.
    let is_safer = |who: usize, than: usize| is_safer(draws[who].p95_mm(which), draws[than].p95_mm(which));
    let [safer, other_one] = if is_safer(worse, better) { [worse, better] } else { [better, worse] };
    let [safe, unsafe_one] = [safer, other_one].map(|who| (called(who), draws[who].p95_text(which)));
    let [called_better, called_worse] = [better, worse].map(called);
    match (most >= P95, is_safer(safer, other_one)) {
        (true, _) => (
            Verdict::new(State::Good, format!("{name} better with {sure} probability")),
            format!("take {name}."),
            [
                format!("{called_better} is better than {called_worse} with {sure} probability."),
                format!(
                    "Its largest distance from the path, {text}, is smaller by more than 0.5 % (95 % quantile {p95} against {other_p95})."
                ),
            ],
        ),
        (false, true) => (
            Verdict::new(State::Partly, format!("{} is the safer one", letters[safer])),
            format!("take {}, or measure what is most uncertain.", letters[safer]),
            [
                format!("{} stays within {} with 95 % probability.", safe.0, safe.1),
                format!(
                    "{} stays within {}, so that {} is the safer one. In a single draw either may be better: {smaller}.",
                    unsafe_one.0, unsafe_one.1, letters[safer]
                ),
            ],
        ),
        (false, false) => (
            Verdict::new(State::Open, "Cannot be told apart"),
            "take either, or measure what is most uncertain.".into(),
            [
                format!("{called_better} and {called_worse} cannot be told apart."),
                format!("In a single draw {smaller} (95 % quantile {p95} against {other_p95})."),
            ],
        ),
    }
}

/// Returns what the `draws` of results with these letters say, each held against the first.
fn verdict(draws: &[Draws], letters: &[char], names: &[String]) -> Headline {
    let unknown = "With which probability one is better is not known.";
    let (mut headline, mut sentences, first) = (Headline::new(unknown, "draws"), Vec::new(), letters[0]);
    let mut further = Vec::new();
    let differs: Vec<Option<String>> = draws.iter().map(|other| draws[0].differs(other)).collect();
    for (letter, differs) in letters.iter().zip(&differs).skip(1) {
        further.push(match differs {
            None => format!("{first} and {letter} have the same draws: in each, the force and every parameter lie at the same quantile of their distributions."),
            Some(why) => format!("{first} and {letter} do not have the same draws, as {why}: machine and force of each are taken as independent of the other's."),
        });
    }
    // What the tool does as it is to be run comes first.
    for which in [1, 0] {
        let (text, mut against) = (DISTANCES[which][1], Vec::new());
        if let Some(unknown) = draws.iter().position(|own| own.sizes[which].is_empty()) {
            further.push(format!("The largest distance {text} is known in no draw of {}.", letters[unknown]));
            continue;
        }
        let is_first = sentences.is_empty();
        for other in 1..draws.len() {
            let sizes = |who: usize| &draws[who].sizes[which];
            let share = |own, other_one| share_smaller(sizes(own), sizes(other_one), differs[other].is_none());
            let (of_first, of_other) = (share(0, other), share(other, 0));
            let [better, worse] = if of_first >= of_other { [0, other] } else { [other, 0] };
            let (most, least) = (of_first.max(of_other), of_first.min(of_other));
            if is_first {
                let (verdict, next, said) = told_apart(draws, which, [better, worse], [most, least], letters, names);
                headline.verdict.get_or_insert(verdict);
                headline.next.get_or_insert(next);
                sentences.extend(said);
            }
            let (p95, sure) = (draws[other].p95_text(which), probability(most, sizes(0).len()));
            against.push(format!("in {} {p95}; {} better with {sure} probability", letters[other], letters[better]));
        }
        let what = format!("largest distance from the path not exceeded with 95 % probability in {first}, {text}");
        let shown = format!("{} mm", or_dash(draws[0].p95_mm(which), three_digits));
        headline.numbers.push(KeyNumber::new(&shown, what, against.join("; ")));
        for (own, letter) in draws.iter().zip(letters) {
            let (largest, points) = (own.largest(which), &own.points);
            if largest["points"] != *points || largest["is_confirmed"] != true {
                let how = if largest["is_confirmed"] == true { "" } else { ", and the engine does not confirm it" };
                let known = &largest["points"];
                further.push(format!("In {letter} the largest distance {text} is of {known} of {points} points{how}."));
            }
        }
    }
    let known = draws.iter().flat_map(|own| &own.sizes).map(Vec::len).filter(|known| *known > 0).min();
    further.push(format!(
        "Probabilities are of {}, whose distances are estimates; only the quantiles are corrected by the engine.",
        counted(known.unwrap_or_default(), "draw")
    ));
    let mut sentences = sentences.into_iter();
    headline.sentence = sentences.next().unwrap_or(headline.sentence);
    headline.cautions = sentences.chain(further).collect();
    headline
}
