//! A number that writes down what is done with it, at several postures at once.
//!
//! Its lanes are postures. Whatever branches, branches as it would for these postures side by side: where they need
//! different ways, code over [`Real`] goes the way that serves all of them, which has no branches, and that is what is
//! written down.

use std::cell::RefCell;

use super::{
    MAX_LANES, Real,
    operators::operators,
    tape::{Operation, Place, Program, Tape},
};

/// The values of a number at the postures.
type Lanes = [f64; MAX_LANES];

#[derive(Default)]
struct Recording {
    tape: Tape,
    values: Vec<Lanes>,
    /// Inputs by posture.
    inputs: Vec<Vec<f64>>,
    /// Whether something was computed posture by posture, by means that cannot be written down.
    is_broken: bool,
}

thread_local! {
    static RECORDING: RefCell<Recording> = RefCell::default();
}

/// What makes the numbers that `work` returns of its inputs, which `postures` gives, a row for each of [`MAX_LANES`] postures. `None` where
/// that cannot be written down as one list of operations.
pub fn record(postures: &[Vec<f64>], work: impl FnOnce(&[Traced]) -> Option<Vec<Traced>>) -> Option<Program> {
    debug_assert_eq!(postures.len(), MAX_LANES);
    let count = postures.first().map_or(0, Vec::len);
    RECORDING.replace(Recording { inputs: postures.to_vec(), ..Recording::default() });
    let inputs: Vec<Traced> = (0..count as u32).map(|number| put(Operation::Input(number))).collect();
    let outputs = work(&inputs);
    let recording = RECORDING.take();
    let outputs: Vec<Place> = outputs?.into_iter().map(|output| output.0).collect();
    (!recording.is_broken).then(|| recording.tape.program(count, &outputs))
}

fn put(operation: Operation) -> Traced {
    RECORDING.with_borrow_mut(|recording| {
        let place = recording.tape.put(operation);
        for place in recording.values.len()..recording.tape.len() {
            let mut values = [0.0; MAX_LANES];
            for (lane, value) in values.iter_mut().enumerate() {
                let at = |operand: Place| recording.values[operand as usize][lane];
                *value = recording.tape.operation(place as Place).value(&recording.inputs[lane], at);
            }
            recording.values.push(values);
        }
        Traced(place)
    })
}

fn values(number: Traced) -> Lanes {
    RECORDING.with_borrow(|recording| recording.values[number.0 as usize])
}

/// A number of the computation that is being recorded on this thread.
#[derive(Debug, Clone, Copy)]
pub struct Traced(Place);

/// Truth that is known for all postures, or that follows from numbers.
#[derive(Debug, Clone, Copy)]
pub enum TracedMask {
    /// Of each posture, a bit.
    Known(u8),
    /// Where the first is the greater.
    Greater(Traced, Traced),
    /// Where it is no number.
    Nan(Traced),
}

operators! { Traced, - |a| put(Operation::Negative(a.0)),
    Add add |a, b| put(Operation::Sum(a.0, b.0)),
    Sub sub |a, b| put(Operation::Difference(a.0, b.0)),
    Mul mul |a, b| put(Operation::Product(a.0, b.0)),
    Div div |a, b| put(Operation::Quotient(a.0, b.0)),
}

impl Real for Traced {
    const LANES: usize = MAX_LANES;
    type Mask = TracedMask;

    fn splat(value: f64) -> Self {
        put(Operation::Constant(value.to_bits()))
    }

    fn lane(self, lane: usize) -> f64 {
        values(self)[lane]
    }

    fn set_lane(&mut self, _lane: usize, _value: f64) {
        RECORDING.with_borrow_mut(|recording| recording.is_broken = true);
    }

    fn sqrt(self) -> Self {
        put(Operation::Root(self.0))
    }

    fn abs(self) -> Self {
        put(Operation::Size(self.0))
    }

    fn greater(self, other: Self) -> TracedMask {
        TracedMask::Greater(self, other)
    }

    fn is_nan(self) -> TracedMask {
        TracedMask::Nan(self)
    }

    fn select(mask: TracedMask, yes: Self, no: Self) -> Self {
        match mask {
            TracedMask::Known(Self::ALL) => yes,
            TracedMask::Known(0) => no,
            TracedMask::Known(_) => {
                RECORDING.with_borrow_mut(|recording| recording.is_broken = true);
                no
            }
            TracedMask::Greater(a, b) => put(Operation::IfGreater([a.0, b.0, yes.0, no.0])),
            TracedMask::Nan(a) => put(Operation::IfNan([a.0, yes.0, no.0])),
        }
    }

    fn bits(mask: TracedMask) -> u8 {
        let each = |holds: &dyn Fn(usize) -> bool| (0..MAX_LANES).map(|lane| u8::from(holds(lane)) << lane).sum();
        match mask {
            TracedMask::Known(bits) => bits,
            TracedMask::Greater(a, b) => {
                let (a, b) = (values(a), values(b));
                each(&|lane| a[lane] > b[lane])
            }
            TracedMask::Nan(a) => {
                let a = values(a);
                each(&|lane| a[lane].is_nan())
            }
        }
    }

    fn mask(bits: u8) -> TracedMask {
        TracedMask::Known(bits & Self::ALL)
    }

    /// Whether it is the constant zero: one that merely is zero at the postures is not left out.
    fn is_zero(self) -> bool {
        RECORDING.with_borrow(|recording| recording.tape.constant(self.0) == Some(0.0))
    }
}
