//! Runs a program line by line and writes each line that is run, with its expressions evaluated.

use std::collections::BTreeMap;

use crate::{
    expand::{
        SiblingFiles,
        calls::Call,
        check_length,
        jumps::SourceFile,
        line::{SourceLine, evaluate_line},
        modes::{CallFrame, Modes},
        variables::Variables,
    },
    model::gcode::{
        BlockDelete, Dialect, ENDED_BY_TOUCH, Fault, GcodeError, GcodeOptions, MacroFault, Refusal, Unsupported,
    },
    read::gcode::{
        CalledFile, Expansion, Origin,
        lines::{self, Lines},
    },
};

/// Most lines that are run.
pub(crate) const MAX_STEPS: usize = 1_000_000;

/// Lines that are looked through for the aim of a jump in the time of a byte that is run.
const LINES_PER_BYTE: usize = 4;

/// State of a program that is being expanded.
pub(crate) struct Run<'a> {
    block_delete: BlockDelete,
    pub(crate) beside: &'a SiblingFiles<'a>,
    calls_kept: Vec<u32>,
    /// Whether it is known where the tool is when the program is called, so that M99 may end it.
    pub(crate) has_start: bool,
    pub(crate) sources: Vec<SourceFile>,
    pub(crate) files: Vec<CalledFile>,
    pub(crate) here: Origin,
    pub(crate) calls: Vec<Call>,
    /// LinuxCNC's open `repeat` loops: their lines, and runs that are still to be done.
    pub(crate) repeats: Vec<(Origin, u32)>,
    /// Sections that are repeated, the innermost last.
    pub(crate) sections: Vec<Section>,
    /// Whether the block before defines one of Heidenhain's cycles with Q parameters.
    pub(crate) defines_cycle: bool,
    /// Q parameters of the last cycle of Heidenhain's, and whether they have changed since.
    pub(crate) cycle_parameters: BTreeMap<String, bool>,
    /// Last values of the counters of Sinumerik's open FOR loops, by their lines.
    pub(crate) last_counts: BTreeMap<Origin, f64>,
    pub(crate) variables: Variables,
    pub(crate) dialect: Dialect,
    pub(crate) modes: Modes,
    /// Saved modes of the main program and of each call.
    pub(crate) call_frames: Vec<CallFrame>,
    bytes: Vec<u8>,
    /// Most decimals of a coordinate that is written as a number.
    pub(crate) decimals: usize,
    origins: Vec<Origin>,
    /// Whether a % opened the program.
    has_tape_marks: bool,
}

/// A section of lines that is repeated, by Sinumerik's REPEAT.
#[derive(Debug)]
pub(crate) struct Section {
    /// First line.
    pub begin: usize,
    /// Line before which a run of it ends, and the line behind the repetition.
    pub stop: usize,
    pub return_to: usize,
    /// Runs that are still to be done.
    pub runs_left: u32,
    /// Number of open calls.
    pub depth: usize,
}

/// Which line comes next.
pub(crate) enum Next {
    Line,
    At(usize),
    End,
}

/// The next line, or a fault at a byte of this one.
pub(crate) type Step = Result<Next, (usize, Fault)>;

