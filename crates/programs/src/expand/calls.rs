//! Calls of subprograms, and the return from them.

use crate::{
    expand::{
        jumps::SourceFile,
        line::{CalledWord, SourceLine},
        modes::CallFrame,
        run::{Next, Run, Step},
        variables::{Arguments, Kind, argument_variable},
    },
    model::gcode::{Dialect, Fault, MacroFault},
    read::gcode::{CalledFile, Origin},
};

/// Most nested calls.
const DEEPEST: usize = 50;

/// A call that is under way.
#[derive(Debug)]
pub(crate) struct Call {
    /// Line behind the call.
    return_to: Origin,
    /// First line of the subprogram.
    begin: Origin,
    /// Runs that are still to be done.
    runs_left: u32,
    /// Its arguments, if it has local variables of its own.
    arguments: Option<Arguments>,
}

impl Call {
    /// Whether it calls a section of the same program without variables of its own, as Heidenhain's CALL LBL does.
    pub fn is_section(&self) -> bool {
        self.arguments.is_none()
    }

    /// Returns the number of runs that are still to be done.
    pub fn runs_left(&self) -> u32 {
        self.runs_left
    }
}

/// What a call names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CallTarget {
    /// LinuxCNC's `o<name> sub`.
    Word,
    /// A program O, in the file or beside it.
    Number,
    /// A program O beside the file (M198).
    File,
}

/// Program numbers are below it; digits before them are the number of runs (`P30100`: O100 three times).
const NUMBER_END: u32 = 10_000;

