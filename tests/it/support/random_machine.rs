//! Random machines that could be built: realistic lengths, stiffnesses and angles, any order of elements.
//!
//! Every chain is closed by construction: its base is put where the chain, in its joints' home values, holds the platform at
//! home. Aligned machines have right angles only, so that axes are parallel, collinear or intersect, joints idle and
//! poses singular.

use kinetostat::spatial::{Axis, Pose};
use nalgebra::{Matrix6, Rotation3, Vector3};
use proptest::prelude::*;

/// Numbers in −1..1 that an element's dimensions are made of.
type Shares = [f64; 8];

#[derive(Debug, Clone, Copy)]
pub enum Kind {
    Drive,
    Joint,
    SprungJoint,
    Beam,
    Link,
    Parallelogram,
    Fixed,
}

/// An element as drawn; its numbers are spread over realistic ranges when it is written.
#[derive(Debug, Clone)]
pub struct Element {
    kind: Kind,
    is_revolute: bool,
    axis: usize,
    shares: Shares,
}

#[derive(Debug, Clone)]
pub struct Leg {
    elements: Vec<Element>,
    /// Where it holds the platform.
    platform: Shares,
}

/// A machine as drawn.
#[derive(Clone)]
pub struct RandomMachine {
    legs: Vec<Leg>,
    is_aligned: bool,
    home: Shares,
    /// Controlled coordinates, the first of them as many as there are drives.
    controls: Vec<&'static str>,
}

fn shares() -> impl Strategy<Value = Shares> {
    prop::array::uniform8(-1.0..1.0)
}

fn element(kind: impl Strategy<Value = Kind>) -> impl Strategy<Value = Element> {
    (kind, prop::bool::weighted(0.7), 0usize..3, shares()).prop_map(|(kind, is_revolute, axis, shares)| Element {
        kind,
        is_revolute,
        axis,
        shares,
    })
}

fn elements_of(kinds: Vec<Kind>) -> impl Strategy<Value = Vec<Element>> {
    kinds.into_iter().map(|kind| element(Just(kind))).collect::<Vec<_>>()
}

/// Elements in an order that makes sense, or in any order.
fn elements() -> impl Strategy<Value = Vec<Element>> {
    use Kind::*;
    let any = prop_oneof![
        3 => Just(Drive), 4 => Just(Joint), 1 => Just(SprungJoint), 2 => Just(Beam), 2 => Just(Link),
        1 => Just(Parallelogram), 2 => Just(Fixed)
    ];
    prop_oneof![
        // A leg that leaves the platform all freedom: one drive, five joints.
        4 => elements_of(vec![Drive, Fixed, Joint, Joint, Link, Joint, Fixed, Joint, Joint]),
        // The leg of a translational machine: slide, beam, hinge, parallelogram, hinge.
        3 => elements_of(vec![Drive, Beam, Joint, Parallelogram, Joint, Fixed]),
        // A serial arm, elastic in its drives and perhaps in a link.
        1 => elements_of(vec![Drive, Fixed, Drive, Fixed, Drive, Link, Drive, Drive, Fixed, Drive]),
        1 => elements_of(vec![Drive, Fixed, Drive, Fixed, Drive]),
        // Rigid links: a leg like a telescope between joints, and a guide without a drive.
        3 => elements_of(vec![Joint, Joint, Fixed, Drive, Fixed, Joint, Joint, Joint]),
        1 => elements_of(vec![Fixed, Joint, Joint, Fixed, Joint]),
        3 => prop::collection::vec(element(any), 1..9),
    ]
}

