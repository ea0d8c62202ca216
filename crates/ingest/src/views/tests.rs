use bendtwin_capture::raw::{ColorImage, DepthImage, Distortion, Mask, Source, Tracks};
use bendtwin_core::views::Label;
use bendtwin_synth::{FilmOptions, Scene, film};

use super::*;

#[test]
fn views_hold_what_masks_show_in_its_place() {
    let recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    let mut reported = Vec::new();
    let views = views(&recording, &mut |share| reported.push(share)).unwrap();
    assert!(reported.is_sorted() && reported.last() == Some(&1.0));
    assert_eq!(views.check(), Ok(()));
    for (index, camera) in views.cameras.iter().enumerate() {
        let recorded = &recording.cameras[index];
        let mut frames = recording.source.frames(index).unwrap();
        assert_eq!(camera.views.len(), recording.frame_count);
        let view = &camera.views[3];
        let object = frames.mask(3, Region::Object).unwrap().unwrap();
        let color = frames.color(3).unwrap().unwrap();
        let shown = |view: &View| view.labels.iter().filter(|l| **l == Label::Object).count();
        assert_eq!(shown(view), object.pixels.iter().filter(|m| **m).count());
        for row in 0..view.size[1] {
            for column in 0..view.size[0] {
                let (x, y) = (column + view.corner[0], row + view.corner[1]);
                let here = view.index(x, y).unwrap();
                assert_eq!(Some(view.colors[here]), color.get(x as usize, y as usize));
            }
        }
        let alone = views_of_frame(&recording, 3).unwrap();
        assert_eq!(alone.cameras[index].views, std::slice::from_ref(view));
        let point = [0.05, 0.02, 0.1];
        let (found, depth) = camera.project(point, 3).unwrap();
        let (expected, far) = recorded.project(point, 3).unwrap();
        assert!((found[0] - expected[0]).abs() < 1e-3 && (found[1] - expected[1]).abs() < 1e-3);
        assert!((depth - far).abs() < 1e-6);
    }
}

#[test]
fn a_frame_beyond_the_end_has_no_views() {
    let recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    assert_eq!(views_of_frame(&recording, recording.frame_count), None);
}

/// An image for all frames, in which a disc stands for the object.
#[derive(Clone, Debug)]
struct Still {
    size: [usize; 2],
    disc: [f64; 3],
}

impl Still {
    fn image<P: Copy>(&self, inside: P, outside: P) -> bendtwin_capture::raw::Image<P> {
        let [width, height] = self.size;
        let [x, y, radius] = self.disc;
        let mut image = bendtwin_capture::raw::Image::filled(width, height, outside);
        for (index, pixel) in image.pixels.iter_mut().enumerate() {
            let (column, row) = ((index % width) as f64, (index / width) as f64);
            if (column - x).hypot(row - y) < radius {
                *pixel = inside;
            }
        }
        image
    }
}

impl Source for Still {
    fn frames(&self, _: usize) -> Result<Box<dyn Frames + '_>, bendtwin_capture::Error> {
        Ok(Box::new(self.clone()))
    }
}

impl Frames for Still {
    fn color(&mut self, _: usize) -> Result<Option<ColorImage>, bendtwin_capture::Error> {
        Ok(Some(self.image([200, 100, 50], [0, 0, 0])))
    }
    fn depth(&mut self, _: usize) -> Result<Option<DepthImage>, bendtwin_capture::Error> {
        Ok(Some(self.image(0.8, 0.0)))
    }
    fn mask(&mut self, _: usize, region: Region) -> Result<Option<Mask>, bendtwin_capture::Error> {
        Ok((region == Region::Object).then(|| self.image(true, false)))
    }
    fn tracks(&mut self) -> Result<Option<Tracks>, bendtwin_capture::Error> {
        Ok(None)
    }
}

fn still(size: [usize; 2], disc: [f64; 3], distortion: Distortion) -> Recording {
    let mut recording = film(Scene::Toy, &FilmOptions::tiny(1)).unwrap();
    recording.cameras.truncate(1);
    let camera = &mut recording.cameras[0];
    [camera.width, camera.height] = size;
    let focal = size[0] as f64;
    let (cx, cy) = (0.5 * size[0] as f64, 0.5 * size[1] as f64);
    camera.intrinsics = bendtwin_capture::raw::Intrinsics { fx: focal, fy: focal, cx, cy };
    camera.distortion = distortion;
    recording.source = std::sync::Arc::new(Still { size, disc });
    recording
}

/// The middle of the object's pixels in a view, and their number.
fn middle(view: &View) -> ([f64; 2], usize) {
    let (mut sum, mut count) = ([0.0; 2], 0);
    for (index, label) in view.labels.iter().enumerate() {
        if *label == Label::Object {
            let index = index as u32;
            sum[0] += f64::from(view.corner[0] + index % view.size[0]);
            sum[1] += f64::from(view.corner[1] + index / view.size[0]);
            count += 1;
        }
    }
    (sum.map(|s| s / count as f64), count)
}

#[test]
fn large_images_are_reduced() {
    let recording = still([1696, 960], [400.0, 300.0, 60.0], Distortion::None);
    let views = views(&recording, &mut |_| {}).unwrap();
    let camera = &views.cameras[0];
    assert_eq!(camera.size, [848, 480]);
    let (at, count) = middle(&camera.views[0]);
    // The middle of pixels 0 and 1 is the middle of the first reduced one.
    assert!((at[0] - 199.75).abs() < 0.3 && (at[1] - 149.75).abs() < 0.3, "{at:?}");
    assert!((count as f64 / (std::f64::consts::PI * 900.0) - 1.0).abs() < 0.02);
    let inside = camera.views[0].index(200, 150).unwrap();
    assert_eq!(camera.views[0].colors[inside], [200, 100, 50]);
    assert_eq!(camera.views[0].depths_mm[inside], 800);
}

#[test]
fn a_lens_is_taken_out() {
    let lens = Distortion::BrownConrady([-0.25, 0.05, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let recording = still([640, 480], [90.0, 80.0, 20.0], lens);
    let views = views(&recording, &mut |_| {}).unwrap();
    let (at, _) = middle(&views.cameras[0].views[0]);
    let camera = &recording.cameras[0];
    let i = camera.intrinsics;
    let straight = lens.undistort([(90.0 - i.cx) / i.fx, (80.0 - i.cy) / i.fy]);
    let expected = [i.fx * straight[0] + i.cx, i.fy * straight[1] + i.cy];
    assert!((expected[0] - 90.0).abs() > 5.0, "the lens bends: {expected:?}");
    assert!((at[0] - expected[0]).abs() < 1.0 && (at[1] - expected[1]).abs() < 1.0, "{at:?}");
}

#[test]
fn without_the_object_there_are_no_views() {
    let recording = still([640, 480], [-100.0, 0.0, 20.0], Distortion::None);
    assert_eq!(views(&recording, &mut |_| {}), None);
}

#[test]
fn frames_are_left_out_until_the_rest_fits() {
    let view = |side: u32| View {
        size: [side; 2],
        labels: vec![Label::Object; (side * side) as usize],
        ..View::default()
    };
    assert!(!exceeds(&[vec![Some(view(2048)), Some(view(2048)), None]]));
    assert!(exceeds(&vec![vec![Some(view(2048)), None]; 3]));
    assert!(exceeds(&vec![vec![Some(view(2048)), Some(view(2048)), Some(view(2048))]; 2]));
}
