//! Parsers of command-line words for values of the library.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use kinetostat::{
    figures::Colours,
    files::exchange::Format,
    machine::{Branch, Elbow, Shoulder, Wrist},
    process::{ForceLaw, GammaChoice},
    products::correction::report::CorrectionFormat,
    questions::{TEMPLATES, Template},
    toolpath::gcode::Dialect,
};

/// Returns a parser of one of `all` values, each with its name on the command line and a description for its help.
fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
    about: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<T> = all.into_iter().collect();
    let values = PossibleValuesParser::new(all.iter().map(|&value| PossibleValue::new(name(value)).help(about(value))));
    values.try_map(move |word| {
        let chosen = all.iter().copied().find(|value| name(*value) == word);
        chosen.ok_or_else(|| format!("\"{word}\" is none of these values"))
    })
}

/// Returns the parser of `--format` for tables and maps.
pub fn format() -> impl TypedValueParser<Value = Format> {
    one_of(Format::ALL, Format::label, |format| match format {
        Format::Csv => "Tables as CSV (RFC 4180)",
        Format::Parquet => "Tables as Apache Parquet, units in the metadata",
        Format::Vti => "Maps over the workspace as VTK image data, for ParaView",
    })
}

/// Returns the parser of `--format` for a correction table.
pub fn correction_format() -> impl TypedValueParser<Value = CorrectionFormat> {
    one_of(CorrectionFormat::ALL, CorrectionFormat::label, |format| match format {
        CorrectionFormat::Csv => "One row per node, units in the column names",
        CorrectionFormat::Json => "One file that says its axes, units, values and bound",
        CorrectionFormat::Comp => "LinuxCNC's COMP_FILE for each joint, where each joint is an axis",
    })
}

/// Returns the parser of `--colours`.
pub fn colours() -> impl TypedValueParser<Value = Colours> {
    one_of(Colours::ALL, Colours::label, |colours| match colours {
        Colours::Viridis => "Perceptually uniform, from dark violet to yellow",
        Colours::Cividis => {
            "Perceptually uniform and the same to readers with and without colour vision, from dark blue to yellow"
        }
        Colours::Grey => "From dark to light grey, for print without colours",
    })
}

/// Returns the parser of `--law`.
pub fn law() -> impl TypedValueParser<Value = ForceLaw> {
    one_of(ForceLaw::ALL, ForceLaw::label, |law| match law {
        ForceLaw::PaperEq17 => {
            "Eq. (17) as the paper prints it: F_x = F_r cos φ + F_t sin φ, F_y = F_r sin φ + F_t cos φ. Not a rotation: with 215 N and −10 N \
             the in-plane force varies between 205 N and 225 N"
        }
        ForceLaw::Rotated => {
            "A rotation: F_x = F_r cos φ − F_t sin φ, F_y = F_r sin φ + F_t cos φ. Used where no law is named"
        }
    })
}

/// A G-code dialect; `None` to detect it from the program.
#[derive(Clone, Copy, Debug)]
pub struct ChosenDialect(pub Option<Dialect>);

/// Returns the parser of `--dialect`.
pub fn dialect() -> impl TypedValueParser<Value = ChosenDialect> {
    let all = std::iter::once(None).chain(Dialect::ALL.map(Some)).map(ChosenDialect);
    let name = |chosen: ChosenDialect| chosen.0.map_or("auto", Dialect::label);
    one_of(all, name, |chosen| match chosen.0 {
        None => "What the text of the program shows",
        Some(Dialect::Iso) => "ISO code, as far as Fanuc, Haas, LinuxCNC and Grbl read it alike",
        Some(Dialect::Fanuc) => "ISO code of Fanuc: G10 L20 sets G54.1",
        Some(Dialect::Haas) => "ISO code of Haas: G10 L20 sets G54.1 (G154)",
        Some(Dialect::LinuxCnc) => "ISO code of LinuxCNC and Grbl: G10 L20 sets G54 ... by where the tool is",
        Some(Dialect::Sinumerik) => "Siemens Sinumerik 840D and its kin",
        Some(Dialect::Heidenhain) => "Heidenhain's conversational language (Klartext)",
    })
}

/// Returns the parser of `--redundancy`.
pub fn redundancy() -> impl TypedValueParser<Value = GammaChoice> {
    one_of(GammaChoice::ALL, GammaChoice::label, |redundancy| match redundancy {
        GammaChoice::AsProgrammed => "As the path gives it",
        GammaChoice::BestConstant => "The same γ at all points, the best there is",
        GammaChoice::Best => "A γ at each point, the best there is",
    })
}

/// Returns the parser of `--branch`.
pub fn branch() -> impl TypedValueParser<Value = Branch> {
    let name = |branch: Branch| branch.label();
    one_of(Branch::ALL, name, |branch| match (branch.shoulder, branch.elbow, branch.wrist) {
        (Shoulder::Front, Elbow::Up, Wrist::Noflip) => "Wrist centre in front of axis 1, elbow up, axis 5 positive",
        (Shoulder::Front, Elbow::Up, Wrist::Flip) => "In front, elbow up, axis 5 negative",
        (Shoulder::Front, Elbow::Down, Wrist::Noflip) => "In front, elbow down, axis 5 positive",
        (Shoulder::Front, Elbow::Down, Wrist::Flip) => "In front, elbow down, axis 5 negative",
        (Shoulder::Back, Elbow::Up, Wrist::Noflip) => "Behind axis 1, elbow bent as up in front, axis 5 positive",
        (Shoulder::Back, Elbow::Up, Wrist::Flip) => "Behind, elbow bent as up in front, axis 5 negative",
        (Shoulder::Back, Elbow::Down, Wrist::Noflip) => "Behind, elbow bent as down in front, axis 5 positive",
        (Shoulder::Back, Elbow::Down, Wrist::Flip) => "Behind, elbow bent as down in front, axis 5 negative",
    })
}

/// Returns the parser of the kind of a new study.
pub fn template() -> impl TypedValueParser<Value = Template> {
    one_of(TEMPLATES.iter().copied(), |template| template.name, |template| template.about)
}
