use bendtwin_mesh::{Limits, parse};

use super::*;
use crate::{
    Motion, PointSet,
    testing::{encoded, mesh, motion, twin, with_surface},
};

/// A file taken apart by the rules of glTF 2.0.
struct File {
    json: Value,
    data: Vec<u8>,
}

impl File {
    fn read(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        assert_eq!((&file[16..20], word(12) % 4), (&b"JSON"[..], 0));
        let json = serde_json::from_slice(&file[20..20 + word(12)]).unwrap();
        let at = 20 + word(12);
        assert_eq!((&file[at + 4..at + 8], word(at) % 4), (&b"BIN\0"[..], 0));
        assert_eq!(at + 8 + word(at), file.len());
        let this = Self { json, data: file[at + 8..].to_vec() };
        assert_eq!(this.json["buffers"][0]["byteLength"], this.data.len());
        let accessors = this.json["accessors"].as_array().unwrap().len();
        (0..accessors).for_each(|a| this.check(a));
        this
    }

    /// Bytes of an accessor.
    fn bytes(&self, accessor: usize) -> &[u8] {
        let view = &self.json["bufferViews"]
            [self.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize];
        let [offset, length] =
            ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
        assert_eq!(offset % 4, 0);
        &self.data[offset..offset + length]
    }

