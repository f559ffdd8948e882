//! Lines and arcs in a plane: tangents, corners that are cut off, circles through three points.

use std::f64::consts::TAU;

use crate::model::TurnDirection;

/// A point or vector in the plane.
pub(crate) type Point = [f64; 2];
/// Centre and sense of an arc.
pub(crate) type About = (Point, TurnDirection);
/// Where a corner begins, the arc that cuts it off (none for a chamfer), and where it ends.
pub(crate) type CutCorner = (Point, Option<About>, Point);

/// Tangents that differ by less, as a share of a radian, make no corner.
const SMOOTH: f64 = 1e-6;

/// A line through a point along a unit vector, or a circle, both without ends.
#[derive(Clone, Copy, Debug)]
enum Curve {
    Line(Point, Point),
    Circle(Point, f64),
}

/// A line or an arc.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub from: Point,
    pub to: Point,
    pub arc: Option<About>,
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn along(a: Point, by: f64, b: Point) -> Point {
    [a[0] + by * b[0], a[1] + by * b[1]]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn unit(a: Point) -> Point {
    let length = libm::hypot(a[0], a[1]);
    [a[0] / length, a[1] / length]
}

/// Returns the signed angle, rad, of the arc from `from` to `to`; a full turn if they are the same.
pub(crate) fn sweep(from: Point, to: Point, centre: Point, turn: TurnDirection) -> f64 {
    let [a, b] = [minus(from, centre), minus(to, centre)];
    let angle = libm::atan2(cross(a, b), dot(a, b)).rem_euclid(TAU);
    match turn {
        TurnDirection::CounterClockwise if angle > 1e-9 => angle,
        TurnDirection::CounterClockwise => TAU,
        TurnDirection::Clockwise if angle > TAU - 1e-9 => -TAU,
        TurnDirection::Clockwise => angle - TAU,
    }
}

/// Returns the centre and sense of the arc through three points; `None` if they are on a line.
pub(crate) fn circle_through(a: Point, b: Point, c: Point) -> Option<About> {
    let (u, v) = (minus(b, a), minus(c, a));
    let area = 2.0 * cross(u, v);
    if area.abs() < 1e-9 * libm::hypot(u[0], u[1]) * libm::hypot(v[0], v[1]) || area == 0.0 {
        return None;
    }
    let (uu, vv) = (dot(u, u), dot(v, v));
    let turn = if area > 0.0 { TurnDirection::CounterClockwise } else { TurnDirection::Clockwise };
    Some(([a[0] + (v[1] * uu - u[1] * vv) / area, a[1] + (u[0] * vv - v[0] * uu) / area], turn))
}

impl Element {
    /// Returns the unit tangent at the end or the start.
    pub fn tangent(&self, at_end: bool) -> Point {
        let point = if at_end { self.to } else { self.from };
        match self.arc {
            None => unit(minus(self.to, self.from)),
            Some((centre, turn)) => {
                let [a, b] = unit(minus(point, centre));
                if turn == TurnDirection::CounterClockwise { [-b, a] } else { [b, -a] }
            }
        }
    }

    /// Returns the angle, rad, by which the way turns to the left where `next` begins.
    pub fn turn_to(&self, next: &Element) -> f64 {
        let (before, behind) = (self.tangent(true), next.tangent(false));
        libm::atan2(cross(before, behind), dot(before, behind))
    }

    /// Returns the radius of the parallel at `distance` to the left of an arc, negative where there is none.
    pub fn parallel_radius(&self, (centre, turn): About, distance: f64) -> f64 {
        let radius = libm::hypot(self.to[0] - centre[0], self.to[1] - centre[1]);
        if turn == TurnDirection::CounterClockwise { radius - distance } else { radius + distance }
    }

    /// Returns by how much the radii at the ends of an arc differ; 0 for a line.
    pub fn radius_mismatch(&self) -> f64 {
        let radius = |p: Point, centre: Point| libm::hypot(p[0] - centre[0], p[1] - centre[1]);
        self.arc.map_or(0.0, |(centre, _)| (radius(self.from, centre) - radius(self.to, centre)).abs())
    }

    /// Returns the line or circle of the parallel at `distance` to the left.
    fn parallel(&self, distance: f64) -> Curve {
        match self.arc {
            None => {
                let [x, y] = self.tangent(true);
                Curve::Line(along(self.to, distance, [-y, x]), [x, y])
            }
            Some(about) => Curve::Circle(about.0, self.parallel_radius(about, distance)),
        }
    }

    /// Returns the point beside the start or the end, at `distance` to the left.
    pub fn beside(&self, at_end: bool, distance: f64) -> Point {
        let [x, y] = self.tangent(at_end);
        along(if at_end { self.to } else { self.from }, distance, [-y, x])
    }

    /// Returns where the parallels of this and the next element, at `distance` to the left, meet nearest to the corner; `None` if nowhere.
    pub fn meeting(&self, next: &Element, distance: f64) -> Option<Point> {
        let away = |p: &Point| dot(minus(*p, self.to), minus(*p, self.to));
        let points = meetings(self.parallel(distance), next.parallel(distance));
        points.into_iter().filter(|p| p.iter().all(|x| x.is_finite())).min_by(|p, q| away(p).total_cmp(&away(q)))
    }

    /// Returns the distance of `p` from the element.
    fn distance_to(&self, p: Point) -> f64 {
        let ends = [self.from, self.to].into_iter().chain(self.foot(p));
        ends.map(|q| libm::hypot(p[0] - q[0], p[1] - q[1])).fold(f64::INFINITY, f64::min)
    }

    /// Returns the distance between two elements, 0 if they cross.
    pub fn distance(&self, other: &Element) -> f64 {
        let on = |e: &Element, p: Point| e.foot(p).is_some();
        let crosses =
            meetings(self.parallel(0.0), other.parallel(0.0)).into_iter().any(|p| on(self, p) && on(other, p));
        if crosses {
            return 0.0;
        }
        // Inside an arc, the nearest point lies across a line, or on the line of two centres.
        let nearest = |arc: &Element, other: &Element| {
            let about = arc.arc?;
            let [x, y] = match other.arc {
                None => other.tangent(true),
                Some((centre, _)) => {
                    let [x, y] = unit(minus(centre, about.0));
                    [y, -x]
                }
            };
            let radius = arc.parallel_radius(about, 0.0);
            let points = [radius, -radius].map(|by| along(about.0, by, [-y, x]));
            points.into_iter().filter(|p| on(arc, *p)).map(|p| other.distance_to(p)).reduce(f64::min)
        };
        let ends = [self.distance_to(other.from), self.distance_to(other.to)];
        let own_ends = [other.distance_to(self.from), other.distance_to(self.to)];
        let inside = [nearest(self, other), nearest(other, self)].into_iter().flatten();
        ends.into_iter().chain(own_ends).chain(inside).fold(f64::INFINITY, f64::min)
    }

    /// Returns the least and greatest coordinates of a box around the element.
    pub fn bounds(&self) -> [Point; 2] {
        let (low, high) = match self.arc {
            None => ([0, 1].map(|i| self.from[i].min(self.to[i])), [0, 1].map(|i| self.from[i].max(self.to[i]))),
            Some(about) => {
                let radius = self.parallel_radius(about, 0.0);
                (about.0.map(|x| x - radius), about.0.map(|x| x + radius))
            }
        };
        [low, high]
    }

    /// Returns the point of the element nearest to `p`, if it is within it.
    fn foot(&self, p: Point) -> Option<Point> {
        match self.arc {
            None => {
                let tangent = self.tangent(true);
                let at = dot(minus(p, self.from), tangent);
                let length = dot(minus(self.to, self.from), tangent);
                (0.0..=length).contains(&at).then(|| along(self.from, at, tangent))
            }
            Some((centre, turn)) => {
                let radius = libm::hypot(self.to[0] - centre[0], self.to[1] - centre[1]);
                let foot = along(centre, radius, unit(minus(p, centre)));
                let whole = sweep(self.from, self.to, centre, turn).abs();
                (sweep(self.from, foot, centre, turn).abs() <= whole).then_some(foot)
            }
        }
    }

    /// Cuts off the corner before the line `next` by a chamfer of this `length`, or one that takes `length` of each line. `None` where
    /// there is no corner, `Err` where it does not fit.
    pub fn chamfer(&self, next: &Element, length: f64, is_leg: bool) -> Result<Option<CutCorner>, ()> {
        let (before, behind) = (self.tangent(true), next.tangent(false));
        if cross(before, behind).abs() < SMOOTH && dot(before, behind) > 0.0 {
            return Ok(None);
        }
        let leg = if is_leg { length } else { length / (2.0 * libm::cos(self.turn_to(next).abs() / 2.0)) };
        let lengths = [minus(self.to, self.from), minus(next.to, next.from)].map(|[a, b]| libm::hypot(a, b));
        let fits = self.arc.is_none() && next.arc.is_none() && leg > 0.0 && lengths.iter().all(|length| leg <= *length);
        if fits { Ok(Some((along(self.to, -leg, before), None, along(self.to, leg, behind)))) } else { Err(()) }
    }
}

/// Cuts off the corner between two elements by an arc of `radius` that is tangential to both. `None` where there is no corner, `Err` where it
/// does not fit.
pub(crate) fn round_corner(a: &Element, b: &Element, radius: f64) -> Result<Option<CutCorner>, ()> {
    let (before, behind) = (a.tangent(true), b.tangent(false));
    let turned = cross(before, behind);
    if turned.abs() < SMOOTH {
        return if dot(before, behind) > 0.0 { Ok(None) } else { Err(()) };
    }
    let side = radius * turned.signum();
    let centre = a.meeting(b, side).ok_or(())?;
    let (begin, end) = a.foot(centre).zip(b.foot(centre)).ok_or(())?;
    let turn = if side > 0.0 { TurnDirection::CounterClockwise } else { TurnDirection::Clockwise };
    Ok(Some((begin, Some((centre, turn)), end)))
}

/// Returns the points in which two curves meet.
fn meetings(a: Curve, b: Curve) -> Vec<Point> {
    match (a, b) {
        (Curve::Line(p, t), Curve::Line(q, u)) => vec![along(p, cross(minus(q, p), u) / cross(t, u), t)],
        (Curve::Line(point, tangent), Curve::Circle(centre, radius))
        | (Curve::Circle(centre, radius), Curve::Line(point, tangent)) => {
            let from = minus(point, centre);
            let middle = -dot(from, tangent);
            let height = radius * radius - dot(from, from) + middle * middle;
            let root = height.max(0.0).sqrt();
            if height < -1e-9 || radius <= 0.0 {
                return Vec::new();
            }
            vec![along(point, middle - root, tangent), along(point, middle + root, tangent)]
        }
        (Curve::Circle(c, r), Curve::Circle(d, s)) => {
            let between = minus(d, c);
            let distance = libm::hypot(between[0], between[1]);
            let middle = (distance * distance + r * r - s * s) / (2.0 * distance);
            let [x, y] = unit(between);
            if distance == 0.0 || s <= 0.0 {
                return Vec::new();
            }
            meetings(Curve::Line(along(c, middle, [x, y]), [-y, x]), Curve::Circle(c, r))
        }
    }
}
