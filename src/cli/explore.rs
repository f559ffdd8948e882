//! `kinetostat explore`: writes a page on which a machine and a workpiece are moved by hand.

use std::path::{Path, PathBuf};

use clap::Args;
use kinetostat::{
    explore::{Explorer, ProgramAtProcess, Scene},
    input::error::{Error, Result},
    inspect::point::PointLoad,
    machine::{Machine, catalogue},
    page::explore_page,
    process::{
        MillingForce,
        file::{Cutter, Process},
    },
    questions::{Overrides, Study},
};

use super::{
    Ending,
    compare::{check_placeable, no_motion_error},
    report::write_page,
};

/// Make a page on which the machine bends under your hand, and a workpiece can be dragged to where it is cut best.
#[derive(Debug, Args)]
#[command(after_help = "\
The page is one file that needs no network: the engine of this program computes in it, with the same results. With a path and
its process, the workpiece can be dragged over the machine, and the error along its path is seen at once; without, the tool
can be pulled and the workspace mapped.

Examples:
  kinetostat explore orthoglide
  kinetostat explore my_machine.toml --out my_machine.html
  kinetostat explore kr270 --wrench 0,0,-500,0,0,0
  kinetostat explore orthoglide --path part.nc --process milling.toml
  kinetostat explore orthoglide --cutter D=10,z=4,ae=5,ap=8,fz=0.08,cut=down --material 'Al 6082-T6'")]
pub struct ExploreArguments {
    /// Built-in machine or machine file
    machine: String,
    /// Path of a workpiece: a polyline (.csv), KRL (.src), RAPID (.mod, .prg), FANUC (.ls), URScript (.script), APT (.apt, .cl, .cls, .ncl) or G-code (any other name)
    #[arg(long, requires = "process")]
    path: Option<PathBuf>,
    /// Load at P in base axes by which the tool is pulled first: fx,fy,fz,mx,my,mz in N and N·mm [default: 100,0,0,0,0,0]
    #[arg(long, value_parser = super::numbers::<6>, allow_hyphen_values = true, conflicts_with = "cutter")]
    wrench: Option<[f64; 6]>,
    /// Cutter and cut whose force, at home and tool angle 0, pulls the tool first: D, ae, ap, fz in mm, z teeth, cut=up or down; kr and ka of Kienzle materials
    #[arg(long, value_name = "D=10,z=4,ae=5,ap=8,fz=0.08,cut=down", requires = "material", conflicts_with = "path")]
    cutter: Option<String>,
    /// Material of the cut of --cutter, as in end_milling of a process file: Al 6082-T6
    #[arg(long, requires = "cutter")]
    material: Option<String>,
    /// Process file: cutting force, chain errors, limits, and where the workpiece stands first
    #[arg(long, requires = "path")]
    process: Option<PathBuf>,
    /// How far the tool may be from its path, mm [default: tolerance_mm of the process, or 0.1]
    #[arg(long, value_parser = super::number, requires = "path")]
    tolerance: Option<f64>,
    /// The page [default: the machine's name and, with a path, that of its program, then _explore.html, in this folder]
    #[arg(long, short)]
    out: Option<PathBuf>,
    /// Replace the page even if it was not written by kinetostat
    #[arg(long)]
    force: bool,
}

/// Runs `kinetostat explore`: writes the interactive page.
pub fn explore(arguments: &ExploreArguments) -> Result<Ending> {
    let machine = &arguments.machine;
    let (scene, wrench) = match (&arguments.cutter, &arguments.material) {
        (Some(cutter), Some(material)) => scene_of_cutter(machine, &Cutter::parse(cutter, material)?)?,
        _ => (read_scene(arguments)?, arguments.wrench),
    };
    Explorer::open(scene.clone())?;
    let stem = |file: &PathBuf| file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let machine = PathBuf::from(&arguments.machine);
    let stems: Vec<String> = std::iter::once(&machine).chain(&arguments.path).map(stem).collect();
    let out = arguments.out.clone().unwrap_or_else(|| format!("{}_explore.html", stems.join("_")).into());
    let question = match arguments.path {
        Some(_) => "Where should this workpiece stand, and what bends when it is cut there?",
        None => "How does this machine bend?",
    };
    write_page(&out, arguments.force, || {
        let scene_json = serde_json::to_value(&scene)
            .map_err(|fault| Error::Page { template: "explore.html".into(), problem: fault.to_string() })?;
        explore_page(&stems.join(" · "), question, scene_json, wrench)
    })
}

/// Reads machine, process and program, so that an error names the file and not the study made of them.
fn check_files(machine: &str, process: &Path, program: &Path) -> Result<()> {
    let machine = Machine::named_or_file(machine)?;
    let file = process.display().to_string();
    let process = Process::open(process, &machine)?.as_programmed("explore")?;
    if process.stock.is_some() {
        let problem = "has [stock], which the page cannot cut: expected a force without it, such as end_milling with its width and depth";
        return Err(Error::argument(file, problem));
    }
    let path = process.read_program(program)?.toolpath(process.sampling)?;
    check_placeable(program, &process, &path)?;
    if path.is_empty() { Err(no_motion_error(program)) } else { Ok(()) }
}

/// Reads the machine, process and program that the arguments name, and returns them as a scene.
fn read_scene(arguments: &ExploreArguments) -> Result<Scene> {
    let machine = &arguments.machine;
    match (&arguments.path, &arguments.process) {
        (Some(program), Some(process)) => {
            super::check_tolerance(arguments.tolerance)?;
            check_files(machine, process, program)?;
            Scene::from_program(&ProgramAtProcess { machine, process, program, tolerance_mm: arguments.tolerance })
        }
        _ if catalogue::find(machine).is_some() => Ok(Scene::from_machine(machine, None)),
        _ => {
            Machine::named_or_file(machine)?;
            let toml = kinetostat::input::toml_file::read(machine.as_ref())?;
            Ok(Scene::from_machine(machine, Some(toml)))
        }
    }
}

/// Returns the scene of a map of `machine` under the force of `cutter`, at the middle height of its workspace, and that force at home and tool angle 0.
fn scene_of_cutter(machine: &str, cutter: &Cutter) -> Result<(Scene, Option<[f64; 6]>)> {
    let cut = cutter.force();
    let force = MillingForce::from(cut);
    let at = Machine::named_or_file(machine)?;
    let wrench = PointLoad::Cut(force, 0.0, cut.torque_Nmm).wrench(&at.tool_at(&at.home.pose.rotation));
    let workspace = &at.workspace;
    let text = format!(
        "schema = 3\nquestion = \"How does this machine bend under the cutter?\"\nmachine = {machine:?}\n[process.force.path_frame]\n\
         radial_force_N = {:?}\ntangential_force_N = {:?}\naxial_force_N = {:?}\n[workspace_map]\nslices_z_mm = [{:?}]\n",
        force.radial,
        force.tangential,
        force.axial,
        f64::midpoint(workspace.min.z, workspace.max.z)
    );
    let study = Study::from_toml(&text, "study.toml", Path::new(""), &Overrides::default())?;
    let problem = "expected a machine whose workspace can be mapped";
    let scene = Scene::from_study(&study)?.ok_or_else(|| Error::argument("--cutter", problem))?;
    Ok((scene, Some(wrench.to_array())))
}
