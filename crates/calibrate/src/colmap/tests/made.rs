//! A model of a made recording: points on what its cameras see, in another gauge.

use bendtwin_capture::raw::{Pose, Recording};
use nalgebra::{Rotation3, UnitQuaternion};

use super::{Model, ModelCamera, ModelImage, ModelPoint};

/// Height of the made table [m].
const TABLE_M: f64 = -0.001;

/// A change of the world: `x` becomes `scale · rotation · x + translation`.
pub(super) struct Gauge {
    pub(super) scale: f64,
    /// Rodrigues' vector.
    pub(super) turn: [f64; 3],
    pub(super) shift: [f64; 3],
}

impl Gauge {
    pub(super) const SOME: [Self; 3] = [
        Self { scale: 3.7, turn: [0.4, -1.2, 2.0], shift: [10.0, -3.0, 5.0] },
        Self { scale: 0.11, turn: [-2.0, 0.3, 0.1], shift: [0.0, 0.0, 0.0] },
        Self { scale: 1.0, turn: [0.0, 3.1, 0.0], shift: [-1.0, 0.5, 0.2] },
    ];

    fn motion(&self) -> Pose {
        let turn = Rotation3::new(self.turn.into());
        Pose {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| turn[(i, j)])),
            translation: self.shift,
        }
    }
}

pub(super) struct Made(Model);

impl Made {
    /// 300 points of each camera: on the table where it is exactly, on things as another frame measured
    /// them, each a millimetre off, and one in ten wrong.
    pub(super) fn of(recording: &Recording, gauge: &Gauge, seed: u64) -> Self {
        let motion = gauge.motion();
        let scaled = |at: [f64; 3]| {
            let turned = Pose { translation: [0.0; 3], ..motion }.moved(at);
            std::array::from_fn(|k| gauge.scale * turned[k] + motion.translation[k])
        };
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut random = move |count: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % count as u64) as usize
        };
        let mut model = Model { cameras: Vec::new(), images: Vec::new(), points: Vec::new() };
        for (index, camera) in recording.cameras.iter().enumerate() {
            let mut frames = recording.source.frames(index).unwrap();
            let depth = frames.depth(1).unwrap().unwrap();
            let mut seen = Vec::new();
            while seen.len() < 300 {
                let (column, row) = (random(camera.width), random(camera.height));
                let metres = f64::from(depth.get(column, row).unwrap());
                if metres <= 0.0 {
                    continue;
                }
                let pixel = [column as f64, row as f64];
                let eye = camera.pose(0).translation;
                let measured = camera.unproject(pixel, metres, 0).map(f64::from);
                // The made table lies a millimetre below the ground.
                let share = (TABLE_M - eye[2]) / (measured[2] - eye[2]);
                let is_table = (measured[2] - TABLE_M).abs() < 0.006;
                let exact = if is_table { metres * share } else { metres };
                let exact = if random(10) == 0 { exact * 1.4 } else { exact };
                let mut off = || 0.001 * (random(2001) as f64 / 1000.0 - 1.0);
                let at = camera.unproject(pixel, exact, 0).map(|x| f64::from(x) + off());
                let id = model.points.len() as u64 + 1;
                model.points.push(ModelPoint { id, at: scaled(at) });
                seen.push(id);
            }
            let pose = camera.pose(0);
            let placed = Pose {
                rotation: motion.after(pose).rotation,
                translation: scaled(pose.translation),
            };
            let inverse = placed.inverse();
            let matrix = nalgebra::Matrix3::from_fn(|i, j| inverse.rotation[i][j]);
            let turn =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
            let i = &camera.intrinsics;
            model.cameras.push(ModelCamera {
                id: index as u32 + 1,
                kind: 1,
                size: [camera.width as u64, camera.height as u64],
                parameters: vec![i.fx, i.fy, i.cx + 0.5, i.cy + 0.5],
            });
            model.images.push(ModelImage {
                rotation: [turn.w, turn.i, turn.j, turn.k],
                translation: inverse.translation,
                camera: index as u32 + 1,
                name: format!("{index}/0.png"),
                points: seen,
            });
        }
        Self(model)
    }

    pub(super) fn model(&self) -> Model {
        self.0.clone()
    }

    pub(super) fn binary(&self) -> [Vec<u8>; 3] {
        let mut cameras = (self.0.cameras.len() as u64).to_le_bytes().to_vec();
        for camera in &self.0.cameras {
            cameras.extend(camera.id.to_le_bytes());
            cameras.extend(camera.kind.to_le_bytes());
            cameras.extend(camera.size.iter().flat_map(|n| n.to_le_bytes()));
            cameras.extend(camera.parameters.iter().flat_map(|x| x.to_le_bytes()));
        }
        let mut images = (self.0.images.len() as u64).to_le_bytes().to_vec();
        for (index, image) in self.0.images.iter().enumerate() {
            images.extend((index as u32 + 1).to_le_bytes());
            let numbers = image.rotation.iter().chain(&image.translation);
            images.extend(numbers.flat_map(|x| x.to_le_bytes()));
            images.extend(image.camera.to_le_bytes());
            images.extend(image.name.bytes().chain([0]));
            images.extend((image.points.len() as u64 + 1).to_le_bytes());
            for point in image.points.iter().chain([&u64::MAX]) {
                images.extend([1.0_f64, 2.0].iter().flat_map(|x| x.to_le_bytes()));
                images.extend(point.to_le_bytes());
            }
        }
        let mut points = (self.0.points.len() as u64).to_le_bytes().to_vec();
        for point in &self.0.points {
            points.extend(point.id.to_le_bytes());
            points.extend(point.at.iter().flat_map(|x| x.to_le_bytes()));
            points.extend([1, 2, 3]);
            points.extend(0.5_f64.to_le_bytes());
            points.extend(1_u64.to_le_bytes());
            points.extend([0; 8]);
        }
        [cameras, images, points]
    }

    pub(super) fn text(&self) -> [String; 3] {
        let list =
            |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let cameras = self.0.cameras.iter().map(|c| {
            format!("{} PINHOLE {} {} {}\n", c.id, c.size[0], c.size[1], list(&c.parameters))
        });
        let images = self.0.images.iter().enumerate().map(|(index, image)| {
            let points = image.points.iter().map(|id| format!("1.5 2.5 {id} "));
            format!(
                "{} {} {} {} {}\n{}3.5 4.5 -1\n",
                index + 1,
                list(&image.rotation),
                list(&image.translation),
                image.camera,
                image.name,
                points.collect::<String>()
            )
        });
        let points = self.0.points.iter();
        let points = points.map(|p| format!("{} {} 1 2 3 0.5 1 0\n", p.id, list(&p.at)));
        let head = "# A comment\n".to_owned();
        [
            head.clone() + &cameras.collect::<String>(),
            head.clone() + &images.collect::<String>(),
            head + &points.collect::<String>(),
        ]
    }
}
