//! Nominal kinematics of several sessions at a time, with what each would find alone.

use super::session::Session;
use crate::{
    machine::{Configuration, SideBySide},
    spatial::Pose,
};

/// Lets the sessions know what their nominal inverse kinematics gives for the pose that each is to go to.
pub(super) fn know_poses(sessions: &mut [&mut Session], poses: &[Pose]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].seeks(&poses[k])).collect();
    let found = with_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().map(|&k| (&sessions[k].command, poses[k])).collect();
        storage.inverse_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].know_from_command(&poses[k], at);
        }
    }
}

/// Finds the poses that command the drives of the sessions: [`Session::target`] then costs nothing, where it is found.
pub fn find_targets(sessions: &mut [&mut Session]) {
    let seeking: Vec<usize> = (0..sessions.len()).filter(|&k| sessions[k].target_sought().is_some()).collect();
    let found = with_storage(sessions, |storage, sessions| {
        let asked: Vec<_> = seeking.iter().filter_map(|&k| sessions[k].target_sought()).collect();
        storage.forward_kinematics(&asked)
    });
    for (&k, at) in seeking.iter().zip(found) {
        if let Some(at) = at {
            sessions[k].command = at;
        }
    }
}

/// What `find` finds with the storage of the sessions; nothing for one alone. Several stand on the same nominal machine.
fn with_storage(
    sessions: &mut [&mut Session],
    find: impl FnOnce(&mut SideBySide, &[&mut Session]) -> Vec<Option<Configuration>>,
) -> Vec<Option<Configuration>> {
    if sessions.len() < 2 {
        return Vec::new();
    }
    let own = sessions[0].side_by_side.take();
    let mut storage = own.unwrap_or_else(|| Box::new(SideBySide::new(&sessions[0].nominal)));
    let found = find(&mut storage, sessions);
    sessions[0].side_by_side = Some(storage);
    found
}
