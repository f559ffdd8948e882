//! G-code programs of 3-axis mills: read, followed, and written back with moved points.
//!
//! What is followed of ISO code is the RS-274 subset a 3-axis mill uses; of other dialects ([`Dialect`]) it is in the user
//! guide. Everything else is refused by name; nothing that could change where the tool goes is ignored.
//!
//! | followed | meaning |
//! |---|---|
//! | G0 G1 G2 G3 | rapid, line, arcs (helical too; centre by I J K or radius by R) |
//! | G73 G74 G76 G81 … G86 G89, G98 G99, G80 | cycles, where they end, no cycle |
//! | G17 G18 G19 | plane of arcs |
//! | G20 G21 | inch, mm |
//! | G54 … G59.3, G54.1 P, G110 … G129, G15 H, G10 L2 L20, G52, G92 … G92.3 | zeros of the coordinates, see [`GcodeOptions::work_offsets_mm`] |
//! | G90 G91, G90.1 G91.1 | absolute or incremental coordinates, and arc centres |
//! | F with G93 G94 G95, S with G96 G97 | feed, spindle speed |
//! | A B C | as [`Rotary`] says; where it says nothing they must keep one value; U V W must be 0 |
//! | G43.4, G43, G49 | whether X, Y and Z are those of the tip while A, B and C turn |
//! | G41 G42, RL RR | where radii are given ([`GcodeOptions::cutter_radii_mm`]), written out as the path of the tool centre |
//! | G28 G28.2 G30 G53; `$H` `$J` | copied as they are; the axes they move are unknown until a G0 or G1 gives them again |
//! | other G, D E H M N O P Q T words that do not move the tip; `$` `?` `!` `~` lines | copied as they are |
//! | `( )`, `;`, `%`, `/`, blank lines | copied as they are; [`BlockDelete`] says whether `/` lines count |
//!
//! Decisions, where controllers differ:
//! - Numbers without a decimal point are whole units: `X10` is 10 mm in G21.
//! - Before the first word that says otherwise: G0, G17, G54, G90, G91.1, G94, G97, G98, [`GcodeOptions::unit`].
//! - Coordinates are those of the tool tip; G43 and G49 do not move the path.
//! - A tool change (M6) leaves the tool where it was, and puts the tool of the last T into the spindle; before the first M6,
//!   that of the last T is there. M2, M30 and the second % end the program; motions after them are refused.
//! - The unit on a line applies to the F on the same line.
//! - A rapid move is one path point, its end. Controllers need not drive it straight.
//! - Where the tool is is not known until G0 and G1 have given X, Y and Z: motions before stay as they are ([`Notes`]).

#[cfg(not(target_family = "wasm"))]
pub use super::write::gcode::feeds::{FedLine, FeedFault};
pub use super::{
    expand::SiblingFiles,
    model::gcode::{
        dialect::Dialect,
        error::{Fault, GcodeError},
        foreign::Foreign,
        macro_fault::MacroFault,
        options::{ArcCentres, BlockDelete, Expand, GcodeOptions, LengthUnit, Notes},
        radius::{CutterOf, RadiusFault},
        refused::{ArcFault, Contradiction, Unsupported},
        rotary::{Rotary, RotaryAxis, RotaryColumn, RotarySide},
        work_offset::WorkOffset,
    },
    read::gcode::{GcodeProgram, tool_comments::tool_comments, written_out::CalledFile},
    write::gcode::fold::{Calls, FoldFailure, FoldFault},
};
