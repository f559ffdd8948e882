//! The draws: standard normal numbers for each uncertain quantity, the same at every place.

use nalgebra::{DMatrix, Vector3};

use super::{ForceFactors, ForceSpread, Role, Setup, UncertainParameter, normal_quantile, sobol};

/// Factors of the cutting force of a tool in each draw.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceDraws {
    /// Of the whole, with tool wear.
    all: Vec<f64>,
    /// Of tool wear in these; empty where tools stay sharp.
    wear: Vec<f64>,
    /// Of each component, less 1; empty for one that does not vary by itself.
    components: [Vec<f64>; ForceSpread::COMPONENTS.len()],
}

impl ForceDraws {
    /// Those of a tool with these standard normal numbers: of the whole, of tool wear, and, the next of `components`, of each component that varies.
    fn of(force: &ForceSpread, [sharp, wear]: [&[f64]; 2], components: &mut impl Iterator<Item = Vec<f64>>) -> Self {
        let factors = |(draw, sharp): (usize, &f64)| force.factors([*sharp, wear.get(draw).copied().unwrap_or(0.0)]);
        let factors: Vec<[f64; 2]> = sharp.iter().enumerate().map(factors).collect();
        Self {
            all: factors.iter().map(|[sharp, wear]| sharp * wear).collect(),
            wear: force.wear.map_or_else(Vec::new, |_| factors.iter().map(|[_, wear]| *wear).collect()),
            components: force.components.map(|spread| {
                let normal = spread.and_then(|_| components.next()).unwrap_or_default();
                normal.iter().map(|z| spread.map_or(0.0, |own| own.value(1.0, *z) - 1.0)).collect()
            }),
        }
    }

    /// Largest of all factors in the draw `index`.
    fn largest(&self, index: usize) -> f64 {
        let component =
            self.components.iter().filter_map(|own| own.get(index)).fold(0.0, |most: f64, own| most.max(*own));
        self.all[index] * (1.0 + component)
    }
}

/// How all that is drawn is distributed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distributions<'a> {
    pub parameters: &'a [UncertainParameter],
    /// Indices of the parameters whose numbers are the products of `factor` with independent ones.
    pub correlated: &'a [usize],
    pub factor: &'a DMatrix<f64>,
    pub force: ForceSpread,
    /// By how much the model is wrong.
    pub model_std: f64,
}

/// Draws of all uncertain quantities, in scrambles that are independent of one another.
#[derive(Debug, Clone)]
pub struct Draws {
    /// Number from which they are made.
    pub seed: u32,
    /// Standard normal number of each parameter in each draw.
    pub normal: Vec<Vec<f64>>,
    /// Coordinate of each parameter in each draw ([`UncertainParameter::coordinate`]).
    pub coordinates: Vec<Vec<f64>>,
    /// Parameters that each pass of the tool has anew, of whose coordinates there are more scrambles.
    pub(super) per_pass: Vec<usize>,
    /// Least and largest coordinate of each parameter.
    pub ranges: Vec<[f64; 2]>,
    /// Parameters that vary together as an identification found, by their indices; empty where there are none.
    pub correlated: Vec<usize>,
    /// Those of the cutting force, of each tool whose force varies by itself.
    pub force: Vec<ForceDraws>,
    /// Largest difference of the factors of the force from 1.
    pub force_range: f64,
    /// Rows of the matrix E of a [`ModelError`](super::ModelError) in each draw, one after another; empty where the model leaves nothing out.
    pub model: Vec<Vec<f64>>,
    /// Largest norm of these matrices.
    pub model_range: f64,
    /// The draws for the force, and for each stiffness with and without it, beginning with the largest force and the softest: it buckles in them first.
    pub from_weakest: Vec<Vec<usize>>,
    /// Largest compliance of any stiffness over its nominal one in any draw, times the factor of the force or not.
    pub weakest: f64,
    /// Matrix whose products with independent numbers are those of `correlated`.
    pub(super) factor: DMatrix<f64>,
}

/// Further scrambles of what each pass has anew, over those of all draws.
const MORE_PASSES: usize = 3;

/// Entries of the matrix of what the model leaves out.
const MODEL_DIMENSIONS: usize = 9;

