//! A workpiece carrier touched by the tool.

use nalgebra::Vector3;

use super::{Configuration, Machine};
use crate::spatial::Pose;

impl Machine {
    /// Takes the point of this carrier that is at `place` (O, mm) without load for its P, on which wrenches then act, and gives the
    /// configuration it has there. Home stays that of the workpiece frame.
    pub fn touched_at(&mut self, place: Vector3<f64>) -> Configuration {
        let from_workpiece = self.home.pose.inverse().transform(place);
        for chain in &mut self.chains {
            chain.route.attachment.translation = from_workpiece;
        }
        Configuration { pose: Pose { translation: place, ..self.home.pose }, ..self.home.clone() }
    }
}
