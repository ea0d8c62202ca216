//! Images and tracks of a scene, with its faults.

use bendtwin_capture::{
    Error,
    raw::{ColorImage, DepthImage, Frames, Mask, Region, Source, Tracks},
};
use bendtwin_synth::analytic::{Hit, Precision, Ray, View};

use super::{AXES, Body, FRAMES, HEIGHT, TestScene, WIDTH};
use crate::vector::{add, turn};

/// Half the largest noise of depth [m].
const NOISE_M: f64 = 0.001;

/// A number from 0 to 1 that depends on everything and looks random.
fn pseudo_random(seed: [usize; 4]) -> f64 {
    let mut x = seed.iter().fold(0x9E37_79B9_7F4A_7C15_u64, |h, s| {
        (h ^ *s as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9).rotate_left(29)
    });
    x ^= x >> 31;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

impl Source for TestScene {
    fn frames(&self, camera: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(SceneReader { scene: self, camera, rendered: None }))
    }
}

struct SceneReader<'a> {
    scene: &'a TestScene,
    camera: usize,
    /// The frame that was rendered last: colour, depth and masks show the same.
    rendered: Option<(usize, View<Body>)>,
}

impl SceneReader<'_> {
    fn moment(&self, frame: usize) -> Option<f64> {
        *self.scene.moments[self.camera].get(frame)?
    }

    fn view(&mut self, frame: usize) -> Option<&View<Body>> {
        let moment = self.moment(frame)?;
        if self.rendered.as_ref().is_none_or(|(f, _)| *f != frame) {
            let camera = &self.scene.cameras[self.camera];
            let view = self.scene.bodies(moment).view(camera, 0, Precision::Double);
            self.rendered = Some((frame, view));
        }
        self.rendered.as_ref().map(|(_, view)| view)
    }

    /// Noise belongs to the moment: a frame that is shown twice is the same twice.
    fn seed(&self, frame: usize) -> usize {
        self.moment(frame).map_or(0, |m| m.to_bits() as usize)
    }
}

impl Frames for SceneReader<'_> {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        if self.scene.damaged.contains(&(self.camera, frame)) {
            let at = format!("color/{}/{frame}.png", self.camera);
            return Err(Error::Damaged { at, fault: "it ends early".to_owned() });
        }
        let (seed, camera) = (self.seed(frame), self.camera);
        let pixel = |[column, row]: [usize; 2], hit: Option<Hit<Body>>| {
            let grain = (8.0 * pseudo_random([seed, camera, column, row])) as u8;
            match hit.map(|h| (h.body, h.local)) {
                Some((Body::Object, local)) => {
                    let cell = local.map(|x| (5.0 * (x + 2.0)) as usize);
                    let shade = |k| {
                        40 + (180.0 * pseudo_random([cell[0], cell[1], cell[2], k])) as u8 + grain
                    };
                    [shade(1), shade(2), shade(3)]
                }
                Some((Body::Ball, ..)) => [210, 160, 130 + grain],
                Some((Body::Floor, ..)) => [120 + grain, 124, 128],
                None => [235, 235, 230 + grain],
            }
        };
        Ok(self.view(frame).map(|view| view.image(pixel)))
    }

    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        let (seed, scene, camera) = (self.seed(frame), self.scene, self.camera);
        let pixel = |[column, row]: [usize; 2], hit: Option<Hit<Body>>| {
            if pseudo_random([seed, camera, column, 7000 + row]) < scene.holes {
                return 0.0;
            }
            let noise =
                NOISE_M * (2.0 * pseudo_random([seed, 50 + camera, column, row]) - 1.0) * 2.0;
            hit.map_or(0.0, |h| (h.depth_m + noise) as f32 * scene.depth_factor[camera])
        };
        Ok(self.view(frame).map(|view| view.image(pixel)))
    }

    fn mask(&mut self, frame: usize, region: Region) -> Result<Option<Mask>, Error> {
        if region == Region::Manipulator && self.scene.hidden_hand {
            return Ok(None);
        }
        let exchanged = self.scene.exchanged_masks.contains(&self.camera);
        let wanted = match (region, exchanged) {
            (Region::Object, false) | (Region::Manipulator, true) => Body::Object,
            _ => Body::Ball,
        };
        let empty =
            region == Region::Object && self.scene.empty_masks.contains(&(self.camera, frame));
        Ok(self.view(frame).map(|view| view.mask(|body| !empty && body == wanted)))
    }

    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let Some(transposed) = self.scene.tracks else { return Ok(None) };
        let camera = &self.scene.cameras[self.camera];
        let ray = |pixel| Ray::through(camera, pixel, 0, Precision::Double);
        let start = self.scene.bodies(0.0);
        let mut spots = Vec::new();
        for row in (0..HEIGHT).step_by(3) {
            for column in (0..WIDTH).step_by(3) {
                let hit = start.hit(&ray([column as f64, row as f64]));
                if let Some(Hit { body: Body::Object, local, .. }) = hit {
                    spots.push(local);
                }
            }
        }
        let mut tracks = Tracks { count: spots.len(), ..Tracks::default() };
        for frame in 0..FRAMES {
            let moment = self.moment(frame).unwrap_or(frame as f64);
            let bodies = self.scene.bodies(moment);
            let (middle, turned) = self.scene.object(moment);
            for spot in &spots {
                let at = add(middle, turn(&turned, std::array::from_fn(|a| spot[a] * AXES[a])));
                let behind = ([-1.0; 2], -1.0);
                let (pixel, depth) = camera.project(at.map(|x| x as f32), 0).unwrap_or(behind);
                let seen = bodies
                    .hit(&ray(pixel))
                    .is_some_and(|h| h.body == Body::Object && (h.depth_m - depth).abs() < 0.01);
                let [x, y] = pixel.map(|p| p as f32);
                tracks.points.push(if transposed { [y, x] } else { [x, y] });
                tracks.visible.push(seen);
            }
        }
        Ok(Some(tracks))
    }
}
