//! An observation: points on an object at one time, in the twin's frame.

use bendtwin_core::{Graph, Point, Skin};

use crate::Error;

/// Most points of an observation.
pub const MAX_POINTS: usize = 200_000;
/// Most cameras of an observation.
pub const MAX_CAMERAS: usize = 16;
/// Coordinates beyond this are no positions of an object [m].
const FARTHEST_M: f32 = 1e3;

/// Points on the object's surface at one time. Only its points are required.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// Positions [m], shape [M, 3].
    pub points: Vec<Point>,
    /// The points are these that nodes carry, shape [M]: tracks, keypoints. `None` is a cloud,
    /// whose points are matched with the twin's skin.
    pub tracks: Option<Skin>,
    /// Weights from 0, shape [M]; empty for equal ones.
    pub weights: Vec<f32>,
    /// Velocities of the points [m/s], shape [M, 3]; empty if unknown. Only a correction uses them,
    /// and only with tracks.
    pub velocities: Vec<Point>,
    /// Positions of the cameras that saw the points [m]. They determine which parts of the surface
    /// could have been seen; without them all parts could.
    pub cameras: Vec<Point>,
}

impl Observation {
    /// Checks lengths, indices and numbers.
    pub(crate) fn check(&self, graph: &Graph) -> Result<(), Error> {
        let refuse = |text: String| Err(Error::Invalid(text));
        let m = self.points.len();
        if m == 0 || m > MAX_POINTS {
            return refuse(format!("it has {m} points: give 1 to {MAX_POINTS}"));
        }
        if self.cameras.len() > MAX_CAMERAS {
            let n = self.cameras.len();
            return refuse(format!("it has {n} cameras: give at most {MAX_CAMERAS}"));
        }
        let lengths = [
            ("weights", self.weights.len()),
            ("velocities", self.velocities.len()),
            ("tracks", self.tracks.as_ref().map_or(0, Skin::len)),
        ];
        if let Some((what, len)) = lengths.into_iter().find(|(_, len)| *len != 0 && *len != m) {
            return refuse(format!("{len} {what} for {m} points"));
        }
        if let Some(i) = self.points.iter().position(|p| !is_place(p)) {
            return refuse(format!(
                "point {i} is {:?}: leave out what was not seen, and give metres",
                self.points[i]
            ));
        }
        if let Some(i) = self.cameras.iter().position(|p| !is_place(p)) {
            return refuse(format!("camera {i} is at {:?}: give metres", self.cameras[i]));
        }
        if let Some(i) = self.velocities.iter().position(|p| !is_place(p)) {
            return refuse(format!("velocity {i} is {:?} m/s", self.velocities[i]));
        }
        let positive = |w: &f32| w.is_finite() && (0.0..=1e6).contains(w);
        if let Some(i) = self.weights.iter().position(|w| !positive(w)) {
            return refuse(format!("weight {i} is {}: give 0 to 1e6", self.weights[i]));
        }
        if !self.weights.is_empty() && self.weights.iter().all(|w| *w == 0.0) {
            return refuse("all weights are zero".into());
        }
        match &self.tracks {
            Some(tracks) if tracks.is_empty() => refuse("it has no tracks".into()),
            Some(tracks) => tracks
                .check(graph.node_count())
                .map_err(|fault| Error::Invalid(format!("a track has no place: {fault}"))),
            None => Ok(()),
        }
    }

    /// Weight of a point.
    pub(crate) fn weight(&self, point: usize) -> f64 {
        self.weights.get(point).map_or(1.0, |w| f64::from(*w))
    }
}

/// A position that an object can have.
pub(crate) fn is_place(p: &Point) -> bool {
    p.iter().all(|x| x.is_finite() && x.abs() <= FARTHEST_M)
}
