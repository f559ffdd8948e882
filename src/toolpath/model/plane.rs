//! The three planes circles and arcs lie in, and the two ways round.

/// A coordinate plane. Angles in it turn from its first axis toward its second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Plane {
    /// First axis x, second y, normal z (G17).
    #[default]
    Xy,
    /// First axis z, second x, normal y (G18).
    Zx,
    /// First axis y, second z, normal x (G19).
    Yz,
}

impl Plane {
    /// Indices (0 = x, 1 = y, 2 = z) of the first axis, the second axis and the normal, a right-handed triple.
    #[must_use]
    pub fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// Which way round a circle or an arc goes, seen from the tip of its plane's normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// From the plane's second axis toward its first (G2).
    Clockwise,
    /// From the plane's first axis toward its second (G3).
    CounterClockwise,
}
