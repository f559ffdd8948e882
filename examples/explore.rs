//! Questions to the engine of the pages as JSON, a line each, answered a line each: `{"ask": {"call": "open", …}}`.
//!
//! `node web/calls.mjs | cargo run --example explore`

use std::io::{BufRead, Write, stdin, stdout};

use kinetostat::explore::call;
use serde_json::Value;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut explorer = None;
    for line in stdin().lock().lines() {
        let asked: Value = serde_json::from_str(&line?)?;
        writeln!(stdout(), "{}", call(&mut explorer, &asked["ask"].to_string()))?;
    }
    Ok(())
}
