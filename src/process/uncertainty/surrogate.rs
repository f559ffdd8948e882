//! Displacements of the tool in all draws, from a few solved ones: a polynomial in compliances and geometry, times the factor of the force.
//!
//! The displacement under one load is `u + (I + E) f (d − u)`: f is the factor of the cutting force, E what the model leaves out
//! ([`ModelError`](super::ModelError)), u the displacement without load and d that under the nominal force, each a sum over the parameters of polynomials of the second degree in the coordinate of one parameter
//! ([`UncertainParameter::coordinate`](super::UncertainParameter::coordinate)), through the nominal value and both [`Response::ENDS`]. What two
//! parameters do to one another is left out: who uses it checks it by draws solved in full.

use nalgebra::Vector3;

use super::{Cause, Draws};
use crate::lanes::{Lanewise, Level, Real};

/// Displacements of the tool tip under one load (O axes, mm): at nominal parameters, and with each parameter alone at its ends.
#[derive(Debug, Clone)]
pub struct Response {
    /// At nominal parameters.
    pub nominal: Vector3<f64>,
    /// For each parameter, at both ends; at one of them where the displacement is taken as linear in it.
    pub ends: Vec<[Option<Vector3<f64>>; 2]>,
}

impl Response {
    /// Standard normal numbers of the ends: the quantiles of 5 % and 95 %.
    pub const ENDS: [f64; 2] = [-1.644_853_626_951_472_2, 1.644_853_626_951_472_2];
}

/// A displacement as a polynomial in the coordinates of the parameters, without products of two.
#[derive(Debug, Clone)]
struct Polynomial {
    constant: Vector3<f64>,
    /// Linear and square coefficient of each parameter.
    terms: Vec<[Vector3<f64>; 2]>,
}

impl Polynomial {
    /// The polynomial through `response`, whose ends are at the coordinates `ends` of each parameter.
    fn through(response: &Response, ends: &[[f64; 2]]) -> Self {
        let term = |(at, x): (&[Option<Vector3<f64>>; 2], &[f64; 2])| {
            // An end that is all but the nominal value says nothing of the slope.
            let is_far = |end: usize| x[end].abs() > 1e-6 * x[0].abs().max(x[1].abs());
            let slope = |end: usize| Some((at[end]? - response.nominal) / x[end]).filter(|_| is_far(end));
            match [slope(0), slope(1)] {
                [Some(below), Some(above)] => {
                    let square = (above - below) / (x[1] - x[0]);
                    [above - square * x[1], square]
                }
                [one, other] => [one.or(other).unwrap_or_default(), Vector3::zeros()],
            }
        };
        Self { constant: response.nominal, terms: response.ends.iter().zip(ends).map(term).collect() }
    }

    fn minus(mut self, other: &Self) -> Self {
        self.constant -= other.constant;
        for (own, other) in self.terms.iter_mut().flatten().zip(other.terms.iter().flatten()) {
            *own -= other;
        }
        self
    }

    /// Its value in a draw.
    fn at(&self, draws: &Draws, draw: usize) -> Vector3<f64> {
        let terms = self.terms.iter().zip(&draws.coordinates);
        terms.fold(self.constant, |sum, ([linear, square], own)| sum + own[draw] * (linear + square * own[draw]))
    }

    /// Computes its components in the draws from `from` on.
    #[inline(always)]
    fn evaluate(&self, draws: &Draws, from: usize, [xs, ys, zs]: &mut [[f64; CHUNK]; 3]) {
        let [x, y, z]: [f64; 3] = self.constant.into();
        (*xs, *ys, *zs) = ([x; CHUNK], [y; CHUNK], [z; CHUNK]);
        for ([linear, square], own) in self.terms.iter().zip(&draws.coordinates) {
            let own = chunk(own, from);
            for (all, axis) in [&mut *xs, ys, zs].into_iter().zip(0..) {
                let (linear, square) = (linear[axis], square[axis]);
                // Plain loops over arrays of one length become vector instructions.
                if square == 0.0 {
                    all.iter_mut().zip(own).for_each(|(sum, own)| *sum += own * linear);
                } else {
                    all.iter_mut().zip(own).for_each(|(sum, own)| *sum += own * (linear + square * own));
                }
            }
        }
    }

    /// The farthest that it is likely to be from its constant: the root of the sum of squares of what each parameter does at most in any draw, and
    /// those that are correlated together.
    fn largest_deviation(&self, draws: &Draws) -> f64 {
        let of = |([linear, square], range): (&[Vector3<f64>; 2], &[f64; 2])| {
            range.map(|x| (x * (linear + square * x)).norm()).into_iter().fold(0.0, f64::max)
        };
        let all: Vec<f64> = self.terms.iter().zip(&draws.ranges).map(of).collect();
        let together: f64 = draws.correlated.iter().map(|own| all[*own]).sum();
        let alone = (0..all.len()).filter(|own| !draws.correlated.contains(own)).map(|own| all[own] * all[own]);
        (alone.sum::<f64>() + together * together).sqrt()
    }
}

