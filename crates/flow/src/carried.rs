//! Points of a manipulator without texture: each of its rigid parts is registered by shape, and carries points that were spread
//! over it.

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;
use nalgebra::Vector3;

use crate::{
    FlowSettings,
    appearance::Glimpse,
    body::{Body, Surfel, parts},
    motion::vector,
    seed::{RIM, evenly},
};

/// The manipulators and the points on them.
#[derive(Default)]
pub(crate) struct Carriers {
    bodies: Vec<Body>,
    /// Whether each body was registered in the last frame.
    known: Vec<bool>,
    pub(crate) points: Vec<Carried>,
}

/// A point on a body.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    pub(crate) camera: usize,
    body: usize,
    /// On the body as it was seen at first [m].
    home: Vector3<f64>,
    /// Column and row in its camera's last frame.
    pub(crate) at: [f64; 2],
    /// Whether it was seen there.
    pub(crate) seen: bool,
}

/// Points that the manipulators' shape is made of, in all cameras together.
const SURFELS: usize = 1500;
/// Two hands are farther apart than the points on one [m].
const GAP_M: f64 = 0.03;

impl Carriers {
    /// Moves the bodies to where they are seen, and their points with them. Points of cameras that lack the frame stay.
    pub(crate) fn advance(&mut self, now: &[Option<Glimpse<'_>>], settings: &FlowSettings) {
        if self.bodies.is_empty() {
            return;
        }
        let seeing = now.iter().flatten().count();
        let observed: Vec<_> = now
            .iter()
            .flatten()
            .flat_map(|g| surface(*g, SURFELS / seeing, settings))
            .map(|surfel| surfel.at)
            .collect();
        self.known = self.bodies.iter_mut().map(|body| body.register(&observed)).collect();
        for point in &mut self.points {
            let Some(glimpse) = now.get(point.camera).copied().flatten() else { continue };
            let place = self.bodies[point.body].to_world(point.home);
            let place: Point = [place.x as f32, place.y as f32, place.z as f32];
            let projected = glimpse.camera.project(place, glimpse.frame);
            point.seen = self.known[point.body]
                && projected.is_some_and(|(at, depth)| shows(glimpse, at, depth, settings));
            if let Some((at, _)) = projected {
                point.at = at;
            }
        }
    }

    /// Spreads points over what cameras see of manipulators for the first time.
    pub(crate) fn seed(&mut self, cameras: &[(usize, Glimpse<'_>)], settings: &FlowSettings) {
        if self.bodies.is_empty() {
            let share = SURFELS / cameras.len().max(1);
            let seen: Vec<_> =
                cameras.iter().flat_map(|(_, g)| surface(*g, share, settings)).collect();
            self.bodies = parts(&seen, GAP_M).into_iter().filter_map(Body::new).collect();
        }
        for &(camera, glimpse) in cameras {
            let jump = settings.depth_jump_m as f32;
            let region = Region::Manipulator;
            for at in evenly(glimpse.view, region, settings) {
                let Some(place) = glimpse.lift(at, region, jump) else { continue };
                let place = vector(place);
                let far = |body: usize| self.bodies[body].distance(place);
                let nearest = (0..self.bodies.len()).min_by(|&a, &b| far(a).total_cmp(&far(b)));
                let Some(body) = nearest.filter(|&body| far(body) < settings.max_deviation_m)
                else {
                    continue;
                };
                let home = self.bodies[body].to_model(place);
                self.points.push(Carried { camera, body, home, at, seen: true });
            }
        }
    }
}

/// Whether a camera sees a manipulator's surface at a place and depth.
fn shows(glimpse: Glimpse<'_>, at: [f64; 2], depth: f64, settings: &FlowSettings) -> bool {
    let jump = settings.depth_jump_m as f32;
    let region = Region::Manipulator;
    glimpse.view.inset(at, region) >= RIM - 1
        && glimpse.view.is_smooth(at, region, jump)
        && glimpse
            .view
            .depth(at, region, jump)
            .is_some_and(|seen| (f64::from(seen) - depth).abs() < settings.max_deviation_m)
}

/// A camera's view of the manipulators' surface.
fn surface(glimpse: Glimpse<'_>, count: usize, settings: &FlowSettings) -> Vec<Surfel> {
    const STEP: f64 = 2.0;
    let jump = settings.depth_jump_m as f32;
    let region = Region::Manipulator;
    let lift = |at| glimpse.lift(at, region, jump).map(vector);
    glimpse
        .view
        .places(region, RIM, count)
        .into_iter()
        .filter(|&at| glimpse.view.is_smooth(at, region, jump))
        .filter_map(|[x, y]| {
            let at = lift([x, y])?;
            let right = lift([x + STEP, y])? - lift([x - STEP, y])?;
            let down = lift([x, y + STEP])? - lift([x, y - STEP])?;
            let normal = right.cross(&down).try_normalize(1e-12)?;
            Some(Surfel { at, normal })
        })
        .collect()
}
