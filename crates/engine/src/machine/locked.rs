//! Locked drives, which stay where they are set whatever the task: a rail before an arm, the drives under a workpiece.

use super::{Coordinate, Drive, Machine, Motion, refusal};
use crate::{
    input::{error::Result, names::listed},
    spatial::{Pose, rotation_exp},
};

/// How far the machine is moved to see whether the other drives meet its task, as a share of its characteristic length.
const TRIAL: f64 = 1e-4;

/// Positions nearer to each other are the same, as a share of them.
const SAME_POSITION: f64 = 1e-14;

/// A drive that can be locked.
struct LockableDrive {
    label: String,
    drive: Drive,
    /// Its index among the drives of the machine, or of the workpiece carrier.
    index: usize,
    carries: bool,
}

impl Machine {
    /// This machine with drives that stay at `positions` (mm or degrees) instead of serving the task; a drive is named by its label in tables
    /// ([`Machine::drive_labels`]), or by its own name if no other has it. Drives of the workpiece carrier that are not named stay where they are.
    ///
    /// Home moves to where these drives are locked, the others as near to their home as the orientation of the platform there allows.
    ///
    /// # Errors
    /// A drive that is unknown, ambiguous or named twice, a position beyond its travel, a task that the others cannot meet.
    pub fn with_locked_drives<N: AsRef<str>>(&self, positions: &[(N, f64)]) -> Result<Machine> {
        let mut machine = self.clone();
        let all = self.lockable_drives();
        let mut carried = self.carrier.as_ref().map_or_else(Vec::new, |carrier| carrier.home.drives.clone());
        let mut named: Vec<&str> = Vec::new();
        for (name, value) in positions {
            let name = name.as_ref();
            let lockable = find_lockable(&all, name)?;
            if named.contains(&lockable.label.as_str()) {
                return Err(refusal(name, "is locked twice".into()));
            }
            named.push(&lockable.label);
            let position = checked_position(&lockable.drive, name, *value)?;
            match lockable.carries {
                true => carried[lockable.index] = position,
                false => {
                    machine.locked.retain(|(index, _)| *index != lockable.index);
                    machine.locked.push((lockable.index, position));
                }
            }
            machine.definition.locked.retain(|(other, _)| *other != lockable.label);
            machine.definition.locked.push((lockable.label.clone(), *value));
        }
        if let Some(carrier) = &mut machine.carrier {
            carrier.home = carrier.serial_configuration(&carried);
        }
        if machine.locked != self.locked {
            machine.rehome_at_locked(&named.join(", "))?;
        }
        Ok(machine)
    }

    /// Label of the drive called `name`, by its label or, if no other has it, by its own name; of the workpiece carrier as well.
    ///
    /// # Errors
    /// No drive, or several.
    pub fn drive_label(&self, name: &str) -> Result<String> {
        find_lockable(&self.lockable_drives(), name).map(|found| found.label.clone())
    }

    /// Labels of the drives that [`Machine::with_locked_drives`] locked.
    pub fn locked_drive_labels(&self) -> impl Iterator<Item = &str> {
        self.definition.locked.iter().map(|(label, _)| label.as_str())
    }

    /// Label, position (mm or degrees, as shown) and drive of the locked drives, and of all of the workpiece carrier.
    pub fn locked_drives(&self) -> Vec<(String, f64, &Drive)> {
        let labels = self.drive_labels();
        let drives: Vec<&Drive> = self.drives().map(|(_, drive)| drive).collect();
        let locked = self.locked.iter().map(|&(index, value)| (labels[index].clone(), value, drives[index]));
        let carried = self.carrier.iter().flat_map(|carrier| {
            let positions = carrier.drive_labels().into_iter().zip(carrier.home.drives.iter().copied());
            positions.zip(carrier.drives()).map(|((label, value), (_, drive))| (label, value, drive))
        });
        // The way through radians must not show.
        let shown = |drive: &Drive, value: f64| (drive.motion.to_shown(value) * 1e9).round() / 1e9;
        locked.chain(carried).map(|(label, value, drive)| (label, shown(drive, value), drive)).collect()
    }

    /// Label and position (mm or degrees, as shown) of the drives that [`Machine::with_resting_drives`] left at home.
    pub fn resting_drives(&self) -> impl Iterator<Item = (String, f64)> {
        let locked = self.locked_drives().into_iter().map(|(label, value, _)| (label, value));
        locked.filter(|(label, _)| self.definition.resting.contains(label))
    }

