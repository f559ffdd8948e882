//! A program that makes the loaded tool follow its path: corrected, written, read back and simulated.
//!
//! ```sh
//! cargo run --release --example compensate
//! ```

use kinetostat::{CompensateOptions, Compensated, Folder, Machine, Method, NoFiles, Process, ProgramJob, Work};

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
    let program = process.parse_program(PROGRAM.into(), "quarter.nc".as_ref())?;
    let job = ProgramJob::new(process, program, "quarter.nc", &Work::default())?;

    // Commands that put every point right, the program with these commands, and what it does as it is written, rounding included.
    let verified = match job.compensate(&CompensateOptions::by(Method::Direct), &mut NoFiles, &Work::default())? {
        Compensated::Verified(verified) => verified,
        Compensated::Refused(refused) => {
            let (point, reason) = &refused.failures[0];
            return Err(format!("no command for point {point}: {reason}").into());
        }
    };
    println!("{}", String::from_utf8_lossy(&verified.written.bytes));
    for pass in &verified.passes {
        println!("{:18} leaves up to {:.6} mm", pass.name, pass.summary.max_mm.unwrap_or(f64::NAN));
    }
    Ok(())
}
