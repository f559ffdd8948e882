//! A number that records the operations done with it, at several postures at once.
//!
//! Its lanes are postures. Whatever branches, branches as it would for these postures side by side: where they need different ways, code over
//! [`Real`] goes the way that serves all of them, which has no branches, and that is what is written down.

use std::cell::RefCell;

use super::{
    MAX_LANES, Real,
    operators::operators,
    tape::{Computation, Operation, OperationIndex, Tape},
};

/// Values of a number at the postures.
type Lanes = [f64; MAX_LANES];

/// The computation that is being recorded on a thread.
#[derive(Default)]
struct Recording {
    tape: Tape,
    values: Vec<Lanes>,
    /// Input values of each posture.
    inputs: Vec<Vec<f64>>,
    /// Whether something was computed posture by posture, which cannot be recorded.
    is_broken: bool,
}

thread_local! {
    static RECORDING: RefCell<Recording> = RefCell::default();
}

/// Records what `work` computes from its inputs at [`MAX_LANES`] `postures` (rows of input values); `None` if that is not one list of operations.
pub fn record(postures: &[Vec<f64>], work: impl FnOnce(&[Traced]) -> Option<Vec<Traced>>) -> Option<Computation> {
    debug_assert_eq!(postures.len(), MAX_LANES);
    let count = postures.first().map_or(0, Vec::len);
    RECORDING.replace(Recording { inputs: postures.to_vec(), ..Recording::default() });
    let inputs: Vec<Traced> = (0..count as u32).map(|number| record_operation(Operation::Input(number))).collect();
    let outputs = work(&inputs);
    let recording = RECORDING.take();
    let outputs: Vec<OperationIndex> = outputs?.into_iter().map(|output| output.0).collect();
    (!recording.is_broken).then(|| recording.tape.program(count, &outputs))
}

/// Records an operation, with its values at the postures.
fn record_operation(operation: Operation) -> Traced {
    RECORDING.with_borrow_mut(|recording| {
        let index = recording.tape.insert(operation);
        for index in recording.values.len()..recording.tape.len() {
            let mut values = [0.0; MAX_LANES];
            for (lane, value) in values.iter_mut().enumerate() {
                let at = |operand: OperationIndex| recording.values[operand as usize][lane];
                *value = recording.tape.operation(index as OperationIndex).value(&recording.inputs[lane], at);
            }
            recording.values.push(values);
        }
        Traced(index)
    })
}

/// Values of a recorded number at the postures.
fn values_of(number: Traced) -> Lanes {
    RECORDING.with_borrow(|recording| recording.values[number.0 as usize])
}

/// A number of the computation that is being recorded on this thread.
#[derive(Debug, Clone, Copy)]
pub struct Traced(OperationIndex);

/// Mask that is known for each posture, or that is a comparison of recorded numbers.
#[derive(Debug, Clone, Copy)]
pub enum TracedMask {
    /// A bit for each posture.
    Known(u8),
    /// Where the first number is the greater.
    Greater(Traced, Traced),
    /// Where the number is NaN.
    Nan(Traced),
}

operators! { Traced, - |a| record_operation(Operation::Negative(a.0)),
    Add add |a, b| record_operation(Operation::Sum(a.0, b.0)),
    Sub sub |a, b| record_operation(Operation::Difference(a.0, b.0)),
    Mul mul |a, b| record_operation(Operation::Product(a.0, b.0)),
    Div div |a, b| record_operation(Operation::Quotient(a.0, b.0)),
}

impl Real for Traced {
    const LANES: usize = MAX_LANES;
    type Mask = TracedMask;

    fn splat(value: f64) -> Self {
        record_operation(Operation::Constant(value.to_bits()))
    }

    fn lane(self, lane: usize) -> f64 {
        values_of(self)[lane]
    }

    fn set_lane(&mut self, _lane: usize, _value: f64) {
        RECORDING.with_borrow_mut(|recording| recording.is_broken = true);
    }

    fn sqrt(self) -> Self {
        record_operation(Operation::Root(self.0))
    }

    fn abs(self) -> Self {
        record_operation(Operation::Size(self.0))
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
            TracedMask::Greater(a, b) => record_operation(Operation::IfGreater([a.0, b.0, yes.0, no.0])),
            TracedMask::Nan(a) => record_operation(Operation::IfNan([a.0, yes.0, no.0])),
        }
    }

    fn mask_to_bits(mask: TracedMask) -> u8 {
        let lane_bits = |holds: &dyn Fn(usize) -> bool| (0..MAX_LANES).map(|lane| u8::from(holds(lane)) << lane).sum();
        match mask {
            TracedMask::Known(bits) => bits,
            TracedMask::Greater(a, b) => {
                let (a, b) = (values_of(a), values_of(b));
                lane_bits(&|lane| a[lane] > b[lane])
            }
            TracedMask::Nan(a) => {
                let a = values_of(a);
                lane_bits(&|lane| a[lane].is_nan())
            }
        }
    }

    fn mask_from_bits(bits: u8) -> TracedMask {
        TracedMask::Known(bits & Self::ALL)
    }

    /// Whether it is the constant zero: a number that merely is zero at the postures is not left out.
    fn all_zero(self) -> bool {
        RECORDING.with_borrow(|recording| recording.tape.constant(self.0) == Some(0.0))
    }
}
