//! Names of the elements of a chain design: their own, or their kind and number.

use super::spec::ElementSpec;

/// The word for the kind of an element, and the name that the file gives it.
pub(super) fn kind_and_name(element: &ElementSpec) -> (&'static str, Option<&str>) {
    match element {
        ElementSpec::Fixed(fixed) => ("fixed", fixed.name.as_deref()),
        ElementSpec::PrismaticDrive(drive) => ("prismatic_drive", Some(&drive.name)),
        ElementSpec::RevoluteDrive(drive) => ("revolute_drive", Some(&drive.name)),
        ElementSpec::PrismaticJoint(joint) => ("prismatic_joint", Some(&joint.name)),
        ElementSpec::RevoluteJoint(joint) => ("revolute_joint", Some(&joint.name)),
        ElementSpec::Beam(beam) => ("beam", beam.name.as_deref()),
        ElementSpec::Link(link) => ("link", link.name.as_deref()),
        ElementSpec::Parallelogram(parallelogram) => ("parallelogram", Some(&parallelogram.name)),
        ElementSpec::UniversalJoint(joint) => ("universal_joint", Some(&joint.name)),
        ElementSpec::SphericalJoint(joint) => ("spherical_joint", Some(&joint.name)),
        ElementSpec::Mass(mass) => ("mass", mass.name.as_deref()),
        ElementSpec::Frame(name) => ("frame", Some(name)),
        ElementSpec::Spring(spring) => ("spring", spring.name.as_deref()),
        ElementSpec::Module(module) => ("module", module.name.as_deref()),
    }
}

/// The name of each element: its own, or its kind and which of this kind it is, from 1.
pub(super) fn names(elements: &[ElementSpec]) -> Vec<String> {
    let of = |(i, element): (usize, &ElementSpec)| {
        let (kind, own) = kind_and_name(element);
        own.map_or_else(|| numbered(kind, &elements[..i]), String::from)
    };
    elements.iter().enumerate().map(of).collect()
}

/// The name of an element of this kind without one of its own, behind the elements `before`.
fn numbered(kind: &str, before: &[ElementSpec]) -> String {
    format!("{kind}_{}", 1 + before.iter().filter(|element| kind_and_name(element).0 == kind).count())
}
