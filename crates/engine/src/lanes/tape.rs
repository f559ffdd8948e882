//! A computation as a list of operations without branches: simplified as it is written down, evaluated, and what nobody uses left out.

use std::collections::HashMap;

/// Number of an operation in its list.
pub type Place = u32;

/// What makes one number of others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation {
    /// The input of this number.
    Input(u32),
    /// The number of these bits.
    Constant(u64),
    /// `a + b`.
    Sum(Place, Place),
    /// `a - b`.
    Difference(Place, Place),
    /// `a * b`.
    Product(Place, Place),
    /// `a / b`.
    Quotient(Place, Place),
    /// `-a`.
    Negative(Place),
    /// Square root.
    Root(Place),
    /// Size without sign.
    Size(Place),
    /// `if a > b { yes } else { no }` of `[a, b, yes, no]`.
    IfGreater([Place; 4]),
    /// `if a is NaN { yes } else { no }` of `[a, yes, no]`.
    IfNan([Place; 3]),
}

impl Operation {
    /// The numbers it is made of.
    pub fn operands(&self) -> impl Iterator<Item = Place> {
        use Operation::*;
        let all = match *self {
            Input(_) | Constant(_) => [None; 4],
            Sum(a, b) | Difference(a, b) | Product(a, b) | Quotient(a, b) => [Some(a), Some(b), None, None],
            Negative(a) | Root(a) | Size(a) => [Some(a), None, None, None],
            IfGreater(all) => all.map(Some),
            IfNan([a, yes, no]) => [Some(a), Some(yes), Some(no), None],
        };
        all.into_iter().flatten()
    }

    /// The same of operands that have moved to `places`.
    fn moved(&self, places: &[Place]) -> Self {
        use Operation::*;
        let at = |place: Place| places[place as usize];
        match *self {
            Input(_) | Constant(_) => *self,
            Sum(a, b) => Sum(at(a), at(b)),
            Difference(a, b) => Difference(at(a), at(b)),
            Product(a, b) => Product(at(a), at(b)),
            Quotient(a, b) => Quotient(at(a), at(b)),
            Negative(a) => Negative(at(a)),
            Root(a) => Root(at(a)),
            Size(a) => Size(at(a)),
            IfGreater(all) => IfGreater(all.map(at)),
            IfNan(all) => IfNan(all.map(at)),
        }
    }

    /// Its value, where `at` has those of its operands.
    pub fn value(&self, inputs: &[f64], at: impl Fn(Place) -> f64) -> f64 {
        use Operation::*;
        match *self {
            Input(number) => inputs[number as usize],
            Constant(bits) => f64::from_bits(bits),
            Sum(a, b) => at(a) + at(b),
            Difference(a, b) => at(a) - at(b),
            Product(a, b) => at(a) * at(b),
            Quotient(a, b) => at(a) / at(b),
            Negative(a) => -at(a),
            Root(a) => at(a).sqrt(),
            Size(a) => at(a).abs(),
            IfGreater([a, b, yes, no]) => at(if at(a) > at(b) { yes } else { no }),
            IfNan([a, yes, no]) => at(if at(a).is_nan() { yes } else { no }),
        }
    }
}

/// Operations in the order in which they were made, none of them twice.
///
/// What is left out of them changes no bit of a finite number but the sign of a zero.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    operations: Vec<Operation>,
    places: HashMap<Operation, Place>,
}

impl Tape {
    /// Number of operations.
    pub fn len(&self) -> usize {
        self.operations.len()
    }

    /// The operation at `place`.
    pub fn operation(&self, place: Place) -> &Operation {
        &self.operations[place as usize]
    }

