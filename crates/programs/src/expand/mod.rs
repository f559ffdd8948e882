//! Expansion of programs into plain motion: calls, loops and jumps are followed, expressions evaluated, cycles written as moves.

use crate::{
    expand::{
        centre_path::RadiiInUse,
        cycles::WithoutCycles,
        switches::{Switches, take_switches},
    },
    model::{
        MAX_MIB,
        gcode::{Dialect, Fault, GcodeError, GcodeOptions, MacroFault, RadiusFault, Refusal, Unsupported},
    },
    read::gcode::{Expansion, GcodeProgram, dialect, lines::Lines},
};

mod beside;
mod calls;
mod centre_path;
mod contour;
mod cycles;
pub(crate) mod edit;
mod expression;
mod flow;
mod frames;
mod geometry;
mod heidenhain;
mod heidenhain_cycles;
mod heidenhain_holes;
mod jumps;
pub(crate) mod line;
mod modes;
#[cfg(not(target_family = "wasm"))]
pub(crate) mod robot;
pub(crate) mod run;
mod sinumerik;
mod sinumerik_cycles;
mod sinumerik_holes;
mod switches;
pub(crate) mod variables;

/// Refuses lines of more than [`MAX_MIB`] in all, those run or written out; `asked` says of what was asked for is still to be done.
pub(crate) fn check_length(bytes: usize, asked: impl FnOnce() -> String) -> Result<(), Fault> {
    match bytes > MAX_MIB << 20 {
        true => Err(Fault::Macro(MacroFault::TooManyBytes { asked: asked() })),
        false => Ok(()),
    }
}

/// Bytes of a file beside the program by its name, if there is one.
pub type SiblingFiles<'a> = dyn Fn(&str) -> Option<Vec<u8>> + 'a;

impl GcodeProgram {
    /// Expands a program (calls, loops, jumps, expressions, cycles) and reads the result as [`GcodeProgram::parse`] does; a comment at its top
    /// says so. `beside` gives files that it may call. `Err`, with the line in its original file, for what cannot be followed.
    pub fn parse_expanded(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &SiblingFiles<'_>,
    ) -> Result<GcodeProgram, GcodeError> {
        GcodeProgram::parse_expansion(source.into(), name, options, beside, false)
    }

    /// Expands a program as [`GcodeProgram::parse_expanded`] does, but leaves cycles, and calls stay where they can when it is rewritten
    /// ([`GcodeProgram::folded_calls`]). `Err` for what cannot be followed.
    pub fn parse_with_calls(
        source: impl Into<Vec<u8>>,
        name: &str,
        options: &GcodeOptions,
        beside: &SiblingFiles<'_>,
    ) -> Result<GcodeProgram, GcodeError> {
        GcodeProgram::parse_expansion(source.into(), name, options, beside, true)
    }

