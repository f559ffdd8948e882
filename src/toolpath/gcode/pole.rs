//! Centres of arcs that lines of their own set (Heidenhain's CC): read, and moved with the first arc about them.

use nalgebra::Vector3;

use crate::toolpath::gcode::{
    arc::Centre,
    edit::LineEdit,
    error::{Fault, Refusal},
    interpret::Interpreter,
    lex::Word,
    modal::Modal,
    motion::{Known, Motion},
    place::Place,
    request::Request,
    walk::Block,
    writer::{Writer, put_axis},
};

/// A centre that a line sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pole {
    /// mm in the workpiece frame along the two axes of the plane, if it is known.
    place: Option<[f64; 2]>,
    /// Where the tool is on the line.
    start: Known,
    modal: Modal,
    origin: Vector3<f64>,
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
    pub(super) fn set_pole(&mut self, request: &Request, word: &Word) -> Result<Pole, Refusal> {
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

impl Writer<'_> {
    /// Writes a line that sets a centre, moved by `shift`.
    pub fn pole(&mut self, block: &Block, pole: &Pole, shift: Vector3<f64>) {
        let place = Place::new(&pole.modal, &pole.words, pole.origin, self.decimals(pole.modal.unit.mm()));
        let tracked = [0, 1, 2].map(|axis| pole.start[axis].and(self.tracked[axis].or(pole.start[axis])));
        let content = self.program.content(block.line);
        let mut edit = LineEdit::new(content, &pole.words, self.style);
        let [first, second, _] = pole.modal.plane.axes();
        let mut written = [tracked[first], tracked[second]];
        let has_words = edit.find(|word| word.letter == ['X', 'Y', 'Z'][first]).is_some();
        if let Some(at) = pole.place.filter(|_| has_words) {
            for (k, axis) in [first, second].into_iter().enumerate() {
                let reached = place.reach(&pole.words, tracked, axis, at[k] + shift[axis]);
                if let Some(number) = &reached.number {
                    put_axis(&mut edit, axis, number);
                }
                written[k] = reached.at;
            }
        }
        self.pole = written[0].zip(written[1]).filter(|_| pole.place.is_some()).map(|(first, second)| [first, second]);
        self.out.extend(edit.render());
        self.end_line(block, true);
    }
}
