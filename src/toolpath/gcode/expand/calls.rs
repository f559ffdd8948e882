//! Subprograms: where they are, and where the flow goes back to.

use crate::toolpath::gcode::{
    error::Fault,
    expand::{
        Origin,
        jumps::Source,
        run::{Next, Run},
    },
};

/// The deepest calls.
const DEEPEST: usize = 50;

/// Where a call comes from, and how often it is still to be done.
#[derive(Debug)]
pub(super) struct Call {
    back: Origin,
    begin: Origin,
    left: u32,
    /// Whether it has variables of its own.
    has_scope: bool,
}

impl Run<'_> {
    /// The first line of a subprogram, in the file or beside it.
    pub(super) fn find(&mut self, name: &str, is_o_word: bool) -> Result<Origin, Fault> {
        let begin = |source: &Source| match is_o_word {
            true => source.o_after(0, name, &["SUB"]),
            false => source.program(name),
        };
        for file in [self.here.file].into_iter().chain(0..self.sources.len()) {
            if let Some(line) = begin(&self.sources[file]) {
                return Ok(Origin { file, line: line + 1 });
            }
        }
        let bare = name.trim_matches(['<', '>']);
        let names =
            [bare.to_lowercase(), bare.to_owned(), format!("O{bare}"), format!("O{bare:0>4}"), format!("o{bare:0>4}")];
        for name in
            names.iter().flat_map(|name| ["", ".ngc", ".nc", ".NC", ".cnc", ".tap"].map(|end| format!("{name}{end}")))
        {
            if let Some(bytes) = (self.beside)(&name) {
                let source = Source::new(&bytes);
                let line = begin(&source).map_or(0, |line| line + 1);
                self.sources.push(source);
                self.files.push(name);
                return Ok(Origin { file: self.sources.len() - 1, line });
            }
        }
        Err(Fault::NoSubprogram { name: bare.to_owned() })
    }

    pub(super) fn call(&mut self, begin: Origin, left: u32, has_scope: bool) -> Result<Next, Fault> {
        if self.calls.len() == DEEPEST {
            return Err(Fault::TooDeep { most: DEEPEST });
        }
        let back = Origin { line: self.here.line + 1, ..self.here };
        self.calls.push(Call { back, begin, left, has_scope });
        self.here = begin;
        Ok(Next::At(begin.line))
    }

    pub(super) fn end_call(&mut self) -> Result<Next, Fault> {
        let Some(call) = self.calls.last_mut() else { return Err(Fault::NoCall) };
        call.left -= 1;
        if call.left > 0 {
            self.here = call.begin;
            return Ok(Next::At(call.begin.line));
        }
        self.here = call.back;
        let (line, has_scope) = (call.back.line, call.has_scope);
        self.calls.pop();
        if has_scope {
            self.variables.end_call();
        }
        Ok(Next::At(line))
    }
}
