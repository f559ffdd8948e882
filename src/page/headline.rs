//! The result at a glance, for the first screen of a page and the terminal: a verdict, a sentence, at most three numbers, and cautions.

use kinetostat_budget::{Budget, Cause, Decision, Entry};
use serde::{Deserialize, Serialize};

use crate::{
    files::words::{capitalised, join_text, millimetres, percent, uncapitalised, with_unit},
    process::KnownForce,
};

/// The result at a glance, for the first screen of a page and the end of the terminal output.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Headline {
    /// Whether the result may be acted on; `None` where nothing is judged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// What the result rests on, in a word or two each, such as "nominal inputs".
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<String>,
    /// What is known of each cause of error that the verdict is about.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub causes: Vec<Entry>,
    /// Sentence on the part of the work that was not solved, and why; `None` if all was.
    pub unsolved: Option<String>,
    /// The result in a sentence of at most twelve words.
    pub sentence: String,
    /// What to do next; `None` where nothing follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
    /// Key numbers, at most three.
    pub numbers: Vec<KeyNumber>,
    /// What the result was computed from, such as a number of points.
    pub basis: String,
    /// Sentences that a reader must know with the result.
    pub cautions: Vec<String>,
}

/// Whether a result may be acted on: its state, and which that is in at most eight words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// The state, which has a colour and a sign of its own.
    pub state: State,
    /// The state in words.
    pub words: String,
}

/// State of a result; what stands more against it is larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Nothing is judged.
    Open,
    /// Within tolerance, identified, possible.
    Good,
    /// In a part, or not surely.
    Partly,
    /// What is known fits, and nobody knows the rest: no better than what does not fit.
    NotDecided,
    /// Out of tolerance, not to be run, not possible.
    Bad,
}

impl State {
    /// Returns its sign, which stands beside the words.
    pub fn sign(self) -> &'static str {
        match self {
            State::Good => "✓",
            State::Partly => "◐",
            State::Bad => "✗",
            State::NotDecided => "?",
            State::Open => "–",
        }
    }
}

impl Verdict {
    /// Creates a verdict of at most eight words.
    pub fn new(state: State, words: impl Into<String>) -> Verdict {
        Verdict { state, words: words.into() }
    }

    /// Returns the verdict on the share of a `whole`, such as "the box", that is within tolerance; `None` where it is not known.
    pub fn of_share(share: Option<f64>, tolerance_mm: Option<f64>, whole: &str) -> Verdict {
        match (tolerance_mm, share) {
            (None, _) => Verdict::new(State::Open, "No tolerance given"),
            (_, None) => Verdict::new(State::Open, "Not known"),
            (_, Some(1.0)) => Verdict::new(State::Good, "Within tolerance everywhere"),
            (_, Some(0.0)) => Verdict::new(State::Bad, "Out of tolerance everywhere"),
            (_, Some(share)) if share < 0.5 => {
                Verdict::new(State::Bad, format!("Within tolerance in only {} of {whole}", percent(share)))
            }
            (_, Some(share)) => {
                Verdict::new(State::Partly, format!("Within tolerance in {} of {whole}", percent(share)))
            }
        }
    }

    /// Returns the verdict on the share of a box in which the deflection, and nothing else of what moves a tool, is within `tolerance_mm`.
    pub fn of_deflection(share: Option<f64>, tolerance_mm: Option<f64>) -> Verdict {
        let judged = Self::of_share(share, tolerance_mm, "the box");
        let (Some(share), Some(tolerance)) = (share, tolerance_mm) else { return judged };
        let words = match share {
            1.0 => format!("Deflection within {tolerance} mm everywhere"),
            0.0 => format!("Deflection beyond {tolerance} mm everywhere"),
            share => format!("Deflection within {tolerance} mm in {} of the box", percent(share)),
        };
        Verdict { words, ..judged }
    }

    /// Returns this verdict as that on a result of which the share `unsolved` is missing.
    pub fn with_unsolved(self, unsolved: f64) -> Verdict {
        let text = format!("{} could not be solved", percent(unsolved));
        match self.state {
            State::Bad => self,
            _ if unsolved >= 0.5 => Verdict::new(State::Bad, text),
            State::Good | State::Partly => Verdict::new(State::Partly, format!("Partly known: {text}")),
            State::Open | State::NotDecided => self,
        }
    }
}

