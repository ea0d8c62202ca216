use std::io::Cursor;

use super::*;

/// A camera that looks down from the side, and what it saw of a red object behind a hand.
fn views() -> Views {
    let (sin, cos) = 0.6_f64.sin_cos();
    let pose = [[0.0, 1.0, 0.0, 0.02], [sin, 0.0, -cos, 0.05], [-cos, 0.0, -sin, 0.7]];
    let view = View {
        frame: 4,
        corner: [11, 7],
        size: [40, 30],
        colors: (0..40 * 30_u32).map(|i| [(i % 251) as u8, (i / 40) as u8, 9]).collect(),
        labels: (0..40 * 30)
            .map(|i| match i % 40 {
                0..5 => Label::Background,
                5..9 => Label::Hand,
                _ => Label::Object,
            })
            .collect(),
        depths_mm: (0..40 * 30).map(|i| if i % 7 == 0 { 0 } else { 600 + i % 50 }).collect(),
    };
    let camera = ViewCamera {
        name: "../left".into(),
        size: [64, 48],
        focal: [70.0, 72.0],
        centre: [31.2, 24.1],
        world_to_camera: vec![pose],
        views: vec![view],
    };
    let blind = ViewCamera { views: Vec::new(), ..camera.clone() };
    Views { cameras: vec![blind, camera] }
}

struct Folder {
    folder: tempfile::TempDir,
    document: Value,
}

impl Folder {
    fn written() -> Self {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(write_nerfstudio(&views(), 4, folder.path()).unwrap(), 1);
        let text = fs::read_to_string(folder.path().join(MARKER)).unwrap();
        Self { document: serde_json::from_str(&text).unwrap(), folder }
    }

    fn frame(&self) -> &Value {
        &self.document["frames"][0]
    }

    fn number(&self, name: &str) -> f64 {
        self.frame()[name].as_f64().unwrap()
    }

    /// Column and row at which nerfstudio sees a point: the camera looks along -z with y up.
    fn pixel(&self, point: Point) -> [f64; 2] {
        let matrix = |i: usize, j: usize| self.frame()["transform_matrix"][i][j].as_f64().unwrap();
        let from = [0, 1, 2].map(|i| f64::from(point[i]) - matrix(i, 3));
        let [x, y, z] = [0, 1, 2].map(|j| (0..3).map(|i| matrix(i, j) * from[i]).sum::<f64>());
        assert!(z < 0.0, "behind the camera");
        let across = self.number("fl_x") * x / -z + self.number("cx");
        [across, self.number("cy") - self.number("fl_y") * y / -z]
    }

    fn image(&self, what: &str) -> (Vec<u8>, png::OutputInfo) {
        let name = self.frame()[what].as_str().unwrap();
        let bytes = fs::read(self.folder.path().join(name)).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (pixels, info)
    }
}

#[test]
fn a_point_lies_on_the_pixel_on_which_the_camera_sees_it() {
    let (written, views) = (Folder::written(), views());
    let camera = &views.cameras[1];
    for point in [[0.0, 0.0, 0.0], [0.1, -0.05, 0.08], [-0.07, 0.12, -0.02]] {
        let ([column, row], _) = camera.project(point, 4).unwrap();
        let found = written.pixel(point);
        // The first pixel has its middle at (0.5, 0.5).
        let expected = [column + 0.5, row + 0.5];
        for axis in 0..2 {
            assert!((found[axis] - expected[axis]).abs() < 1e-4, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn points_have_the_colours_of_the_pixels_on_which_they_lie() {
    let written = Folder::written();
    let name = written.document["ply_file_path"].as_str().unwrap();
    let bytes = fs::read(written.folder.path().join(name)).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let rows: Vec<&[u8]> = bytes[end..].chunks(15).collect();
    let (image, info) = written.image("file_path");
    assert_eq!(info.color_type, png::ColorType::Rgba);
    assert!(rows.len() > 500);
    for row in rows {
        let axis = |k: usize| f32::from_le_bytes(row[4 * k..4 * k + 4].try_into().unwrap());
        let [column, line] = written.pixel([axis(0), axis(1), axis(2)]);
        // Middles of pixels, within rounding.
        assert!((column.fract() - 0.5).abs() < 1e-2 && (line.fract() - 0.5).abs() < 1e-2);
        let at = 4 * (line as usize * info.width as usize + column as usize);
        assert_eq!(image[at..at + 3], row[12..]);
        assert_eq!(image[at + 3], 255);
    }
}

#[test]
fn hands_are_masked_and_the_rest_is_transparent() {
    let written = Folder::written();
    let (image, info) = written.image("file_path");
    let (mask, _) = written.image("mask_path");
    let (depth, deep) = written.image("depth_file_path");
    assert_eq!((info.width, info.height, deep.bit_depth), (64, 48, png::BitDepth::Sixteen));
    assert_eq!((written.number("w"), written.number("h")), (64.0, 48.0));
    let view = &views().cameras[1].views[0];
    for i in 0..64 * 48 {
        let inside = view.index(i % 64, i / 64);
        let label = inside.map(|at| view.labels[at]);
        let i = i as usize;
        assert_eq!(image[4 * i + 3] == 255, label == Some(Label::Object));
        assert_eq!(mask[i] == 255, label != Some(Label::Hand));
        let steps = u16::from_be_bytes([depth[2 * i], depth[2 * i + 1]]);
        assert_eq!(steps, inside.map_or(0, |at| view.depths_mm[at]));
    }
    assert_eq!(written.document["depth_unit_scale_factor"], 0.001);
}