    /// The constant at `place`, if it is one.
    pub fn constant(&self, place: Place) -> Option<f64> {
        match self.operations[place as usize] {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Where the number that `operation` makes stands; written down if it is new.
    pub fn put(&mut self, operation: Operation) -> Place {
        use Operation::*;
        if !matches!(operation, Input(_) | Constant(_)) && operation.operands().all(|a| self.constant(a).is_some()) {
            let value = operation.value(&[], |place| self.constant(place).unwrap_or(f64::NAN));
            return self.put(Constant(value.to_bits()));
        }
        match operation {
            Sum(a, b) => self.sum(a, b),
            Difference(a, b) => self.difference(a, b),
            Product(a, b) => self.product(a, b),
            Quotient(a, _) if self.is(a, 0.0) => a,
            Quotient(a, b) if self.is(b, 1.0) => a,
            Negative(a) => match self.operations[a as usize] {
                Negative(b) => b,
                Difference(b, c) => self.write(Difference(c, b)),
                _ => self.write(Negative(a)),
            },
            IfGreater([_, _, yes, no]) if yes == no => yes,
            other => self.write(other),
        }
    }

    fn is(&self, place: Place, value: f64) -> bool {
        self.constant(place) == Some(value)
    }

    fn negated(&self, place: Place) -> Option<Place> {
        match self.operations[place as usize] {
            Operation::Negative(of) => Some(of),
            _ => None,
        }
    }

    fn sum(&mut self, a: Place, b: Place) -> Place {
        match (self.negated(a), self.negated(b)) {
            _ if self.is(a, 0.0) => b,
            _ if self.is(b, 0.0) => a,
            (_, Some(b)) => self.put(Operation::Difference(a, b)),
            (Some(a), _) => self.put(Operation::Difference(b, a)),
            _ => self.write(Operation::Sum(a.min(b), a.max(b))),
        }
    }

    fn difference(&mut self, a: Place, b: Place) -> Place {
        match (self.negated(a), self.negated(b)) {
            _ if self.is(b, 0.0) => a,
            _ if self.is(a, 0.0) => self.put(Operation::Negative(b)),
            _ if a == b => self.put(Operation::Constant(0)),
            (_, Some(b)) => self.put(Operation::Sum(a, b)),
            _ => self.write(Operation::Difference(a, b)),
        }
    }

    fn product(&mut self, a: Place, b: Place) -> Place {
        match (self.negated(a), self.negated(b)) {
            _ if self.is(a, 0.0) || self.is(b, 0.0) => self.put(Operation::Constant(0)),
            _ if self.is(a, 1.0) => b,
            _ if self.is(b, 1.0) => a,
            _ if self.is(a, -1.0) => self.put(Operation::Negative(b)),
            _ if self.is(b, -1.0) => self.put(Operation::Negative(a)),
            (Some(a), _) => self.negative_product(a, b),
            (_, Some(b)) => self.negative_product(a, b),
            _ => self.write(Operation::Product(a.min(b), a.max(b))),
        }
    }

    fn negative_product(&mut self, a: Place, b: Place) -> Place {
        let product = self.put(Operation::Product(a, b));
        self.put(Operation::Negative(product))
    }

    fn write(&mut self, operation: Operation) -> Place {
        let next = self.operations.len() as Place;
        let place = *self.places.entry(operation).or_insert(next);
        if place == next {
            self.operations.push(operation);
        }
        place
    }

    /// What makes `outputs` of `inputs` numbers.
    pub fn program(&self, inputs: usize, outputs: &[Place]) -> Program {
        let mut is_used = vec![false; self.len()];
        for &output in outputs {
            is_used[output as usize] = true;
        }
        for place in (0..self.len()).rev() {
            if is_used[place] {
                for operand in self.operations[place].operands() {
                    is_used[operand as usize] = true;
                }
            }
        }
        let (mut places, mut operations) = (vec![Place::MAX; self.len()], Vec::new());
        for place in (0..self.len()).filter(|&place| is_used[place]) {
            places[place] = operations.len() as Place;
            operations.push(self.operations[place].moved(&places));
        }
        Program { inputs, operations, outputs: outputs.iter().map(|&output| places[output as usize]).collect() }
    }
}

/// Numbers made of others by operations in a fixed order.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// How many numbers it is given.
    pub inputs: usize,
    /// Each after those that it uses.
    pub operations: Vec<Operation>,
    /// Where the numbers stand that it gives.
    pub outputs: Vec<Place>,
}

impl Program {
    /// What it gives for `inputs`; `values` is storage.
    pub fn evaluate(&self, inputs: &[f64], values: &mut Vec<f64>) -> Vec<f64> {
        values.clear();
        for operation in &self.operations {
            let value = operation.value(inputs, |place| values[place as usize]);
            values.push(value);
        }
        self.outputs.iter().map(|&output| values[output as usize]).collect()
    }

    /// Number of operations that compute.
    pub fn operation_count(&self) -> usize {
        let is_given = |operation: &&Operation| matches!(operation, Operation::Input(_) | Operation::Constant(_));
        self.operations.len() - self.operations.iter().filter(is_given).count()
    }
}
