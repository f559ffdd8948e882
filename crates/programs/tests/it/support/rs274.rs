//! A second reading of G-code, for tests: nothing of the library is used, and nothing is refused.
//!
//! It knows G0 to G3 in three planes, drilling cycles, units, absolute and incremental coordinates, G10 L2, G52, G92, G54 to
//! G59, and M98 with L. What moves is given in machine
//! coordinates: all offsets are zero before G10 L2 says otherwise.

/// One motion.
#[derive(Clone, Debug)]
pub enum Step {
    /// Straight to a place.
    To([f64; 3]),
    /// Round from a place about a centre by an angle; the axes of the plane, the axis along it, and how far along that.
    Round { from: [f64; 3], centre: [f64; 2], sweep: f64, axes: [usize; 3], rise: f64 },
    /// Into a hole: up to R if it is below, over it, at R, at the bottom, and back; whether it stops at R on the way back.
    Hole { up: [f64; 3], over: [f64; 3], clear: [f64; 3], bottom: [f64; 3], back: [f64; 3], stops: bool },
}

impl Step {
    /// The place at parameter `t` of an arc, or the end of a straight motion.
    pub fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Step::To(end) => *end,
            Step::Hole { back, .. } => *back,
            Step::Round { from, centre, sweep, axes: [u, v, w], rise } => {
                let (a, b) = (from[*u] - centre[0], from[*v] - centre[1]);
                let (sin, cos) = (sweep * t).sin_cos();
                let mut place = *from;
                place[*u] = centre[0] + a * cos - b * sin;
                place[*v] = centre[1] + a * sin + b * cos;
                place[*w] += rise * t;
                place
            }
        }
    }
}

/// The state between two lines.
struct Reading {
    place: [f64; 3],
    unit: f64,
    steps_mode: bool,
    plane: [usize; 3],
    motion: u32,
    offsets: [[f64; 3]; 6],
    active: usize,
    local: [f64; 3],
    shift: [f64; 3],
    at_r: bool,
    r: f64,
    z: f64,
    initial: Option<f64>,
    steps: Vec<Step>,
}

/// What M70 and M73 keep.
#[derive(Clone, Copy)]
struct Modes {
    unit: f64,
    steps_mode: bool,
    plane: [usize; 3],
    active: usize,
}

/// What `source` moves.
pub fn read(source: &str) -> Vec<Step> {
    let lines: Vec<Vec<(char, f64)>> = source.lines().map(words).collect();
    let mut reading = Reading {
        place: [0.0; 3],
        unit: 1.0,
        steps_mode: false,
        plane: [0, 1, 2],
        motion: 0,
        offsets: [[0.0; 3]; 6],
        active: 0,
        local: [0.0; 3],
        shift: [0.0; 3],
        at_r: false,
        r: 0.0,
        z: 0.0,
        initial: None,
        steps: Vec::new(),
    };
    reading.run(&lines, 0);
    reading.steps
}

fn words(line: &str) -> Vec<(char, f64)> {
    let mut words: Vec<(char, String)> = Vec::new();
    let mut in_comment = false;
    for c in line.split(';').next().unwrap_or_default().chars().filter(|c| !c.is_whitespace()) {
        in_comment |= c == '(';
        match words.last_mut() {
            _ if in_comment => in_comment = c != ')',
            _ if c.is_ascii_alphabetic() => words.push((c.to_ascii_uppercase(), String::new())),
            Some((_, number)) => number.push(c),
            None => {}
        }
    }
    words.into_iter().filter_map(|(letter, number)| Some((letter, number.parse().ok()?))).collect()
}

impl Reading {
    /// Runs from line `at` to the end of the program or subprogram.
    fn run(&mut self, lines: &[Vec<(char, f64)>], mut at: usize) {
        // At the end of a subprogram with M73, what was kept last is restored.
        let (mut kept, mut restores) = (None, false);
        while let Some(line) = lines.get(at) {
            let m = |number: f64| line.contains(&('M', number));
            let value = |letter: char| line.iter().find(|(l, _)| *l == letter).map(|(_, value)| *value);
            if m(98.0) {
                let begin = lines.iter().position(|line| line.first() == Some(&('O', value('P').unwrap()))).unwrap();
                for _ in 0..value('L').unwrap_or(1.0) as usize {
                    self.run(lines, begin + 1);
                }
            } else if m(99.0) || m(2.0) || m(30.0) {
                return kept.filter(|_| restores).map_or((), |modes| self.become_as(modes));
            } else if m(70.0) || m(73.0) {
                let Reading { unit, steps_mode, plane, active, .. } = *self;
                (kept, restores) = (Some(Modes { unit, steps_mode, plane, active }), restores || m(73.0));
                self.line(line);
            } else if m(71.0) {
                kept = None;
                self.line(line);
            } else if m(72.0) {
                self.become_as(kept.unwrap());
            } else {
                self.line(line);
            }
            at += 1;
        }
    }

    fn become_as(&mut self, modes: Modes) {
        let Modes { unit, steps_mode, plane, active } = modes;
        (self.unit, self.steps_mode, self.plane, self.active) = (unit, steps_mode, plane, active);
    }

    fn origin(&self, axis: usize) -> f64 {
        self.offsets[self.active][axis] + self.local[axis] + self.shift[axis]
    }