/// The longest displacements, to be computed with the instructions that the processor has.
struct Sampling<'a> {
    surrogate: &'a Surrogate,
    draws: &'a Draws,
    sizes: &'a mut [f64],
}

impl Lanewise for Sampling<'_> {
    type Output = ();

    fn run_with<R: Real>(mut self) {
        R::vectorized(
            #[inline(always)]
            || self.fill(),
        );
    }
}

impl Sampling<'_> {
    #[inline(always)]
    fn fill(&mut self) {
        let Self { surrogate, draws, sizes } = self;
        let (mut free, mut own) = ([[0.0; CHUNK]; 3], [[0.0; CHUNK]; 3]);
        let (sizes, _) = sizes.as_chunks_mut::<CHUNK>();
        for (number, sizes) in sizes.iter_mut().enumerate() {
            let from = number * CHUNK;
            surrogate.unloaded.evaluate(draws, from, &mut free);
            let force = chunk(draws.force_of(surrogate.tool), from);
            for load in &surrogate.by_load {
                load.evaluate(draws, from, &mut own);
                add_model_error(draws, from, &mut own);
                for i in 0..CHUNK {
                    let x = free[0][i] + force[i] * own[0][i];
                    let y = free[1][i] + force[i] * own[1][i];
                    let z = free[2][i] + force[i] * own[2][i];
                    let square = x * x + y * y + z * z;
                    sizes[i] = if square > sizes[i] { square } else { sizes[i] };
                }
            }
            for size in sizes {
                *size = size.sqrt();
            }
        }
    }
}

/// Adds what the model leaves out to displacements by the force in the draws from `from` on.
#[inline(always)]
fn add_model_error(draws: &Draws, from: usize, [xs, ys, zs]: &mut [[f64; CHUNK]; 3]) {
    let [a, b, c, d, e, f, g, h, k] = &draws.model[..] else { return };
    let [a, b, c, d, e, f, g, h, k] = [a, b, c, d, e, f, g, h, k].map(|own| chunk(own, from));
    for i in 0..CHUNK {
        let (x, y, z) = (xs[i], ys[i], zs[i]);
        xs[i] += a[i] * x + b[i] * y + c[i] * z;
        ys[i] += d[i] * x + e[i] * y + f[i] * z;
        zs[i] += g[i] * x + h[i] * y + k[i] * z;
    }
}

/// Draws computed at a time.
const CHUNK: usize = 256;

/// The numbers of `all` draws from `from` on that are computed at a time, as an array, so that its length is known.
#[inline(always)]
fn chunk(all: &[f64], from: usize) -> &[f64; CHUNK] {
    all[from..].first_chunk().expect("there are whole chunks of draws")
}

const _: () = assert!(Draws::COUNT.is_multiple_of(CHUNK));

/// Displacements at one place, in all draws.
#[derive(Debug, Clone)]
pub struct Surrogate {
    unloaded: Polynomial,
    /// Displacement under each load that may be the worst, less that without load.
    by_load: Vec<Polynomial>,
    /// Index of the tool that cuts there ([`Draws::force_of`]).
    tool: usize,
}

impl Surrogate {
    /// Makes it of the displacements without load and under each load, as far as that may move the tool farthest in some of `draws`; `ends` are the
    /// coordinates of the ends of each parameter.
    pub fn new(ends: &[[f64; 2]], unloaded: &Response, loaded: &[Response], draws: &Draws) -> Self {
        let unloaded = Polynomial::through(unloaded, ends);
        let free = unloaded.largest_deviation(draws);
        let with_bounds = |response: &Response| {
            let load = Polynomial::through(response, ends).minus(&unloaded);
            let nominal = (unloaded.constant + load.constant).norm();
            let largest_factor = (1.0 + draws.force_range) * (1.0 + draws.model_range);
            let by_parameters = libm::hypot(free, load.largest_deviation(draws) * largest_factor);
            let by_force = libm::hypot(draws.force_range, draws.model_range * (1.0 + draws.force_range));
            let deviation = libm::hypot(by_parameters, by_force * load.constant.norm());
            (load, [nominal - deviation, nominal + deviation])
        };
        let all: Vec<(Polynomial, [f64; 2])> = loaded.iter().map(with_bounds).collect();
        let least = all.iter().fold(0.0, |most: f64, (_, [least, _])| most.max(*least));
        let may_be_longest = all.into_iter().filter(|(_, [_, most])| *most >= least);
        let by_load = may_be_longest.map(|(load, _)| load).collect();
        Self { unloaded, by_load, tool: 0 }
    }

