//! Studies with uncertain inputs, and machines of draws made without the draws of a study.

use kinetostat::{
    Machine, Work,
    compensation::{BoundedPath, TaskPoint},
    input::{Folder, error::Result},
    machine::ChainError,
    process::{
        Process,
        uncertainty::{Uncertainty, normal_quantile, sobol},
    },
    products::program::{CompensateOptions, Compensated, PartSink, ProgramJob, VerifiedPart, VerifiedProgram},
    simulation::{Machines, spread_along::PointSpread},
    spatial::Pose,
    toolpath::gcode::CalledFile,
};

/// A slide of 10 N/µm that pushes back along x, and nothing else.
pub const LEVER: &str = r#"
schema = 1
name = "lever"
title = "a slide"
gravity_m_per_s2 = [0.0, 0.0, 0.0]
[platform]
tool_tip_mm = [0.0, 0.0, 50.0]
controls = ["x"]
[workspace]
min_mm = [-1.0, 0.0, 0.0]
max_mm = [1.0, 0.0, 0.0]
[[chain]]
name = "guide"
elements = [{ prismatic_drive = { name = "slide", axis = "x", stiffness_N_per_mm = 1e4 } }]
[[mount]]
name = "guide"
chain = "guide"
"#;

pub const TOLERANCES: &str = "[[uncertainty.chain_error]]\nchain = \"*\"\nturn_about_drive_axis_deg = { uniform = [-0.1, 0.1] }\n\
     [uncertainty.process]\nforce_relative_std = 0.15\n";
/// A rapid move, two cuts and a retract.
pub const NC: &str = "G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F600\nX30 Y5\nY25\nG0 Z20\n";
/// A model that leaves nothing out.
pub const EXACT_MODEL: &str = "[uncertainty.model]\nrelative_std = 0.0\n";

/// A study of `machine` with these tables, whose model leaves nothing out unless `uncertainty` says so.
pub fn study_text(machine: &str, process: &str, uncertainty: &str, question: &str) -> String {
    let is_said = uncertainty.is_empty() || uncertainty.contains("uncertainty.model");
    let uncertainty = format!("{uncertainty}\n{}", if is_said { "" } else { EXACT_MODEL });
    let uncertainty = exact_machine(&uncertainty);
    format!("schema = 3\nquestion = \"?\"\nmachine = \"{machine}\"\n{process}\n{uncertainty}\n{question}\n")
}

/// The tables of a study or a process with what `[uncertainty]` does not name taken as exact, unless it says otherwise.
pub fn exact_machine(tables: &str) -> String {
    let header = "[uncertainty]\n";
    let first = ["[uncertainty", "[[uncertainty"].iter().filter_map(|own| tables.find(own)).min();
    match first {
        Some(_) if ["machine = \"provenance\"", "machine = \"exact\""].iter().any(|own| tables.contains(own)) => {
            tables.to_owned()
        }
        Some(_) if tables.contains(header) => tables.replacen(header, "[uncertainty]\nmachine = \"exact\"\n", 1),
        Some(at) => format!("{}[uncertainty]\nmachine = \"exact\"\n{}", &tables[..at], &tables[at..]),
        None => tables.to_owned(),
    }
}

pub fn force(radial: f64, tangential: f64, axial: f64) -> String {
    format!(
        "[process.force.path_frame]\nradial_force_N = {radial:?}\ntangential_force_N = {tangential:?}\naxial_force_N = {axial:?}\n"
    )
}

/// The job of a program with this name and text on the [`LEVER`] or a built-in machine, by the text of a process.
pub fn job(machine: &str, process: &str, (name, program): (&str, &str)) -> ProgramJob {
    let machine = match machine {
        "lever" => Machine::from_toml(LEVER, "lever.toml").unwrap(),
        name => Machine::named_or_file(name).unwrap(),
    };
    let text = format!("schema = 1\n{}", exact_machine(process));
    let process = Process::from_toml(&text, "process.toml", Folder::in_memory([]), &machine).unwrap();
    let folder = Folder::in_memory([(name.to_owned(), program.as_bytes().to_vec())]);
    let program = process.program_in_folder(&folder, name).unwrap();
    ProgramJob::new(process, program, name, &Work::default()).unwrap()
}