impl Draws {
    /// Number of scrambles.
    pub const SCRAMBLES: usize = 16;
    /// Draws of a scramble.
    pub const PER_SCRAMBLE: usize = 256;
    /// Number of draws.
    pub const COUNT: usize = Self::SCRAMBLES * Self::PER_SCRAMBLE;

    /// Draws of what is distributed so, made from `seed`.
    pub(super) fn new(distributions: Distributions<'_>, seed: u32) -> Self {
        Self::in_scrambles(distributions, seed, seed.into(), Self::SCRAMBLES, Self::PER_SCRAMBLE)
    }

    /// The draws as in [`Self::new`], but in other `scrambles` with `per_scramble` draws each. Their random numbers are those of `random`, made from `seed`.
    pub(super) fn in_scrambles(
        distributions: Distributions<'_>,
        seed: u32,
        random: u64,
        scrambles: usize,
        per_scramble: usize,
    ) -> Self {
        let Distributions { parameters, correlated, factor, force, model_std } = distributions;
        let (of_model, count) = (if model_std > 0.0 { MODEL_DIMENSIONS } else { 0 }, scrambles * per_scramble);
        // Those of tool wear, of further tools and of components come last, behind those of the model whether they are drawn or not, so that they change no
        // others.
        let (tools, components) = (1 + force.other_tools, force.varied_components().count());
        let has_tools = force.wear.is_some() || tools > 1 || components > 0;
        let behind = if has_tools { MODEL_DIMENSIONS + 2 * tools - 1 + components * tools } else { of_model };
        let dimensions = parameters.len() + 1 + behind;
        let points = sobol::points(dimensions, scrambles, per_scramble, random);
        // The force comes first, so that it is the same with other parameters.
        let mut normal: Vec<Vec<f64>> =
            points.into_iter().map(|own| own.into_iter().map(normal_quantile).collect()).collect();
        let sharp = normal.remove(0);
        let mut of_model_and_tools = normal.split_off(parameters.len());
        let of_tools = of_model_and_tools.split_off(if has_tools { MODEL_DIMENSIONS } else { of_model });
        let mut of_tools: Vec<Vec<f64>> = std::iter::once(sharp).chain(of_tools).collect();
        let of_components = of_tools.split_off(of_tools.len().min(2 * tools));
        let mut of_components = of_components.into_iter();
        let of_tool = |own: &[Vec<f64>]| {
            let wear = own.get(1).map_or(&[][..], Vec::as_slice);
            ForceDraws::of(&force, [&own[0], wear], &mut of_components)
        };
        let force: Vec<ForceDraws> = of_tools.chunks(2).map(of_tool).collect();
        let largest = |draw: usize| force.iter().fold(0.0, |most: f64, own| most.max(own.largest(draw)));
        let largest_force: Vec<f64> = (0..count).map(largest).collect();
        // In each direction a third of the mean square.
        let entry = |own: Vec<f64>| own.into_iter().map(|z| model_std / 3.0f64.sqrt() * z).collect();
        let model: Vec<Vec<f64>> = of_model_and_tools.into_iter().take(of_model).map(entry).collect();
        let norm = |draw: usize| model.iter().map(|own| own[draw] * own[draw]).sum::<f64>().sqrt();
        let model_range = (0..count).map(norm).fold(0.0, f64::max);
        let independent: Vec<Vec<f64>> = correlated.iter().map(|parameter| normal[*parameter].clone()).collect();
        for (row, parameter) in factor.row_iter().zip(correlated) {
            let product = |draw: usize| row.iter().zip(&independent).map(|(a, own)| a * own[draw]).sum();
            normal[*parameter] = (0..count).map(product).collect();
        }
        let all_forces = force.iter().flat_map(|own| &own.all);
        let force_range = all_forces.fold(0.0, |most: f64, factor| most.max((factor - 1.0).abs()));
        let of = |(own, normal): (&UncertainParameter, &Vec<f64>)| normal.iter().map(|z| own.coordinate(*z)).collect();
        let mut coordinates: Vec<Vec<f64>> = parameters.iter().zip(&normal).map(of).collect();
        let is_per_pass = |own: &usize| matches!(parameters[*own].role, Role::Setup(Setup::Repeatability(_)));
        let per_pass: Vec<usize> = (0..parameters.len()).filter(is_per_pass).collect();
        // No other random numbers of a seed have this bit.
        let more = sobol::points(per_pass.len(), MORE_PASSES * scrambles, per_scramble, random | 1 << 45);
        for (own, more) in per_pass.iter().zip(more) {
            coordinates[*own].extend(more.into_iter().map(normal_quantile).map(|z| parameters[*own].coordinate(z)));
        }
        let range =
            |own: &Vec<f64>| own.iter().fold([0.0f64; 2], |[least, largest], x| [least.min(*x), largest.max(*x)]);
        let ranges = coordinates.iter().map(range).collect();
        let in_order = |weakness: &Vec<f64>| {
            let mut order: Vec<usize> = (0..count).collect();
            if !crate::FOR_PAGES {
                order.sort_by(|a, b| weakness[*b].total_cmp(&weakness[*a]));
            }
            order
        };
        // Where weight makes it fall over, the force says nothing.
        let softness = |(own, normal): (&UncertainParameter, &Vec<f64>)| -> Option<[Vec<f64>; 2]> {
            let alone = normal.iter().map(|z| own.compliance_ratio(*z)).collect::<Option<Vec<f64>>>()?;
            Some([alone.iter().zip(&largest_force).map(|(own, factor)| own * factor).collect(), alone])
        };
        // Pages seek no draws that fall over.
        let sought = if crate::FOR_PAGES { &[] } else { parameters };
        let softest = sought.iter().zip(&normal).filter_map(softness).flatten();
        let weakness: Vec<Vec<f64>> = std::iter::once(largest_force.clone()).chain(softest).collect();
        let weakest = weakness.iter().flatten().fold(1.0, |most: f64, own| most.max(*own));
        let from_weakest = weakness.iter().map(in_order).collect();
        Self {
            seed,
            normal,
            coordinates,
            per_pass,
            ranges,
            correlated: correlated.into(),
            force,
            force_range,
            model,
            model_range,
            from_weakest,
            weakest,
            factor: factor.clone(),
        }
    }

