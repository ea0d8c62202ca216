use std::io::{Cursor, Read as _};

use bendtwin_capture::{Limits, npy::Floats};

use super::*;
use crate::{
    Format, PointSet,
    testing::{encoded, motion, twin},
};

#[test]
fn it_has_the_motion_and_all_that_the_twin_file_has() {
    let twin = twin();
    let motion = motion(&twin);
    let scene = Scene::new("a", &twin, PointSet::Skin, Some(&motion)).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(encoded(&scene, Format::Npz))).unwrap();
    let mut member = |name: &str| {
        let mut content = Vec::new();
        archive.by_name(name).unwrap().read_to_end(&mut content).unwrap();
        content
    };
    let floats =
        |name: &str, content: &[u8]| Floats::decode(name, content, &Limits::default()).unwrap();
    let positions = floats("positions", &member("positions.npy"));
    assert_eq!(positions.shape, [3, 2, 3]);
    let expected: Vec<f32> = (0..3).flat_map(|f| scene.points_at(f).concat()).collect();
    assert_eq!(positions.values, expected);
    let controls = floats("controls", &member("controls.npy"));
    assert_eq!((controls.shape, controls.values), (vec![3, 2, 3], motion.controls.concat()));
    assert_eq!(floats("times", &member("times_s.npy")).values, [1.0, 2.0, 3.0].map(|f| f / 30.0));

    let file = twin.encode().unwrap();
    let tensors = SafeTensors::deserialize(&file).unwrap();
    assert!(tensors.len() > 20);
    for (name, tensor) in tensors.tensors() {
        let array = member(&format!("{name}.npy"));
        assert!(array.ends_with(tensor.data()), "{name}");
        if tensor.dtype() == Dtype::F32 {
            assert_eq!(floats(&name, &array).shape, tensor.shape(), "{name}");
        }
    }
    let metadata: serde_json::Value = serde_json::from_slice(&member(METADATA)).unwrap();
    assert_eq!(metadata["timing"]["substeps"], 100);
}

#[test]
fn a_twin_at_rest_is_one_frame() {
    let twin = twin();
    let scene = Scene::new("a", &twin, PointSet::Nodes, None).unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(encoded(&scene, Format::Npz))).unwrap();
    let mut content = Vec::new();
    archive.by_name("positions.npy").unwrap().read_to_end(&mut content).unwrap();
    let positions = Floats::decode("a", &content, &Limits::default()).unwrap();
    assert_eq!(positions.shape, [1, 5, 3]);
    assert_eq!(positions.values, twin.graph.rest_positions.concat());
}