/// What is known of each point of a verified program.
#[derive(Default)]
pub struct Kept {
    pub tasks: Vec<TaskPoint>,
    pub commanded: Vec<Pose>,
    pub spread: Vec<Option<PointSpread>>,
}

impl PartSink for Kept {
    fn may_call(&self, _: &CalledFile) -> Result<()> {
        Ok(())
    }

    fn take(&mut self, verified: &VerifiedPart<'_>, _: Option<&BoundedPath>) -> Result<()> {
        self.tasks.extend_from_slice(verified.part.tasks());
        self.commanded.extend(verified.written.iter().map(|answer| answer.target.unwrap()));
        self.spread.extend_from_slice(&verified.spread);
        Ok(())
    }
}

/// The program of `job` as it was `asked` for, verified.
pub fn verified(job: &ProgramJob, asked: &CompensateOptions) -> Result<(VerifiedProgram, Kept)> {
    let mut kept = Kept::default();
    match job.compensate(asked, &mut kept, &Work::default())? {
        Compensated::Verified(verified) => Ok((*verified, kept)),
        Compensated::Refused(refusal) => panic!("{refusal:?}"),
    }
}

/// Whether a parameter is an error of a chain, by its name.
pub fn is_error(name: &str) -> bool {
    [".turn", ".translation.", ".offset"].iter().any(|part| name.contains(part))
}

/// The machines of a draw and its factor of the cutting force.
pub struct Drawn {
    /// Without errors of chains.
    pub unloaded: Machine,
    pub actual: Machine,
    pub factor: f64,
}

/// Makes `count` draws, from another seed than those of studies and without anything of theirs but the distributions; `errors` are those of the process.
pub fn draws(uncertainty: &Uncertainty, errors: &[ChainError], count: usize) -> impl Iterator<Item = Drawn> {
    let points = sobol::points(uncertainty.parameters.len() + 2, 1, count, 4711);
    (0..count).map(move |index| {
        let z: Vec<f64> = points.iter().map(|own| normal_quantile(own[index])).collect();
        drawn(uncertainty, errors, &z)
    })
}

/// The draw whose parameters, force and tool wear are at the quantiles of the standard normal numbers `z`.
pub fn drawn(uncertainty: &Uncertainty, errors: &[ChainError], z: &[f64]) -> Drawn {
    let is_turn = |name: &str| name.ends_with(".turn");
    let values = |is_wanted: &dyn Fn(&str) -> bool| -> Vec<(&str, f64)> {
        let wanted = uncertainty.parameters.iter().enumerate().filter(|(_, own)| is_wanted(own.name()));
        wanted.flat_map(|(i, own)| own.at(z[i])).collect()
    };
    let unloaded = uncertainty.machine.with_parameters(&values(&|name| !is_error(name))).unwrap();
    // Its drives are offset where it is calibrated at home under its own weight.
    let unloaded = Machines::new(&unloaded, &[]).unwrap().actual;
    let turns = values(&is_turn);
    let turned = unloaded.chains.iter().map(|chain| {
        let turn = turns.iter().find(|(name, _)| name.strip_suffix(".turn") == Some(&chain.name));
        ChainError::turn_about_drive_axis(chain, turn.map_or(0.0, |(_, deg)| deg.to_radians()))
    });
    // A machine made anew by its parameters takes most of the time of a draw.
    let more = values(&|name| is_error(name) && !is_turn(name));
    let actual = if more.is_empty() { unloaded.clone() } else { unloaded.with_parameters(&more).unwrap() };
    let actual = actual.with_errors(&turned.collect::<Vec<_>>()).with_errors(errors);
    let [sharp, wear] = uncertainty.force.factors([0, 1].map(|own| z[uncertainty.parameters.len() + own]));
    Drawn { unloaded, actual, factor: sharp * wear }
}
