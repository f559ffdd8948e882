//! Random machines that could be built: realistic lengths, stiffnesses and angles, any order of elements.
//!
//! Every chain is closed by construction: its base is put where the chain, in its joints' home values, holds the platform at
//! home; so is every way of a module. Aligned machines have right angles only, so that axes are parallel, collinear or
//! intersect, joints idle and poses singular.

use std::collections::BTreeMap;

use kinetostat::spatial::{Axis, Pose};
use nalgebra::{Matrix6, Rotation3, Vector3};
use proptest::prelude::*;

/// Numbers in −1..1 that an element's dimensions are made of.
type Shares = [f64; 8];

#[derive(Debug, Clone)]
pub enum Kind {
    Drive,
    Joint,
    SprungJoint,
    Beam,
    Link,
    Parallelogram,
    Fixed,
    Universal,
    Spherical,
    Mass,
    /// A frame with a name, for springs.
    Frame,
    /// Ways between the frame reached and an inner one; it stands where the first of them ends.
    Module(Vec<Leg>),
}

/// An element as drawn; its numbers are spread over realistic ranges when it is written.
#[derive(Debug, Clone)]
pub struct Element {
    kind: Kind,
    is_revolute: bool,
    axis: usize,
    shares: Shares,
}

/// A chain, or a way of a module.
#[derive(Debug, Clone)]
pub struct Leg {
    elements: Vec<Element>,
    /// Springs between its named frames.
    springs: Vec<Shares>,
    /// Where it holds the platform or the inner frame.
    platform: Shares,
    /// Where the first way of a module begins.
    base: Shares,
}

/// A machine as drawn.
#[derive(Clone)]
pub struct RandomMachine {
    legs: Vec<Leg>,
    /// Couplings of hinges in each chain.
    couplings: Vec<Shares>,
    /// Gravity and the platform's mass, if it has weight.
    weight: Option<Shares>,
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

/// Elements and module between them: `before`, the module, `after`.
fn around_module(before: Vec<Kind>, module: BoxedStrategy<Kind>, after: Vec<Kind>) -> BoxedStrategy<Vec<Element>> {
    let parts = (elements_of(before), element(module), elements_of(after));
    parts.prop_map(|(before, module, after)| before.into_iter().chain([module]).chain(after).collect()).boxed()
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
        8 => elements_of(vec![Drive, Fixed, Joint, Joint, Link, Joint, Fixed, Joint, Joint]),
        // The leg of a translational machine: slide, beam, hinge, parallelogram, hinge.
        6 => elements_of(vec![Drive, Beam, Joint, Parallelogram, Joint, Fixed]),
        // A serial arm, elastic in its drives and perhaps in a link.
        2 => elements_of(vec![Drive, Fixed, Drive, Fixed, Drive, Link, Drive, Drive, Fixed, Drive]),
        2 => elements_of(vec![Drive, Fixed, Drive, Fixed, Drive]),
        // Rigid links: a leg like a telescope between joints, and a guide without a drive.
        6 => elements_of(vec![Joint, Joint, Fixed, Drive, Fixed, Joint, Joint, Joint]),
        2 => elements_of(vec![Fixed, Joint, Joint, Fixed, Joint]),
        6 => prop::collection::vec(element(any), 1..9),
        2 => elements_of(vec![Universal, Fixed, Drive, Fixed, Spherical]),
        // A serial arm with a closed loop in it, and one on a parallel machine.
        2 => around_module(vec![Drive, Fixed], module(1), vec![Fixed, Drive, Drive, Fixed, Drive]),
        1 => around_module(vec![], module(0), vec![Fixed, Drive, Fixed, Drive]),
        // Legs with a compliant joint or a closed loop in them.
        1 => around_module(vec![Drive, Beam, Joint], module(1), vec![Joint, Fixed]),
        1 => around_module(vec![Universal, Fixed], module(0), vec![Fixed, Spherical]),
    ]
}