/// One of the numbers of a headline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyNumber {
    /// The number as shown, without unit.
    pub value: String,
    /// Its unit, empty if it has none.
    pub unit: String,
    /// What the number is, and over what it is taken.
    pub what: String,
    /// What it is compared with: a tolerance, the best, another place.
    pub against: String,
    /// Where a table has the number, if one does.
    pub found: Option<InTable>,
    /// Whether it is within its tolerance, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<State>,
}

/// Where a table has a key number: the extreme of a column over certain rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InTable {
    /// CSV file.
    pub file: String,
    /// Columns; of several, the largest absolute value in a row counts.
    pub columns: Vec<String>,
    /// Conditions on rows, as pairs of column and value.
    pub rows: Vec<[String; 2]>,
    /// Whether it is the smallest or the largest value.
    pub extreme: Extreme,
    /// The value with all digits.
    pub value: f64,
}

/// Whether the smallest or the largest value is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extreme {
    /// The smallest.
    Smallest,
    /// The largest.
    Largest,
}

/// Returns the distance, mm, that takes most of its tolerance, bounds of `budget` included, and that; `None` where none of the `judged` is known.
pub(crate) fn worst_judged(budget: &Budget, judged: &[(Option<f64>, Option<f64>)]) -> Option<(f64, f64)> {
    let share = |(mm, tolerance): &(f64, f64)| (mm + budget.bounds_mm()) / tolerance;
    let known = judged.iter().filter_map(|own| own.0.zip(own.1));
    known.max_by(|one, other| share(one).total_cmp(&share(other)))
}

/// Returns the names of `causes`, joined.
fn names_of(causes: &[Cause]) -> String {
    join_text(&causes.iter().map(|own| own.text()).collect::<Vec<_>>())
}

impl Headline {
    /// Returns a headline with a sentence that was computed from `basis`, without numbers.
    pub fn new(sentence: impl Into<String>, basis: impl Into<String>) -> Self {
        Self { sentence: sentence.into(), basis: basis.into(), ..Self::default() }
    }

    /// Sets the verdict, and that inputs are nominal where they are.
    #[must_use]
    pub fn judged(mut self, verdict: Verdict, is_nominal: bool) -> Self {
        self.verdict = Some(verdict);
        self.marks.extend(is_nominal.then(|| "nominal inputs".into()));
        self
    }

    /// Returns this as the result on a path on which so much of the force is known: where none is, nothing is judged.
    #[must_use]
    pub fn where_force_is(mut self, known: KnownForce) -> Self {
        let state = self.verdict.as_ref().map_or(State::Open, |own| own.state);
        if known == KnownForce::Nowhere {
            for number in &mut self.numbers {
                (number.state, number.against) = (None, "without the cutting force".into());
            }
        }
        match (known, state) {
            (KnownForce::Everywhere, _) => self,
            (KnownForce::Nowhere, State::Bad) => self.marked("force unknown"),
            (KnownForce::Nowhere, _) => {
                self.verdict = Some(Verdict::new(State::Bad, "No force is known where the tool cuts"));
                self.sentence = "No force of this cut is known, so none is compensated.".into();
                self.next("give a law or a force of this cut in the process file, and compute again.")
            }
            (KnownForce::Partly, State::Good) => {
                self.verdict = Some(Verdict::new(State::Partly, "Within tolerance where the force is known"));
                self
            }
            _ => self.marked("force partly unknown"),
        }
    }

