use super::*;
use bendtwin_capture::raw::Region;

fn tiny() -> Recording {
    film(Scene::Toy, &FilmOptions::tiny(3)).unwrap()
}

#[test]
fn a_film_repeats_in_any_order() {
    let (a, b) = (tiny(), tiny());
    let (mut forward, mut backward) = (a.source.frames(1).unwrap(), b.source.frames(1).unwrap());
    let _ = backward.tracks();
    for frame in [0, 7, 19] {
        let _ = backward.depth(19 - frame);
        assert_eq!(forward.color(frame).unwrap(), backward.color(frame).unwrap());
        assert_eq!(forward.depth(frame).unwrap(), backward.depth(frame).unwrap());
    }
    assert_eq!(forward.tracks().unwrap(), backward.tracks().unwrap());
    assert!(forward.color(20).unwrap().is_none());
    assert!(matches!(a.source.frames(2).map(|_| ()), Err(capture::Error::NoCamera(2))));
}

#[test]
fn depth_in_masks_lies_on_the_truth() {
    let recording = tiny();
    for frame in [0, 12] {
        let count = recording.truth_tracks.len() / recording.frame_count;
        let truth = &recording.truth_tracks[frame * count..(frame + 1) * count];
        let (mut seen, mut near) = (0, 0);
        for (index, camera) in recording.cameras.iter().enumerate() {
            let mut frames = recording.source.frames(index).unwrap();
            let depth = frames.depth(frame).unwrap().unwrap();
            let mask = frames.mask(frame, Region::Object).unwrap().unwrap();
            let hand = frames.mask(frame, Region::Manipulator).unwrap().unwrap();
            assert!(hand.pixels.iter().filter(|p| **p).count() > 20);
            for (i, _) in mask.pixels.iter().enumerate().filter(|(_, shown)| **shown) {
                assert!(!hand.pixels[i]);
                let pixel = [(i % camera.width) as f64, (i / camera.width) as f64];
                let z = depth.pixels[i];
                if z > 0.0 {
                    let point = camera.unproject(pixel, f64::from(z), frame);
                    let distance = truth
                        .iter()
                        .map(|t| (0..3).map(|a| (t[a] - point[a]).powi(2)).sum::<f32>().sqrt())
                        .fold(f32::INFINITY, f32::min);
                    seen += 1;
                    near += usize::from(distance < 0.05);
                }
            }
        }
        assert!(seen > 100 && near as f64 > 0.9 * f64::from(seen), "{near} of {seen}");
    }
}

#[test]
fn tracks_follow_the_material() {
    let recording = tiny();
    let mut frames = recording.source.frames(0).unwrap();
    let tracks = frames.tracks().unwrap().unwrap();
    assert!(tracks.count > 60, "{}", tracks.count);
    assert_eq!(tracks.points.len(), tracks.count * recording.frame_count);
    let share = |frame: usize| {
        let row = &tracks.visible[frame * tracks.count..(frame + 1) * tracks.count];
        row.iter().filter(|v| **v).count() as f64 / tracks.count as f64
    };
    assert!(share(0) > 0.9 && share(recording.frame_count - 1) > 0.5);
    assert!(tracks.visible.iter().any(|v| !v));
}

#[test]
fn the_mesh_is_the_body_in_the_first_frame() {
    let recording = tiny();
    let file = recording.mesh.unwrap();
    let mesh =
        bendtwin_mesh::parse(&file.name, &file.bytes, &bendtwin_mesh::Limits::default()).unwrap();
    let surface = bendtwin_mesh::Bvh::new(&mesh);
    let count = recording.truth_tracks.len() / recording.frame_count;
    for p in &recording.truth_tracks[..count] {
        assert!(surface.closest(*p).unwrap().distance < 1e-6);
    }
    // It encloses the body: its volume is that of the lattice.
    assert!(mesh.sample_interior(0.008).unwrap().len() > 100);
    let options = FilmOptions { shape: Shape::Unaligned, ..FilmOptions::tiny(3) };
    let other = film(Scene::Toy, &options).unwrap().mesh.unwrap();
    assert!(other.to_world.is_none() && other.bytes != file.bytes);
    let none = FilmOptions { shape: Shape::Absent, tracks: false, ..FilmOptions::tiny(3) };
    let bare = film(Scene::Rope, &none).unwrap();
    assert!(bare.mesh.is_none());
    assert!(bare.source.frames(0).unwrap().tracks().unwrap().is_none());
}

#[test]
fn motion_capture_is_not_filmed() {
    assert!(matches!(film(Scene::Cable, &FilmOptions::tiny(0)), Err(Error::NotFilmed("cable"))));
}

#[test]
fn a_sheet_lies_on_the_table() {
    let sheet =
        crate::Sheet { size_m: [0.2, 0.2], columns: 2, black: vec![true, false, false, true] };
    let options = FilmOptions { sheet: Some(sheet), ..FilmOptions::tiny(3) };
    let [with, without] = [options, FilmOptions::tiny(3)].map(|options| {
        let film = film(Scene::Toy, &options).unwrap();
        film.source.frames(0).unwrap().color(0).unwrap().unwrap()
    });
    let count = |image: &bendtwin_capture::raw::ColorImage, range: std::ops::Range<u8>| {
        image.pixels.iter().filter(|pixel| pixel.iter().all(|c| range.contains(c))).count()
    };
    assert!(count(&with, 0..40) > count(&without, 0..40) + 10);
    assert_ne!(with, without);
}

#[test]
fn a_second_hand_holds_from_the_start_or_joins_later() {
    let shown = |hands: Hands, clutter: bool| {
        let options = FilmOptions { hands, clutter, ..FilmOptions::tiny(3) };
        let recording = film(Scene::Ring, &options).unwrap();
        let mut frames = recording.source.frames(0).unwrap();
        [0, recording.frame_count - 1].map(|frame| {
            let mask = frames.mask(frame, Region::Manipulator).unwrap().unwrap();
            mask.pixels.iter().filter(|shown| **shown).count()
        })
    };
    let [one, two, joining] = [Hands::One, Hands::Two, Hands::Joining].map(|h| shown(h, false));
    assert!(two[0] as f64 > 1.5 * one[0] as f64, "{one:?} {two:?}");
    assert!(joining[1] as f64 > 1.5 * one[1] as f64, "{one:?} {joining:?}");
    assert_eq!(shown(Hands::One, true), one, "what stands beside is no hand");
}
