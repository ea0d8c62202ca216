//! Images and tracks of a scene, with its faults.

use bendtwin_capture::{
    Error,
    raw::{Camera, ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks},
};
use bendtwin_core::geometry::vector3;
use bendtwin_synth::analytic::{Hit, Precision, Ray, View};

use super::{BALL_M, HAND_M, TestScene, Vec3, hand_middle, place, point, sphere};

/// A scene and its cameras.
#[derive(Debug)]
pub(super) struct SceneSource {
    pub(super) scene: TestScene,
    pub(super) cameras: Vec<Camera>,
}

impl Source for SceneSource {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(SceneReader { source: self, camera, index: camera }))
    }
}

struct SceneReader<'a> {
    source: &'a SceneSource,
    camera: usize,
    index: usize,
}

impl SceneReader<'_> {
    fn camera(&self) -> &Camera {
        &self.source.cameras[self.camera]
    }

    fn view(&self, frame: usize) -> View<Region> {
        self.source.scene.bodies(frame).view(self.camera(), frame, Precision::Single)
    }

    /// A pattern that is fixed to the bodies.
    fn textured(&self, frame: usize) -> ColorImage {
        let origin = place(frame, Vec3::zeros());
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|a| place(frame, a) - origin);
        self.view(frame).image(|at, hit| {
            let Some(Hit { depth_m, .. }) = hit else { return [0; 3] };
            let world = vector3(self.camera().unproject(at.map(|v| v as f64), depth_m, frame));
            let [x, y, z] = axes.map(|a| 300.0 * a.dot(&(world - origin)));
            let waves =
                [(x + 0.7 * y).sin() * (z - x).sin(), (y * 0.8 - z).sin(), (x * 0.6 + z).cos()];
            waves.map(|v| (128.0 + 100.0 * v) as u8)
        })
    }

    fn is_missing(&self, frame: usize) -> bool {
        self.source.scene.missing.contains(&(self.index, frame))
    }
}

impl Frames for SceneReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        let plain = |hit: Option<Hit<Region>>| match hit.map(|h| h.body) {
            Some(Region::Object) => [200, 100, 50],
            Some(Region::Manipulator) => [50, 50, 50],
            None => [0; 3],
        };
        let image = if self.source.scene.tracked {
            self.view(frame).image(|_, hit| plain(hit))
        } else {
            // Recordings without tracks need a texture to follow.
            self.textured(frame)
        };
        Ok((!self.is_missing(frame)).then_some(image))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        // To the millimetre, as cameras give it; a wall 1.5 m away behind all.
        let rounded = |depth_m: f64| (depth_m * 1e3).round() as f32 / 1e3;
        let image = self.view(frame).image(|_, hit| rounded(hit.map_or(1.5, |h| h.depth_m)));
        Ok((!self.is_missing(frame)).then_some(image))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        let shown = self.source.scene.masks;
        let unmasked =
            region == Region::Manipulator && self.source.scene.hand_unmasked.contains(&frame);
        let image = self.view(frame).mask(|body| shown && !unmasked && body == region);
        let there = region == Region::Object || self.source.scene.hand;
        Ok((there && !self.is_missing(frame)).then_some(image))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let scene = &self.source.scene;
        if !scene.tracked {
            return Ok(None);
        }
        let ball = sphere(900).into_iter().map(|p| (Region::Object, p * BALL_M));
        let hand =
            sphere(120).into_iter().map(|p| (Region::Manipulator, hand_middle() + p * HAND_M));
        let all: Vec<(Region, Vec3)> =
            ball.chain(hand.take(if scene.hand { 120 } else { 0 })).collect();
        let mut tracks = Tracks { count: all.len(), ..Tracks::default() };
        for frame in 0..scene.frames {
            let bodies = scene.bodies(frame);
            for (i, (region, p)) in all.iter().enumerate() {
                let world = place(frame, *p);
                let Some((mut pixel, z)) = self.camera().project(point(world), frame) else {
                    tracks.points.push([f32::NAN; 2]);
                    tracks.visible.push(false);
                    continue;
                };
                let ray = Ray::through(self.camera(), pixel, frame, Precision::Single);
                let seen = |hit: Hit<_>| hit.body == *region && (hit.depth_m - z).abs() < 2e-3;
                let mut visible = bodies.hit(&ray).is_some_and(seen);
                if *region == Region::Manipulator && scene.hand_hidden.contains(&frame) {
                    visible = false;
                }
                if let Some((_, speed)) =
                    scene.slipping.filter(|(n, _)| i % n == 0 && *region == Region::Object)
                {
                    pixel[0] += speed * frame.saturating_sub(4) as f64;
                }
                tracks.points.push(pixel.map(|x| x as f32));
                tracks.visible.push(visible);
            }
        }
        Ok(Some(tracks))
    }
}
