//! A program as it runs, line by line, writing out what it does.

use crate::toolpath::{
    expand::{
        Beside,
        calls::Call,
        jumps::Source,
        line::{SourceLine, evaluated},
        modes::{Frame, Modes},
        variables::Variables,
    },
    model::gcode::{BlockDelete, Dialect, Fault, GcodeError, GcodeOptions, MacroFault, Refusal},
    read::gcode::{
        CalledFile, Origin, WrittenOut,
        lines::{self, Lines},
    },
};

/// The most lines that are run.
const MOST_STEPS: usize = 1_000_000;

pub(crate) struct Run<'a> {
    block_delete: BlockDelete,
    pub(crate) beside: &'a Beside<'a>,
    pub(crate) sources: Vec<Source>,
    pub(crate) files: Vec<CalledFile>,
    pub(crate) here: Origin,
    pub(crate) calls: Vec<Call>,
    /// LinuxCNC's `repeat` loops under way: their lines and how often they are still to be done.
    pub(crate) repeats: Vec<(Origin, u32)>,
    pub(crate) variables: Variables,
    pub(crate) dialect: Dialect,
    pub(crate) modes: Modes,
    /// What is kept of modes: of the main program, and of each call.
    pub(crate) frames: Vec<Frame>,
    bytes: Vec<u8>,
    origins: Vec<Origin>,
    /// Whether a % has opened the program.
    has_tape_marks: bool,
}

/// What comes after a line.
pub(crate) enum Next {
    Line,
    At(usize),
    End,
}

pub(crate) type Step = Result<Next, (usize, Fault)>;

