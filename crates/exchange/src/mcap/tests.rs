use super::*;
use crate::{
    Format,
    testing::{encoded, mesh, motion, twin},
};

/// Messages by topic, in order, with their schemas.
fn messages(file: &[u8]) -> Vec<(String, String, u64, Value)> {
    let read = ::mcap::MessageStream::new(file).unwrap().map(|message| {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((&*schema.encoding, &*message.channel.message_encoding), ("jsonschema", "json"));
        let content = serde_json::from_slice(&message.data).unwrap();
        check(&serde_json::from_slice(&schema.data).unwrap(), &content);
        (message.channel.topic.clone(), schema.name.clone(), message.log_time, content)
    });
    read.collect()
}

/// Content has the fields of its schema, of their types, and no others.
fn check(schema: &Value, content: &Value) {
    match schema["type"].as_str().unwrap() {
        "object" => {
            let Some(properties) = schema["properties"].as_object() else { return };
            let content = content.as_object().unwrap();
            assert!(content.keys().eq(properties.keys()), "{content:?} {properties:?}");
            properties.iter().for_each(|(name, schema)| check(schema, &content[name]));
        }
        "array" => {
            content.as_array().unwrap().iter().for_each(|item| check(&schema["items"], item));
        }
        "string" => assert!(content.is_string()),
        "integer" => assert!(content.is_u64()),
        "number" => assert!(content.is_number()),
        "boolean" => assert!(content.is_boolean()),
        other => panic!("{other}"),
    }
}

fn cloud(content: &Value) -> Vec<Point> {
    let bytes = BASE64.decode(content["data"].as_str().unwrap()).unwrap();
    bytes.chunks(12).map(bytemuck::pod_read_unaligned).collect()
}

#[test]
fn every_frame_is_a_message_of_each_topic() {
    let twin = twin();
    let motion = motion(&twin);
    let scene = Scene::new("a", &twin, PointSet::Nodes, Some(&motion)).unwrap();
    let messages = messages(&encoded(&scene, Format::Mcap));
    let of = |topic: &str| -> Vec<_> { messages.iter().filter(|m| m.0 == topic).collect() };
    let (nodes, controls, shape) = (of("/twin/nodes"), of("/twin/controls"), of("/twin/shape"));
    assert_eq!([nodes.len(), controls.len(), shape.len(), messages.len()], [3, 3, 3, 9]);
    for frame in 0..3 {
        assert_eq!(nodes[frame].1, "foxglove.PointCloud");
        assert_eq!(cloud(&nodes[frame].3), scene.points_at(frame).to_vec());
        assert_eq!(cloud(&controls[frame].3), scene.controls_at(frame));
        assert_eq!(nodes[frame].2, ((frame as f64 + 1.0) / 30.0 * 1e9).round() as u64);
        assert_eq!(shape[frame].1, "foxglove.SceneUpdate");
        let lines = &shape[frame].3["entities"][0]["lines"][0];
        assert_eq!(lines["indices"], json!([0, 1, 1, 2, 2, 3, 0, 3]));
        let place = lines["points"][2]["z"].as_f64().unwrap() as f32;
        assert_eq!(place, scene.points_at(frame)[2][2]);
    }
    assert_eq!(nodes[2].3["timestamp"], json!({"sec": 0, "nsec": 100_000_000}));
}

#[test]
fn a_mesh_is_triangles_and_a_skin_points_alone() {
    let (twin, mesh) = (twin(), mesh());
    let scene = Scene::new("a", &twin, PointSet::Mesh(&mesh), None).unwrap();
    let all = messages(&encoded(&scene, Format::Mcap));
    let triangles =
        &all.iter().find(|m| m.0 == "/twin/shape").unwrap().3["entities"][0]["triangles"];
    assert_eq!(triangles[0]["indices"], json!(mesh.triangles.as_flattened()));
    let scene = Scene::new("a", &twin, PointSet::Skin, None).unwrap();
    let topics: Vec<_> =
        messages(&encoded(&scene, Format::Mcap)).into_iter().map(|m| m.0).collect();
    assert_eq!(topics, ["/twin/skin", "/twin/controls"]);
}
