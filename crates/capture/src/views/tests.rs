use bendtwin_core::{View, ViewCamera, Views, views::Label};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{Limits, read};

fn sample() -> Views {
    let view = |frame: u32, corner: [u32; 2], size: [u32; 2]| {
        let count = (size[0] * size[1]) as usize;
        View {
            frame,
            corner,
            size,
            colors: (0..count).map(|i| [i as u8, 1, frame as u8]).collect(),
            labels: (0..count).map(|i| Label::from_number((i % 3) as u8).unwrap()).collect(),
            depths_mm: (0..count).map(|i| 500 + i as u16).collect(),
        }
    };
    let camera = |name: &str, views| ViewCamera {
        name: name.into(),
        size: [40, 30],
        focal: [50.5, 51.0],
        centre: [19.5, 14.25],
        world_to_camera: vec![[[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.9]]],
        views,
    };
    Views {
        cameras: vec![
            camera("left", vec![view(0, [3, 4], [5, 6]), view(2, [0, 0], [40, 30])]),
            camera("blind", Vec::new()),
        ],
    }
}

#[test]
fn views_survive_their_archive_and_bundles_pass_them_over() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("observation.zip");
    write_observation(&capture, Some(&sample()), &path).unwrap();
    assert_eq!(read_views(&path, &Limits::default()).unwrap(), Some(sample()));
    assert_eq!(read(&path, &Limits::default()).unwrap(), capture);
    let without = folder.path().join("without.zip");
    write_observation(&capture, None, &without).unwrap();
    assert_eq!(read_views(&without, &Limits::default()).unwrap(), None);
}

#[test]
fn views_that_contradict_themselves_are_neither_written_nor_read() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut views = sample();
    views.cameras[0].views[0].labels.pop();
    let path = folder.path().join("wrong.zip");
    let error = write_observation(&capture, Some(&views), &path).unwrap_err();
    assert!(error.to_string().contains("frame 0 of camera `left`"), "{error}");
    let path = folder.path().join("observation.zip");
    write_observation(&capture, Some(&sample()), &path).unwrap();
    let good = crate::check::testing::unpack(&std::fs::read(&path).unwrap());
    let wrong = [
        (place(0, arrays::LABELS), crate::npy::write("|u1", &[1], &[0])),
        (place(0, arrays::LABELS), crate::npy::write("|u1", &[1230], &[9; 1230])),
        (place(0, arrays::VIEWS), crate::npy::write("<i4", &[1, 5], &[255; 20])),
        (place(1, arrays::POSES), crate::npy::write("<f8", &[1, 2], &[0; 16])),
        (
            MARKER.to_owned(),
            br#"{"format": "bendtwin-views", "version": 7, "cameras": []}"#.to_vec(),
        ),
        (MARKER.to_owned(), b"[".to_vec()),
    ];
    for (name, bytes) in wrong {
        let mut files = good.clone();
        files.insert(name.clone(), bytes);
        let path = folder.path().join("damaged.zip");
        std::fs::write(&path, crate::check::testing::pack(&files)).unwrap();
        assert!(read_views(&path, &Limits::default()).is_err(), "{name}");
    }
}