    /// Makes it of the displacements without load and under a single one; `ends` as in [`Self::new`].
    pub fn under_one_load(ends: &[[f64; 2]], unloaded: &Response, loaded: &Response) -> Self {
        let unloaded = Polynomial::through(unloaded, ends);
        Self { by_load: vec![Polynomial::through(loaded, ends).minus(&unloaded)], unloaded, tool: 0 }
    }

    /// Returns the surrogate of the same place where the tool with this index cuts ([`Draws::force_of`]), not the first.
    #[must_use]
    pub fn of_tool(self, tool: usize) -> Self {
        Self { tool, ..self }
    }

    /// Returns the surrogate of the same place where the tool is moved by `shift`, mm, whatever is drawn.
    #[must_use]
    pub fn shifted(&self, shift: Vector3<f64>) -> Self {
        let mut own = self.clone();
        own.unloaded.constant += shift;
        own
    }

    /// Length of the longest displacement under all loads, in each of the first `count` draws, mm; whole scrambles.
    pub fn largest_displacements(&self, draws: &Draws, count: usize) -> Vec<f64> {
        let mut sizes = vec![0.0; count];
        Level::best().run(Sampling { surrogate: self, draws, sizes: &mut sizes });
        sizes
    }

    /// Displacement under the first load in each draw, O axes, mm.
    pub fn displacements(&self, draws: &Draws) -> Vec<[f64; 3]> {
        let Some(load) = self.by_load.first() else { return Vec::new() };
        let moved = |draw: usize| {
            let by_force = load.at(draws, draw);
            let by_force = by_force + draws.model_error(draw, &by_force);
            (self.unloaded.at(draws, draw) + draws.force_of(self.tool)[draw] * by_force).into()
        };
        (0..draws.force.len()).map(moved).collect()
    }

    /// Variance of the length of the longest displacement under all loads, mm², by each of `causes` alone, over the draws of the first scramble.
    pub fn variances<'a>(&self, draws: &Draws, causes: impl Iterator<Item = &'a Cause>) -> Vec<f64> {
        let alone = |square: &dyn Fn(&Polynomial, usize) -> f64| {
            let longest = |draw| self.by_load.iter().fold(0.0, |most: f64, load| most.max(square(load, draw))).sqrt();
            variance(&(0..Draws::PER_SCRAMBLE).map(longest).collect::<Vec<f64>>())
        };
        let by_parameters = |parameters: &[usize]| {
            let moved = |own: &Polynomial, draw: usize| {
                let terms = parameters.iter().map(|parameter| {
                    let (x, [linear, square]) = (draws.coordinates[*parameter][draw], own.terms[*parameter]);
                    x * (linear + x * square)
                });
                terms.fold(own.constant, |sum, term| sum + term)
            };
            alone(&|load, draw| (moved(&self.unloaded, draw) + moved(load, draw)).norm_squared())
        };
        let by_force = |which: usize| {
            let factor = |draw| draws.sharp_and_wear(self.tool, draw)[which];
            alone(&|load, draw| (self.unloaded.constant + factor(draw) * load.constant).norm_squared())
        };
        let under_model = |load: &Polynomial, draw| load.constant + draws.model_error(draw, &load.constant);
        let by_model = || alone(&|load, draw| (self.unloaded.constant + under_model(load, draw)).norm_squared());
        let by = |cause: &Cause| match cause {
            Cause::Parameters(parameters) => by_parameters(parameters),
            Cause::Force => by_force(0),
            Cause::Wear => by_force(1),
            Cause::Model => by_model(),
        };
        causes.map(by).collect()
    }
}

/// Mean of the squared differences of `values` from their mean.
fn variance(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64
}

/// Mean of `values`, and its standard error; that is not a number for a single value.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    (values.iter().sum::<f64>() / count, (variance(values) / (count - 1.0)).sqrt())
}

/// Value below or at which the share `share` of `values` is; they are put in another order.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let place = ((share * values.len() as f64).ceil() as usize).clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// Quantiles over draws, in scrambles of [`Draws::PER_SCRAMBLE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiles {
    /// Half of the draws are below.
    pub median: f64,
    /// 95 % of the draws are below.
    pub p95: f64,
    /// Standard error of `p95` as an estimate, from its spread over scrambles.
    pub p95_standard_error: f64,
}

impl Quantiles {
    /// Quantiles of `values`, one for each draw.
    pub fn of(values: &[f64]) -> Self {
        let of_scrambles: Vec<f64> =
            values.chunks(Draws::PER_SCRAMBLE).map(|own| quantile(&mut own.to_vec(), P95)).collect();
        let mut all = values.to_vec();
        Self {
            median: quantile(&mut all, 0.5),
            p95: quantile(&mut all, P95),
            p95_standard_error: mean_and_error(&of_scrambles).1,
        }
    }
}

/// Share of the draws that [`Quantiles::p95`] holds.
pub const P95: f64 = 0.95;
