use std::io::{Cursor, Read as _};

use bendtwin_mesh::{Limits, parse};

use super::*;
use crate::{
    Format,
    testing::{encoded, mesh, motion, twin, with_surface},
    write as write_file,
};

/// Header and data of a file.
fn parts(file: &[u8]) -> (String, &[u8]) {
    const END: &[u8] = b"end_header\n";
    let at = file.windows(END.len()).position(|w| w == END).unwrap() + END.len();
    (String::from_utf8(file[..at].to_vec()).unwrap(), &file[at..])
}

#[test]
fn nodes_come_with_their_springs() {
    let twin = twin();
    let scene = Scene::new("a", &twin, PointSet::Nodes, None).unwrap();
    let file = encoded(&scene, Format::Ply);
    let (header, data) = parts(&file);
    assert!(header.contains("element vertex 5\n") && header.contains("element edge 4\n"));
    let (vertex, edge) = (12 + 1 + 4 + 4, 8);
    assert_eq!(data.len(), 5 * vertex + 4 * edge);
    let second = &data[vertex..2 * vertex];
    let x: [f32; 3] = bytemuck::pod_read_unaligned(&second[..12]);
    assert_eq!((x, second[12]), (twin.graph.rest_positions[1], 0));
    assert_eq!(bytemuck::pod_read_unaligned::<f32>(&second[17..]), 2.0);
    let last = &data[data.len() - edge..];
    assert_eq!(bytemuck::pod_read_unaligned::<[u32; 2]>(last), [0, 3]);
}

#[test]
fn a_mesh_is_read_again() {
    let (twin, mesh) = (twin(), mesh());
    let scene = Scene::new("a", &twin, PointSet::Mesh(&mesh), None).unwrap();
    let read = parse("a.ply", &encoded(&scene, Format::Ply), &Limits::default()).unwrap();
    assert_eq!((read.vertices, read.triangles), (scene.points_at(0).to_vec(), mesh.triangles));
}

#[test]
fn a_sequence_has_a_file_for_each_frame_in_a_folder_or_an_archive() {
    let (twin, mesh) = (twin(), mesh());
    let motion = motion(&twin);
    let scene = Scene::new("a", &twin, PointSet::Mesh(&mesh), Some(&motion)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("frames");
    write_file(&scene, Format::PlySequence, &frames).unwrap();
    let zipped = folder.path().join("frames.zip");
    write_file(&scene, Format::PlySequence, &zipped).unwrap();
    let bytes = std::fs::read(zipped).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    assert_eq!((archive.len(), std::fs::read_dir(&frames).unwrap().count()), (3, 3));
    for frame in 0..3 {
        let name = format!("frame_{frame:06}.ply");
        let mut content = Vec::new();
        archive.by_name(&name).unwrap().read_to_end(&mut content).unwrap();
        assert_eq!(content, std::fs::read(frames.join(&name)).unwrap());
        let read = parse(&name, &content, &Limits::default()).unwrap();
        assert_eq!(read.vertices, scene.points_at(frame).to_vec());
    }
}

#[test]
fn a_surface_has_colours_in_ply_and_obj() {
    let twin = with_surface();
    let scene = Scene::new("a", &twin, PointSet::Surface, None).unwrap();
    let file = encoded(&scene, Format::Ply);
    let (header, data) = parts(&file);
    assert!(header.contains("property uchar blue\n") && header.contains("element face 4\n"));
    assert_eq!((data.len(), &data[12..15]), (4 * 15 + 4 * 13, &[255, 0, 0][..]));
    for name in ["a.ply", "a.obj"] {
        let format = Format::of_path(Path::new(name)).unwrap();
        let read = parse(name, &encoded(&scene, format), &Limits::default()).unwrap();
        assert_eq!(read.triangles, scene.triangles());
        assert_eq!(read.vertices, *scene.points_at(0));
    }
    let text = String::from_utf8(encoded(&scene, Format::Obj)).unwrap();
    assert!(
        text.contains("v 0 0 0.5 1.0000 0.0000 0.0000\n") && text.contains("f 1 3 2\n"),
        "{text}"
    );
}
