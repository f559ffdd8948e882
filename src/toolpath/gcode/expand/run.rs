//! A program as it runs, line by line, writing out what it does.

use crate::toolpath::gcode::{
    BlockDelete,
    error::{Fault, GcodeError, Refusal},
    expand::{
        Beside, Origin, WrittenOut,
        calls::Call,
        jumps::Source,
        line::{SourceLine, evaluated},
        variables::Variables,
    },
    lines::{self, Lines},
};

/// The most lines that are run.
const MOST_STEPS: usize = 1_000_000;

pub(super) struct Run<'a> {
    block_delete: BlockDelete,
    pub(super) beside: &'a Beside<'a>,
    pub(super) sources: Vec<Source>,
    pub(super) files: Vec<String>,
    pub(super) here: Origin,
    pub(super) calls: Vec<Call>,
    /// LinuxCNC's `repeat` loops under way: their lines and how often they are still to be done.
    pub(super) repeats: Vec<(Origin, u32)>,
    pub(super) variables: Variables,
    bytes: Vec<u8>,
    origins: Vec<Origin>,
}

/// What comes after a line.
pub(super) enum Next {
    Line,
    At(usize),
    End,
}

type Step = Result<Next, (usize, Fault)>;

impl<'a> Run<'a> {
    pub fn new(source: &[u8], name: &str, block_delete: BlockDelete, beside: &'a Beside<'a>) -> Run<'a> {
        Run {
            block_delete,
            beside,
            sources: vec![Source::new(source)],
            files: vec![name.to_owned()],
            here: Origin { file: 0, line: 0 },
            calls: Vec::new(),
            repeats: Vec::new(),
            variables: Variables::default(),
            bytes: Vec::new(),
            origins: Vec::new(),
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
                Err((line.begin, Fault::TooManySteps { most: MOST_STEPS }))
            } else {
                self.step(&line)
            };
            let next = next.map_err(|fault| refused(fault).locate(&self.files[at.file], at.line + 1, &line.bytes))?;
            match next {
                Next::Line => self.here.line += 1,
                Next::At(line) => self.here.line = line,
                Next::End => break,
            }
        }
        let lines = &self.sources[0].lines;
        let has_tape_marks = lines.first().is_some_and(|line| line.bytes.trim_ascii_start().starts_with(b"%"));
        if has_tape_marks {
            self.bytes.extend_from_slice(b"%\n");
            self.origins.push(Origin { file: 0, line: lines.len() - 1 });
        }
        let lines = lines.len();
        let header = format!("(written out by kinetostat: {} lines for {lines})\n", self.origins.len() + 1);
        let at = if has_tape_marks { self.bytes.iter().position(|b| *b == b'\n').map_or(0, |at| at + 1) } else { 0 };
        self.bytes.splice(at..at, header.into_bytes());
        self.origins.insert(usize::from(at > 0), Origin::default());
        Ok((self.bytes, WrittenOut { origins: self.origins, files: self.files, lines }))
    }

    /// A subprogram that has run to the end of its file.
    fn not_back(&self) -> GcodeError {
        let last = self.source().lines.last();
        let bytes = last.map_or(&[][..], |line| &line.bytes);
        Refusal::new(0..bytes.len(), Fault::NoReturn).locate(&self.files[self.here.file], self.here.line, bytes)
    }

    pub(super) fn source(&self) -> &Source {
        &self.sources[self.here.file]
    }

    fn step(&mut self, line: &SourceLine) -> Step {
        if self.block_delete == BlockDelete::Skip && lines::is_deletable(&line.bytes) {
            self.write(line.bytes.clone());
            return Ok(Next::Line);
        }
        // Behind the first line, a % ends the program or is that of a file called.
        if line.bytes.trim_ascii_start().starts_with(b"%") {
            if self.here == (Origin { file: 0, line: 0 }) {
                self.write(line.bytes.clone());
            }
            return Ok(if self.here.line == 0 || !self.calls.is_empty() { Next::Line } else { Next::End });
        }
        let at = |fault| (line.begin, fault);
        let keyword = line.keyword();
        match (&line.o_name, keyword) {
            (Some(_), "") => Ok(self.program(line)),
            (Some(name), _) => self.o_word(line, name).map_err(at),
            (None, "IF" | "GOTO" | "WHILE" | "DO" | "END") => self.flow(line).map_err(at),
            _ => self.words(line),
        }
    }

    /// A program number: the first is the program's own, the next one begins what it calls.
    fn program(&mut self, line: &SourceLine) -> Next {
        let is_first =
            self.here.file == 0 && !self.source().lines[..self.here.line].iter().any(SourceLine::begins_program);
        if is_first {
            self.write(line.bytes.clone());
        }
        if is_first || !self.calls.is_empty() { Next::Line } else { Next::End }
    }

    /// A line of words: calls by M97 and M98, the end by M2, M30 and M99, or motion.
    fn words(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        let m = line.number('M', &self.variables).map_err(at)?;
        let called = |letter| line.number(letter, &self.variables).map_err(at);
        match m {
            Some(m @ (97.0 | 98.0)) => {
                let p = called('P')?.ok_or_else(|| at(Fault::Expression { expected: "P on the line" }))?;
                let times = called('L')?.unwrap_or(1.0);
                if line.rest().contains(['X', 'Y', 'Z']) {
                    return Err(at(Fault::CallWithMotion));
                }
                let (p, times) = (p as u32, times as u32);
                let (begin, times) = if m == 97.0 {
                    let label = self.source().label(self.here.line, p).ok_or_else(|| at(Fault::NoLabel))?;
                    (Origin { file: self.here.file, line: label }, times)
                } else {
                    match self.find(&p.to_string(), false) {
                        Err(_) if p > 9999 => (self.find(&(p % 10_000).to_string(), false).map_err(at)?, p / 10_000),
                        found => (found.map_err(at)?, times),
                    }
                };
                if times == 0 { Ok(Next::Line) } else { self.call(begin, times, false).map_err(at) }
            }
            Some(99.0) => match called('P')? {
                None => self.end_call().map_err(at),
                Some(_) => Err(at(Fault::Expression { expected: "M99 without P" })),
            },
            m => {
                let bytes = evaluated(line, &mut self.variables)?;
                if !bytes.trim_ascii().is_empty() || line.bytes.trim_ascii().is_empty() {
                    self.write(bytes);
                }
                Ok(if matches!(m, Some(2.0 | 30.0)) { Next::End } else { Next::Line })
            }
        }
    }

    fn write(&mut self, bytes: Vec<u8>) {
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