    /// Returns this as a verdict on distances, mm, that are `judged` by their tolerances, where `budget` is what is known of their causes: "within tolerance" only
    /// if each cause has a value or a bound, and all fit. Of what is not to be run or does not fit already nothing is changed.
    #[must_use]
    pub fn resting_on(mut self, budget: &Budget, judged: &[(Option<f64>, Option<f64>)]) -> Self {
        self.causes = budget.entries().cloned().collect();
        let state = self.verdict.as_ref().map_or(State::Open, |own| own.state);
        let (bounds, unknown) = (budget.bounds_mm(), budget.unknown());
        let worst = worst_judged(budget, judged);
        if !matches!(state, State::Good | State::Partly) || judged.iter().all(|own| own.1.is_none()) {
            return self;
        }
        let used = worst.map_or_else(String::new, |(mm, tolerance)| {
            format!("{} of {tolerance} mm", millimetres(mm + bounds, 3).trim_end_matches(" mm"))
        });
        // What is drawn of the control is in the number, not the deflection alone.
        let is_of_control = |own: &Entry| own.counted && [Cause::Accuracy, Cause::Repeatability].contains(&own.cause);
        let alone = if budget.entries().any(is_of_control) { "what is computed" } else { "the deflection" };
        let decision = worst.map(|(mm, tolerance)| budget.decide(mm, tolerance));
        match decision {
            // By a distribution, and nothing is missing in it.
            Some(Decision::Out { .. }) if state == State::Partly && unknown.is_empty() && bounds == 0.0 => self,
            Some(Decision::Out { .. }) => {
                let text = worst.map_or_else(String::new, |(mm, tolerance)| {
                    format!("{} for {tolerance} mm allowed", millimetres(mm + bounds, 3))
                });
                self.unless(State::Bad, format!("Out of tolerance: {text}"), alone);
                let bound = |own: &Entry| {
                    Some(format!("{} {}", own.cause.text(), millimetres(own.mm.filter(|mm| *mm > 0.0)?, 3)))
                };
                let added: Vec<String> = budget.entries().filter(|own| !own.counted).filter_map(bound).collect();
                let added = join_text(&added.iter().map(String::as_str).collect::<Vec<_>>());
                let more = match unknown.is_empty() {
                    true => String::new(),
                    false => format!(" More is added by what nobody knows: {}.", names_of(&unknown)),
                };
                if let Some((mm, _)) = worst.filter(|_| !added.is_empty()) {
                    let caution = format!("{} by {alone}, to which are added: {added}.{more}", millimetres(mm, 3));
                    self.cautions.insert(0, caution);
                }
                let largest = budget.entries().filter(|own| !own.counted);
                let largest = largest.max_by(|one, other| one.mm.unwrap_or(0.0).total_cmp(&other.mm.unwrap_or(0.0)));
                let largest = largest.filter(|own| own.mm.is_some_and(|mm| mm > worst.map_or(0.0, |own| own.0)));
                match largest.and_then(bound) {
                    Some(largest) => self.next(format!(
                        "do not cut; {largest} is the largest part: make it smaller, and compute again."
                    )),
                    None => self.next("do not cut; make what the numbers show as largest smaller, and compute again."),
                }
            }
            _ if !unknown.is_empty() => {
                let text = format!("Not decided: {} of {} causes unknown", unknown.len(), self.causes.len());
                let own_text = self.unless(State::NotDecided, text, alone);
                let known = match used.is_empty() {
                    true => "What is known uses an unknown part".into(),
                    false => format!("What is known uses {used}"),
                };
                let names = names_of(&unknown);
                self.cautions.insert(0, format!("{known} ({own_text}); of {names} nobody knows what is added."));
                let first = unknown.first().map_or("", |own| own.text());
                let then = self.next.take().unwrap_or_default();
                self.next(format!(
                    "do not cut; find out about {first} first (docs: what a verdict rests on), and compute again. Until then: {then}"
                ))
            }
            _ if state == State::Good => {
                let scope = budget.scope().map(|own| own.iter().map(|own| own.text()).collect::<Vec<_>>());
                let tolerance = worst.map_or(0.0, |own| own.1);
                let text = match scope.as_deref() {
                    Some(scope @ [_, _, _, _, ..]) => Some(format!("Within {tolerance} mm by {} causes", scope.len())),
                    Some(scope) => Some(format!("Within {tolerance} mm by {}", join_text(scope))),
                    None => (bounds > 0.0).then(|| "Within tolerance, bounds included".into()),
                };
                self.marks.extend(scope.map(|_| "as asked".into()));
                self.verdict = text.map(|text| Verdict::new(State::Good, text)).or(self.verdict);
                self
            }
            _ => {
                self.marks.extend(budget.scope().map(|_| "of the causes asked".into()));
                self
            }
        }
    }

