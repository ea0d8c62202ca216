use bendtwin_core::views::Label;
use bendtwin_splat::Cpu;

use super::*;
use crate::{
    Dressed,
    testing::{Ball, motion_of},
};

/// Pairs of a scene, as pixels, until one is refused.
fn pairs(ball: &Ball, most: usize) -> Vec<(ComparedPair, Vec<u8>)> {
    let dressed = Dressed::new(&ball.twin.graph, &ball.splats).unwrap();
    let motion = motion_of(&ball.nodes, 2);
    let scene = Scene { dressed: &dressed, motion, views: &ball.views, held_out: &[] };
    let mut found = Vec::new();
    let mut emit = |pair: ComparedPair| {
        let file = std::io::Cursor::new(pair.canvas.to_png().unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let [width, height] = ball.views.cameras[pair.camera].size;
        assert_eq!((reader.info().width, reader.info().height), (2 * width, height));
        let mut pixels = vec![0; 6 * (width * height) as usize];
        reader.next_frame(&mut pixels).unwrap();
        found.push((pair, pixels));
        Ok(found.len() < most)
    };
    compared_pairs(&scene, &mut Cpu::default(), &mut emit).unwrap();
    found
}

#[test]
fn a_recorded_image_lies_beside_its_rendering() {
    let ball = Ball::new(3);
    let found = pairs(&ball, usize::MAX);
    let cameras = ball.views.cameras.len();
    assert_eq!(found.len(), 3 * cameras);
    assert_eq!(found.iter().filter(|(pair, _)| pair.is_training).count(), 2 * cameras);
    for (pair, pixels) in &found {
        let [width, _] = ball.views.cameras[pair.camera].size.map(|n| n as usize);
        let rows = pixels.chunks_exact(6 * width).map(|row| row.split_at(3 * width));
        let (mut recorded, mut difference, mut count) = (0_u8, 0_u64, 0);
        for (a, b) in rows.flat_map(|(left, right)| left.iter().zip(right)) {
            recorded = recorded.max(*a);
            difference += u64::from(a.abs_diff(*b));
            count += 1;
        }
        assert!(recorded > 150, "{recorded}");
        assert!(difference < 8 * count, "{difference} of {count}");
    }
    assert_eq!(pairs(&ball, 2).len(), 2);
}

#[test]
fn hands_are_black_in_both() {
    let mut ball = Ball::new(1);
    for camera in &mut ball.views.cameras {
        camera.views.iter_mut().for_each(|view| view.labels.fill(Label::Hand));
        camera.views.iter_mut().for_each(|view| view.colors.fill([9, 200, 9]));
        let view = &camera.views[0];
        // The view is the whole image.
        assert_eq!(view.size, camera.size);
    }
    let found = pairs(&ball, usize::MAX);
    assert!(!found.is_empty() && found.iter().all(|(_, pixels)| pixels.iter().all(|p| *p == 0)));
}
