//! Centres of arcs that lines of their own set (Heidenhain's CC).

use nalgebra::Vector3;

use crate::toolpath::{
    model::gcode::{
        arc::Centre,
        error::Fault,
        modal::Modal,
        motion::{Known, Motion},
        refused::Refusal,
        word::Word,
    },
    read::gcode::{interpret::Interpreter, request::Request},
};

/// A centre that a line sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pole {
    /// mm in the workpiece frame along the two axes of the plane, if it is known.
    pub(crate) place: Option<[f64; 2]>,
    /// Where the tool is on the line.
    pub(crate) start: Known,
    pub(crate) modal: Modal,
    pub(crate) origin: Vector3<f64>,
    /// The words of the line.
    pub words: Vec<Word>,
}

impl Pole {
    /// Whether `motion` is an arc about it.
    pub fn is_of(&self, motion: &Motion) -> bool {
        matches!((motion.centre, self.place), (Some(Centre::Pole(centre)), Some(place)) if centre == place)
    }
}

impl Interpreter {
    /// The centre that the line, which `word` begins, gives the arcs that follow; without coordinates it is where the tool is.
    pub(crate) fn set_pole(&mut self, request: &Request, word: &Word) -> Result<Pole, Refusal> {
        let [first, second, normal] = self.modal.plane.axes();
        let axes = request.axes();
        if axes[normal].is_some() || axes[first].is_some() != axes[second].is_some() {
            return Err(word.refuse(Fault::PoleAxes));
        }
        let origin = if axes[first].is_some() { self.origin(word)? } else { Vector3::zeros() };
        let at = self.end(axes, origin)?;
        let place = at[first].zip(at[second]).map(|(first, second)| [first, second]);
        self.pole = place;
        Ok(Pole { place, start: self.position, modal: self.modal, origin, words: Vec::new() })
    }
}
