use std::io::Cursor;

use bendtwin_core::{Skin, Tube};

use super::*;

/// A picture: width, height and its bytes, red, green, blue, opacity.
fn read(bytes: &[u8]) -> (usize, usize, Vec<[u8; 4]>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    let pixels = data.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    (info.width as usize, info.height as usize, pixels)
}

/// A square of two triangles that each of its four nodes carries a corner of, upright, red.
fn square() -> (Surface, Vec<Point>) {
    let nodes = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]];
    let carriers = Skin {
        starts: vec![0, 1, 2, 3, 4],
        nodes: vec![0, 1, 2, 3],
        weights: vec![1.0; 4],
        frames: vec![[u32::MAX; 3]; 4],
        offsets_m: vec![[0.0; 3]; 4],
        observed_points: vec![u32::MAX; 4],
    };
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    (Surface { carriers, triangles, colors: vec![[200, 20, 20]; 4], tubes: vec![] }, nodes)
}

#[test]
fn a_surface_fills_the_picture_in_its_colour_on_a_transparent_background() {
    let (surface, nodes) = square();
    let (width, height, pixels) = read(&of_surface(&surface, &nodes, 160));
    assert_eq!((width, height), (160, 120));
    assert_eq!(pixels[0][3], 0, "the corner is transparent");
    let [red, green, _, opacity] = pixels[60 * 160 + 80];
    assert!(opacity == 255 && red > 100 && red > 3 * green, "{:?}", pixels[60 * 160 + 80]);
    let rows: Vec<usize> = (0..120).filter(|y| pixels[y * 160 + 80][3] > 0).collect();
    let share = (rows[rows.len() - 1] - rows[0] + 1) as f64 / 120.0;
    assert!((0.9..0.95).contains(&share), "it has {share} of the height");
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    let points = [[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    // The widest view looks along x, so that the blue point is behind the red one but lower in the picture.
    let colors = [[255, 0, 0], [0, 0, 255], [0, 255, 0], [0, 255, 0]];
    let (width, height, pixels) = read(&of_points(&points, &colors, 64));
    let counts = |channel: usize| {
        pixels
            .iter()
            .filter(|p| p[3] == 255 && p[channel] > 80 && p[(channel + 1) % 3] < 40)
            .count()
    };
    let (red, blue) = (counts(0), counts(2));
    assert!(red > blue && blue > 0, "{red} red and {blue} blue pixels of {width} x {height}");
}

#[test]
fn cables_and_nothing_have_pictures_too() {
    let nodes: Vec<Point> = (0..10).map(|i| [0.1 * i as f32, 0.0, 0.05]).collect();
    let tube = Tube { nodes: (0..10).collect(), radius_m: 0.03 };
    let cable = Surface { tubes: vec![tube], ..Surface::default() };
    let (_, _, pixels) = read(&of_surface(&cable, &nodes, 200));
    let opaque = pixels.iter().filter(|p| p[3] == 255).count();
    assert!((500..6000).contains(&opaque), "{opaque} pixels");
    let (_, _, pixels) = read(&of_surface(&Surface::default(), &[], 16));
    assert!(pixels.iter().all(|p| p[3] == 0));
    let (width, ..) = read(&of_points(&[[f32::NAN; 3]], &[], 1_000_000));
    assert_eq!(width, 1024, "the width is bounded");
}

#[test]
fn places_far_apart_are_drawn_within_the_picture() {
    let points = [[1e30, -1e30, 0.0], [-1e30, 1e30, 1e30], [0.0; 3]];
    let (_, _, pixels) = read(&of_points(&points, &[], 32));
    assert!(pixels.iter().any(|p| p[3] > 0));
}