/// A machine of one to six chains; often all of one kind, as machines are.
pub fn random_machine() -> impl Strategy<Value = RandomMachine> {
    let leg = || (elements(), shares()).prop_map(|(elements, platform)| Leg { elements, platform });
    let alike = (elements(), prop::collection::vec((shares(), shares()), 1..7)).prop_map(|(elements, places)| {
        let leg = |(platform, _)| Leg { elements: elements.clone(), platform };
        places.into_iter().map(leg).collect()
    });
    let legs = prop_oneof![2 => alike, 1 => prop::collection::vec(leg(), 1..7)];
    let controls = Just(vec!["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]).prop_shuffle();
    let controls = prop_oneof![2 => Just(vec!["x", "y", "z"]), 1 => controls];
    (legs, prop::bool::weighted(0.4), shares(), controls).prop_map(|(legs, is_aligned, home, controls)| RandomMachine {
        legs,
        is_aligned,
        home,
        controls,
    })
}

/// `share` in −1..1 spread over powers of ten.
fn logarithmic(share: f64, low: f64, high: f64) -> f64 {
    (low * (high / low).powf(0.5 * (share + 1.0))).round()
}

fn between(share: f64, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (share + 1.0)
}

impl RandomMachine {
    /// The machine file.
    pub fn toml(&self) -> String {
        let drives: usize = self.legs.iter().map(|leg| leg.elements.iter().filter(|e| e.is_drive()).count()).sum();
        let count = drives.clamp(1, self.controls.len());
        let home = self.frame(&self.home, 100.0);
        let at = home.translation;
        let (low, high) = (at.add_scalar(-10.0), at.add_scalar(10.0));
        let mut toml = format!(
            "schema = 1\nname = \"random\"\ntitle = \"random\"\n\
             platform = {{ tool_tip_mm = [5.0, -3.0, 60.0], controls = {:?} }}\n\
             workspace = {{ min_mm = {:?}, max_mm = {:?} }}\nhome = {{ {} }}\n\
             [material.steel]\nyoungs_modulus_N_per_mm2 = 210000.0\nshear_modulus_N_per_mm2 = 80000.0\n",
            &self.controls[..count],
            low.as_slice(),
            high.as_slice(),
            written(&home),
        );
        for (i, leg) in self.legs.iter().enumerate() {
            let mut end = Pose::identity();
            let elements: Vec<String> =
                leg.elements.iter().enumerate().map(|(k, e)| self.element(k, e, &mut end)).collect();
            let platform = self.frame(&leg.platform, 150.0);
            let base = home.compose(&platform).compose(&end.inverse());
            toml += &format!(
                "[[chain]]\nname = \"c{i}\"\nelements = [\n  {},\n]\n[[mount]]\nname = \"m{i}\"\nchain = \"c{i}\"\n\
                 base = {{ {} }}\nplatform = {{ {} }}\n",
                elements.join(",\n  "),
                written(&base),
                written(&platform),
            );
        }
        toml
    }

    /// A frame at most `distance` mm away along each axis.
    fn frame(&self, shares: &Shares, distance: f64) -> Pose {
        let angle = |share: f64| if self.is_aligned { (share * 2.0).round() * 90.0 } else { share * 180.0 };
        let length =
            |share: f64| if self.is_aligned { (share * 2.0).round() * distance / 2.0 } else { share * distance };
        let turned = Vector3::new(angle(shares[3]), angle(shares[4]), angle(shares[5])).map(f64::to_radians);
        Pose {
            translation: Vector3::new(length(shares[0]), length(shares[1]), length(shares[2])),
            ..Pose::from_roll_pitch_yaw(turned)
        }
    }

    /// Writes one element and moves `end` along it.
    fn element(&self, index: usize, element: &Element, end: &mut Pose) -> String {
        let Element { kind, is_revolute, axis, shares } = element;
        let (name, letter) = (format!("e{index}"), ["x", "y", "z"][*axis]);
        let home = match (is_revolute, self.is_aligned) {
            (true, true) => (shares[0] * 2.0).round() * 45.0,
            (true, false) => shares[0] * 90.0,
            (false, _) => (shares[0] * 200.0).round(),
        };
        let (word, unit) = if *is_revolute { ("revolute", "deg") } else { ("prismatic", "mm") };
        let stiffness = if *is_revolute {
            format!("stiffness_Nmm_per_rad = {:e}", logarithmic(shares[1], 1e6, 1e10))
        } else {
            format!("stiffness_N_per_mm = {:e}", logarithmic(shares[1], 1e2, 1e5))
        };
        let joint = format!("name = \"{name}\", axis = \"{letter}\", home_{unit} = {home:?}");
        match kind {
            Kind::Drive | Kind::Joint | Kind::SprungJoint => {
                let along = [Axis::X, Axis::Y, Axis::Z][*axis];
                match is_revolute {
                    true => end.rotate_about(along, home.to_radians()),
                    false => end.translate_along(along, home),
                }
                match kind {
                    Kind::Drive => format!("{{ {word}_drive = {{ {joint}, {stiffness} }} }}"),
                    Kind::Joint => format!("{{ {word}_joint = {{ {joint} }} }}"),
                    // Softer than a drive, and not quite at rest.
                    _ => {
                        let neutral = home + shares[2];
                        let soft = stiffness.replace("e10", "e7").replace("e9", "e6").replace("e8", "e5");
                        format!("{{ {word}_joint = {{ {joint}, neutral_{unit} = {neutral:?}, {soft} }} }}")
                    }
                }
            }
            Kind::Beam => {
                let length = between(shares[0], 50.0, 600.0);
                end.translate_along(Axis::X, length);
                let section = section(shares);
                format!("{{ beam = {{ length_mm = {length:?}, section = {section}, material = \"steel\" }} }}")
            }
            Kind::Link => {
                let advance = between(shares[0], 0.0, 500.0);
                end.translate_along(Axis::X, advance);
                let key = if shares[7] > 0.5 { "compliance_mm_rad_N" } else { "stiffness_N_mm_rad" };
                let matrix = link_matrix(shares, shares[7] > 0.5);
                let rows: Vec<String> =
                    (0..6).map(|i| format!("{:?}", matrix.row(i).iter().collect::<Vec<_>>())).collect();
                format!("{{ link = {{ advance_mm = {advance:?}, {key} = [{}] }} }}", rows.join(", "))
            }
            Kind::Parallelogram => {
                let (length, width) = (between(shares[1], 100.0, 600.0), between(shares[2], 40.0, 120.0));
                let home = if self.is_aligned { (shares[0] * 2.0).round() * 30.0 } else { shares[0] * 60.0 };
                end.rotate_about(Axis::Z, home.to_radians());
                end.translate_along(Axis::X, length);
                end.rotate_about(Axis::Z, -home.to_radians());
                let section = section(shares);
                format!(
                    "{{ parallelogram = {{ name = \"{name}\", length_mm = {length:?}, width_mm = {width:?}, \
                     bar_section = {section}, material = \"steel\", home_deg = {home:?} }} }}"
                )
            }
            Kind::Fixed => {
                let pose = self.frame(shares, 300.0);
                *end = end.compose(&pose);
                let [x, y, z]: [f64; 3] = pose.translation.into();
                let angles = roll_pitch_yaw(&pose);
                format!("{{ fixed = {{ translation_mm = [{x:?}, {y:?}, {z:?}], rotation_deg = {angles:?} }} }}")
            }
        }
    }
}

/// What can be pasted into a regression test.
impl std::fmt::Debug for RandomMachine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.toml())
    }
}