    /// This machine along a path that commands the locked drives: those that its task does not need and nothing commands stay at home, where they
    /// are taken to stand as the program begins. These are revolute joints A, B and C of a head unless the path says how the tool stands
    /// (`is_oriented`), what carries the six revolute joints of an arm, and drives with other names than X, Y and Z beside such drives.
    ///
    /// # Errors
    /// Several drives could serve the task in place of each other, and nothing says which of them does.
    pub fn with_resting_drives(&self, is_oriented: bool) -> Result<Machine> {
        let head = (!is_oriented && !self.has_locked_head()).then(|| self.with_commanded_head()).flatten();
        let mut machine = head.unwrap_or_else(|| self.clone());
        match machine.redundancy.saturating_sub(machine.locked.len()) {
            0 => {}
            spare => machine = machine.with_spare_at_home(spare)?,
        }
        let told: Vec<&str> = self.locked_drive_labels().collect();
        let labels = machine.locked_drives().into_iter().map(|(label, ..)| label);
        machine.definition.resting = labels.filter(|label| !told.contains(&&**label)).collect();
        Ok(machine)
    }

    /// This machine with those `spare` drives locked at home that its task does not need; `Err` where others might be.
    fn with_spare_at_home(&self, spare: usize) -> Result<Machine> {
        let is_free = |drive: &usize| self.locked.iter().all(|(locked, _)| locked != drive);
        let free: Vec<usize> = (0..self.drive_count()).filter(is_free).collect();
        let at_home = |drives: &[usize]| self.with_locked_drives(&self.shown_at_home(drives)).ok();
        let mut named = self.groups_by_name(&free).into_iter().filter(|group| group.len() == spare);
        if let Some(machine) = named.find_map(|group| at_home(&group)) {
            return Ok(machine);
        }
        let could: Vec<usize> = free.into_iter().filter(|drive| at_home(&[*drive]).is_some()).collect();
        let only = (could.len() == spare).then(|| at_home(&could)).flatten();
        only.ok_or_else(|| {
            let labels: Vec<String> = self.shown_at_home(&could).into_iter().map(|(label, _)| label).collect();
            let problem = format!(
                "machine {} has {spare} more than its task needs, and nothing says which of these the path moves: expected {spare} of them in \
                 [locked] or --lock, also where they stand as at home, or in columns of the path",
                self.name
            );
            refusal(&labels.join(", "), problem)
        })
    }

    /// Groups of the `free` drives of which one may be what nothing commands, the likeliest first.
    fn groups_by_name(&self, free: &[usize]) -> Vec<Vec<usize>> {
        let (labels, count) = (self.drive_labels(), self.drive_count());
        let drives: Vec<&Drive> = self.drives().map(|(_, drive)| drive).collect();
        let is_revolute = |drive: usize| drives[drive].motion == Motion::Revolute;
        let arm = count.saturating_sub(6);
        // A revolute joint before six others is one of the arm's seven, unless the six are known to be an arm.
        let carries_arm = self.chains.len() == 1
            && (arm..count).all(is_revolute)
            && (self.arm.is_some() || !(0..arm).any(is_revolute));
        let called = |drive: usize, letters: &[&str]| {
            letters.contains(&&*labels[drive]) || letters.contains(&&*drives[drive].name)
        };
        let beside = |letters: &[&str]| -> Vec<usize> {
            let has_word = free.iter().any(|drive| called(*drive, letters));
            free.iter().copied().filter(|drive| has_word && !called(*drive, letters)).collect()
        };
        let below: Vec<usize> = free.iter().copied().filter(|drive| carries_arm && *drive < arm).collect();
        vec![below, beside(&["X", "Y", "Z", "A", "B", "C"]), beside(&["X", "Y", "Z"])]
    }

    /// Label of each of the drives with these indices, and its position at home, mm or degrees.
    pub(super) fn shown_at_home(&self, drives: &[usize]) -> Vec<(String, f64)> {
        let labels = self.drive_labels();
        let all: Vec<&Drive> = self.drives().map(|(_, drive)| drive).collect();
        let shown = |&index: &usize| (labels[index].clone(), all[index].motion.to_shown(self.home.drives[index]));
        drives.iter().map(shown).collect()
    }

