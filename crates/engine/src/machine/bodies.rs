//! Bodies of a machine, for what must not touch what, and where their frames stand.

use std::{path::Path, sync::Arc};

use kinetostat_cell::{
    Body, Cell,
    spec::{BodySpec, check_pairs, may_touch},
};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion};

use super::{Chain, Configuration, Machine, Motion, MoveScrew, Route, Step};
use crate::{
    input::{check::Check, error::Result, file, names::listed},
    spatial::Pose,
};

/// Frame of bodies that stand fast: O.
pub const O_FRAME: usize = 0;
/// Frame of bodies that move with P.
pub const PLATFORM_FRAME: usize = 1;
/// Frame on which the workpiece is placed: that of the workpiece carrier, or O without one.
pub const WORKPIECE_FRAME: usize = 2;
/// Bodies at most: each is held against each of those that move otherwise.
const MAX_BODIES: usize = 500;
/// Frames that every machine has.
pub(super) const FIXED_FRAMES: usize = 3;

/// A body as the machine file has it, checked but for the files of its meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineBody {
    /// Its name, unlike that of any other body of the machine.
    pub name: String,
    /// Its place in the machine file, for errors.
    pub key: String,
    /// As it is written.
    pub spec: Arc<BodySpec>,
}

impl MachineBody {
    /// Checks a body whose name gets `prefix` before it.
    pub(super) fn resolve(spec: &BodySpec, prefix: &str, check: &Check) -> Result<Self> {
        check.key("name").readable(&spec.name)?;
        // Pages, which ask of no body, are spared the code.
        #[cfg(not(target_family = "wasm"))]
        spec.resolve(&spec.name, O_FRAME, None, check)?;
        let key = check.location().split_once(": ").map_or_else(String::new, |(_, key)| key.into());
        Ok(Self { name: format!("{prefix}{}", spec.name), key, spec: Arc::new(spec.clone()) })
    }
}

impl Route {
    /// Frames of it on which bodies hang, each once.
    fn body_frames(&self) -> Vec<usize> {
        let mut frames: Vec<usize> = self.bodies.iter().map(|hung| hung.frame).collect();
        frames.dedup();
        frames
    }

    /// Number of joints before each frame, and in all: passive joints at one place, such as those of a universal joint, are one.
    fn joints_before_frames(&self, chain: &Chain) -> (Vec<usize>, usize) {
        let (mut before, mut count, mut seen) = (Vec::new(), 0, Vec::new());
        // Whether the last step is a passive revolute joint, so that the next at this place belongs to it.
        let mut continues = false;
        for step in &self.steps {
            match *step {
                Step::Frame => before.push(count),
                Step::Fixed(transform) => continues &= transform.translation.norm() == 0.0,
                Step::Move { motion, coordinate, .. } => {
                    let is_drive = chain.drives.iter().any(|drive| drive.coordinate == coordinate);
                    let is_passive = coordinate >= chain.virtual_count;
                    if (is_drive || is_passive) && !seen.contains(&coordinate) {
                        let is_turn = is_passive && motion == Motion::Revolute;
                        count += usize::from(!(continues && is_turn));
                        continues = is_turn;
                        seen.push(coordinate);
                    }
                }
            }
        }
        (before, count)
    }
}

impl Machine {
    /// Whether it or its workpiece carrier has bodies.
    pub fn has_bodies(&self) -> bool {
        self.listed_bodies().next().is_some()
    }

    /// All bodies, each with its frame: O, the platform, the workpiece's, then those of the chains and of the carrier, in the order of the file.
    pub fn listed_bodies(&self) -> impl Iterator<Item = (usize, &MachineBody)> {
        let fixed = self.base_bodies.iter().map(|body| (O_FRAME, body));
        let platform = self.platform_bodies.iter().map(|body| (PLATFORM_FRAME, body));
        let routes = self.body_chains().flat_map(|chain| chain.route.with_loops());
        let mut first = FIXED_FRAMES;
        let hung = routes.flat_map(move |route| {
            let frames = route.body_frames();
            let start = first;
            first += frames.len();
            route.bodies.iter().map(move |hung| {
                let index = frames.iter().position(|frame| *frame == hung.frame).unwrap_or_default();
                (start + index, &hung.body)
            })
        });
        fixed.chain(platform).chain(hung)
    }

