//! A computation as a list of operations without branches: simplified as it is recorded, stripped of what is unused, and evaluated.

use std::collections::HashMap;

/// Index of an operation in its list.
pub type OperationIndex = u32;

/// An operation that makes one number of others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation {
    /// The input of this index.
    Input(u32),
    /// The `f64` of these bits.
    Constant(u64),
    /// `a + b`.
    Sum(OperationIndex, OperationIndex),
    /// `a - b`.
    Difference(OperationIndex, OperationIndex),
    /// `a * b`.
    Product(OperationIndex, OperationIndex),
    /// `a / b`.
    Quotient(OperationIndex, OperationIndex),
    /// `-a`.
    Negative(OperationIndex),
    /// Square root.
    Root(OperationIndex),
    /// Absolute value.
    Size(OperationIndex),
    /// `if a > b { yes } else { no }` of `[a, b, yes, no]`.
    IfGreater([OperationIndex; 4]),
    /// `if a is NaN { yes } else { no }` of `[a, yes, no]`.
    IfNan([OperationIndex; 3]),
}

impl Operation {
    /// Indices of its operands.
    pub fn operands(&self) -> impl Iterator<Item = OperationIndex> {
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

    /// The operation with each operand replaced by its entry in `indices`.
    fn renumbered(&self, indices: &[OperationIndex]) -> Self {
        use Operation::*;
        let at = |index: OperationIndex| indices[index as usize];
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

    /// Value of the operation, with `inputs` by number and the values of its operands as `value_of` returns them.
    pub fn value(&self, inputs: &[f64], value_of: impl Fn(OperationIndex) -> f64) -> f64 {
        use Operation::*;
        match *self {
            Input(number) => inputs[number as usize],
            Constant(bits) => f64::from_bits(bits),
            Sum(a, b) => value_of(a) + value_of(b),
            Difference(a, b) => value_of(a) - value_of(b),
            Product(a, b) => value_of(a) * value_of(b),
            Quotient(a, b) => value_of(a) / value_of(b),
            Negative(a) => -value_of(a),
            Root(a) => value_of(a).sqrt(),
            Size(a) => value_of(a).abs(),
            IfGreater([a, b, yes, no]) => value_of(if value_of(a) > value_of(b) { yes } else { no }),
            IfNan([a, yes, no]) => value_of(if value_of(a).is_nan() { yes } else { no }),
        }
    }
}

/// Operations in the order in which they were recorded, none of them twice.
/// Simplifying them changes no bit of a finite number but the sign of a zero.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    operations: Vec<Operation>,
    indices: HashMap<Operation, OperationIndex>,
}

impl Tape {
    /// Number of operations.
    pub fn len(&self) -> usize {
        self.operations.len()
    }

    /// The operation at `index`.
    pub fn operation(&self, index: OperationIndex) -> &Operation {
        &self.operations[index as usize]
    }

