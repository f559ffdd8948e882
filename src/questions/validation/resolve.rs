//! Checks a validation study as written and makes a study of it.

use super::{
    FigureKind, Picture, Quoted, Shown, ValidationStudy, Variant,
    spec::{FigureSpec, QuotedSpec, ValidationSpec},
};
use crate::{
    input::{Inputs, check::Check, error::Result, names::listed},
    machine::Machine,
    questions::{
        Question, Resolved, StudyContext, Template,
        path::{resolve as paths, spec::PathSpec},
    },
    work::Work,
};

/// Largest relative difference that agrees, if the study gives none.
const AGREEMENT: f64 = 0.1;
/// Stem of the file names of the figure of the machine, which no other figure may have.
const MACHINE_AT_HOME: &str = "machine_at_home";
/// Most panels of a figure.
pub(super) const MAX_FRAMES: usize = 6;

impl Question for ValidationStudy {
    type Spec = ValidationSpec;
    type Shown = Shown;
    const NAME: &str = "a validation study";
    const TEMPLATE: Template = Template {
        name: "validation",
        about: "Numbers quoted by a paper or a measurement beside those of the model",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["summary", "variants"];

    /// Checks the study, and makes the paths of its cases under each process.
    fn resolve(spec: &ValidationSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_grid(context.name)?;
        let (machine, check) = (&context.machine, &context.check);
        for (key, count) in [("variant", spec.variant.len()), ("case", spec.case.len())] {
            if count == 0 {
                return check.key(key).fail("expected at least one".into());
            }
        }
        check_names(spec.case.iter().map(|case| case.name.as_str()), &check.key("case"))?;
        for (i, case) in spec.case.iter().enumerate() {
            let before = spec.case[..i].iter().map(|case| case.name.as_str());
            check.key("case").item(i).key("name").unique_file(&case.name, before)?;
        }
        check_names(spec.variant.iter().map(|variant| variant.name.as_str()), &check.key("variant"))?;
        let points = paths::circle_points(spec.case.iter().map(|case| &case.circle), context.overrides);
        paths::check_total(points.saturating_mul(spec.variant.len()), &check.key("case"))?;
        let (mut variants, mut inputs) = (Vec::new(), Inputs::default());
        for (v, written) in spec.variant.iter().enumerate() {
            let process = context.process(written.process.as_deref(), &check.key("variant").item(v))?;
            let mut paths = Vec::new();
            for (i, case) in spec.case.iter().enumerate() {
                let path =
                    PathSpec { circle: Some(case.circle.clone()), line: None, file: None, methods: Some(Vec::new()) };
                let (path, ..) = paths::path(&path, &process, context, &check.key("case").item(i))?;
                paths.push(path);
                inputs = inputs.and(process.inputs.clone());
            }
            variants.push(Variant { name: written.name.clone(), paths });
        }
        let cases: Vec<String> = spec.case.iter().map(|case| case.name.clone()).collect();
        let points: Vec<usize> = variants[0].paths.iter().map(|path| path.stations.len()).collect();
        let inputs = inputs.and(Inputs::of("points of the paths", format!("{points:?}")));
        let pictures = pictures(&spec.figure, &cases, machine, check)?;
        let quoted = quoted(&spec.quoted, &cases, machine, check)?;
        let study = ValidationStudy { quoted, machine: machine.clone(), cases, variants };
        Ok(Resolved { study, shown: Shown { pictures }, inputs })
    }

    /// Returns the number of points that are solved, over all passes.
    fn items(&self) -> (usize, &'static str) {
        (super::point_count(self), "points")
    }

    /// Returns the number of blocks, over all passes.
    fn pieces(&self) -> usize {
        super::block_count(self)
    }

    /// Computes all paths under all processes and keeps their blocks in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        super::run(self, work).map(drop)
    }
}

/// Checks that names are readable and differ from one another.
fn check_names<'a>(names: impl Iterator<Item = &'a str>, check: &Check) -> Result<()> {
    let mut before: Vec<&str> = Vec::new();
    for (i, name) in names.enumerate() {
        let check = check.item(i).key("name");
        check.readable(name)?;
        check.unique(name, before.iter().copied())?;
        before.push(name);
    }
    Ok(())
}

/// Returns the index of the case called `name`.
fn case_index(name: &str, cases: &[String], check: &Check) -> Result<usize> {
    match cases.iter().position(|case| case == name) {
        Some(index) => Ok(index),
        None => check.fail(format!("no case is called \"{name}\"; there are: {}", listed(cases))),
    }
}

/// Returns the quoted numbers, checked.
fn quoted(specs: &[QuotedSpec], cases: &[String], machine: &Machine, check: &Check) -> Result<Vec<Quoted>> {
    let quoted = |(i, spec): (usize, &QuotedSpec)| {
        let check = check.key("quoted").item(i);
        if let Err(problem) = spec.quantity.check_machine(machine) {
            check.key("quantity").misfit(problem, ())?;
        }
        Ok(Quoted {
            source: spec.source.trim().to_string(),
            case: case_index(&spec.case, cases, &check.key("case"))?,
            quantity: spec.quantity,
            value: check.key("value").finite_scalar(spec.value)?,
            relation: spec.relation,
            agreement: check.key("agreement").positive(spec.agreement.unwrap_or(AGREEMENT))?,
            reason: spec.reason.clone().unwrap_or_default(),
        })
    };
    specs.iter().enumerate().map(quoted).collect()
}

/// Returns the figures, checked: kinds, cases and file names.
fn pictures(specs: &[FigureSpec], cases: &[String], machine: &Machine, check: &Check) -> Result<Vec<Picture>> {
    let check = check.key("figure");
    check_names(specs.iter().map(|figure| figure.name.as_str()), &check)?;
    let (mut pictures, mut stems): (Vec<Picture>, Vec<String>) = (Vec::new(), vec![MACHINE_AT_HOME.into()]);
    for (i, spec) in specs.iter().enumerate() {
        let check = check.item(i);
        if !spec.name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-')) {
            let problem = format!("begins file names: expected letters, digits, _ and -, got \"{}\"", spec.name);
            return check.key("name").fail(problem);
        }
        check.key("name").short(&spec.name)?;
        let max_cases = if spec.kind == FigureKind::Curves { MAX_FRAMES } else { 1 };
        let check_cases = check.key("cases");
        if !(1..=max_cases).contains(&spec.cases.len()) {
            let expected = if max_cases == 1 { "one case".into() } else { format!("1 to {max_cases} cases") };
            return check_cases.fail(format!("must name {expected} for this kind, got {}", spec.cases.len()));
        }
        let shown = spec.cases.iter().map(|name| case_index(name, cases, &check_cases)).collect::<Result<_>>()?;
        let picture = Picture { name: spec.name.clone(), title: spec.title.clone(), kind: spec.kind, cases: shown };
        for stem in picture.file_stems(machine) {
            if stems.iter().any(|other| other.eq_ignore_ascii_case(&stem)) {
                return check.key("name").fail(format!("there would be two figures called \"{stem}\""));
            }
            stems.push(stem);
        }
        pictures.push(picture);
    }
    Ok(pictures)
}
