//! The faults of macros, jumps and subprogram calls in G-code.

use thiserror::Error;

use crate::model::MAX_MIB;

/// The reason why a macro, a jump or a call is refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MacroFault {
    /// An expression that is none.
    #[error("not an expression that can be evaluated; expected {expected}")]
    Expression {
        /// What should stand there.
        expected: &'static str,
    },
    /// A variable that nothing was assigned to.
    #[error("a variable without a value; expected one that the program has assigned before")]
    NoValue,
    /// A division by zero and the like.
    #[error("its value is no number; expected a finite one")]
    NotFinite,
    /// A variable of the machine.
    #[error("depends on the state of the machine; expected variables #1 to #999 and names that the program assigns")]
    MachineState,
    /// A contour that is not that of lines and arcs in a plane.
    #[error("cannot be written out as lines and arcs; expected {expected}")]
    Contour {
        /// What should stand there.
        expected: &'static str,
    },
    /// A name that no DEF declares.
    #[error(
        "a name that the program does not declare; expected an R parameter, or DEF REAL, DEF INT or DEF BOOL before it"
    )]
    Undeclared,
    /// A jump without an aim.
    #[error(
        "its other end is not in the program; expected the label, or the word that ends or begins the same loop, branch or subprogram"
    )]
    NoLabel,
    /// A call of what is not there.
    #[error("subprogram {name} is neither in the file nor beside it; expected {expected}")]
    NoSubprogram {
        /// Name of the subprogram.
        name: String,
        /// What it is called in the file, or the name of its file.
        expected: String,
    },
    /// Brackets and their kin too deep in one another.
    #[error(
        "{depth} levels of brackets and signs in one another; expected at most {most}, and variables for what stands within"
    )]
    TooNested {
        /// Number of levels.
        depth: usize,
        /// Largest number of levels.
        most: usize,
    },
    /// A program whose lines are too long in all.
    #[error(
        "up to here, the lines that the program runs or is written out as have more than {MAX_MIB} MiB in all{asked}; expected a program \
         that is shorter written out"
    )]
    TooManyBytes {
        /// How many runs of the section around it are still to be done, in words.
        asked: String,
    },
    /// A program that goes on and on.
    #[error("the program has run {most} lines and has not ended; expected one that ends")]
    TooManySteps {
        /// Number of lines that were run.
        most: usize,
    },
    /// Subprograms that call themselves.
    #[error("calls are more than {most} deep; expected subprograms that do not call themselves")]
    TooDeep {
        /// Largest depth of calls.
        most: usize,
    },
    /// M99 where nothing was called.
    #[error(
        "ends a subprogram where none was called, or repeats the main program for ever; expected M2 or M30, or start_mm in [gcode], from \
         where the program runs as a subprogram"
    )]
    NoCall,
    /// A subprogram that does not come back.
    #[error("the subprogram ends here without M99, endsub, M17, RET or LBL 0; expected its own of them")]
    NoReturn,
    /// A word of a call that is not read.
    #[error(
        "{letter} of a call is not read: controls differ in what it means; expected P, L and, after G65, arguments"
    )]
    CallWord {
        /// Letter of the word.
        letter: char,
    },
    /// G66.
    #[error("macro calls that stay in force (G66) are not followed; expected G65, or the macro written out")]
    ModalCall,
    /// G65 with L whose macro assigns to its arguments.
    #[error("a macro that is repeated changes its arguments, which controls read differently; expected L1")]
    ChangedArguments,
    /// A main program without an end before a subprogram.
    #[error("the program runs into another one; expected M2, M30 or M99 before it")]
    RunsOn,
}