impl<'a> Run<'a> {
    /// Prepares to run `source`, called `name`, from its first line; `beside` gives the files that it may call.
    pub fn new(source: Vec<u8>, name: &str, options: &GcodeOptions, beside: &'a SiblingFiles<'a>) -> Run<'a> {
        let dialect = options.dialect.unwrap_or_default();
        Run {
            block_delete: options.block_delete,
            beside,
            calls_kept: options.calls_kept.clone(),
            has_start: options.start_mm.is_some(),
            sources: vec![SourceFile::new(&source, dialect)],
            files: vec![CalledFile { name: name.to_owned(), bytes: source }],
            here: Origin { file: 0, line: 0 },
            calls: Vec::new(),
            repeats: Vec::new(),
            sections: Vec::new(),
            defines_cycle: false,
            cycle_parameters: BTreeMap::new(),
            last_counts: BTreeMap::new(),
            variables: Variables::new(dialect),
            dialect,
            modes: Modes::new(options),
            call_frames: vec![CallFrame::default()],
            bytes: Vec::new(),
            decimals: 0,
            origins: Vec::new(),
            has_tape_marks: false,
        }
    }

    /// Runs the program to its end; returns the bytes of the expanded program, and where its lines come from. `Err` for what cannot be run.
    pub fn run_to_end(mut self) -> Result<(Vec<u8>, Expansion), GcodeError> {
        let (mut steps, mut bytes) = (0, 0);
        loop {
            self.end_sections();
            let Some(line) = self.sources[self.here.file].lines.get(self.here.line).cloned() else {
                match self.calls.is_empty() {
                    true => break,
                    false => return Err(self.missing_return()),
                }
            };
            steps += 1;
            bytes += line.bytes.len();
            let at = self.here;
            let refused = |(byte, fault): (usize, Fault)| {
                let span =
                    byte.min(line.bytes.len())..line.bytes.trim_ascii_end().len().max(byte.min(line.bytes.len()));
                Refusal::new(span, fault)
            };
            let next = if steps > MAX_STEPS {
                Err((line.begin, Fault::Macro(MacroFault::TooManySteps { most: MAX_STEPS })))
            } else {
                let checked = check_length(bytes, || self.runs_asked()).map_err(|fault| (line.begin, fault));
                checked.and_then(|()| self.follow_line(&line))
            };
            let locate = |refusal: Refusal| refusal.locate(&self.files[at.file].name, at.line + 1, &line.bytes);
            let next = next.map_err(|fault| locate(refused(fault)).with_dialect(self.dialect))?;
            match next {
                Next::Line => self.here.line += 1,
                Next::At(line) => {
                    self.here.line = line;
                    // Where it leads was sought line by line.
                    bytes += self.source().lines.len() / LINES_PER_BYTE;
                }
                Next::End => break,
            }
        }
        let lines = self.sources[0].lines.len();
        if self.has_tape_marks {
            self.bytes.extend_from_slice(b"%\n");
            self.origins.push(Origin { file: 0, line: lines - 1 });
        }
        Ok((
            self.bytes,
            Expansion {
                origins: self.origins,
                files: self.files,
                lines,
                header: 0,
                keeps_calls: false,
                decimals: self.decimals,
            },
        ))
    }

    /// Returns in words how many runs of the section around this line, or of the subprogram, are still to be done.
    fn runs_asked(&self) -> String {
        let of_repeat = self.repeats.last().map(|(_, left)| *left);
        let left = self.sections.last().map(|section| section.runs_left).or(of_repeat);
        let left = left.or(self.calls.last().map(Call::runs_left));
        left.map_or_else(String::new, |left| format!(", with {left} more runs of this section to do"))
    }

    /// Returns the error that a subprogram has run to the end of its file without a return.
    fn missing_return(&self) -> GcodeError {
        let last = self.source().lines.last();
        let bytes = last.map_or(&[][..], |line| &line.bytes);
        Refusal::new(0..bytes.len(), Fault::Macro(MacroFault::NoReturn))
            .locate(&self.files[self.here.file].name, self.here.line, bytes)
            .with_dialect(self.dialect)
    }

    /// Begins the sections that end at this line anew, or goes on behind them if that was their last run.
    fn end_sections(&mut self) {
        while let Some(section) = self.sections.last_mut() {
            if section.depth != self.calls.len() || section.stop != self.here.line {
                return;
            }
            section.runs_left -= 1;
            if section.runs_left > 0 {
                self.here.line = section.begin;
                return;
            }
            self.here.line = section.return_to;
            self.sections.pop();
        }
    }

    /// Jumps to `line`, which leaves the sections that it is not in.
    pub(crate) fn jump_to(&mut self, line: usize) -> Next {
        let depth = self.calls.len();
        self.sections.retain(|section| section.depth != depth || (section.begin..section.stop).contains(&line));
        Next::At(line)
    }

    /// Returns the file that the current line is in.
    pub(crate) fn source(&self) -> &SourceFile {
        &self.sources[self.here.file]
    }

    /// Runs one line, and returns which line comes next.
    fn follow_line(&mut self, line: &SourceLine) -> Step {
        if self.block_delete == BlockDelete::Skip && lines::is_deletable(&line.bytes) {
            self.write_line(line.bytes.clone());
            return Ok(Next::Line);
        }
        match self.dialect {
            Dialect::Sinumerik => return self.follow_sinumerik(line),
            Dialect::Heidenhain => return self.follow_heidenhain(line),
            _ => {}
        }
        // Behind code, a % ends the program or is that of a file called.
        if line.is_percent() {
            let opens = self.is_first_code();
            if opens && self.calls.is_empty() {
                self.write_line(line.bytes.clone());
                self.has_tape_marks = true;
            }
            return Ok(if opens || !self.calls.is_empty() { Next::Line } else { Next::End });
        }
        let at = |fault| (line.begin, fault);
        let keyword = line.keyword();
        match (&line.o_name, keyword) {
            (Some(_), "") => self.follow_program_number(line).map_err(|fault| (0, fault)),
            (Some(name), _) => self.follow_o_word(line, name).map_err(at),
            (None, "IF" | "GOTO" | "WHILE" | "DO" | "END") => self.follow_fanuc_flow(line).map_err(at),
            _ => self.follow_words(line),
        }
    }

    /// Whether only comments stand before this line of its file.
    pub(crate) fn is_first_code(&self) -> bool {
        self.source().lines[..self.here.line].iter().all(SourceLine::is_without_code)
    }

    /// Runs a line with a program number. The first is the program's own; another one begins a subprogram, so the program ends before it.
    fn follow_program_number(&mut self, line: &SourceLine) -> Result<Next, Fault> {
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
        self.write_line(line.bytes.clone());
        Ok(Next::Line)
    }

    /// Runs a line of words: a call, the end by M2, M30 or M99, or motion; returns which line comes next.
    fn follow_words(&mut self, line: &SourceLine) -> Step {
        let calls = line.has_word(b'M', &[98.0, 198.0]) || line.has_word(b'G', &[65.0]);
        if calls && !self.calls_kept.is_empty() && self.is_kept_call(line)? {
            self.write_evaluated(line)?;
            return Ok(Next::Line);
        }
        if line.has_word(b'M', &[97.0, 98.0, 198.0]) {
            return self.call_by_number(line);
        }
        if line.has_word(b'G', &[65.0]) {
            return self.call_macro(line);
        }
        // Here, as otherwise a line behind it that computes with where it ended (#5063) would be refused in its place.
        if line.has_word(b'G', &ENDED_BY_TOUCH) {
            return Err((line.begin, Fault::Unsupported(Unsupported::Touch)));
        }
        if line.has_word(b'G', &[66.0, 66.1]) {
            return Err((line.begin, Fault::Macro(MacroFault::ModalCall)));
        }
        if line.has_word(b'M', &[99.0]) {
            return self.return_by_m99(line);
        }
        self.write_evaluated(line)?;
        Ok(if line.has_word(b'M', &[2.0, 30.0]) { Next::End } else { Next::Line })
    }

    /// Whether `line` calls a program that the options say moves nothing.
    fn is_kept_call(&self, line: &SourceLine) -> Result<bool, (usize, Fault)> {
        let words = line.words(&self.variables)?;
        let number = words.iter().find(|word| word.letter == 'P').and_then(|word| word.value);
        Ok(number.is_some_and(|number| self.calls_kept.iter().any(|kept| f64::from(*kept) == number)))
    }

    /// Writes a line that calls and branches nowhere, with values in place of its expressions; `Err` gives the byte of the fault.
    pub(crate) fn write_evaluated(&mut self, line: &SourceLine) -> Result<(), (usize, Fault)> {
        self.decimals = self.decimals.max(line.decimals());
        let bytes = evaluate_line(line, &mut self.variables)?;
        let bytes = self.save_or_restore(line, bytes)?;
        if !bytes.trim_ascii().is_empty() || line.bytes.trim_ascii().is_empty() {
            self.write_line(bytes);
        }
        Ok(())
    }

    /// Writes the line `bytes` with the ending of the current line, from which it comes.
    pub(crate) fn write_line(&mut self, bytes: Vec<u8>) {
        let ending = &self.sources[self.here.file].endings[self.here.line];
        self.bytes.extend(bytes);
        self.bytes.extend_from_slice(if ending.is_empty() { b"\n" } else { ending });
        self.origins.push(self.here);
    }
}

impl SourceFile {
    /// Splits a file into lines.
    pub fn new(bytes: &[u8], dialect: Dialect) -> SourceFile {
        let lines = Lines::split(bytes);
        SourceFile {
            endings: (0..lines.len()).map(|line| bytes[lines.ending(line)].to_vec()).collect(),
            lines: (0..lines.len()).map(|line| SourceLine::of(&bytes[lines.content(line)], dialect)).collect(),
        }
    }
}