impl Run<'_> {
    /// Runs a line with M97, M98 or M198: writes its other words, then calls subprogram P (M97: the line with N = P) L times.
    pub(crate) fn call_by_number(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        let words = line.words(&self.variables)?;
        let is_call = |word: &&CalledWord| word.letter == 'M' && matches!(word.value, Some(97.0 | 98.0 | 198.0));
        let call = words.iter().find(is_call).ok_or_else(|| at(Fault::NotAWord))?;
        let has_length = words.iter().any(|word| word.letter == 'G' && matches!(word.value, Some(43.0 | 44.0)));
        let other = words.iter().find(|word| word.letter == 'Q' || (word.letter == 'H' && !has_length));
        if let Some(word) = other {
            return Err((word.span.start, Fault::Macro(MacroFault::CallWord { letter: word.letter })));
        }
        let (p, l) = (whole_number(&words, 'P')?, whole_number(&words, 'L')?);
        let p = p.ok_or_else(|| at(Fault::Macro(MacroFault::Expression { expected: "P on the line" })))?;
        let (begin, times) = match call.value {
            Some(97.0) => {
                let label =
                    self.source().label_at(self.here.line, p).ok_or_else(|| at(Fault::Macro(MacroFault::NoLabel)))?;
                (Origin { line: label, ..self.here }, l)
            }
            m => {
                let target = if m == Some(98.0) { CallTarget::Number } else { CallTarget::File };
                match self.find_subprogram(&p.to_string(), target) {
                    Err(Fault::Macro(MacroFault::NoSubprogram { .. })) if p >= NUMBER_END && l.is_none() => {
                        (self.find_subprogram(&(p % NUMBER_END).to_string(), target).map_err(at)?, Some(p / NUMBER_END))
                    }
                    found => (found.map_err(at)?, l),
                }
            }
        };
        let call_words: Vec<CalledWord> =
            words.iter().filter(|word| *word == call || matches!(word.letter, 'P' | 'L')).cloned().collect();
        if let Some(rest) = line.without_words(&call_words) {
            self.write_evaluated(&rest)?;
        }
        self.call(begin, times.unwrap_or(1), None).map_err(at)
    }

    /// Runs a line with G65: calls subprogram P L times, with the other words as arguments, letter by letter.
    pub(crate) fn call_macro(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        let words = line.words(&self.variables)?;
        let (p, l) = (whole_number(&words, 'P')?, whole_number(&words, 'L')?);
        let p = p.ok_or_else(|| at(Fault::Macro(MacroFault::Expression { expected: "P on the line" })))?;
        let mut arguments = Vec::new();
        for word in words.iter().filter(|word| !matches!(word.letter, 'P' | 'L')) {
            if word.letter == 'G' && word.value == Some(65.0) {
                continue;
            }
            let number = argument_variable(word.letter);
            let number = number.ok_or((word.span.start, Fault::Macro(MacroFault::CallWord { letter: word.letter })))?;
            if words.iter().filter(|other| other.letter == word.letter).count() > 1 {
                return Err((word.span.start, Fault::Repeated { letter: word.letter }));
            }
            arguments.extend(word.value.map(|value| (number.to_string(), Kind::Real, value)));
        }
        let begin = self.find_subprogram(&p.to_string(), CallTarget::Number).map_err(at)?;
        self.call(begin, l.unwrap_or(1), Some(arguments)).map_err(at)
    }

    /// Runs a line with M99: writes its other words, then returns behind the call, or to line N`P` of the calling program.
    pub(crate) fn return_by_m99(&mut self, line: &SourceLine) -> Step {
        let at = |fault| (line.begin, fault);
        let words = line.words(&self.variables)?;
        if let Some(word) = words.iter().find(|word| matches!(word.letter, 'L' | 'Q')) {
            return Err((word.span.start, Fault::Macro(MacroFault::CallWord { letter: word.letter })));
        }
        let p = whole_number(&words, 'P')?;
        if p.is_none() && self.calls.is_empty() && self.has_start {
            self.write_evaluated(line)?;
            return Ok(Next::End);
        }
        let is_return = |word: &CalledWord| word.letter == 'P' || (word.letter == 'M' && word.value == Some(99.0));
        let return_words: Vec<CalledWord> = words.iter().filter(|word| is_return(word)).cloned().collect();
        if let Some(rest) = line.without_words(&return_words) {
            self.write_evaluated(&rest)?;
        }
        match p {
            None => self.end_call().map_err(at),
            Some(label) => {
                if let Some(call) = self.calls.last_mut() {
                    call.runs_left = 1;
                    self.end_call().map_err(at)?;
                }
                self.source()
                    .label_at(self.here.line.saturating_sub(1), label)
                    .map(Next::At)
                    .ok_or_else(|| at(Fault::Macro(MacroFault::NoLabel)))
            }
        }
    }

    /// Returns the first line of the subprogram `name`, in the program or in a file beside it, which is then read. `Err` if there is none.
    pub(crate) fn find_subprogram(&mut self, name: &str, target: CallTarget) -> Result<Origin, Fault> {
        const ENDS: [&str; 9] = ["", ".ngc", ".nc", ".NC", ".cnc", ".CNC", ".tap", ".TAP", ".txt"];
        const SINUMERIK_ENDS: [&str; 5] = [".SPF", ".spf", ".MPF", ".mpf", ""];
        const HEIDENHAIN_ENDS: [&str; 5] = ["", ".H", ".h", ".nc", ".NC"];
        let is_iso = self.dialect.is_iso();
        let ends: &[&str] = match self.dialect {
            Dialect::Sinumerik => &SINUMERIK_ENDS,
            Dialect::Heidenhain => &HEIDENHAIN_ENDS,
            _ => &ENDS,
        };
        let begin = |source: &SourceFile| match target {
            CallTarget::Word => source.next_o_line(0, name, &["SUB"]),
            CallTarget::Number | CallTarget::File => source.program_line(name),
        };
        let is_searched = |file: &usize| target != CallTarget::File || *file > 0;
        for file in [self.here.file].into_iter().chain(0..self.sources.len()).filter(is_searched) {
            if let Some(line) = begin(&self.sources[file]) {
                return Ok(Origin { file, line: line + 1 });
            }
        }
        let bare = name.trim_matches(['<', '>']);
        let is_name = !bare.is_empty() && !bare.contains(['/', '\\']);
        let o_names = [
            format!("{bare:0>4}"),
            format!("O{bare}"),
            format!("o{bare}"),
            format!("O{bare:0>4}"),
            format!("o{bare:0>4}"),
        ];
        let stems = [bare.to_lowercase(), bare.to_owned()];
        let stems = stems.iter().chain(o_names.iter().filter(|_| is_iso)).filter(|_| is_name);
        for name in stems.flat_map(|stem| ends.iter().map(move |end| format!("{stem}{end}"))) {
            let file = match self.files.iter().skip(1).position(|file| file.name == name) {
                Some(read) => read + 1,
                None => {
                    let Some(bytes) = (self.beside)(&name) else { continue };
                    self.sources.push(SourceFile::new(&bytes, self.dialect));
                    self.files.push(CalledFile { name, bytes });
                    self.sources.len() - 1
                }
            };
            return Ok(Origin { file, line: begin(&self.sources[file]).map_or(0, |line| line + 1) });
        }
        let expected = match self.dialect {
            Dialect::Sinumerik => format!("the file {bare}.SPF"),
            Dialect::Heidenhain => "a file of this name".to_owned(),
            _ => format!("O{bare}, a file of this name, or {bare} in calls_kept of [gcode] if it moves nothing"),
        };
        Err(Fault::Macro(MacroFault::NoSubprogram { name: bare.to_owned(), expected }))
    }

    /// Calls the subprogram at `begin` for `times` runs, with local variables if there are `arguments`; goes on with the next line if that is
    /// not even once. `Err` if calls nest too deep.
    pub(crate) fn call(&mut self, begin: Origin, times: u32, arguments: Option<Arguments>) -> Result<Next, Fault> {
        if times == 0 {
            return Ok(Next::Line);
        }
        if self.calls.len() == DEEPEST {
            return Err(Fault::Macro(MacroFault::TooDeep { most: DEEPEST }));
        }
        if let Some(arguments) = &arguments {
            self.variables.call(arguments);
        }
        let return_to = Origin { line: self.here.line + 1, ..self.here };
        self.call_frames.push(CallFrame::default());
        self.calls.push(Call { return_to, begin, runs_left: times, arguments });
        self.here = begin;
        Ok(Next::At(begin.line))
    }

    /// Ends a run of a subprogram: goes on with the next run, or behind the call. `Err` without a call, or if its arguments have changed.
    pub(crate) fn end_call(&mut self) -> Result<Next, Fault> {
        if !self.calls.is_empty() {
            self.restore_at_return();
        }
        let Some(call) = self.calls.last_mut() else { return Err(Fault::Macro(MacroFault::NoCall)) };
        call.runs_left -= 1;
        if call.runs_left > 0 {
            if let Some(arguments) = call.arguments.as_ref().filter(|_| self.dialect == Dialect::Sinumerik) {
                self.variables.end_call();
                self.variables.call(arguments);
            } else if call.arguments.as_ref().is_some_and(|arguments| !self.variables.has_arguments(arguments)) {
                return Err(Fault::Macro(MacroFault::ChangedArguments));
            }
            self.here = call.begin;
            return Ok(Next::At(call.begin.line));
        }
        self.here = call.return_to;
        let (line, has_scope) = (call.return_to.line, call.arguments.is_some());
        self.calls.pop();
        self.sections.retain(|section| section.depth <= self.calls.len());
        self.call_frames.pop();
        if has_scope {
            self.variables.end_call();
        }
        Ok(Next::At(line))
    }
}

/// Returns the whole number after `letter`, `None` without the letter. `Err`, with its byte, if it is repeated or not whole.
fn whole_number(words: &[CalledWord], letter: char) -> Result<Option<u32>, (usize, Fault)> {
    let mut found = words.iter().filter(|word| word.letter == letter);
    let Some(word) = found.next() else { return Ok(None) };
    if let Some(second) = found.next() {
        return Err((second.span.start, Fault::Repeated { letter }));
    }
    match word.value {
        Some(value) if value.fract() == 0.0 && (0.0..=1e8).contains(&value) => Ok(Some(value as u32)),
        _ => Err((word.span.start, Fault::NotWhole { letter })),
    }
}