    fn line(&mut self, words: &[(char, f64)]) {
        let value = |letter: char| words.iter().find(|(l, _)| *l == letter).map(|(_, value)| *value);
        let has = |code: f64| words.iter().any(|(letter, value)| *letter == 'G' && *value == code);
        for (_, code) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match *code {
                17.0 => self.plane = [0, 1, 2],
                18.0 => self.plane = [2, 0, 1],
                19.0 => self.plane = [1, 2, 0],
                20.0 => self.unit = 25.4,
                21.0 => self.unit = 1.0,
                90.0 => self.steps_mode = false,
                91.0 => self.steps_mode = true,
                98.0 => self.at_r = false,
                99.0 => self.at_r = true,
                80.0 => (self.motion, self.initial) = (80, None),
                0.0..=3.0 => (self.motion, self.initial) = (*code as u32, None),
                81.0..=89.0 => self.motion = *code as u32,
                54.0..=59.0 => self.active = *code as usize - 54,
                92.1 => self.shift = [0.0; 3],
                _ => {}
            }
        }
        let given = ['X', 'Y', 'Z'].map(|letter| value(letter).map(|value| value * self.unit));
        if has(10.0) {
            let offset = value('P').unwrap() as usize - 1;
            (0..3).for_each(|k| self.offsets[offset][k] = given[k].unwrap_or(self.offsets[offset][k]));
        } else if has(52.0) {
            (0..3).for_each(|k| self.local[k] = given[k].unwrap_or(self.local[k]));
        } else if has(92.0) {
            for (k, value) in given.into_iter().enumerate().filter_map(|(k, value)| Some((k, value?))) {
                self.shift[k] = self.place[k] - value - self.offsets[self.active][k] - self.local[k];
            }
        } else if self.motion >= 81 {
            self.drill(given, value('R').map(|r| r * self.unit), value('L').unwrap_or(1.0) as usize);
        } else if given.iter().any(Option::is_some) || value('I').or(value('J')).or(value('K')).is_some() {
            let from = self.place;
            for (k, value) in given.into_iter().enumerate().filter_map(|(k, value)| Some((k, value?))) {
                self.place[k] = value + if self.steps_mode { from[k] } else { self.origin(k) };
            }
            let step = match self.motion {
                0 | 1 => Step::To(self.place),
                turn => self.arc(turn, from, ['I', 'J', 'K'].map(&value), value('R')),
            };
            self.steps.push(step);
        }
    }

    fn arc(&self, turn: u32, from: [f64; 3], ijk: [Option<f64>; 3], radius: Option<f64>) -> Step {
        let axes @ [u, v, w] = self.plane;
        let to = self.place;
        let centre = match radius {
            // The centre left of the chord for a counter-clockwise arc below half a turn.
            Some(radius) => {
                let (du, dv) = (to[u] - from[u], to[v] - from[v]);
                let half = du.hypot(dv) / 2.0;
                let away = (radius * self.unit).powi(2) - half * half;
                let side = if turn == 3 { 1.0 } else { -1.0 } * radius.signum() * away.max(0.0).sqrt() / (2.0 * half);
                [f64::midpoint(from[u], to[u]) - dv * side, f64::midpoint(from[v], to[v]) + du * side]
            }
            None => [u, v].map(|axis| from[axis] + ijk[axis].unwrap_or(0.0) * self.unit),
        };
        let angle = |p: [f64; 3]| (p[v] - centre[1]).atan2(p[u] - centre[0]);
        let closed = (to[u] - from[u]).hypot(to[v] - from[v]) < 1e-9;
        let turned = (angle(to) - angle(from)).rem_euclid(std::f64::consts::TAU);
        let sweep = match (turn, closed) {
            (3, true) => std::f64::consts::TAU,
            (_, true) => -std::f64::consts::TAU,
            (3, _) => turned,
            _ => turned - std::f64::consts::TAU,
        };
        Step::Round { from, centre, sweep, axes, rise: to[w] - from[w] }
    }

    fn drill(&mut self, given: [Option<f64>; 3], r: Option<f64>, repeats: usize) {
        if given.iter().all(Option::is_none) && r.is_none() {
            return;
        }
        self.r = r.unwrap_or(self.r);
        self.z = given[2].unwrap_or(self.z);
        for _ in 0..if self.steps_mode { repeats } else { 1 } {
            let initial = *self.initial.get_or_insert(self.place[2]);
            let start = self.place[2];
            let mut up = self.place;
            for (k, value) in given.into_iter().enumerate().take(2).filter_map(|(k, value)| Some((k, value?))) {
                self.place[k] = value + if self.steps_mode { self.place[k] } else { self.origin(k) };
            }
            let clear = self.r + if self.steps_mode { start } else { self.origin(2) };
            let bottom = self.z + if self.steps_mode { clear } else { self.origin(2) };
            let back = if self.at_r { clear } else { initial.max(clear) };
            let at = |z: f64| [self.place[0], self.place[1], z];
            up[2] = start.max(clear);
            let (over, clear, bottom) = (at(start.max(clear)), at(clear), at(bottom));
            self.place[2] = back;
            let stops = matches!(self.motion, 85 | 89);
            self.steps.push(Step::Hole { up, over, clear, bottom, back: self.place, stops });
        }
    }
}
