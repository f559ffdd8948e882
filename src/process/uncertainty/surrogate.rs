//! Displacements of the tool in all draws, from a few solved ones: a polynomial in compliances and geometry, times the factor of the force.
//!
//! The displacement under one load is `u + (I + E) f (d − u)`: f is the factor of the cutting force, E what the model leaves out
//! ([`ModelError`](super::ModelError)), u the displacement without load and d that under the nominal force, each a sum over the parameters of polynomials of the second degree in the coordinate of one parameter
//! ([`UncertainParameter::coordinate`](super::UncertainParameter::coordinate)), through the nominal value and both [`Response::ENDS`]. What two
//! parameters do to one another is left out: who uses it checks it by draws solved in full.

use nalgebra::Vector3;

use super::{Cause, Cut, Draws, Varying};
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

    /// Its value in a draw, on this pass of the tool.
    fn at(&self, draws: &Draws, draw: usize, pass: usize) -> Vector3<f64> {
        let terms = self.terms.iter().zip(&draws.coordinates).enumerate();
        let x = |(term, (_, own)): &(usize, (_, &Vec<f64>))| own[draws.place(*term, draw, pass)];
        terms
            .map(|own| (x(&own), own.1.0))
            .fold(self.constant, |sum, (x, [linear, square])| sum + x * (linear + square * x))
    }

    /// Computes its components in the draws from `from` on, on this pass of the tool, of its constant and these `terms`.
    #[inline(always)]
    fn evaluate(&self, terms: &[usize], draws: &Draws, from: usize, pass: usize, [xs, ys, zs]: &mut [[f64; CHUNK]; 3]) {
        let [x, y, z]: [f64; 3] = self.constant.into();
        (*xs, *ys, *zs) = ([x; CHUNK], [y; CHUNK], [z; CHUNK]);
        for &term in terms {
            let ([linear, square], own) =
                (&self.terms[term], chunk(&draws.coordinates[term], draws.place(term, from, pass)));
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

/// A vector over an angle as its mean and its first two harmonics: factors of 1, cosine, sine, and these of twice the angle.
#[derive(Debug, Clone, Copy)]
pub struct Harmonics([Vector3<f64>; Self::COUNT]);

impl Harmonics {
    /// Number of factors.
    pub const COUNT: usize = 5;
    /// Number of angles, a sixth of a revolution apart, from which they are known.
    pub const NODES: usize = 6;

    /// Returns the waves with these factors at `turn`, in revolutions.
    pub fn waves(turn: f64) -> [f64; Self::COUNT] {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
        [1.0, cosine, sine, cosine * cosine - sine * sine, 2.0 * sine * cosine]
    }

    /// Those of a vector that is this at the nodes; a third harmonic is left out.
    pub fn through(nodes: &[Vector3<f64>; Self::NODES]) -> Self {
        let mut factors = [Vector3::zeros(); Self::COUNT];
        for (number, node) in nodes.iter().enumerate() {
            for (factor, wave) in factors.iter_mut().zip(Self::waves(number as f64 / Self::NODES as f64)) {
                *factor += node * wave;
            }
        }
        let [mean, harmonics @ ..] = &mut factors;
        *mean /= Self::NODES as f64;
        harmonics.iter_mut().for_each(|own| *own *= 2.0 / Self::NODES as f64);
        Self(factors)
    }

    /// The vector where `waves` are these.
    pub fn at(&self, waves: &[f64; Self::COUNT]) -> Vector3<f64> {
        self.0.iter().zip(waves).map(|(factor, wave)| factor * *wave).sum()
    }
}

/// Loads that turn once about an axis in equal steps, where what parameters change is of the first two harmonics: five polynomials instead of one for each load.
#[derive(Debug, Clone)]
struct Turning {
    /// The polynomials without constants.
    harmonics: [Polynomial; Harmonics::COUNT],
    /// Their factors under each load.
    waves: Vec<[f64; Harmonics::COUNT]>,
}

impl Turning {
    /// Fewest parameters with which it saves time.
    const FEWEST_TERMS: usize = 3;
    /// Largest difference from the harmonics at the ends of a parameter, over the largest displacement: rounding.
    const ROUNDING: f64 = 1e-9;

    /// Finds them for all `loads`, where `ends` are as in [`Surrogate::new`]; `None` where they do not turn so, or it would save nothing.
    fn of(loads: &[Polynomial], ends: &[[f64; 2]]) -> Option<Self> {
        let every = loads.len() / Harmonics::NODES;
        if ends.len() < Self::FEWEST_TERMS || every < 2 || every * Harmonics::NODES != loads.len() {
            return None;
        }
        let waves: Vec<_> = (0..loads.len()).map(|load| Harmonics::waves(load as f64 / loads.len() as f64)).collect();
        let rounding = Self::ROUNDING * loads.iter().fold(0.0, |most: f64, load| most.max(load.constant.norm()));
        let nothing = Polynomial { constant: Vector3::zeros(), terms: vec![[Vector3::zeros(); 2]; ends.len()] };
        let mut harmonics: [Polynomial; Harmonics::COUNT] = std::array::from_fn(|_| nothing.clone());
        for (term, ends) in ends.iter().enumerate() {
            let farthest = ends[0].abs().max(ends[1].abs());
            for (power, reach) in [farthest, farthest * farthest].into_iter().enumerate() {
                let coefficient = |load: usize| loads[load].terms[term][power];
                let own = Harmonics::through(&std::array::from_fn(|node| coefficient(node * every)));
                let is_near = |load: usize| (own.at(&waves[load]) - coefficient(load)).norm() * reach <= rounding;
                if !(0..loads.len()).all(is_near) {
                    return None;
                }
                harmonics.iter_mut().zip(own.0).for_each(|(all, own)| all.terms[term][power] = own);
            }
        }
        Some(Self { harmonics, waves })
    }
}

/// What components of the force that vary by themselves add to a displacement under it: for each the displacement that it adds, less that without it, and its factor in each draw, less 1.
type Added<'a> = [(&'a Polynomial, &'a [f64])];

/// The longest displacements, to be computed with the instructions that the processor has.
struct Sampling<'a> {
    surrogate: &'a Surrogate,
    draws: &'a Draws,
    /// Parameters that vary.
    terms: &'a [usize],
    /// Factor of the force in each draw; 1 if `None`.
    force: Option<&'a [f64]>,
    /// Of the components under the only load.
    added: &'a Added<'a>,
    /// Whether the model leaves something out.
    model: bool,
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
        let Self { surrogate, draws, terms, force, added, model, sizes } = self;
        let (mut free, mut own, mut more) = ([[0.0; CHUNK]; 3], [[0.0; CHUNK]; 3], [[0.0; CHUNK]; 3]);
        let mut buffers = [[[0.0; CHUNK]; 3]; Harmonics::COUNT];
        let turning = surrogate.turning.as_ref().filter(|_| terms.len() >= Turning::FEWEST_TERMS);
        let ((sizes, _), pass) = (sizes.as_chunks_mut::<CHUNK>(), surrogate.pass);
        for (number, sizes) in sizes.iter_mut().enumerate() {
            let from = number * CHUNK;
            surrogate.unloaded.evaluate(terms, draws, from, pass, &mut free);
            let force = force.map_or(&[1.0; CHUNK], |own| chunk(own, from));
            if let Some(own) = turning {
                for (own, all) in own.harmonics.iter().zip(&mut buffers) {
                    own.evaluate(terms, draws, from, pass, all);
                }
            }
            for (number, load) in surrogate.by_load.iter().enumerate() {
                match turning {
                    None => load.evaluate(terms, draws, from, pass, &mut own),
                    Some(Turning { waves, .. }) => add_harmonics(load.constant, &waves[number], &buffers, &mut own),
                }
                for (polynomial, factor) in *added {
                    polynomial.evaluate(terms, draws, from, pass, &mut more);
                    let factor = chunk(factor, from);
                    for (all, more) in own.iter_mut().zip(&more) {
                        (0..CHUNK).for_each(|i| all[i] += factor[i] * more[i]);
                    }
                }
                if *model {
                    add_model_error(draws, from, &mut own);
                }
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

/// Adds up `harmonics` in the draws of a chunk, times their `waves`, and a constant.
#[inline(always)]
fn add_harmonics(
    constant: Vector3<f64>,
    [_, cosine, sine, second_cosine, second_sine]: &[f64; Harmonics::COUNT],
    [mean, a, b, c, d]: &[[[f64; CHUNK]; 3]; Harmonics::COUNT],
    all: &mut [[f64; CHUNK]; 3],
) {
    for axis in 0..3 {
        let (constant, mean, a, b, c, d) = (constant[axis], &mean[axis], &a[axis], &b[axis], &c[axis], &d[axis]);
        for (i, sum) in all[axis].iter_mut().enumerate() {
            *sum = constant + mean[i] + cosine * a[i] + sine * b[i] + second_cosine * c[i] + second_sine * d[i];
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
    /// The same, where it is known as harmonics.
    turning: Option<Turning>,
    /// What each component of the force that varies by itself adds under the only load, with its index.
    components: Vec<(usize, Polynomial)>,
    /// Index of the tool that cuts there ([`Draws::force_of`]).
    tool: usize,
    /// Number of its pass.
    pass: usize,
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
        let (by_load, bounds): (Vec<Polynomial>, Vec<[f64; 2]>) = loaded.iter().map(with_bounds).unzip();
        let mut turning = Turning::of(&by_load, ends);
        let least = bounds.iter().fold(0.0, |most: f64, [least, _]| most.max(*least));
        let may_be_longest = |load: &usize| bounds[*load][1] >= least;
        if let Some(own) = &mut turning {
            own.waves = (0..own.waves.len()).filter(may_be_longest).map(|load| own.waves[load]).collect();
        }
        let by_load =
            by_load.into_iter().enumerate().filter(|(load, _)| may_be_longest(load)).map(|(_, own)| own).collect();
        Self { unloaded, by_load, turning, components: Vec::new(), tool: 0, pass: 0 }
    }

    /// Makes it of the displacements without load and under a single one; `ends` as in [`Self::new`].
    pub fn under_one_load(ends: &[[f64; 2]], unloaded: &Response, loaded: &Response) -> Self {
        let unloaded = Polynomial::through(unloaded, ends);
        let by_load = vec![Polynomial::through(loaded, ends).minus(&unloaded)];
        Self { by_load, unloaded, turning: None, components: Vec::new(), tool: 0, pass: 0 }
    }

    /// Returns the surrogate where components of the force under the only load vary by themselves: `with` are the displacements where that with the index is there twice.
    ///
    /// # Panics
    /// There are several loads.
    #[must_use]
    pub fn with_components<'a>(self, ends: &[[f64; 2]], with: impl Iterator<Item = (usize, &'a Response)>) -> Self {
        let [load] = &self.by_load[..] else { panic!("one load") };
        let added = |(own, response): (usize, &Response)| {
            (own, Polynomial::through(response, ends).minus(&self.unloaded).minus(load))
        };
        Self { components: with.map(added).collect(), ..self }
    }

    /// Returns the surrogate of the same place where this `cut` is made, not that of the first tool on its first pass.
    #[must_use]
    pub fn of_cut(self, Cut { tool, pass }: Cut) -> Self {
        Self { tool, pass, ..self }
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
        self.largest_by(
            draws,
            &Varying { terms: (0..draws.coordinates.len()).collect(), force: true, model: true },
            count,
        )
    }

    /// As [`Surrogate::largest_displacements`], where only these vary.
    pub fn largest_by(&self, draws: &Draws, varying: &Varying, count: usize) -> Vec<f64> {
        let added = self.components.iter().filter(|_| varying.force);
        let added: Vec<_> = added.map(|(own, added)| (added, draws.component(self.tool, *own))).collect();
        let force = varying.force.then(|| draws.force_of(self.tool));
        self.sample(draws, &varying.terms, force, &added, varying.model, count)
    }

    /// As [`Surrogate::largest_displacements`], where only the parameters `terms` vary, `force` is the factor of the force and `added` what its components do, and the
    /// model leaves something out or not.
    fn sample(
        &self,
        draws: &Draws,
        terms: &[usize],
        force: Option<&[f64]>,
        added: &Added<'_>,
        model: bool,
        count: usize,
    ) -> Vec<f64> {
        let mut sizes = vec![0.0; count];
        Level::best().run(Sampling { surrogate: self, draws, terms, force, added, model, sizes: &mut sizes });
        sizes
    }

    /// Displacement under the first load in each draw, O axes, mm.
    pub fn displacements(&self, draws: &Draws) -> Vec<[f64; 3]> {
        let Some(load) = self.by_load.first() else { return Vec::new() };
        let moved = |draw: usize| {
            let by_force = load.at(draws, draw, self.pass);
            let by_force = by_force + draws.model_error(draw, &by_force);
            (self.unloaded.at(draws, draw, self.pass) + draws.force_of(self.tool)[draw] * by_force).into()
        };
        (0..draws.force_of(self.tool).len()).map(moved).collect()
    }

    /// Variance of the length of the longest displacement under all loads, mm², by each of `causes` alone, over the draws of the first scramble.
    pub fn variances<'a>(&self, draws: &Draws, causes: impl Iterator<Item = &'a Cause>) -> Vec<f64> {
        let alone = |terms: &[usize], force: Option<&[f64]>, model| {
            variance(&self.sample(draws, terms, force, &[], model, Draws::PER_SCRAMBLE))
        };
        let of_component = |which: usize| {
            let (_, added) = self.components.iter().find(|(own, _)| *own == which)?;
            let added = [(added, draws.component(self.tool, which))];
            Some(variance(&self.sample(draws, &[], None, &added, false, Draws::PER_SCRAMBLE)))
        };
        let factors = |which: usize| -> Vec<f64> {
            (0..Draws::PER_SCRAMBLE).map(|draw| draws.sharp_and_wear(self.tool, draw)[which]).collect()
        };
        let by = |cause: &Cause| match cause {
            Cause::Parameters(parameters) => alone(parameters, None, false),
            Cause::Force => alone(&[], Some(&factors(0)), false),
            Cause::Wear => alone(&[], Some(&factors(1)), false),
            Cause::Component(which) => of_component(*which).unwrap_or(0.0),
            Cause::Model => alone(&[], None, true),
        };
        causes.map(by).collect()
    }
}

/// Mean of the squared differences of `values` from their mean.
pub(super) fn variance(values: &[f64]) -> f64 {
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