    fn floats(&self, accessor: usize) -> Vec<f32> {
        assert_eq!(self.json["accessors"][accessor]["componentType"], FLOAT);
        self.bytes(accessor).chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn points(&self, accessor: usize) -> Vec<Point> {
        assert_eq!(self.json["accessors"][accessor]["type"], "VEC3");
        self.floats(accessor).as_chunks().0.to_vec()
    }

    /// Length, and the bounds that positions must state.
    fn check(&self, accessor: usize) {
        let about = &self.json["accessors"][accessor];
        // Colours are four numbers of two bytes.
        let words = match about["type"].as_str().unwrap() {
            "VEC3" => 3,
            "VEC4" => 2,
            _ => 1,
        };
        assert_eq!(self.bytes(accessor).len() as u64, about["count"].as_u64().unwrap() * words * 4);
        if about["type"] == "VEC3" {
            let points = self.points(accessor);
            for a in 0..3 {
                let of = |name: &str| about[name][a].as_f64().unwrap() as f32;
                let low = points.iter().map(|p| p[a]).fold(f32::INFINITY, f32::min);
                let high = points.iter().map(|p| p[a]).fold(f32::NEG_INFINITY, f32::max);
                assert_eq!((of("min"), of("max")), (low, high));
            }
        }
    }

    /// Positions of a mesh at a key frame of the animation.
    fn posed(&self, mesh: usize, key: usize) -> Vec<Point> {
        let primitive = &self.json["meshes"][mesh]["primitives"][0];
        let index = |value: &Value| value["POSITION"].as_u64().unwrap() as usize;
        let mut points = self.points(index(&primitive["attributes"]));
        let targets = primitive["targets"].as_array().unwrap();
        let sampler = &self.json["animations"][0]["samplers"][0];
        let weights = self.floats(sampler["output"].as_u64().unwrap() as usize);
        assert_eq!(weights.len() % targets.len(), 0);
        for (t, target) in targets.iter().enumerate() {
            let weight = weights[key * targets.len() + t];
            for (p, d) in points.iter_mut().zip(self.points(index(target))) {
                (0..3).for_each(|a| p[a] += weight * d[a]);
            }
        }
        points
    }
}

#[test]
fn every_frame_is_a_morph_target_that_the_animation_reaches() {
    let twin = twin();
    let motion = motion(&twin);
    let scene = Scene::new("a \"twin\"", &twin, PointSet::Nodes, Some(&motion)).unwrap();
    let file = File::read(&encoded(&scene, Format::Glb));
    for key in 0..3 {
        for (mesh, expected) in [(0, scene.points_at(key)), (1, scene.controls_at(key).into())] {
            for (p, q) in file.posed(mesh, key).iter().zip(&*expected) {
                assert!((0..3).all(|a| (p[a] - q[a]).abs() < 1e-6), "{p:?} {q:?}");
            }
        }
    }
    let animation = &file.json["animations"][0];
    let times = animation["samplers"][0]["input"].as_u64().unwrap() as usize;
    assert_eq!(file.floats(times), [1.0, 2.0, 3.0].map(|f: f32| (f64::from(f) / 30.0) as f32));
    assert_eq!(file.json["accessors"][times]["min"][0].as_f64().unwrap() as f32, 1.0 / 30.0);
    for channel in animation["channels"].as_array().unwrap() {
        let node = channel["target"]["node"].as_u64().unwrap() as usize;
        assert!(file.json["nodes"][node]["mesh"].is_u64());
        assert_eq!(channel["target"]["path"], "weights");
    }
    // Points, and springs on the same accessors.
    let primitives = file.json["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!([&primitives[0]["mode"], &primitives[1]["mode"]], [0, 1]);
    assert_eq!(primitives[0]["targets"], primitives[1]["targets"]);
    let lines = file.bytes(primitives[1]["indices"].as_u64().unwrap() as usize);
    assert_eq!(lines, bytemuck::cast_slice::<_, u8>(scene.lines()));
    assert_eq!(file.json["nodes"][0]["name"], "a \"twin\"");
}

#[test]
fn the_projects_own_reader_sees_the_mesh_with_y_up() {
    let (twin, mesh) = (twin(), mesh());
    let motion = motion(&twin);
    let scene = Scene::new("a", &twin, PointSet::Mesh(&mesh), Some(&motion)).unwrap();
    let bytes = encoded(&scene, Format::Glb);
    File::read(&bytes);
    let read = parse("a.glb", &bytes, &Limits::default()).unwrap();
    assert_eq!(read.triangles, mesh.triangles);
    for ([x, y, z], turned) in scene.points_at(0).iter().zip(&read.vertices) {
        let expected = [*x, *z, -*y];
        assert!((0..3).all(|a| (expected[a] - turned[a]).abs() < 1e-6), "{turned:?}");
    }
}

#[test]
fn a_twin_at_rest_has_no_animation() {
    let twin = twin();
    let scene = Scene::new("a", &twin, PointSet::Nodes, None).unwrap();
    let file = File::read(&encoded(&scene, Format::Glb));
    assert!(file.json.get("animations").is_none());
    assert!(file.json["meshes"][0].get("weights").is_none());
    assert_eq!(file.points(1), twin.graph.rest_positions);
}

#[test]
fn motions_whose_weights_would_fill_the_file_are_refused() {
    let twin = twin();
    let frames = MAX_FRAMES + 1;
    let motion = Motion {
        times_s: (0..frames).map(|f| f as f64).collect(),
        nodes: twin.graph.rest_positions.repeat(frames),
        controls: Vec::new(),
    };
    let scene = Scene::new("a", &twin, PointSet::Nodes, Some(&motion)).unwrap();
    let error = crate::encode(&scene, Format::Glb, &mut std::io::Cursor::new(Vec::new()));
    let message = error.unwrap_err().to_string();
    assert!(message.contains("--every") && message.contains("2000"), "{message}");
}

#[test]
fn a_surface_has_triangles_in_its_colours_and_moves() {
    let twin = with_surface();
    let motion = motion(&twin);
    let scene = Scene::new("a toy", &twin, PointSet::Surface, Some(&motion)).unwrap();
    let file = File::read(&encoded(&scene, Format::Glb));
    assert_eq!(file.json["nodes"][0]["name"], "a toy");
    let primitive = &file.json["meshes"][0]["primitives"][0];
    assert_eq!((&primitive["mode"], &primitive["material"]), (&json!(TRIANGLES), &json!(0)));
    let colors = primitive["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    let accessor = &file.json["accessors"][colors];
    assert_eq!((&accessor["normalized"], &accessor["type"]), (&json!(true), &json!("VEC4")));
    let words: Vec<u16> =
        file.bytes(colors).chunks(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(words[..4], [65535, 0, 0, 65535]);
    // Half of the light.
    assert!((f64::from(words[5]) / 65535.0 - 0.503).abs() < 1e-3, "{words:?}");
    let surface = twin.surface.as_ref().unwrap();
    for frame in 0..3 {
        let nodes = &motion.nodes[5 * frame..5 * frame + 5];
        let posed = file.posed(0, frame);
        for (p, q) in posed.iter().zip(surface.positions(nodes)) {
            assert!((0..3).all(|a| (p[a] - q[a]).abs() < 1e-6), "{p:?} {q:?}");
        }
    }
}
