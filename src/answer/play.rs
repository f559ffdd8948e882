//! Play of the drives along a path: columns of its points, and what the first screen says of it.

use serde_json::{Value, json};

use crate::{
    files::{
        exchange::{Cell, Column, Row, cells, numbers, texts},
        words::{counted, millimetres},
    },
    machine::Machine,
    page::{self, Better},
    simulation::{ROUNDING_MM, along_path::PathPointResult, play::PointPlay},
    statics::has_play,
};

/// Returns the columns of the play at the points of a path; none where no drive of `machine` has any.
pub fn play_columns(machine: &Machine) -> Vec<Column> {
    if !has_play(machine) {
        return Vec::new();
    }
    let lengths = ["play_seated_mm", "play_open_mm", "play_open_x_mm", "play_open_y_mm", "play_open_z_mm"];
    [numbers(lengths), texts(["play_sides", "play_reversed"])].concat()
}

/// Returns the lengths among [`play_columns`] that pages draw.
pub fn play_quantities(machine: &Machine) -> impl Iterator<Item = page::Quantity> {
    let labels =
        [("play_seated_mm", "motion by play of pressed drives"), ("play_open_mm", "open play, to either side")];
    let all = labels.map(|(name, label)| page::Quantity::new([name], label, "mm", Better::Smaller));
    all.into_iter().filter(|_| has_play(machine))
}

/// Returns the cells of [`play_columns`]: of what play does at a command that does not know it (`plain`), and of what is left at `result`.
pub fn play_cells(machine: &Machine, plain: Option<&PointPlay>, result: Option<&PathPointResult>) -> Row {
    if !has_play(machine) {
        return Row::new();
    }
    let mut row: Row = vec![plain.map(|play| play.seated_mm.norm()).into()];
    let Some((result, play)) = result.and_then(|result| Some((result, result.play.as_ref()?))) else {
        row.resize(play_columns(machine).len(), Cell::Missing);
        return row;
    };
    row.push(play.open_mm.norm().into());
    row.extend(cells(play.open_mm.iter().copied()));
    let labels = machine.drive_labels();
    let drives = labels.iter().zip(machine.drives()).zip(play.sides.iter().zip(&result.drive_forces));
    let sides =
        drives.filter(|((_, (_, drive)), _)| drive.half_backlash > 0.0).map(|((label, _), (side, force))| match side {
            0 => format!("{label}±"),
            _ if *force > 0.0 => format!("{label}+"),
            _ => format!("{label}-"),
        });
    row.push(sides.collect::<Vec<_>>().join(" ").into());
    row.push(play.reversed.iter().map(|drive| labels[*drive].as_str()).collect::<Vec<_>>().join(" ").into());
    row
}

/// Play along a path, collected point by point.
#[derive(Debug, Default)]
pub struct PlayCounts {
    /// Longest motion of the tool by seated play, and half the widest interval of open play, mm.
    most_mm: [f64; 2],
    /// Number of points whose play is known, and of those at which some of it is open.
    points: [usize; 2],
    /// Number of points at which a drive changes its side, and the first of them.
    reversals: usize,
    first_reversal: usize,
}

impl PlayCounts {
    /// Adds point `k`; `plain` and `left` as of [`play_cells`].
    pub fn add(&mut self, k: usize, plain: Option<&PointPlay>, left: Option<&PointPlay>) {
        let (Some(plain), Some(left)) = (plain.or(left), left.or(plain)) else { return };
        let sizes = [plain.seated_mm.norm(), left.open_mm.norm()];
        self.most_mm = [0, 1].map(|which| self.most_mm[which].max(sizes[which]));
        self.points = [self.points[0] + 1, self.points[1] + usize::from(sizes[1] > ROUNDING_MM)];
        if !left.reversed.is_empty() {
            self.first_reversal = if self.reversals == 0 { k } else { self.first_reversal };
            self.reversals += 1;
        }
    }

    /// Returns what play does, in sentences; `taken_back` says what becomes of the seated one, `place` where a point is. Empty without play.
    pub fn sentences(&self, taken_back: &str, place: impl Fn(usize) -> String) -> String {
        let ([seated, open], [points, open_points]) = (self.most_mm, self.points);
        let mut text = match seated > ROUNDING_MM {
            true => format!("Play of the drives moves the tool by up to {}: {taken_back}.\n", millimetres(seated, 3)),
            false => String::new(),
        };
        if open_points > 0 {
            text += &format!(
                "Open play and friction of the drives leave up to ±{} at {open_points} of {}, in no distance here and removed by no compensation.\n",
                millimetres(open, 3),
                counted(points, "point")
            );
        }
        if self.reversals > 0 {
            let (count, first) = (counted(self.reversals, "point"), place(self.first_reversal));
            text += &format!("Drives change the side of their backlash at {count}, first at {first}.\n");
        }
        text
    }

    /// Returns half the widest interval of open play, mm; `None` where no point has play.
    pub fn open_mm(&self) -> Option<f64> {
        (self.points[0] > 0).then_some(self.most_mm[1])
    }

    /// Returns the same as JSON; `None` where no point has play.
    pub fn json(&self) -> Option<Value> {
        let ([seated, open], [points, open_points]) = (self.most_mm, self.points);
        (points > 0).then(|| {
            json!({
                "seated_max_mm": seated,
                "open_max_mm": open,
                "points": points,
                "points_open": open_points,
                "points_reversed": self.reversals,
                "first_reversed_point": (self.reversals > 0).then_some(self.first_reversal),
            })
        })
    }
}