    /// Value of the operation at `index`, if it is a constant.
    pub fn constant(&self, index: OperationIndex) -> Option<f64> {
        match self.operations[index as usize] {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Inserts an operation, simplified, if it is new; returns its index.
    pub fn insert(&mut self, operation: Operation) -> OperationIndex {
        use Operation::*;
        if !matches!(operation, Input(_) | Constant(_)) && operation.operands().all(|a| self.constant(a).is_some()) {
            let value = operation.value(&[], |index| self.constant(index).unwrap_or(f64::NAN));
            return self.insert(Constant(value.to_bits()));
        }
        match operation {
            Sum(a, b) => self.sum(a, b),
            Difference(a, b) => self.difference(a, b),
            Product(a, b) => self.product(a, b),
            Quotient(a, _) if self.is_constant(a, 0.0) => a,
            Quotient(a, b) if self.is_constant(b, 1.0) => a,
            Negative(a) => match self.operations[a as usize] {
                Negative(b) => b,
                Difference(b, c) => self.insert_as_is(Difference(c, b)),
                _ => self.insert_as_is(Negative(a)),
            },
            IfGreater([_, _, yes, no]) if yes == no => yes,
            other => self.insert_as_is(other),
        }
    }

    /// Whether the operation at `index` is the constant `value`.
    fn is_constant(&self, index: OperationIndex, value: f64) -> bool {
        self.constant(index) == Some(value)
    }

    /// Operand of the operation at `index`, if that is a negation.
    fn negation_operand(&self, index: OperationIndex) -> Option<OperationIndex> {
        match self.operations[index as usize] {
            Operation::Negative(operand) => Some(operand),
            _ => None,
        }
    }

    /// Index of `a + b`, simplified.
    fn sum(&mut self, a: OperationIndex, b: OperationIndex) -> OperationIndex {
        match (self.negation_operand(a), self.negation_operand(b)) {
            _ if self.is_constant(a, 0.0) => b,
            _ if self.is_constant(b, 0.0) => a,
            (_, Some(b)) => self.insert(Operation::Difference(a, b)),
            (Some(a), _) => self.insert(Operation::Difference(b, a)),
            _ => self.insert_as_is(Operation::Sum(a.min(b), a.max(b))),
        }
    }

    /// Index of `a - b`, simplified.
    fn difference(&mut self, a: OperationIndex, b: OperationIndex) -> OperationIndex {
        match (self.negation_operand(a), self.negation_operand(b)) {
            _ if self.is_constant(b, 0.0) => a,
            _ if self.is_constant(a, 0.0) => self.insert(Operation::Negative(b)),
            _ if a == b => self.insert(Operation::Constant(0)),
            (_, Some(b)) => self.insert(Operation::Sum(a, b)),
            _ => self.insert_as_is(Operation::Difference(a, b)),
        }
    }

    /// Index of `a * b`, simplified.
    fn product(&mut self, a: OperationIndex, b: OperationIndex) -> OperationIndex {
        match (self.negation_operand(a), self.negation_operand(b)) {
            _ if self.is_constant(a, 0.0) || self.is_constant(b, 0.0) => self.insert(Operation::Constant(0)),
            _ if self.is_constant(a, 1.0) => b,
            _ if self.is_constant(b, 1.0) => a,
            _ if self.is_constant(a, -1.0) => self.insert(Operation::Negative(b)),
            _ if self.is_constant(b, -1.0) => self.insert(Operation::Negative(a)),
            (Some(a), _) => self.negative_product(a, b),
            (_, Some(b)) => self.negative_product(a, b),
            _ => self.insert_as_is(Operation::Product(a.min(b), a.max(b))),
        }
    }

    /// Index of `-(a * b)`, simplified.
    fn negative_product(&mut self, a: OperationIndex, b: OperationIndex) -> OperationIndex {
        let product = self.insert(Operation::Product(a, b));
        self.insert(Operation::Negative(product))
    }

    /// Inserts an operation as it is, if it is new; returns its index.
    fn insert_as_is(&mut self, operation: Operation) -> OperationIndex {
        let next = self.operations.len() as OperationIndex;
        let index = *self.indices.entry(operation).or_insert(next);
        if index == next {
            self.operations.push(operation);
        }
        index
    }

    /// Computation that computes the operations at `outputs` from inputs, whose number is `inputs`, without unused operations.
    pub fn program(&self, inputs: usize, outputs: &[OperationIndex]) -> Computation {
        let mut is_used = vec![false; self.len()];
        for &output in outputs {
            is_used[output as usize] = true;
        }
        for index in (0..self.len()).rev() {
            if is_used[index] {
                for operand in self.operations[index].operands() {
                    is_used[operand as usize] = true;
                }
            }
        }
        let (mut indices, mut operations) = (vec![OperationIndex::MAX; self.len()], Vec::new());
        for index in (0..self.len()).filter(|&index| is_used[index]) {
            indices[index] = operations.len() as OperationIndex;
            operations.push(self.operations[index].renumbered(&indices));
        }
        Computation { inputs, operations, outputs: outputs.iter().map(|&output| indices[output as usize]).collect() }
    }
}

/// A computation without branches: operations in a fixed order.
#[derive(Debug, Clone, PartialEq)]
pub struct Computation {
    /// Number of inputs.
    pub inputs: usize,
    /// Operations, each after its operands.
    pub operations: Vec<Operation>,
    /// Indices of the operations that give the outputs.
    pub outputs: Vec<OperationIndex>,
}

impl Computation {
    /// Outputs for `inputs`, in the order of [`Computation::outputs`]; `values` is storage for the values of all operations.
    pub fn evaluate(&self, inputs: &[f64], values: &mut Vec<f64>) -> Vec<f64> {
        values.clear();
        for operation in &self.operations {
            let value = operation.value(inputs, |index| values[index as usize]);
            values.push(value);
        }
        self.outputs.iter().map(|&output| values[output as usize]).collect()
    }

    /// Number of operations that compute, without inputs and constants.
    pub fn operation_count(&self) -> usize {
        let is_leaf = |operation: &&Operation| matches!(operation, Operation::Input(_) | Operation::Constant(_));
        self.operations.len() - self.operations.iter().filter(is_leaf).count()
    }
}