    /// Expands and reads a program; if `keeps_calls`, its cycles are not expanded.
    fn parse_expansion(
        source: Vec<u8>,
        name: &str,
        options: &GcodeOptions,
        beside: &SiblingFiles<'_>,
        keeps_calls: bool,
    ) -> Result<GcodeProgram, GcodeError> {
        let dialect = dialect::resolve_dialect(&source, name, options.dialect)?;
        let options = &GcodeOptions { dialect: Some(dialect), ..options.clone() };
        let (mut bytes, mut expansion) = run::Run::new(source, name, options, beside).run_to_end()?;
        let mut switches = Switches::new();
        if options.cutter_radii_mm.is_some() {
            switches = take_switches(&mut bytes, dialect, options).map_err(|(line, refusal)| {
                let content = &bytes[Lines::split(&bytes).content(line)];
                expansion.relocate(refusal.locate(name, line + 1, content).with_dialect(dialect))
            })?;
        }
        // The lines that a stage writes, by the lines that it read.
        let compose = |expansion: &mut Expansion, switches: &mut Switches, lines: &[usize]| {
            expansion.compose(lines);
            let mut before = std::mem::take(switches);
            switches.extend(lines.iter().enumerate().filter_map(|(line, from)| Some((line, before.remove(from)?))));
        };
        let count = switches.len();
        let plain = match dialect.is_iso() {
            true => frames::plain_coordinates(&bytes, name, options),
            false => Ok(None),
        };
        let plain = plain.map_err(|fault| expansion.relocate(fault))?;
        let has_plain = plain.is_some();
        if let Some((moves, lines)) = plain {
            compose(&mut expansion, &mut switches, &lines);
            bytes = moves;
        }
        if !dialect.is_iso() {
            // Cycles that are not known are left in place, and refused when the program is read.
            let without_cycles = dialect.without_cycles(&bytes, options).map_err(|(line, refusal)| {
                let content = &bytes[Lines::split(&bytes).content(line)];
                expansion.relocate(refusal.locate(name, line + 1, content).with_dialect(dialect))
            })?;
            let has_cycles = without_cycles.is_some();
            if let Some((moves, lines)) = without_cycles {
                bytes = moves;
                compose(&mut expansion, &mut switches, &lines);
            }
            let (moves, lines, is_changed) =
                contour::follow(&bytes, dialect, options.block_delete).map_err(|(line, refusal)| {
                    let content = &bytes[Lines::split(&bytes).content(line)];
                    expansion.relocate(refusal.locate(name, line + 1, content).with_dialect(dialect))
                })?;
            expansion.keeps_calls = keeps_calls && !is_changed && !has_cycles && count == 0;
            if is_changed {
                bytes = moves;
                compose(&mut expansion, &mut switches, &lines);
            }
        } else if keeps_calls {
            // Lines in rotated coordinates are not those that were called.
            expansion.keeps_calls = !has_plain && count == 0;
        } else {
            let program = GcodeProgram::parse(bytes, name, options).map_err(|fault| expansion.relocate(fault))?;
            let without_cycles = program.without_cycles().map_err(|fault| expansion.relocate(fault))?;
            bytes = without_cycles.map_or(program.source, |(moves, lines)| {
                compose(&mut expansion, &mut switches, &lines);
                moves
            });
        }
        let mut cutter_radii_mm = RadiiInUse::new();
        if count > 0 {
            let program = GcodeProgram::parse(bytes, name, options).map_err(|fault| expansion.relocate(fault))?;
            if switches.len() < count {
                // Its line has become nothing.
                let refusal = Refusal::new(0..0, Fault::Unsupported(Unsupported::CutterCompensation));
                return Err(expansion.relocate(refusal.locate(name, 1, b"")));
            }
            let (moves, lines, radii) = program.with_centre_path(&switches).map_err(|mut fault| {
                if let Fault::Radius(RadiusFault::CutsInto { line }) = &mut fault.fault {
                    *line = expansion.line_of(*line);
                }
                expansion.relocate(fault)
            })?;
            expansion.compose(&lines);
            (bytes, cutter_radii_mm) = (moves, radii);
        }
        expansion.add_header(&mut bytes, dialect);
        let program = GcodeProgram::parse(bytes, name, options).map_err(|fault| expansion.relocate(fault))?;
        Ok(program.expanded_by(expansion, cutter_radii_mm))
    }

    /// Returns the program with its `expansion`: notes have the lines of the files that were expanded, and the radii that were written out.
    fn expanded_by(mut self, expansion: Expansion, cutter_radii_mm: RadiiInUse) -> Self {
        let chosen = self.notes.chosen_angles.iter_mut().map(|(line, _)| line);
        for line in self.notes.unlocated_lines.iter_mut().chain(chosen) {
            *line = expansion.line_of(*line);
        }
        if let Some((_, line)) = &mut self.notes.assumed_unit {
            *line = expansion.line_of(*line);
        }
        self.notes.cutter_radii_mm = cutter_radii_mm;
        self.own_format = self.own_format.at_most(expansion.decimals);
        self.notes.written_out = Some([expansion.lines, expansion.origins.len()]);
        self.expansion = Some(expansion);
        self
    }
}

impl Dialect {
    /// Returns a program not in ISO code with its cycles as moves, and the index of the line each line comes from; `None` without cycles.
    /// `Err` gives the index of the line with a cycle that cannot be.
    pub(crate) fn without_cycles(
        self,
        source: &[u8],
        options: &GcodeOptions,
    ) -> Result<Option<WithoutCycles>, (usize, Refusal)> {
        match self {
            Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => Ok(None),
            Dialect::Sinumerik => sinumerik_cycles::expand_cycles(source, options),
            Dialect::Heidenhain => heidenhain_cycles::expand_cycles(source, options.block_delete),
        }
    }
}
