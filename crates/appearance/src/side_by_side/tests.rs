use bendtwin_core::Views;
use bendtwin_splat::Cpu;

use super::{
    layout::{GAP_PX, LINE_PX},
    *,
};
use crate::{
    Dressed,
    testing::{Ball, motion_of},
};

/// The video of the first camera.
fn filmed(ball: &Ball, views: &Views) -> Vec<u8> {
    let dressed = Dressed::new(&ball.twin.graph, &ball.splats).unwrap();
    let motion = motion_of(&ball.nodes, 2);
    let scene = Scene { dressed: &dressed, motion, views, held_out: &[] };
    let mut bytes = Vec::new();
    let mut rasteriser = Cpu::default();
    assert!(side_by_side(&scene, 0, 30.0, &mut rasteriser, &mut bytes, &mut || true).unwrap());
    bytes
}

/// Brightest channel of each panel, by frames.
fn brightest(bytes: &[u8], layout: Layout) -> Vec<[u8; 3]> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let frames = reader.info().animation_control.unwrap().num_frames;
    let [width, height] = layout.size().map(|n| n as usize);
    let [panel_width, panel_height] = layout.panel.map(|n| n as usize);
    let mut found = Vec::new();
    for _ in 0..frames {
        let mut pixels = vec![0; 3 * width * height];
        reader.next_frame(&mut pixels).unwrap();
        found.push(std::array::from_fn(|k| {
            let left = (GAP_PX + k as f32 * layout.step) as usize;
            let rows = LINE_PX as usize..LINE_PX as usize + panel_height;
            let row =
                |y: usize| &pixels[3 * (y * width + left)..3 * (y * width + left + panel_width)];
            rows.flat_map(row).copied().max().unwrap_or_default()
        }));
    }
    found
}

#[test]
fn a_perfect_prediction_differs_by_rounding_alone() {
    let ball = Ball::new(3);
    let found = brightest(&filmed(&ball, &ball.views), layout_of(&ball));
    assert_eq!(found.len(), 3);
    for [recorded, predicted, difference] in found {
        assert!(recorded > 150 && predicted > 150, "{recorded} {predicted}");
        // Half-covered pixels at the outline are object or background in the recording.
        assert!(difference < 140, "{difference}");
    }
}

#[test]
fn what_was_recorded_elsewhere_shows_as_a_difference() {
    let ball = Ball::new(3);
    let mut views = ball.views.clone();
    for view in &mut views.cameras[0].views {
        view.colors.fill([255, 0, 255]);
    }
    let found = brightest(&filmed(&ball, &views), layout_of(&ball));
    assert!(found.iter().all(|[.., difference]| *difference > 200), "{found:?}");
}

#[test]
fn frames_that_were_left_out_are_bridged() {
    let ball = Ball::new(5);
    let mut views = ball.views.clone();
    views.cameras[0].views.retain(|view| view.frame % 2 == 0);
    let bytes = filmed(&ball, &views);
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control.unwrap().num_frames, 3);
    let size = reader.output_buffer_size().unwrap();
    reader.next_frame(&mut vec![0; size]).unwrap();
    let control = reader.info().frame_control.unwrap();
    assert_eq!((control.delay_num, control.delay_den), (200, 3000));
}

#[test]
fn hands_hide_a_prediction_and_are_not_compared() {
    let ball = Ball::new(1);
    let mut view = ball.views.cameras[0].views[0].clone();
    view.labels.fill(Label::Hand);
    view.colors.fill([200, 100, 50]);
    let area = Rectangle::of(&view);
    let image = Image {
        color: vec![[1.0; 3]; area.pixel_count()],
        alpha: vec![1.0; area.pixel_count()],
        ..Image::default()
    };
    assert!(prediction(&image, &view, area).iter().all(|p| *p == [80, 40, 20]));
    let difference = difference(&image, &Target::new(&view, area));
    assert!(difference.iter().all(|p| *p == NOT_COMPARED));
}

#[test]
fn cameras_without_views_have_no_video() {
    let ball = Ball::new(1);
    let dressed = Dressed::new(&ball.twin.graph, &ball.splats).unwrap();
    let views = Views::default();
    let motion = motion_of(&ball.nodes, 1);
    let scene = Scene { dressed: &dressed, motion, views: &views, held_out: &[] };
    let mut bytes = Vec::new();
    let wrote =
        side_by_side(&scene, 0, 30.0, &mut Cpu::default(), &mut bytes, &mut || true).unwrap();
    assert!(!wrote && bytes.is_empty());
}

/// The layout of the first camera's video, whose area is the whole image.
fn layout_of(ball: &Ball) -> Layout {
    Layout::new(ball.views.cameras[0].size)
}
