//! Programs of poses: KUKA KRL, ABB RAPID, FANUC listings, URScript, and APT or CLDATA of CAM systems. Read, followed, and written back with moved points.
//!
//! What a statement means is followed, or it is refused with file, line and statement; all that does not move the tool is copied as it stands. A
//! reader for each language gives the statements that move the tool one after another (`statement.rs`); what they lead to, and how they are
//! written, is the same for all. A program is held as its bytes, and what a statement does is found anew whenever it is walked through.
//!
//! Decisions:
//! - Positions are those of the tool tip. The orientation of a robot's tool is that of the frame the program has of it,
//!   N; `R_WP = R_WB R_BN R_NP` with the base B in force and [`RobotOptions::tool_rotation`] for `R_PN` where the
//!   program does not say it. APT gives the axis of the tool.
//! - Where nothing else is said, the base of the first motion is the workpiece frame W ([`RobotOptions::bases`]).
//! - A motion from point to point (PTP, MoveJ, RAPID in APT) is one path point, its end, at which nothing is cut.
//! - Where the tool is is not known until a pose says it in full, and after motions to positions of joints: motions
//!   from there stay as they are, and the one that says it again has its end only.
//! - The orientation turns evenly from the start of a motion to its end.

pub use super::{
    model::robot::{
        arm::{ArmData, ArmPosture},
        error::{RobotError, RobotFault},
        language::{CutcomPoints, Language, RobotOptions},
        rotation::{abc_of_rotation, rotation_of_abc},
    },
    read::robot::{RobotProgram, walk::RobotNotes},
};
