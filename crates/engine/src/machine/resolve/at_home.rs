//! Checks of the assembled machine in its home pose: the ends of each spring are apart, and each module has some compliance.

use nalgebra::{DMatrix, Matrix6, Vector6};

use crate::{
    input::{check::Check, error::Result},
    lanes::{Frame, Screw},
    machine::{
        Anchor, Loop, Machine, Route,
        spec::{ElementSpec, MachineSpec, ModuleSpec},
    },
    spatial::Pose,
};

/// Ends of a spring that are nearer to each other have no direction, as a share of the machine's characteristic length.
const COINCIDENT: f64 = 1e-9;
/// A motion with less than this share of itself outside the span of others is none of its own.
const INDEPENDENT: f64 = 1e-6;

/// Checks at home that springs between points have a direction and that no module is rigid in itself.
pub(super) fn check_at_home(machine: &Machine, spec: &MachineSpec, check: &Check) -> Result<()> {
    let mut values = Vec::new();
    let mut first_drive = 0;
    for (chain, passive) in machine.chains.iter().zip(&machine.home.passive) {
        chain.rigid_values(&machine.home.drives[first_drive..], passive, &mut values);
        first_drive += chain.drives.len();
        let at_home = HomeCheck { spec, check, characteristic_length: machine.characteristic_length, values: &values };
        at_home.end_twists(&chain.route, &Pose::identity())?;
    }
    Ok(())
}

/// Checks of one chain with the machine at home.
struct HomeCheck<'a> {
    spec: &'a MachineSpec,
    check: &'a Check,
    characteristic_length: f64,
    /// Chain coordinates at home, mm and rad.
    values: &'a [f64],
}

/// A part of a route: its elementary motions `first..end`, and the twists that they give the end of the route.
struct RoutePart {
    first: usize,
    end: usize,
    twists: DMatrix<f64>,
}

