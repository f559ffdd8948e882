//! Data types of G-code programs: dialects, words, modal state, motions, arcs, rotary axes, work offsets, options and faults.

pub(crate) mod arc;
pub(crate) mod dialect;
pub(crate) mod error;
pub(crate) mod foreign;
pub(crate) mod inclined;
pub(crate) mod macro_fault;
pub(crate) mod modal;
pub(crate) mod motion;
pub(crate) mod options;
pub(crate) mod radius;
pub(crate) mod refused;
pub(crate) mod rotary;
pub(crate) mod word;
pub(crate) mod work_offset;

pub(crate) use {
    arc::*, dialect::*, error::*, foreign::*, inclined::*, macro_fault::*, modal::*, motion::*, options::*, radius::*,
    refused::*, rotary::*, word::*, work_offset::*,
};
