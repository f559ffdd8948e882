//! Writes recorded operations as branch-free Rust that needs nothing but `core`.

use std::fmt::Write;

use super::function::{Function, Start};
use crate::{
    lanes::{Computation, Operation},
    statics::one_step::StepInput,
};

/// Returns the text of a Rust function `name` that computes `program` from its `arrays`, with names and lengths, and with `about` as its doc.
fn function_text(name: &str, about: &str, arrays: &[(&str, usize)], program: &Computation) -> String {
    let given: Vec<String> = arrays.iter().map(|(name, length)| format!("{name}: &[f64; {length}]")).collect();
    let mut text = format!("/// {about}\npub fn {name}({}) -> [f64; {}] {{\n", given.join(", "), program.outputs.len());
    let mut is_used = vec![false; program.inputs];
    for operation in &program.operations {
        if let Operation::Input(number) = operation {
            is_used[*number as usize] = true;
        }
    }
    let mut first = 0;
    for (array, length) in arrays {
        let numbers = first..first + length;
        let names: Vec<String> = numbers.map(|n| if is_used[n] { format!("x{n}") } else { "_".into() }).collect();
        if names.iter().any(|name| name != "_") {
            _ = writeln!(text, "    let [{}] = *{array};", names.join(", "));
        } else {
            _ = writeln!(text, "    let _ = {array};");
        }
        first += length;
    }
    for (place, operation) in program.operations.iter().enumerate() {
        if !matches!(operation, Operation::Input(_) | Operation::Constant(_)) {
            _ = writeln!(text, "    let v{place} = {};", operation_text(program, operation));
        }
    }
    let outputs: Vec<String> = program.outputs.iter().map(|&output| operand_text(program, output)).collect();
    _ = writeln!(text, "    [{}]\n}}", outputs.join(", "));
    text
}

/// Returns the Rust variable or literal that holds the result of operation number `place`.
fn operand_text(program: &Computation, place: u32) -> String {
    match program.operations[place as usize] {
        Operation::Input(number) => format!("x{number}"),
        // Reads back with the same bits.
        Operation::Constant(bits) => format!("{:?}", f64::from_bits(bits)),
        _ => format!("v{place}"),
    }
}

/// Returns the Rust expression of an operation; empty for inputs and constants, which are written where they are used.
fn operation_text(program: &Computation, operation: &Operation) -> String {
    let at = |place: u32| operand_text(program, place);
    match *operation {
        Operation::Input(_) | Operation::Constant(_) => String::new(),
        Operation::Sum(a, b) => format!("{} + {}", at(a), at(b)),
        Operation::Difference(a, b) => format!("{} - {}", at(a), at(b)),
        Operation::Product(a, b) => format!("{} * {}", at(a), at(b)),
        Operation::Quotient(a, b) => format!("{} / {}", at(a), at(b)),
        Operation::Negative(a) => format!("-{}", at(a)),
        Operation::Root(a) => format!("root({})", at(a)),
        Operation::Size(a) => format!("size({})", at(a)),
        Operation::IfGreater([a, b, yes, no]) => {
            format!("if {} > {} {{ {} }} else {{ {} }}", at(a), at(b), at(yes), at(no))
        }
        Operation::IfNan([a, yes, no]) => format!("if {0} != {0} {{ {1} }} else {{ {2} }}", at(a), at(yes), at(no)),
    }
}

/// Returns the Rust code of a start: its basis terms, coefficients and their sum.
fn start_text(start: &Start) -> String {
    let (terms, numbers) = (start.coefficients.len(), start.coefficients.first().map_or(0, Vec::len));
    let arrays = [("at", 3), ("wrench", 6)];
    let mut text = function_text("terms", "Products of Chebyshev polynomials.", &arrays, &start.basis);
    _ = write!(
        text,
        "\n/// Where the steps start.\npub fn start(at: &[f64; 3], wrench: &[f64; 6]) -> [f64; {numbers}] {{
    let mut state = [0.0; {numbers}];
    for (row, term) in COEFFICIENTS.iter().zip(terms(at, wrench)) {{
        for (number, coefficient) in state.iter_mut().zip(row) {{
            *number += coefficient * term;
        }}
    }}
    state
}}

/// Of each term, its coefficient in each number of the state.
static COEFFICIENTS: [[f64; {numbers}]; {terms}] = [\n"
    );
    for row in &start.coefficients {
        let row: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
        _ = writeln!(text, "    [{}],", row.join(", "));
    }
    text + "];\n"
}

/// Returns the text of a Rust module with the start and the Newton step of a function.
pub(super) fn module(function: &Function) -> String {
    let state = function.step.outputs.len();
    let mut text = start_text(&function.start);
    let arrays: &[(&str, usize)] = match function.given {
        StepInput::Tip => &[("state", state), ("at", 3), ("wrench", 6)],
        StepInput::Drives => &[("state", state), ("wrench", 6)],
    };
    text += "\n";
    text += &function_text("step", "One Newton step of the whole machine: the next state.", arrays, &function.step);
    let uses = |wanted: fn(&Operation) -> bool| function.step.operations.iter().any(wanted);
    if uses(|operation| matches!(operation, Operation::Root(_))) {
        text += ROOT;
    }
    if uses(|operation| matches!(operation, Operation::Size(_))) {
        text += SIZE;
    }
    text
}

/// `core` has no square root; that of C is rounded correctly, and most often one instruction.
const ROOT: &str = "
fn root(x: f64) -> f64 {
    extern \"C\" {
        fn sqrt(x: f64) -> f64;
    }
    // It takes any number.
    unsafe { sqrt(x) }
}
";

const SIZE: &str = "
fn size(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & (u64::MAX >> 1))
}
";