impl<'a> Run<'a> {
    pub fn new(source: Vec<u8>, name: &str, options: &GcodeOptions, beside: &'a Beside<'a>) -> Run<'a> {
        let dialect = options.dialect.unwrap_or_default();
        Run {
            block_delete: options.block_delete,
            beside,
            sources: vec![Source::new(&source)],
            files: vec![CalledFile { name: name.to_owned(), bytes: source }],
            here: Origin { file: 0, line: 0 },
            calls: Vec::new(),
            repeats: Vec::new(),
            variables: Variables::of(dialect),
            dialect,
            modes: Modes::new(options),
            frames: vec![Frame::default()],
            bytes: Vec::new(),
            origins: Vec::new(),
            has_tape_marks: false,
        }
    }

    /// Runs the program to its end.
    pub fn all(mut self) -> Result<(Vec<u8>, WrittenOut), GcodeError> {
        let mut steps = 0;
        loop {
            let Some(line) = self.sources[self.here.file].lines.get(self.here.line).cloned() else {
                match self.calls.is_empty() {
                    true => break,
                    false => return Err(self.not_back()),
                }
            };
            steps += 1;
            let at = self.here;
            let refused = |(byte, fault): (usize, Fault)| {
                let span =
                    byte.min(line.bytes.len())..line.bytes.trim_ascii_end().len().max(byte.min(line.bytes.len()));
                Refusal::new(span, fault)
            };
            let next = if steps > MOST_STEPS {
                Err((line.begin, Fault::Macro(MacroFault::TooManySteps { most: MOST_STEPS })))
            } else {
                self.step(&line)
            };
            let next =
                next.map_err(|fault| refused(fault).locate(&self.files[at.file].name, at.line + 1, &line.bytes))?;
            match next {
                Next::Line => self.here.line += 1,
                Next::At(line) => self.here.line = line,
                Next::End => break,
            }
        }
        let lines = self.sources[0].lines.len();
        if self.has_tape_marks {
            self.bytes.extend_from_slice(b"%\n");
            self.origins.push(Origin { file: 0, line: lines - 1 });
        }
        Ok((self.bytes, WrittenOut { origins: self.origins, files: self.files, lines, header: 0, keeps_calls: false }))
    }

    /// A subprogram that has run to the end of its file.
    fn not_back(&self) -> GcodeError {
        let last = self.source().lines.last();
        let bytes = last.map_or(&[][..], |line| &line.bytes);
        Refusal::new(0..bytes.len(), Fault::Macro(MacroFault::NoReturn)).locate(
            &self.files[self.here.file].name,
            self.here.line,
            bytes,
        )
    }

    pub(crate) fn source(&self) -> &Source {
        &self.sources[self.here.file]
    }

    fn step(&mut self, line: &SourceLine) -> Step {
        if self.block_delete == BlockDelete::Skip && lines::is_deletable(&line.bytes) {
            self.write(line.bytes.clone());
            return Ok(Next::Line);
        }
        // Behind code, a % ends the program or is that of a file called.
        if line.is_mark() {
            let opens = self.is_first();
            if opens && self.calls.is_empty() {
                self.write(line.bytes.clone());
                self.has_tape_marks = true;
            }
            return Ok(if opens || !self.calls.is_empty() { Next::Line } else { Next::End });
        }
        let at = |fault| (line.begin, fault);
        let keyword = line.keyword();
        match (&line.o_name, keyword) {
            (Some(_), "") => self.program(line).map_err(|fault| (0, fault)),
            (Some(name), _) => self.o_word(line, name).map_err(at),
            (None, "IF" | "GOTO" | "WHILE" | "DO" | "END") => self.flow(line).map_err(at),
            _ => self.words(line),
        }
    }

    /// Whether nothing but comments stands before this line of its file.
    fn is_first(&self) -> bool {
        self.source().lines[..self.here.line].iter().all(SourceLine::is_bare)
    }

    /// A program number: the first is the program's own, the next one begins what it calls.
    fn program(&mut self, line: &SourceLine) -> Result<Next, Fault> {
        let before = &self.source().lines[..self.here.line];
        let is_own = self.here.file == 0 && !before.iter().any(SourceLine::begins_program);
        if !self.calls.is_empty() {
            return Ok(Next::Line);
        }
        if !is_own {
            return Ok(Next::End);
        }
        if before.iter().any(|line| !line.code.trim().is_empty()) {
            return Err(Fault::Macro(MacroFault::RunsOn));
        }
        self.write(line.bytes.clone());
        Ok(Next::Line)
    }

    /// A line of words: a call, the end by M2, M30 and M99, or motion.
    fn words(&mut self, line: &SourceLine) -> Step {
        if line.has(b'M', &[97.0, 98.0, 198.0]) {
            return self.call_by_number(line);
        }
        if line.has(b'G', &[65.0]) {
            return self.call_macro(line);
        }
        if line.has(b'G', &[66.0, 66.1]) {
            return Err((line.begin, Fault::Macro(MacroFault::ModalCall)));
        }
        if line.has(b'M', &[99.0]) {
            return self.go_back(line);
        }
        self.plain(line)?;
        Ok(if line.has(b'M', &[2.0, 30.0]) { Next::End } else { Next::Line })
    }

    /// Writes a line that steers nothing, with values in place of its expressions.
    pub(crate) fn plain(&mut self, line: &SourceLine) -> Result<(), (usize, Fault)> {
        let bytes = evaluated(line, &mut self.variables)?;
        let bytes = self.kept_and_restored(line, bytes)?;
        if !bytes.trim_ascii().is_empty() || line.bytes.trim_ascii().is_empty() {
            self.write(bytes);
        }
        Ok(())
    }

    pub(crate) fn write(&mut self, bytes: Vec<u8>) {
        let ending = &self.sources[self.here.file].endings[self.here.line];
        self.bytes.extend(bytes);
        self.bytes.extend_from_slice(if ending.is_empty() { b"\n" } else { ending });
        self.origins.push(self.here);
    }
}

impl Source {
    pub fn new(bytes: &[u8]) -> Source {
        let lines = Lines::of(bytes);
        Source {
            endings: (0..lines.len()).map(|line| bytes[lines.ending(line)].to_vec()).collect(),
            lines: (0..lines.len()).map(|line| SourceLine::new(&bytes[lines.content(line)])).collect(),
        }
    }
}
