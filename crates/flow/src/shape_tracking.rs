//! Tracking of manipulators without texture by their shape: each rigid part is registered to the
//! depth images, and points that were spread over it move with it.

mod body;

use bendtwin_capture::raw::Region;
use bendtwin_core::Point;
use nalgebra::Vector3;

use self::body::{Body, Surfel, parts};
use crate::{
    FlowSettings,
    appearance::PosedView,
    motion::vector,
    seed::{MIN_INSET_PX, evenly},
};

/// Rigid parts of manipulators and the points on them.
#[derive(Default)]
pub(crate) struct ShapeTracker {
    bodies: Vec<Body>,
    /// True for each body that was registered in the last frame.
    known: Vec<bool>,
    pub(crate) points: Vec<BodyPoint>,
}

/// A point on a body.
#[derive(Clone, Debug)]
pub(crate) struct BodyPoint {
    pub(crate) camera: usize,
    body: usize,
    /// Place on the body when first seen [m].
    seed_point: Vector3<f64>,
    /// Column and row in its camera's last frame.
    pub(crate) at: [f64; 2],
    /// True if it was seen there.
    pub(crate) seen: bool,
}

/// Points that the manipulators' shape is made of, in all cameras together.
const MAX_SURFELS: usize = 1500;
/// Least distance between two hands [m]; neighbouring points on one are nearer.
const MIN_GAP_M: f64 = 0.03;

impl ShapeTracker {
    /// Moves the bodies to where they are seen, and their points with them. Points of cameras that
    /// lack the frame stay.
    pub(crate) fn advance(&mut self, now: &[Option<PosedView<'_>>], settings: &FlowSettings) {
        if self.bodies.is_empty() {
            return;
        }
        let seeing = now.iter().flatten().count();
        let observed: Vec<_> = now
            .iter()
            .flatten()
            .flat_map(|g| surface(*g, MAX_SURFELS / seeing, settings))
            .map(|surfel| surfel.at)
            .collect();
        self.known = self.bodies.iter_mut().map(|body| body.register(&observed)).collect();
        for point in &mut self.points {
            let Some(posed) = now.get(point.camera).copied().flatten() else { continue };
            let place = self.bodies[point.body].to_world(point.seed_point);
            let place: Point = [place.x as f32, place.y as f32, place.z as f32];
            let projected = posed.camera.project(place, posed.frame);
            point.seen = self.known[point.body]
                && projected.is_some_and(|(at, depth)| shows(posed, at, depth, settings));
            if let Some((at, _)) = projected {
                point.at = at;
            }
        }
    }

    /// Spreads points over what cameras see of manipulators for the first time.
    pub(crate) fn seed(&mut self, cameras: &[(usize, PosedView<'_>)], settings: &FlowSettings) {
        if self.bodies.is_empty() {
            let share = MAX_SURFELS / cameras.len().max(1);
            let seen: Vec<_> =
                cameras.iter().flat_map(|(_, g)| surface(*g, share, settings)).collect();
            self.bodies = parts(&seen, MIN_GAP_M).into_iter().filter_map(Body::new).collect();
        }
        for &(camera, posed) in cameras {
            let jump = settings.depth_jump_m as f32;
            let region = Region::Manipulator;
            for at in evenly(posed.view, region, settings) {
                let Some(place) = posed.lift(at, region, jump) else { continue };
                let place = vector(place);
                let far = |body: usize| self.bodies[body].distance(place);
                let nearest = (0..self.bodies.len()).min_by(|&a, &b| far(a).total_cmp(&far(b)));
                let Some(body) = nearest.filter(|&body| far(body) < settings.max_deviation_m)
                else {
                    continue;
                };
                let seed_point = self.bodies[body].to_model(place);
                self.points.push(BodyPoint { camera, body, seed_point, at, seen: true });
            }
        }
    }
}

/// True if a camera sees a manipulator's surface at a place and depth.
fn shows(posed: PosedView<'_>, at: [f64; 2], depth: f64, settings: &FlowSettings) -> bool {
    let jump = settings.depth_jump_m as f32;
    let region = Region::Manipulator;
    posed.view.inset(at, region) >= MIN_INSET_PX - 1
        && posed.view.is_smooth(at, region, jump)
        && posed
            .view
            .depth(at, region, jump)
            .is_some_and(|seen| (f64::from(seen) - depth).abs() < settings.max_deviation_m)
}

/// A camera's view of the manipulators' surface.
fn surface(posed: PosedView<'_>, count: usize, settings: &FlowSettings) -> Vec<Surfel> {
    const STEP_PX: f64 = 2.0;
    let jump = settings.depth_jump_m as f32;
    let region = Region::Manipulator;
    let lift = |at| posed.lift(at, region, jump).map(vector);
    posed
        .view
        .places(region, MIN_INSET_PX, count)
        .into_iter()
        .filter(|&at| posed.view.is_smooth(at, region, jump))
        .filter_map(|[x, y]| {
            let at = lift([x, y])?;
            let right = lift([x + STEP_PX, y])? - lift([x - STEP_PX, y])?;
            let down = lift([x, y + STEP_PX])? - lift([x, y - STEP_PX])?;
            let normal = right.cross(&down).try_normalize(1e-12)?;
            Some(Surfel { at, normal })
        })
        .collect()
}
