//! A machine as lines in space: what a drawing of it needs, and nothing of its stiffness.

use nalgebra::Vector3;

use super::{Anchor, Chain, Configuration, Machine, Motion, Route, Step};
use crate::spatial::{ChainSkeleton, JointMark, MassMark, Polyline, Pose, Skeleton};

impl Machine {
    /// Skeleton for the chain coordinates `chains` (one set per chain, drive coordinates with ρ added, mm and rad) and the platform at `platform`.
    pub fn skeleton(&self, chains: &[Vec<f64>], platform: &Pose) -> Skeleton {
        Skeleton {
            chains: self.chains.iter().zip(chains).map(|(chain, values)| SkeletonWalker::walk(chain, values)).collect(),
            platform_mm: platform.translation.into(),
            platform_axes: std::array::from_fn(|i| platform.rotation.column(i).into_owned().into()),
            tool_tip_mm: platform.transform(self.tool_tip).into(),
            platform_mass: self
                .platform_mass
                .map(|mass| MassMark { position_mm: platform.transform(mass.at).into(), kilograms: mass.kilograms }),
        }
    }

    /// Skeleton of the machine in the rigid configuration `at`.
    pub fn rigid_skeleton(&self, at: &Configuration) -> Skeleton {
        let mut first = 0;
        let values = |(chain, passive): (&Chain, &Vec<f64>)| {
            let mut values = Vec::new();
            chain.rigid_values(&at.drives[first..], passive, &mut values);
            first += chain.drives.len();
            values
        };
        let chains: Vec<Vec<f64>> = self.chains.iter().zip(&at.passive).map(values).collect();
        self.skeleton(&chains, &at.pose)
    }
}

impl Machine {
    /// Length of all links from the base to the tool tip at home, one after another, and of the travel of all prismatic joints, mm; `None` of a machine whose
    /// platform several chains carry, or with a closed loop.
    pub fn serial_length_mm(&self) -> Option<f64> {
        let ([_], 0) = (&self.chains[..], self.chains.iter().map(|own| own.route.loop_count()).sum::<usize>()) else {
            return None;
        };
        let between = |line: &Polyline| -> f64 {
            line.windows(2).map(|ends| (Vector3::from(ends[1]) - Vector3::from(ends[0])).norm()).sum()
        };
        let links: f64 = self.rigid_skeleton(&self.home).chains.iter().flat_map(|own| &own.links).map(between).sum();
        let slides = self.drive_ranges().into_iter().zip(self.drives());
        let slides = slides.filter(|(_, (_, drive))| drive.motion == Motion::Prismatic);
        Some(links + slides.map(|(range, _)| range[1] - range[0]).sum::<f64>() + self.tool_tip.norm())
    }
}

impl Machine {
    /// Smallest and largest coordinate of each drive, mm or rad: its travel, or else what home, the named points and the
    /// corners of the workspace ask for, as far as they can be reached.
    pub fn drive_ranges(&self) -> Vec<[f64; 2]> {
        let (low, high) = (self.workspace.min, self.workspace.max);
        let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let places = (0..8).map(corner).chain(self.points.iter().map(|point| point.position));
        let reached = places.filter_map(|place| self.inverse_kinematics_at(place).ok());
        let mut ranges: Vec<[f64; 2]> = self.home.drives.iter().map(|rho| [*rho; 2]).collect();
        for at in reached {
            for (range, rho) in ranges.iter_mut().zip(&at.drives) {
                *range = [range[0].min(*rho), range[1].max(*rho)];
            }
        }
        for (range, (_, drive)) in ranges.iter_mut().zip(self.drives()) {
            if let Some((low, high)) = drive.travel {
                *range = [low, high];
            }
        }
        ranges
    }
}

/// Draws a route step by step, from base to platform.
struct SkeletonWalker<'a> {
    chain: &'a Chain,
    values: &'a [f64],
    pose: Pose,
    line: Polyline,
    links: Vec<Polyline>,
    joints: Vec<JointMark>,
    /// The near end of the parallelogram that is being followed: both revolute joints of its short link.
    near: Option<[[f64; 3]; 2]>,
}

impl<'a> SkeletonWalker<'a> {
    /// Skeleton of `chain` at the chain coordinates `values` (mm, rad).
    fn walk(chain: &'a Chain, values: &'a [f64]) -> ChainSkeleton {
        let mut drawn = ChainSkeleton {
            name: chain.name.clone(),
            links: Vec::new(),
            joints: Vec::new(),
            springs: Vec::new(),
            masses: Vec::new(),
        };
        Self::walk_route(chain, &chain.route, values, &Pose::identity(), &mut drawn);
        drawn
    }

