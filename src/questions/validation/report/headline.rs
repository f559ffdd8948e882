//! The first screen of a validation study: how many numbers agree, and which is farthest off.

use super::compared::{Line, lines};
use crate::{
    files::words::{counted, typographic},
    page::headline::{Headline, KeyNumber},
    questions::validation::{Relation, ValidationResults},
};

/// The answer at a glance.
pub(super) fn headline(results: &ValidationResults, cautions: &str) -> Headline {
    let study = &results.study;
    let count = |is_meant: &dyn Fn(&Line<'_>) -> bool| lines(results).filter(|line| is_meant(line)).count();
    let all = results.compared.len();
    let agreeing = count(&|line| line.compared.agrees);
    let differing = all - agreeing - count(&|line| line.ours().is_none());
    let explained = count(&|line| !line.compared.agrees && !line.quoted.reason.is_empty());
    let basis = format!("{}, process \"{}\"", counted(study.cases.len(), "path"), study.variants[0].name);
    let numbers = counted(all, "quoted number");
    let sentence = match agreeing {
        0 => format!("None of the {numbers} agrees with ours."),
        agreeing if agreeing == all => format!("All {numbers} agree with ours."),
        agreeing => format!("{agreeing} of {numbers} agree with ours; {differing} differ."),
    };
    let of_all = format!("of {} agree", counted(all, "number"));
    let agree = KeyNumber::new(&agreeing.to_string(), of_all, "each within its tolerance, in the table below");
    let told = format!("{explained} with a reason, below");
    let differ = (differing > 0).then(|| KeyNumber::new(&differing.to_string(), "differ", told));
    Headline::new(sentence, basis).with_cautions(cautions).with(agree).with_all(differ).with_all(farthest(results))
}

/// The number that is off by the largest ratio.
fn farthest(results: &ValidationResults) -> Option<KeyNumber> {
    let differing = lines(results).filter(|line| !line.compared.agrees && line.quoted.relation == Relation::About);
    let off = differing.filter_map(|line| {
        let ours = line.ours()?;
        let ratio = line.ratio(ours).filter(|ratio| *ratio > 0.0)?;
        Some((ratio.ln().abs(), ours, line))
    });
    let (_, ours, line) = off.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let percent = 100.0 * (ours / line.quoted.value - 1.0);
    let what = format!("largest difference of a quoted value: {} of {}", line.what(), line.case());
    let against = format!("{} here, {} quoted", line.shown(ours), line.as_quoted());
    Some(KeyNumber::new(&typographic(&format!("{percent:+.0} %")), what, against))
}