    fn body_chains(&self) -> impl Iterator<Item = &Chain> {
        self.chains.iter().chain(self.carrier.iter().flat_map(|carrier| &carrier.chains))
    }

    /// The bodies for distances, on the frames of [`frame_poses`](Self::frame_poses), in the order of [`listed_bodies`](Self::listed_bodies). Meshes are read
    /// from the folder of the machine file.
    ///
    /// # Errors
    /// A mesh cannot be read, is open or inside out.
    pub fn bodies(&self) -> Result<Vec<Body>> {
        let origin = self.definition.origin();
        let folder = Path::new(origin).parent().unwrap_or(Path::new(""));
        let check = Check::new(origin);
        let read = |name: &str| file::read(&folder.join(name));
        let body = |(frame, body): (usize, &MachineBody)| {
            body.spec.resolve(&body.name, frame, Some(&read), &check.key(&body.key)).transpose()
        };
        self.listed_bodies().filter_map(body).collect()
    }

    /// The files of meshes of its bodies, each once: name as the machine file has it, and contents.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn body_files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let folder = Path::new(self.definition.origin()).parent().unwrap_or(Path::new(""));
        let mut names: Vec<&str> = self.listed_bodies().flat_map(|(_, body)| body.spec.mesh_files()).collect();
        names.sort_unstable();
        names.dedup();
        names.into_iter().map(|name| Ok((name.to_owned(), file::read(&folder.join(name))?))).collect()
    }

    /// Number of frames of [`frame_poses`](Self::frame_poses).
    pub fn frame_count(&self) -> usize {
        let routes = self.body_chains().flat_map(|chain| chain.route.with_loops());
        FIXED_FRAMES + routes.map(|route| route.body_frames().len()).sum::<usize>()
    }

    /// Index of the chain of a frame, and of the frame in its route; `None` for other frames, of loops and of the workpiece carrier, too.
    pub(super) fn chain_of_frame(&self, frame: usize) -> Option<(usize, usize)> {
        let mut left = frame.checked_sub(FIXED_FRAMES)?;
        for (index, chain) in self.chains.iter().enumerate() {
            for (number, route) in chain.route.with_loops().into_iter().enumerate() {
                let frames = route.body_frames();
                if let Some(own) = frames.get(left) {
                    return (number == 0).then_some((index, *own));
                }
                left -= frames.len();
            }
        }
        None
    }

    /// Fills `poses` with the poses in O of the frames of bodies in the rigid configuration `at` (mm): O, the platform, the workpiece's frame, those of the
    /// chains, those of the workpiece carrier.
    pub fn frame_poses(&self, at: &Configuration, poses: &mut Vec<Isometry3<f64>>) {
        let workpiece = self.carrier.as_ref().map_or(Isometry3::identity(), |carrier| isometry(&carrier.home.pose));
        poses.clear();
        poses.extend([Isometry3::identity(), isometry(&at.pose), workpiece]);
        self.push_frames(at, poses);
        if let Some(carrier) = &self.carrier {
            carrier.push_frames(&carrier.home, poses);
        }
    }

    /// Appends the poses of the frames of its chains.
    fn push_frames(&self, at: &Configuration, poses: &mut Vec<Isometry3<f64>>) {
        let (mut values, mut screws, mut first) = (Vec::new(), Vec::new(), 0);
        for (chain, passive) in self.chains.iter().zip(&at.passive) {
            if chain.route.with_loops().iter().any(|route| !route.bodies.is_empty()) {
                chain.rigid_values(&at.drives[first..], passive, &mut values);
                push_route(&chain.route, &Pose::identity(), &values, &mut screws, poses);
            }
            first += chain.drives.len();
        }
    }

    /// The bodies and the pairs of them that are to be apart: not those that may touch by the file, or with at most one joint between them.
    ///
    /// # Errors
    /// As [`bodies`](Self::bodies).
    pub fn cell(&self) -> Result<Cell> {
        let bodies = self.bodies()?;
        let near = self.joined_frames();
        let frames: Vec<usize> = bodies.iter().map(|body| body.frame).collect();
        let names: Vec<String> = bodies.iter().map(|body| body.name.clone()).collect();
        Ok(Cell::new(bodies, |a, b| {
            near.contains(&[frames[a].min(frames[b]), frames[a].max(frames[b])])
                || may_touch(self.may_touch(), [&names[a], &names[b]])
        }))
    }

    /// Frames that no drive of the machine moves: O, the workpiece's, and those of the workpiece carrier.
    pub fn resting_frames(&self) -> Vec<usize> {
        let of = |chain: &Chain| chain.route.with_loops().iter().map(|route| route.body_frames().len()).sum::<usize>();
        let moving: usize = self.chains.iter().map(of).sum();
        [O_FRAME, WORKPIECE_FRAME].into_iter().chain(FIXED_FRAMES + moving..self.frame_count()).collect()
    }

    /// Pairs of bodies that may touch by the machine file.
    pub fn may_touch(&self) -> &[[String; 2]] {
        &self.definition.spec().may_touch
    }

    /// Pairs of frames, the lesser first, with at most one joint between them.
    pub fn joined_frames(&self) -> Vec<[usize; 2]> {
        let mut joined = Vec::new();
        let mut first = FIXED_FRAMES;
        let own = self.chains.iter().map(|chain| (chain, PLATFORM_FRAME));
        let carrier = self.carrier.iter().flat_map(|carrier| &carrier.chains).map(|chain| (chain, WORKPIECE_FRAME));
        for (chain, end) in own.chain(carrier) {
            for (number, route) in chain.route.with_loops().into_iter().enumerate() {
                let frames = route.body_frames();
                let (before, all) = route.joints_before_frames(chain);
                let mut along: Vec<(usize, usize)> =
                    frames.iter().enumerate().map(|(index, frame)| (first + index, before[*frame])).collect();
                first += frames.len();
                if number == 0 {
                    along.extend([(O_FRAME, 0), (end, all)]);
                }
                for (index, a) in along.iter().enumerate() {
                    let near = along[index + 1..].iter().filter(|b| a.1.abs_diff(b.1) <= 1);
                    joined.extend(near.map(|b| [a.0.min(b.0), a.0.max(b.0)]));
                }
            }
        }
        joined
    }

    /// Checks that no two bodies have one name, and that pairs that may touch name bodies.
    pub(super) fn check_body_names(&self) -> Result<()> {
        let check = Check::new(self.definition.origin());
        let bodies: Vec<&MachineBody> = self.listed_bodies().map(|(_, body)| body).collect();
        if bodies.len() > MAX_BODIES {
            return check
                .key("body")
                .fail(format!("expected at most {MAX_BODIES} bodies in all, got {}", bodies.len()));
        }
        for (index, body) in bodies.iter().enumerate() {
            let before = bodies[..index].iter().map(|body| body.name.as_str());
            check.key(&body.key).key("name").unique(&body.name, before)?;
        }
        let names = listed(bodies.iter().map(|body| &body.name));
        check_pairs(self.may_touch(), &names, |name| bodies.iter().any(|body| body.name == *name), &check)
    }
}

/// Appends the poses of the frames of `route`, which starts at `start`, and of its loops.
fn push_route(
    route: &Route,
    start: &Pose,
    values: &[f64],
    screws: &mut Vec<MoveScrew>,
    poses: &mut Vec<Isometry3<f64>>,
) {
    let mut frames = Vec::new();
    route.forward(start, values, screws, &mut frames);
    poses.extend(route.body_frames().into_iter().map(|frame| isometry(&frames[frame])));
    for inner in &route.loops {
        push_route(&inner.route, &frames[inner.from], values, screws, poses);
    }
}

/// Returns a pose as an isometry.
fn isometry(pose: &Pose) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
    Isometry3::from_parts(pose.translation.into(), rotation)
}