    /// Replaces the verdict by one that is worse, which no number and no caution may contradict; returns its words, to be told behind others.
    pub(super) fn unless(&mut self, state: State, words: String, alone: &str) -> String {
        let condition = &format!("By {alone} alone: ");
        let own_text = self.own_text();
        self.sentence =
            format!("{} alone: {}", capitalised(alone.trim_start_matches("the ")), uncapitalised(&self.sentence));
        self.verdict = Some(Verdict::new(state, words));
        self.numbers.iter_mut().filter(|own| own.state == Some(State::Good)).for_each(|own| own.state = None);
        let tells = |own: &str| own.contains("ithin tolerance") || own.contains("ithin the tolerance");
        self.cautions.iter_mut().filter(|own| tells(own)).for_each(|own| own.insert_str(0, condition));
        for number in self.numbers.iter_mut().filter(|own| tells(&own.against)) {
            number.against.insert_str(0, &condition.to_lowercase());
        }
        own_text
    }

    /// Returns the words of the verdict, to be told behind others.
    fn own_text(&self) -> String {
        uncapitalised(self.verdict.as_ref().map_or("", |own| &own.words))
    }

    /// Adds a mark, such as "simulated".
    #[must_use]
    pub fn marked(mut self, mark: &str) -> Self {
        self.marks.push(mark.into());
        self
    }

    /// Sets what to do next.
    #[must_use]
    pub fn next(mut self, step: impl Into<String>) -> Self {
        self.next = Some(step.into());
        self
    }

    /// Returns this as the result of what must not be done: `sentence` comes first and what it found behind it, nothing is good, and `next` is to be done.
    #[must_use]
    pub fn barred(mut self, sentence: String, verdict: Verdict, next: &str) -> Self {
        let found = std::mem::replace(&mut self.sentence, sentence);
        self.cautions.insert(0, found);
        self.numbers.iter_mut().for_each(|number| number.state = None);
        (self.verdict, self.next) = (Some(verdict), Some(next.into()));
        self
    }

    /// Adds each line of `text` that is not blank as a caution.
    #[must_use]
    pub fn with_cautions(mut self, text: &str) -> Self {
        self.cautions.extend(text.lines().filter(|line| !line.trim().is_empty()).map(String::from));
        self
    }

    /// Adds key numbers.
    #[must_use]
    pub fn with_numbers(mut self, numbers: impl IntoIterator<Item = KeyNumber>) -> Self {
        self.numbers.extend(numbers);
        self
    }

    /// Adds one key number to those of the first screen.
    #[must_use]
    pub fn with(mut self, number: KeyNumber) -> Self {
        self.numbers.push(number);
        self
    }
}

impl KeyNumber {
    /// Returns the number `shown`, such as `1.712 mm`, split into value and unit, with its meaning and what it is compared with.
    pub fn new(shown: &str, what: impl Into<String>, against: impl Into<String>) -> Self {
        let (value, unit) = match shown.rsplit_once(' ') {
            Some((value, unit)) => (value, unit),
            None => match shown.strip_suffix('°') {
                Some(value) => (value, "°"),
                None => (shown, ""),
            },
        };
        Self {
            value: value.into(),
            unit: unit.into(),
            what: what.into(),
            against: against.into(),
            found: None,
            state: None,
        }
    }

    /// Sets whether the number, `length_mm`, is within the tolerance, if there is one.
    #[must_use]
    pub fn held_to(mut self, tolerance_mm: Option<f64>, length_mm: f64) -> Self {
        self.state = tolerance_mm.map(|most| if length_mm <= most { State::Good } else { State::Bad });
        self
    }

    /// Sets where a table has the number.
    #[must_use]
    pub fn found(mut self, found: InTable) -> Self {
        self.found = Some(found);
        self
    }

    /// Returns the value with its unit.
    pub fn shown(&self) -> String {
        with_unit(&self.value, &self.unit)
    }
}

impl InTable {
    /// Returns the extreme of `columns` in `file` over the rows that meet the conditions `rows`.
    pub fn new<C: Into<String>>(
        file: &str,
        columns: impl IntoIterator<Item = C>,
        rows: &[[&str; 2]],
        extreme: Extreme,
        value: f64,
    ) -> Self {
        Self {
            file: file.into(),
            columns: columns.into_iter().map(Into::into).collect(),
            rows: rows.iter().map(|pair| pair.map(String::from)).collect(),
            extreme,
            value,
        }
    }
}
