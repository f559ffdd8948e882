//! How far the tool moves under a cutting force, and how stiff the machine is there.
//!
//! ```sh
//! cargo run --release --example equilibrium -- orthoglide
//! ```

use kinetostat::{Machine, MillingForce, Solver, nalgebra::Vector3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "orthoglide".into());
    let machine = Machine::named_or_file(&name)?;

    // The middle of the workspace, with the platform oriented as at home: where P is commanded, O, mm.
    let position: Vector3<f64> = (machine.workspace.min + machine.workspace.max) / 2.0;
    let commanded = machine.inverse_kinematics_at(position)?;
    println!("{}, P at {:.1?} mm, drives at {:.3?}", machine.title, position.as_slice(), commanded.drives);

    // A milling force on the tool, in its own frame, as a wrench at P in axes of O, N and N·mm.
    let tool = machine.tool_at(&commanded.pose.rotation);
    let load = MillingForce::KLIMCHIK_GROOVE.wrench(130f64.to_radians(), &tool);

    // The same solver serves any number of drives and loads.
    let found = Solver::new(&machine).solve(&commanded.drives, &load)?;

    println!("{:?} after {} iterations", found.status, found.iterations);
    let moved = machine.tool_displacement(&commanded.pose, &found.pose);
    println!("the tool tip moves by {:.4} mm: {:.4?}", moved.norm(), moved.as_slice());
    println!("as JSON: {}", serde_json::to_string(&found)?);
    Ok(())
}
