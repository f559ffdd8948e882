//! The first screen of a validation study: how many numbers agree, and which is farthest off.

use super::{
    summary::{as_quoted, shown, unit},
    tables::ratio,
};
use crate::{
    files::words::{counted, typographic},
    page::headline::{Headline, KeyNumber},
    questions::validation::{Compared, Quoted, Relation, ValidationResults},
};

/// The answer at a glance.
pub(super) fn headline(results: &ValidationResults, cautions: &str) -> Headline {
    let study = &results.study;
    let all = results.compared.len();
    let agreeing = results.compared.iter().filter(|compared| compared.agrees).count();
    let unsolved = results.compared.iter().filter(|compared| compared.ours[0].is_err()).count();
    let cases = counted(study.cases.len(), "path");
    let basis = format!("{cases}, process \"{}\"", study.variants[0].name);
    let sentence = match agreeing {
        0 => format!("None of the {} agrees with ours.", counted(all, "quoted number")),
        agreeing if agreeing == all => format!("All {} agree with ours.", counted(all, "quoted number")),
        agreeing => {
            let (quoted, others) = (counted(all, "quoted number"), all - agreeing - unsolved);
            format!("{agreeing} of {quoted} agree with ours; {others} differ.")
        }
    };
    let explained = study.quoted.iter().zip(&results.compared);
    let explained = explained.filter(|(quoted, compared)| !compared.agrees && !quoted.reason.is_empty()).count();
    let differing = all - agreeing - unsolved;
    let mut headline = Headline::new(sentence, basis).with_cautions(cautions);
    headline = headline.with(KeyNumber::new(
        &agreeing.to_string(),
        format!("of {} agree", counted(all, "number")),
        "each within its tolerance, in the table below",
    ));
    if differing > 0 {
        let told = format!("{explained} with a reason, below");
        headline = headline.with(KeyNumber::new(&differing.to_string(), "differ", told));
    }
    headline.with_all(farthest(results))
}

/// The number that is off by the largest ratio.
fn farthest(results: &ValidationResults) -> Option<KeyNumber> {
    let study = &results.study;
    let off = |(quoted, compared): &(&Quoted, &Compared)| {
        ratio(quoted, &compared.ours[0]).filter(|ratio| *ratio > 0.0).map(|ratio| ratio.ln().abs())
    };
    let differing = study.quoted.iter().zip(&results.compared);
    let differing = differing
        .filter(|(quoted, compared)| !compared.agrees && quoted.relation == Relation::About)
        .filter_map(|pair| Some((off(&pair)?, pair)));
    let (_, (quoted, compared)) = differing.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let ours = compared.ours[0].as_ref().ok()?;
    let unit = unit(quoted, study);
    let percent = 100.0 * (ours / quoted.value - 1.0);
    let what = format!(
        "largest difference of a quoted value: {} of {}",
        quoted.quantity.label().replace('_', " "),
        study.cases[quoted.case]
    );
    let against = format!("{}{unit} here, {}{unit} quoted", shown(quoted, *ours), as_quoted(quoted));
    Some(KeyNumber::new(&typographic(&format!("{percent:+.0} %")), what, against))
}