    /// Draws a route that starts at the pose `start`, and its loops.
    fn walk_route(chain: &'a Chain, route: &'a Route, values: &'a [f64], start: &Pose, drawn: &mut ChainSkeleton) {
        let pose = start.compose(&route.base);
        let mut walker = Self {
            chain,
            values,
            pose,
            line: vec![pose.translation.into()],
            links: Vec::new(),
            joints: Vec::new(),
            near: None,
        };
        let mut frames = Vec::new();
        for step in &route.steps {
            match *step {
                Step::Fixed(transform) => walker.advance(&transform),
                Step::Frame => frames.push(walker.pose),
                Step::Move { motion, axis, coordinate, sign } => {
                    let direction = walker.pose.rotation.column(axis.index()).into_owned();
                    let width = walker.parallelogram_width(coordinate);
                    walker.add_joint(motion, coordinate, sign, direction);
                    if width > 0.0 && sign > 0.0 {
                        walker.near = Some(walker.short_link(width));
                        walker.start_line();
                    }
                    match motion {
                        Motion::Prismatic => walker.slide(coordinate, direction * sign),
                        Motion::Revolute => walker.pose.rotate_about(axis, sign * values[coordinate]),
                    }
                    if width > 0.0 && sign < 0.0 {
                        walker.close_parallelogram(width);
                    }
                }
            }
        }
        walker.advance(&route.attachment);
        walker.start_line();
        drawn.links.append(&mut walker.links);
        drawn.joints.append(&mut walker.joints);
        let place = |anchor: &Anchor| match anchor.frame {
            Some(frame) => frames[frame].transform(anchor.at).into(),
            None => anchor.at.into(),
        };
        drawn.springs.extend(route.point_springs.iter().map(|spring| vec![place(&spring.from), place(&spring.to)]));
        let masses = route.masses.iter().map(|mass| MassMark {
            position_mm: frames[mass.frame].transform(mass.at).into(),
            kilograms: mass.kilograms,
        });
        drawn.masses.extend(masses);
        for inner in &route.loops {
            Self::walk_route(chain, &inner.route, values, &frames[inner.from], drawn);
        }
    }

    /// Moves on by a rigid transform, whose length is drawn.
    fn advance(&mut self, transform: &Pose) {
        self.pose = self.pose.compose(transform);
        if transform.translation != Vector3::zeros() {
            self.line.push(self.pose.translation.into());
        }
    }

    /// Ends the present line, kept unless it is a single point, and begins another at the present pose.
    fn start_line(&mut self) {
        let line = std::mem::replace(&mut self.line, vec![self.pose.translation.into()]);
        if line.len() > 1 {
            self.links.push(line);
        }
    }

    /// Moves along a prismatic joint, which leaves a gap in the lines, or by an elastic deflection, which the line follows.
    fn slide(&mut self, coordinate: usize, direction: Vector3<f64>) {
        let is_elastic = coordinate < self.chain.virtual_count && !self.is_drive(coordinate);
        if !is_elastic {
            self.start_line();
        }
        self.pose.translation += direction * self.values[coordinate];
        if let Some(last) = self.line.last_mut() {
            *last = self.pose.translation.into();
        }
        if !is_elastic && let Some(joint) = self.joints.last_mut() {
            joint.position_mm = self.pose.translation.into();
        }
    }

    /// Whether the chain coordinate is that of a drive.
    fn is_drive(&self, coordinate: usize) -> bool {
        self.chain.drives.iter().any(|drive| drive.coordinate == coordinate)
    }

    /// Marks the drive or passive joint with this coordinate at the present pose.
    fn add_joint(&mut self, motion: Motion, coordinate: usize, sign: f64, direction: Vector3<f64>) {
        let index = self.chain.drives.iter().position(|drive| drive.coordinate == coordinate);
        let drive = index.map(|index| &self.chain.drives[index]);
        let value = index.map_or(self.values[coordinate], |index| self.chain.commanded_drives(self.values)[index]);
        let passive = coordinate.checked_sub(self.chain.virtual_count).and_then(|j| self.chain.passive.get(j));
        let (name, limits) = match (drive, passive) {
            (Some(drive), _) => (&drive.name, drive.travel),
            (None, Some(joint)) if sign > 0.0 => (&joint.name, joint.limits),
            _ => return,
        };
        self.joints.push(JointMark {
            name: name.clone(),
            is_drive: drive.is_some(),
            slides: motion == Motion::Prismatic,
            position_mm: self.pose.translation.into(),
            axis: direction.into(),
            value: motion.to_shown(value),
            limits: limits.map(|(low, high)| [motion.to_shown(low), motion.to_shown(high)]),
        });
    }

    /// Distance between the bars of the parallelogram with this coordinate; 0 for other joints.
    fn parallelogram_width(&self, coordinate: usize) -> f64 {
        let joint = coordinate.checked_sub(self.chain.virtual_count).and_then(|j| self.chain.passive.get(j));
        joint.and_then(|joint| joint.parallelogram_width).unwrap_or(0.0)
    }

    /// Ends of the short link, `width` mm long, of the parallelogram that begins or ends at the present pose; O, mm.
    fn short_link(&self, width: f64) -> [[f64; 3]; 2] {
        let half = self.pose.rotation.column(1) * (width / 2.0);
        [(self.pose.translation - half).into(), (self.pose.translation + half).into()]
    }

    /// Draws the parallelogram from its near short link to the far one, which is here.
    fn close_parallelogram(&mut self, width: f64) {
        let [far_low, far_high] = self.short_link(width);
        if let Some([low, high]) = self.near.take() {
            self.links.push(vec![low, high, far_high, far_low, low]);
        }
        self.line = vec![self.pose.translation.into()];
    }
}