impl HomeCheck<'_> {
    /// Checks springs and modules of `route`; returns the twists its end can have (columns; O axes, at O, displacements over the length).
    fn end_twists(&self, route: &Route, start: &Pose) -> Result<DMatrix<f64>> {
        let mut parts: Vec<(usize, RoutePart)> = Vec::new();
        let (mut moves, mut frames) = (0, Vec::new());
        let each = |coordinate: usize, screw: Screw<f64>| {
            let twist = self.scaled_twist(screw);
            match parts.iter_mut().find(|(moved, _)| *moved == coordinate) {
                Some((_, part)) => {
                    part.end = moves + 1;
                    part.twists += twist;
                }
                None => parts.push((coordinate, RoutePart { first: moves, end: moves + 1, twists: twist })),
            }
            moves += 1;
        };
        route.propagate(Frame::splat(start).compose(&route.base), self.values, each, |frame| {
            frames.push(Pose::from(frame));
        });
        self.check_springs(route, &frames)?;
        let mut parts: Vec<RoutePart> = parts.into_iter().map(|(_, part)| part).collect();
        let before = route.moves_before_frames();
        let mut modules: Vec<(usize, usize)> = route.loops.iter().map(|inner| (inner.from, inner.to)).collect();
        // The innermost first: they are parts of the others.
        modules.sort_by_key(|(from, to)| (to - from, *from));
        modules.dedup();
        for (from, to) in modules {
            let is_within = |part: &RoutePart| before[from] <= part.first && part.end <= before[to];
            let (inner, outer): (Vec<RoutePart>, Vec<RoutePart>) = parts.into_iter().partition(is_within);
            let loops: Vec<&Loop> = route.loops.iter().filter(|other| (other.from, other.to) == (from, to)).collect();
            let mut ways = vec![join_columns(inner.iter().map(|part| &part.twists))];
            for other in &loops {
                ways.push(self.end_twists(&other.route, &frames[from])?);
            }
            parts = outer;
            parts.push(RoutePart { first: before[from], end: before[to], twists: self.common_twists(&ways, &loops)? });
        }
        Ok(join_columns(parts.iter().map(|part| &part.twists)))
    }

    /// Twist of `screw` as a column, its displacement as a share of the characteristic length.
    fn scaled_twist(&self, screw: Screw<f64>) -> DMatrix<f64> {
        let twist = crate::spatial::Twist::from(screw);
        let linear = twist.linear / self.characteristic_length;
        DMatrix::from_iterator(6, 1, linear.iter().chain(twist.angular.iter()).copied())
    }

    /// Twists that all chains (`ways`) of a module allow; `Err` where chains are rigid against one another.
    fn common_twists(&self, ways: &[DMatrix<f64>], loops: &[&Loop]) -> Result<DMatrix<f64>> {
        let wrenches: Vec<DMatrix<f64>> = ways.iter().map(orthogonal_complement).collect();
        let carried = join_columns(wrenches.iter());
        let common = orthogonal_complement(&carried);
        let directions = carried.ncols() + common.ncols() - 6;
        if directions == 0 {
            return Ok(common);
        }
        let (key, names) = self.module_key(loops);
        let word = if directions == 1 { "direction" } else { "directions" };
        self.check.key(&key).fail(format!(
            "the chains {names} are rigid against one another in {directions} {word} at home, where what they carry is not \
             determined: give one of them an elastic element (beam, link, parallelogram) or more joints"
        ))
    }

    /// Key in the machine file of the module with these `loops`, and the names of its chains separated by commas.
    fn module_key(&self, loops: &[&Loop]) -> (String, String) {
        let is_it = |module: &ModuleSpec| {
            let has = |other: &&Loop| module.mounts.iter().any(|mount| other.name.ends_with(&mount.name));
            module.mounts.len() == loops.len() + 1 && loops.iter().all(has)
        };
        for (c, design) in self.spec.chain.iter().enumerate() {
            for (e, element) in design.elements.iter().enumerate() {
                if let ElementSpec::Module(module) = element
                    && is_it(module)
                {
                    let names: Vec<&str> = module.mounts.iter().map(|mount| mount.name.as_str()).collect();
                    return (format!("chain[{c}].elements[{e}].module"), names.join(", "));
                }
            }
        }
        ("chain".into(), loops.iter().map(|other| other.name.as_str()).collect::<Vec<_>>().join(", "))
    }

    /// Refuses springs of `route` whose ends coincide at home, unless they have no force there; `frames`: poses of its frames in O.
    fn check_springs(&self, route: &Route, frames: &[Pose]) -> Result<()> {
        let place = |anchor: &Anchor| anchor.frame.map_or(anchor.at, |frame| frames[frame].transform(anchor.at));
        for spring in &route.point_springs {
            let (from, to) = (place(&spring.from), place(&spring.to));
            let has_direction = (to - from).norm() > COINCIDENT * self.characteristic_length;
            if !has_direction && spring.tension_at_zero_length() != 0.0 {
                let [x, y, z]: [f64; 3] = from.into();
                return self.check.key(&self.spring_key(&spring.name)).fail(format!(
                    "both ends of the spring are at ({x:.3}, {y:.3}, {z:.3}) mm at home, so that its force has no direction: expected \
                     ends apart from each other, or free_length_mm = 0 without preload"
                ));
            }
        }
        Ok(())
    }

    /// Key in the machine file of the spring that tables call `name`.
    fn spring_key(&self, name: &str) -> String {
        let named = self.spec.chain.iter().enumerate().flat_map(|(c, design)| {
            let names = ElementSpec::names(&design.elements).into_iter().enumerate();
            names.map(move |(e, own)| (own, format!("chain[{c}].elements[{e}].spring"), &design.elements[e]))
        });
        let fitting =
            named.filter(|(own, _, element)| matches!(element, ElementSpec::Spring(_)) && name.ends_with(own));
        fitting.max_by_key(|(own, ..)| own.len()).map_or_else(|| name.into(), |(_, key, _)| key)
    }
}

/// Joins the columns of all matrices, six rows each, into one matrix.
fn join_columns<'m>(matrices: impl Iterator<Item = &'m DMatrix<f64>>) -> DMatrix<f64> {
    let columns: Vec<Vector6<f64>> =
        matrices.flat_map(|matrix| matrix.column_iter().map(|c| Vector6::from_iterator(c.iter().copied()))).collect();
    DMatrix::from_fn(6, columns.len(), |i, j| columns[j][i])
}

/// An orthonormal basis of the directions orthogonal to all columns of `matrix`.
fn orthogonal_complement(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut sum = Matrix6::zeros();
    for column in matrix.column_iter() {
        if let Some(unit) = column.into_owned().try_normalize(f64::MIN_POSITIVE) {
            sum += Matrix6::from_fn(|i, j| unit[i] * unit[j]);
        }
    }
    let eigen = sum.symmetric_eigen();
    let free: Vec<usize> = (0..6).filter(|&i| eigen.eigenvalues[i] <= INDEPENDENT * INDEPENDENT).collect();
    DMatrix::from_fn(6, free.len(), |i, j| eigen.eigenvectors[(i, free[j])])
}