/// A parallel module; in its ways, `depth` modules within each other.
fn module(depth: usize) -> BoxedStrategy<Kind> {
    use Kind::*;
    let way = |elements: BoxedStrategy<Vec<Element>>| hung(elements, 1);
    let ways = |kinds: Vec<Kind>, count: std::ops::Range<usize>| {
        prop::collection::vec(way(elements_of(kinds).boxed()), count).boxed()
    };
    let beams = ways(vec![Beam], 2..4);
    let legs = || ways(vec![Universal, Fixed, Drive, Fixed, Spherical], 1..4);
    // A rigid guide, or one with a beam, among driven legs.
    let guided = |guide: Vec<Kind>| {
        (way(elements_of(guide).boxed()), legs()).prop_map(|(guide, legs)| [vec![guide], legs].concat())
    };
    // A driven arm that a rod turns, too.
    let arm = way(elements_of(vec![Drive, Fixed, Joint]).boxed());
    let rod = way(elements_of(vec![Drive, Fixed, Universal, Beam, Spherical]).boxed());
    let four_bar = (arm, rod).prop_map(|(arm, rod)| vec![rod, arm]);
    let any = prop_oneof![Just(Drive), Just(Joint), Just(SprungJoint), Just(Beam), Just(Link), Just(Fixed)];
    let any = prop::collection::vec(way(prop::collection::vec(element(any), 1..6).boxed()), 2..4);
    let rigid = prop_oneof![
        2 => beams,
        2 => guided(vec![Universal, Joint]),
        2 => guided(vec![Universal, Joint, Beam]),
        2 => four_bar,
        1 => any,
    ];
    if depth == 0 {
        return rigid.prop_map(Module).boxed();
    }
    let inner = || around_module(vec![Fixed], module(depth - 1), vec![Beam]);
    let nested =
        (way(inner()), ways(vec![Beam, Fixed, Beam], 1..3)).prop_map(|(inner, beams)| [vec![inner], beams].concat());
    let swung = around_module(vec![Drive, Fixed], module(depth - 1), vec![Joint]);
    let swung = (way(swung), way(elements_of(vec![Drive, Universal, Beam, Spherical]).boxed()));
    let swung = swung.prop_map(|(swung, rod)| vec![swung, rod]);
    prop_oneof![2 => rigid, 1 => nested, 1 => swung].prop_map(Module).boxed()
}

/// A leg of these elements; one beside `plain` that have not has masses and frames among them, some with springs.
fn hung(elements: BoxedStrategy<Vec<Element>>, plain: u32) -> impl Strategy<Value = Leg> {
    let extra = || element(prop_oneof![Just(Kind::Mass), Just(Kind::Frame)]);
    let nothing = Just((Vec::new(), Vec::new()));
    let something = (prop::collection::vec(extra(), 1..6), prop::collection::vec(shares(), 0..3));
    (elements, prop_oneof![plain => nothing, 1 => something], shares(), shares()).prop_map(
        |(mut elements, (extras, springs), platform, base)| {
            for extra in extras {
                let place = between(extra.shares[7], 0.0, elements.len() as f64 + 0.99) as usize;
                elements.insert(place, extra);
            }
            Leg { elements, springs, platform, base }
        },
    )
}