impl Element {
    fn is_drive(&self) -> bool {
        matches!(self.kind, Kind::Drive)
    }
}

fn section(shares: &Shares) -> String {
    let size = between(shares[4], 8.0, 40.0);
    match shares[5] {
        share if share < -0.3 => format!("{{ round = {{ diameter_mm = {size:?} }} }}"),
        share if share < 0.3 => format!("{{ rectangle = {{ width_mm = {size:?}, height_mm = {:?} }} }}", size * 0.6),
        _ => format!("{{ tube = {{ outer_diameter_mm = {size:?}, inner_diameter_mm = {:?} }} }}", size * 0.8),
    }
}

/// `S L Lᵀ S` with S of realistic stiffnesses and L unit lower triangular: any coupling, positive definite.
fn link_matrix(shares: &Shares, is_compliance: bool) -> Matrix6<f64> {
    let size = |i: usize| match (i < 3, is_compliance) {
        (true, false) => logarithmic(shares[1 + i], 1e3, 1e6).sqrt(),
        (false, false) => logarithmic(shares[1 + i], 1e7, 1e10).sqrt(),
        (true, true) => 1.0 / logarithmic(shares[1 + i], 1e3, 1e6).sqrt(),
        (false, true) => 1.0 / logarithmic(shares[1 + i], 1e7, 1e10).sqrt(),
    };
    let lower = Matrix6::from_fn(|i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => 0.4 * shares[(3 * i + j) % 8],
    });
    let product = lower * lower.transpose();
    Matrix6::from_fn(|i, j| product[(i.max(j), i.min(j))] * (size(i) * size(j)))
}

fn roll_pitch_yaw(pose: &Pose) -> [f64; 3] {
    let (roll, pitch, yaw) = Rotation3::from_matrix_unchecked(pose.rotation).euler_angles();
    [roll, pitch, yaw].map(f64::to_degrees)
}

/// Position and angles of a frame, as in a machine file.
fn written(pose: &Pose) -> String {
    format!("position_mm = {:?}, rotation_deg = {:?}", pose.translation.as_slice(), roll_pitch_yaw(pose))
}