    /// Describes [`Machine::locked_drives`]; `None` if there are none.
    pub fn locked_text(&self) -> Option<String> {
        let locked = self.locked_drives().into_iter();
        let locked = locked.map(|(label, value, drive)| {
            let unit = drive.motion.position_suffix();
            match self.definition.path_axes.iter().find(|(axis, _)| *axis == label) {
                Some((_, [low, high])) => format!("{label} moved within {low} to {high}{unit} by the path"),
                None => format!("{label} at {value}{unit}"),
            }
        });
        let text = locked.collect::<Vec<_>>().join(", ");
        let resting = match self.definition.resting.as_slice() {
            [] => String::new(),
            labels => format!(" (as at home, since nothing in the path commands them: {})", labels.join(", ")),
        };
        (!text.is_empty()).then(|| text + &resting)
    }

    /// All drives that can be locked: those of the machine, then those of its workpiece carrier.
    fn lockable_drives(&self) -> Vec<LockableDrive> {
        let lockable_of = |machine: &Machine, carries: bool| -> Vec<LockableDrive> {
            let drives = machine.drives().zip(machine.drive_labels()).enumerate();
            let lockable = |(index, ((_, drive), label)): (usize, ((usize, &Drive), String))| LockableDrive {
                label,
                drive: drive.clone(),
                index,
                carries,
            };
            drives.map(lockable).collect()
        };
        let mut all = lockable_of(self, false);
        all.extend(self.carrier.iter().flat_map(|carrier| lockable_of(carrier, true)));
        all
    }

    /// Moves home to where the locked drives stand, and checks that the others meet the task there; errors name `named`.
    pub(super) fn rehome_at_locked(&mut self, named: &str) -> Result<()> {
        if self.locked.len() > self.redundancy {
            let spare = match self.redundancy {
                0 => "no drive more than its task needs".into(),
                count => format!("{count} more than its task needs"),
            };
            let problem = format!("machine {} has {spare}, and {} would be locked", self.name, self.locked.len());
            return Err(refusal(named, problem));
        }
        let mut drives = self.home.drives.clone();
        for &(drive, value) in &self.locked {
            drives[drive] = value;
        }
        let at = self.forward_kinematics(&drives).map_err(|why| refusal(named, format!("locked there: {why}")))?;
        let pose = Pose { rotation: self.home.pose.rotation, ..at.pose };
        self.home = at;
        let home = self.inverse_kinematics_from(&self.home, &pose);
        self.home = home.map_err(|why| refusal(named, format!("locked there, home cannot be met: {why}")))?;
        for coordinate in self.controls.clone() {
            let mut beside = self.home.pose;
            match coordinate {
                Coordinate::Translation(axis) => beside.translation[axis] += TRIAL * self.characteristic_length,
                Coordinate::Rotation(axis) => {
                    let mut turn = nalgebra::Vector3::zeros();
                    turn[axis] = TRIAL;
                    beside.rotation *= rotation_exp(turn);
                }
            }
            if self.unlimited_inverse_kinematics_from(&self.home, &beside).is_err() {
                let problem = format!("locked there, no other drive controls {}", coordinate.name());
                return Err(refusal(named, problem));
            }
        }
        Ok(())
    }
}

/// Finds the drive whose label is `name`, or the only one of this name; `Err` for none or several.
fn find_lockable<'a>(all: &'a [LockableDrive], name: &str) -> Result<&'a LockableDrive> {
    if let Some(found) = all.iter().find(|drive| drive.label == name) {
        return Ok(found);
    }
    let mut alike = all.iter().filter(|drive| drive.drive.name == name);
    match (alike.next(), alike.next()) {
        (Some(found), None) => Ok(found),
        (Some(first), Some(second)) => Err(refusal(
            name,
            format!("several drives are called so: expected {}, {} or another label", first.label, second.label),
        )),
        (None, _) => {
            let known = listed(all.iter().map(|drive| &drive.label));
            Err(refusal(name, format!("no drive is called so; there are: {known}")))
        }
    }
}

/// Converts the shown position `value` to mm or rad; `Err` if it is not finite or beyond travel.
fn checked_position(drive: &Drive, name: &str, value: f64) -> Result<f64> {
    let unit = drive.motion.position_unit();
    if !value.is_finite() {
        return Err(refusal(name, format!("must be a number in {unit}, got {value}")));
    }
    let position = drive.motion.from_shown(value);
    match drive.travel {
        Some((low, high)) if !(low..=high).contains(&position) => {
            // At the end of the travel, but for the way through degrees.
            let inside = position.clamp(low, high);
            if (position - inside).abs() <= SAME_POSITION * inside.abs() {
                return Ok(inside);
            }
            let (low, high) = (drive.motion.to_shown(low), drive.motion.to_shown(high));
            Err(refusal(name, format!("must be within its travel of {low} to {high} {unit}, got {value}")))
        }
        _ => Ok(position),
    }
}