/// A machine of one to six chains; often all of one kind, as machines are.
pub fn random_machine() -> impl Strategy<Value = RandomMachine> {
    let leg = || hung(elements().boxed(), 2);
    let alike = (leg(), prop::collection::vec(shares(), 1..7)).prop_map(|(leg, places)| {
        let leg = |platform| Leg { platform, ..leg.clone() };
        places.into_iter().map(leg).collect()
    });
    let legs = prop_oneof![2 => alike, 1 => prop::collection::vec(leg(), 1..7)];
    let controls = Just(vec!["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]).prop_shuffle();
    let controls = prop_oneof![2 => Just(vec!["x", "y", "z"]), 1 => controls];
    let couplings = prop_oneof![3 => Just(Vec::new()), 1 => prop::collection::vec(shares(), 1..4)];
    let weight = prop::option::weighted(0.5, shares());
    (legs, prop::bool::weighted(0.4), shares(), controls, couplings, weight).prop_map(
        |(legs, is_aligned, home, controls, couplings, weight)| RandomMachine {
            legs,
            couplings,
            weight,
            is_aligned,
            home,
            controls,
        },
    )
}

/// A serial arm with a closed loop in it, or on a parallel machine, most often with weight.
pub fn random_arm() -> impl Strategy<Value = RandomMachine> {
    use Kind::*;
    let elements = prop_oneof![
        3 => around_module(vec![Drive, Fixed], module(1), vec![Fixed, Drive, Drive, Fixed, Drive]),
        2 => around_module(vec![Drive, Fixed, Drive], module(1), vec![Link, Drive, Fixed, Drive, Drive, Drive]),
        2 => around_module(vec![], module(1), vec![Fixed, Drive, Fixed, Drive, Drive]),
    ];
    let controls = Just(vec!["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]);
    let couplings = prop_oneof![1 => Just(Vec::new()), 1 => prop::collection::vec(shares(), 1..4)];
    let weight = prop::option::weighted(0.7, shares());
    let leg = hung(elements.boxed(), 1);
    (leg, prop::bool::weighted(0.3), shares(), controls, couplings, weight).prop_map(
        |(leg, is_aligned, home, controls, couplings, weight)| RandomMachine {
            legs: vec![leg],
            couplings,
            weight,
            is_aligned,
            home,
            controls,
        },
    )
}

/// `share` in −1..1 spread over powers of ten.
fn logarithmic(share: f64, low: f64, high: f64) -> f64 {
    (low * (high / low).powf(0.5 * (share + 1.0))).round()
}

fn between(share: f64, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (share + 1.0)
}

/// A chain as it is written: what it needs besides its own elements, and its drives.
#[derive(Default)]
struct Written {
    /// Designs of the ways of its modules.
    designs: String,
    design_count: usize,
    /// Where its drives stand in their own coordinates, mm or deg, by name; and whether they are hinges.
    drives: Vec<(String, f64, bool)>,
    /// What each hinge shows instead, and where at home, by name.
    shown: BTreeMap<String, (String, f64)>,
}

impl RandomMachine {
    /// The machine file.
    pub fn toml(&self) -> String {
        let drives: usize = self.legs.iter().map(Leg::drive_count).sum();
        let count = drives.clamp(1, self.controls.len());
        let home = self.frame(&self.home, 100.0);
        let at = home.translation;
        let (low, high) = (at.add_scalar(-10.0), at.add_scalar(10.0));
        let mut toml = format!(
            "schema = 1\nname = \"random\"\ntitle = \"random\"\n{}workspace = {{ min_mm = {:?}, max_mm = {:?} }}\n\
             home = {{ {} }}\n[material.steel]\nyoungs_modulus_N_per_mm2 = 210000.0\n\
             shear_modulus_N_per_mm2 = 80000.0\n",
            self.platform(count),
            low.as_slice(),
            high.as_slice(),
            written(&home),
        );
        for (i, leg) in self.legs.iter().enumerate() {
            let chain = format!("c{i}");
            let mut written_chain = Written::default();
            self.leg(leg, &chain, "", &mut written_chain);
            written_chain = Written { shown: self.shown(&written_chain.drives), ..Written::default() };
            let (elements, end) = self.leg(leg, &chain, "", &mut written_chain);
            let platform = self.frame(&leg.platform, 150.0);
            let base = home.compose(&platform).compose(&end.inverse());
            toml += &written_chain.designs;
            toml += &format!(
                "[[chain]]\nname = \"{chain}\"\nelements = [\n  {elements},\n]\n[[mount]]\nname = \"m{i}\"\n\
                 chain = \"{chain}\"\nbase = {{ {} }}\nplatform = {{ {} }}\n",
                written(&base),
                written(&platform),
            );
        }
        toml
    }

    fn platform(&self, controls: usize) -> String {
        let controls = &self.controls[..controls];
        let Some(shares) = &self.weight else {
            return format!(
                "gravity_m_per_s2 = [0.0, 0.0, 0.0]\n\
                 platform = {{ tool_tip_mm = [5.0, -3.0, 60.0], controls = {controls:?} }}\n"
            );
        };
        let towards = Vector3::new(shares[0], shares[1], shares[2] - 0.1).normalize() * 9.81;
        let mass = match shares[3] > 0.0 {
            true => format!(", mass = {{ {} }}", mass(shares)),
            false => String::new(),
        };
        format!(
            "gravity_m_per_s2 = {:?}\nplatform = {{ tool_tip_mm = [5.0, -3.0, 60.0], controls = {controls:?}{mass} }}\n",
            towards.as_slice()
        )
    }

    /// Couplings of hinges: each shows itself with some factor, and parts of hinges before it.
    fn shown(&self, drives: &[(String, f64, bool)]) -> BTreeMap<String, (String, f64)> {
        let hinges: Vec<&(String, f64, bool)> = drives.iter().filter(|drive| drive.2).collect();
        let mut shown = BTreeMap::new();
        for shares in self.couplings.iter().filter(|_| !hinges.is_empty()) {
            let place = between(shares[0], 0.0, hinges.len() as f64 - 0.01) as usize;
            let factor = |share: f64| [-1.0, 1.0, 0.5, -2.0, 1.0, -0.731][between(share, 0.0, 5.99) as usize];
            let offset = if self.is_aligned { 90.0 } else { shares[1] * 180.0 };
            let (mut of, mut home) = (Vec::new(), offset);
            for (i, (name, value, _)) in hinges[..=place].iter().enumerate() {
                if i == place || shares[2 + i % 3] > 0.0 {
                    let factor = factor(shares[5 + (place - i) % 3]);
                    of.push(format!("{name} = {factor:?}"));
                    home += factor * value;
                }
            }
            let text = format!("shown = {{ of = {{ {} }}, offset_deg = {offset:?} }}", of.join(", "));
            shown.insert(hinges[place].0.clone(), (text, home));
        }
        shown
    }

    /// Writes the elements of a leg; also where it ends. `prefix` stands before the names of its joints in the machine.
    fn leg(&self, leg: &Leg, chain: &str, prefix: &str, into: &mut Written) -> (String, Pose) {
        let mut end = Pose::identity();
        let mut elements: Vec<String> = Vec::new();
        let mut frames: Vec<String> = if prefix.is_empty() { vec!["O".into()] } else { Vec::new() };
        for (index, element) in leg.elements.iter().enumerate() {
            elements.push(match &element.kind {
                Kind::Module(ways) => self.module(ways, chain, &format!("{prefix}e{index}"), &mut end, into),
                Kind::Drive => self.drive(index, element, prefix, &mut end, into),
                Kind::Frame => {
                    frames.push(format!("f{index}"));
                    format!("{{ frame = \"f{index}\" }}")
                }
                _ => self.element(index, element, &mut end),
            });
        }
        let springs = leg.springs.iter().filter(|_| frames.len() > 1);
        elements.extend(springs.enumerate().map(|(i, shares)| spring(i, shares, &frames)));
        (elements.join(",\n  "), end)
    }

    /// Writes a module and moves `end` to its inner frame.
    fn module(&self, ways: &[Leg], chain: &str, name: &str, end: &mut Pose, into: &mut Written) -> String {
        let mut inner = None;
        let mut mounts = Vec::new();
        for (i, way) in ways.iter().enumerate() {
            let mount = format!("{name}w{i}");
            let full = name.rsplit('_').next().unwrap_or(name);
            let own = format!("{full}w{i}");
            let (elements, way_end) = self.leg(way, chain, &format!("{mount}_"), into);
            let platform = self.frame(&way.platform, 150.0);
            let base = match &inner {
                None => {
                    let base = self.frame(&way.base, 150.0);
                    inner = Some(base.compose(&way_end).compose(&platform.inverse()));
                    base
                }
                Some(inner) => inner.compose(&platform).compose(&way_end.inverse()),
            };
            let design = format!("{chain}_{}", into.design_count);
            into.design_count += 1;
            into.designs += &format!("[[chain]]\nname = \"{design}\"\nelements = [\n  {elements},\n]\n");
            mounts.push(format!(
                "{{ name = \"{own}\", chain = \"{design}\", base = {{ {} }}, platform = {{ {} }} }}",
                written(&base),
                written(&platform)
            ));
        }
        *end = end.compose(&inner.unwrap_or(Pose::identity()));
        format!("{{ module = {{ mounts = [{}] }} }}", mounts.join(", "))
    }

    fn drive(&self, index: usize, element: &Element, prefix: &str, end: &mut Pose, into: &mut Written) -> String {
        let Moved { home, word, unit, stiffness, along, letter } = self.moved(element);
        advance(end, element.is_revolute, along, home);
        let name = format!("{prefix}e{index}");
        let (shown, home_shown) = match into.shown.get(&name) {
            Some((text, home)) => (format!(", {text}"), *home),
            None => (String::new(), home),
        };
        into.drives.push((name, home, element.is_revolute));
        format!(
            "{{ {word}_drive = {{ name = \"e{index}\", axis = \"{letter}\", home_{unit} = {home_shown:?}, {stiffness}{shown} }} }}"
        )
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

    /// What the numbers of a drive or joint are.
    fn moved(&self, element: &Element) -> Moved {
        let Element { is_revolute, axis, shares, .. } = element;
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
        let (along, letter) = (AXES[*axis], ["x", "y", "z"][*axis]);
        Moved { home, word, unit, stiffness, along, letter }
    }

    /// Writes one element and moves `end` along it.
    fn element(&self, index: usize, element: &Element, end: &mut Pose) -> String {
        let Element { kind, is_revolute, axis, shares } = element;
        let name = format!("e{index}");
        match kind {
            Kind::Drive | Kind::Module(_) | Kind::Frame => unreachable!("written by themselves"),
            Kind::Joint | Kind::SprungJoint => {
                let Moved { home, word, unit, stiffness, along, letter } = self.moved(element);
                let joint = format!("name = \"{name}\", axis = \"{letter}\", home_{unit} = {home:?}");
                advance(end, *is_revolute, along, home);
                if matches!(kind, Kind::Joint) {
                    return format!("{{ {word}_joint = {{ {joint} }} }}");
                }
                // Softer than a drive, and not quite at rest.
                let neutral = home + shares[2];
                let soft = stiffness.replace("e10", "e7").replace("e9", "e6").replace("e8", "e5");
                format!("{{ {word}_joint = {{ {joint}, neutral_{unit} = {neutral:?}, {soft} }} }}")
            }
            Kind::Universal | Kind::Spherical => {
                let (word, axes) = match kind {
                    Kind::Universal => ("universal", vec![*axis, (axis + if *is_revolute { 1 } else { 2 }) % 3]),
                    _ => ("spherical", vec![0, 1, 2]),
                };
                let angle =
                    |i: usize| if self.is_aligned { (shares[i] * 2.0).round() * 45.0 } else { shares[i] * 80.0 };
                let angles: Vec<f64> = (0..axes.len()).map(angle).collect();
                for (&axis, angle) in axes.iter().zip(&angles) {
                    end.rotate_about(AXES[axis], angle.to_radians());
                }
                let letters: Vec<&str> = axes.iter().map(|&axis| ["x", "y", "z"][axis]).collect();
                let axes = if letters.len() == 2 { format!(", axes = {letters:?}") } else { String::new() };
                format!("{{ {word}_joint = {{ name = \"{name}\", home_deg = {angles:?}{axes} }} }}")
            }
            Kind::Mass => format!("{{ mass = {{ {} }} }}", mass(shares)),
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

impl Leg {
    fn drive_count(&self) -> usize {
        let count = |element: &Element| match &element.kind {
            Kind::Drive => 1,
            Kind::Module(ways) => ways.iter().map(Leg::drive_count).sum(),
            _ => 0,
        };
        self.elements.iter().map(count).sum()
    }
}

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Numbers and words of a drive or joint.
struct Moved {
    home: f64,
    word: &'static str,
    unit: &'static str,
    stiffness: String,
    along: Axis,
    letter: &'static str,
}

fn advance(end: &mut Pose, is_revolute: bool, along: Axis, home: f64) {
    match is_revolute {
        true => end.rotate_about(along, home.to_radians()),
        false => end.translate_along(along, home),
    }
}

/// A mass and its centre.
fn mass(shares: &Shares) -> String {
    let at = [shares[4], shares[5], shares[6]].map(|share| (share * 300.0).round());
    format!("kg = {:?}, at_mm = {at:?}", logarithmic(shares[3], 1.0, 500.0))
}

/// A spring between points of two different frames, in any order.
fn spring(number: usize, shares: &Shares, frames: &[String]) -> String {
    let count = frames.len();
    let from = between(shares[0], 0.0, count as f64 - 0.01) as usize;
    let to = (from + 1 + between(shares[1], 0.0, count as f64 - 1.01) as usize) % count;
    let point = |i: usize| [0, 1, 2].map(|axis| (shares[(i + axis) % 8] * 300.0).round());
    let free_length = if shares[2] < -0.5 { 0.0 } else { between(shares[2], 50.0, 400.0) };
    let preload = if shares[3] < 0.0 { String::new() } else { format!(", preload_N = {:?}", shares[4] * 500.0) };
    let end = |frame: usize, i: usize| format!("{{ frame = \"{}\", at_mm = {:?} }}", frames[frame], point(i));
    format!(
        "{{ spring = {{ name = \"s{number}\", from = {}, to = {}, stiffness_N_per_mm = {:e}, free_length_mm = \
         {free_length:?}{preload} }} }}",
        end(from, 5),
        end(to, 2),
        logarithmic(shares[5], 1.0, 1e3),
    )
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
