//! Raw recordings written as PhysTwin cases and read back.

use bendtwin_capture::{
    Error, Limits,
    raw::{self, Camera, Distortion, Recording, Region, write_case},
};
use bendtwin_synth::{FilmOptions, Scene, film};

#[test]
fn a_film_comes_back_from_a_case() {
    let film = film(Scene::Toy, &FilmOptions { frames: 4, ..FilmOptions::tiny(5) }).unwrap();
    let folder = tempfile::tempdir().unwrap();
    write_case(&film, folder.path()).unwrap();
    let read = raw::open(folder.path(), &Limits::default()).unwrap();
    assert_eq!(read.frame_count, 4);
    assert_eq!(read.train_frame_count, film.train_frame_count);
    assert_eq!(read.truth_tracks, film.truth_tracks);
    for (index, (a, b)) in film.cameras.iter().zip(&read.cameras).enumerate() {
        assert_eq!(a.intrinsics, b.intrinsics);
        let flat =
            |c: &Camera| [c.poses[0].rotation.as_flattened(), &c.poses[0].translation].concat();
        assert!(flat(a).iter().zip(flat(b)).all(|(x, y)| (x - y).abs() < 1e-6));
        let (mut ours, mut theirs) =
            (film.source.frames(index).unwrap(), read.source.frames(index).unwrap());
        assert_eq!(ours.color(2).unwrap(), theirs.color(2).unwrap());
        assert_eq!(ours.depth(3).unwrap(), theirs.depth(3).unwrap());
        for region in [Region::Object, Region::Manipulator] {
            assert_eq!(ours.mask(1, region).unwrap(), theirs.mask(1, region).unwrap());
        }
        assert_eq!(ours.tracks().unwrap(), theirs.tracks().unwrap());
    }
    let mesh = |recording: &Recording| {
        let file = recording.mesh.clone().unwrap();
        let mesh = bendtwin_mesh::parse(&file.name, &file.bytes, &Default::default()).unwrap();
        let rotation = file.to_world.unwrap().rotation;
        let place = |v: &[f32; 3]| rotation.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
        mesh.vertices.iter().map(place).collect::<Vec<_>>()
    };
    for (a, b) in mesh(&film).iter().zip(mesh(&read)) {
        assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-6));
    }
}

#[test]
fn what_a_case_cannot_say_is_refused() {
    let mut film = film(Scene::Toy, &FilmOptions { frames: 4, ..FilmOptions::tiny(5) }).unwrap();
    film.cameras[1].distortion = Distortion::KannalaBrandt([0.1, 0.0, 0.0, 0.0]);
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(write_case(&film, folder.path()), Err(Error::Camera { .. })));
}