    /// Where the coordinate of the parameter `own` is in the draw `index` on this pass of the tool: passes are independent of one another, up to 64 of them.
    #[inline(always)]
    pub fn place(&self, own: usize, index: usize, pass: usize) -> usize {
        if pass == 0 || !self.per_pass.contains(&own) {
            return index;
        }
        // Whole chunks, as they are read.
        let chunks = self.coordinates[own].len() / Self::PER_SCRAMBLE;
        (index + pass * Self::PER_SCRAMBLE) % (chunks.max(1) * Self::PER_SCRAMBLE).min(self.coordinates[own].len())
    }

    /// Factor of the cutting force in each draw, with tool wear, of the tool with this index ([`Uncertainty::tool_index`](super::Uncertainty::tool_index)).
    ///
    /// # Panics
    /// There is no such tool.
    #[inline(always)]
    pub fn force_of(&self, tool: usize) -> &[f64] {
        &self.force[tool].all
    }

    /// Factors of the force of the tool with this index in the draw `index`.
    pub fn factors(&self, tool: usize, index: usize) -> ForceFactors {
        let ForceDraws { all, components, .. } = &self.force[tool];
        let component = |own: usize| components[own].get(index).copied().unwrap_or(0.0);
        ForceFactors { all: all[index], components: std::array::from_fn(component) }
    }

    /// Factor of a component of the force of the tool with this index in each draw, less 1; empty where it does not vary by itself.
    pub(super) fn component(&self, tool: usize, component: usize) -> &[f64] {
        &self.force[tool].components[component]
    }

    /// Factors of the force of a sharp tool and of tool wear in the draw `index`, whose product is that of [`Self::force_of`].
    pub fn sharp_and_wear(&self, tool: usize, index: usize) -> [f64; 2] {
        let wear = self.force[tool].wear.get(index).copied().unwrap_or(1.0);
        [self.force_of(tool)[index] / wear, wear]
    }

    /// What the model leaves out of the displacement `by_force` in the draw `index`.
    pub fn model_error(&self, index: usize, by_force: &Vector3<f64>) -> Vector3<f64> {
        let row = |row: usize| (0..3).map(|k| self.model[3 * row + k][index] * by_force[k]).sum();
        if self.model.is_empty() { Vector3::zeros() } else { Vector3::from_fn(|own, _| row(own)) }
    }
}
