//! A program that makes the loaded tool follow its path: corrected, written, read back and simulated.
//!
//! ```sh
//! cargo run --release --example compensate
//! ```

use kinetostat::{
    Folder, Machine, Method, Process,
    products::program::{Corrected, ProgramCommands, ProgramJob},
    simulation::ProgramFile,
};

const PROCESS: &str = r#"
schema = 1
placement = { origin_mm = [126.35, 126.35, 226.35] }

[force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0

[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
"#;

const PROGRAM: &str = "G90 G21\nG0 X0 Y0 Z0\nG1 X10 Y0 F300\nG3 X0 Y10 I-10 J0\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::named("orthoglide")?;
    // Files may be on disk, `Process::open`, or in memory; this process names none.
    let process = Process::from_toml(PROCESS, "process", Folder::in_memory([]), &machine)?;
    let program = ProgramFile::parse(PROGRAM.into(), "quarter.nc".as_ref(), &process)?;
    let job = ProgramJob::new(process, program, "quarter.nc")?;

    let nothing_to_tell = || ();
    let without = job.pass_by(Method::None, &nothing_to_tell, |_, _| Ok(()))?;

    // Commands that put every point right.
    let mut corrected = Corrected::new(&job);
    let commanded = job.pass_by(Method::Direct, &nothing_to_tell, |part, answers| {
        corrected.add(&job, part, answers);
        Ok(())
    })?;
    if let Some((point, reason)) = corrected.failures.first() {
        return Err(format!("no command for point {point}: {reason}").into());
    }

    // The program with these commands, and what it does as it is written, rounding included.
    let written = job.write(&corrected)?;
    let proof = job.pass("as written", &ProgramCommands::Sent(&written.sent), &nothing_to_tell, |_, _| Ok(()))?;

    println!("{}", String::from_utf8_lossy(&written.bytes));
    for pass in [&without, &commanded, &proof] {
        println!("{:12} leaves up to {:.6} mm", pass.name, pass.summary.max_mm.unwrap_or(f64::NAN));
    }
    Ok(())
}
