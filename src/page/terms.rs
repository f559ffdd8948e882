//! Words on the first screen that a reader may not know, said where they are first used.

use super::description::{Description, Fact};
use crate::files::words::typographic;

/// Words, what they begin with in a text, and their meaning.
const TERMS: [(&str, &str, &str); 3] = [
    (
        "Chain errors",
        "chain error",
        "how the machine as built differs from its file: legs turned and displaced, drives zeroed elsewhere",
    ),
    (
        "Tool angle φ",
        "tool angle",
        "direction of the radial cutting force about the tool, from the x axis; it turns with the direction of feed",
    ),
    ("Departure", "departure", "displacements by single sources added, less the displacement by all at once"),
];

/// The terms that the first screen of `description` uses, in the order of a glossary.
pub(super) fn terms(description: &Description) -> Vec<Fact> {
    let headline = &description.headline;
    let numbers = headline.numbers.iter().flat_map(|number| [&number.what, &number.against]);
    let texts = [&description.question, &headline.sentence, &headline.basis].into_iter();
    let text: Vec<&str> = texts.chain(numbers).chain(&headline.cautions).map(String::as_str).collect();
    let text = text.join(" ");
    let lower_case = text.to_lowercase();
    let used = TERMS.iter().filter(|(_, begin, _)| lower_case.contains(begin));
    let mut terms: Vec<Fact> =
        used.map(|(term, _, meaning)| Fact { label: (*term).into(), value: (*meaning).into() }).collect();
    terms.extend(description.terms.iter().cloned());
    let machine = &description.machine;
    if text.contains("workspace box") {
        let [low, high] = machine.workspace_mm;
        let ranges: Vec<String> =
            (0..3).map(|axis| format!("{} {} to {}", ["x", "y", "z"][axis], low[axis], high[axis])).collect();
        let value = format!("where the machine's file has P work: {} mm", typographic(&ranges.join(", ")));
        terms.push(Fact { label: "Workspace box".into(), value });
    }
    let words: Vec<&str> = text.split(|letter: char| !(letter.is_alphanumeric() || letter == '_')).collect();
    for point in machine.points.iter().filter(|point| words.contains(&point.label.as_str())) {
        let place: Vec<String> = point.position.iter().map(f64::to_string).collect();
        let value = format!("a point of the machine's file, at {} mm", typographic(&format!("({})", place.join(", "))));
        terms.push(Fact { label: point.label.clone(), value });
    }
    terms
}
