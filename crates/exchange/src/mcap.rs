//! MCAP with messages that Foxglove draws: a point cloud of the twin, one of its control points, and
//! springs or a mesh as a scene. Messages are JSON in Foxglove's own schemas, so that any reader of
//! MCAP understands them without a compiler for them.

mod schemas;

use std::{
    borrow::Cow,
    collections::BTreeMap,
    io::{Seek, Write},
};

use base64::{Engine as _, engine::general_purpose::STANDARD as BASE64};
use bendtwin_core::Point;
use mcap::{WriteOptions, Writer, records::MessageHeader, records::Metadata};
use serde_json::{Value, json};

use crate::{Error, PointSet, Scene};

/// The frame of reference of all messages.
const FRAME_ID: &str = "world";
/// `FLOAT32` of Foxglove's numeric types.
const FLOAT32: u8 = 7;
/// `LINE_LIST` of Foxglove's kinds of lines.
const LINE_LIST: u8 = 2;
const SPRING_M: f64 = 0.001;

/// Writes the file. Messages are stamped with the time since the rollout's start.
pub(crate) fn write(scene: &Scene<'_>, out: &mut (impl Write + Seek)) -> Result<(), Error> {
    let options = WriteOptions::new().compression(None).library(bendtwin_core::BUILD);
    let mut writer = options.create(out)?;
    let about = [("name", scene.name()), ("frame", "metres, z up")];
    let metadata = about.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
    writer.write_metadata(&Metadata { name: "bendtwin".to_owned(), metadata })?;

    let cloud = writer.add_schema("foxglove.PointCloud", "jsonschema", &schemas::point_cloud())?;
    let update =
        writer.add_schema("foxglove.SceneUpdate", "jsonschema", &schemas::scene_update())?;
    let mut topic = |schema, name: &str| writer.add_channel(schema, name, "json", &BTreeMap::new());
    let points = match scene.points() {
        PointSet::Nodes => "/twin/nodes",
        PointSet::Skin => "/twin/skin",
        PointSet::Surface | PointSet::Mesh(_) => "/twin/surface",
    };
    let points = topic(cloud, points)?;
    let has_controls = !scene.controls_at(0).is_empty();
    let controls = has_controls.then(|| topic(cloud, "/twin/controls")).transpose()?;
    let has_shapes = !(scene.lines().is_empty() && scene.triangles().is_empty());
    let shapes = has_shapes.then(|| topic(update, "/twin/shape")).transpose()?;

    for (frame, time_s) in scene.times_s().iter().enumerate() {
        let at = Stamp::of(*time_s);
        let places = scene.points_at(frame);
        send(&mut writer, points, frame, at, &point_cloud(at, &places))?;
        if let Some(channel) = controls {
            send(&mut writer, channel, frame, at, &point_cloud(at, scene.controls_at(frame)))?;
        }
        if let Some(channel) = shapes {
            send(&mut writer, channel, frame, at, &scene_update(scene, at, places))?;
        }
    }
    writer.finish()?;
    Ok(())
}

/// A time since the start, as messages have it.
#[derive(Clone, Copy)]
struct Stamp {
    ns: u64,
}

impl Stamp {
    fn of(time_s: f64) -> Self {
        // A saturating cast: no rollout lasts 500 years.
        Self { ns: (time_s.max(0.0) * 1e9).round() as u64 }
    }

    fn json(self) -> Value {
        json!({"sec": self.ns / 1_000_000_000, "nsec": self.ns % 1_000_000_000})
    }
}

fn send<W: Write + Seek>(
    writer: &mut Writer<W>,
    channel_id: u16,
    frame: usize,
    at: Stamp,
    message: &Value,
) -> Result<(), Error> {
    let sequence = u32::try_from(frame).unwrap_or(u32::MAX);
    let header = MessageHeader { channel_id, sequence, log_time: at.ns, publish_time: at.ns };
    writer.write_to_known_channel(&header, message.to_string().as_bytes())?;
    Ok(())
}

fn identity() -> Value {
    json!({
        "position": {"x": 0, "y": 0, "z": 0},
        "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
    })
}

fn point_cloud(at: Stamp, points: &[Point]) -> Value {
    let field =
        |(index, name): (usize, &str)| json!({"name": name, "offset": 4 * index, "type": FLOAT32});
    let fields: Vec<Value> = ["x", "y", "z"].into_iter().enumerate().map(field).collect();
    json!({
        "timestamp": at.json(),
        "frame_id": FRAME_ID,
        "pose": identity(),
        "point_stride": 12,
        "fields": fields,
        "data": BASE64.encode(bytemuck::cast_slice::<Point, u8>(points)),
    })
}

/// Springs as lines, or the mesh as triangles, in place of those of the frame before.
fn scene_update(scene: &Scene<'_>, at: Stamp, points: Cow<'_, [Point]>) -> Value {
    let points: Vec<Value> =
        points.iter().map(|[x, y, z]| json!({"x": x, "y": y, "z": z})).collect();
    let color = json!({"r": 0.25, "g": 0.5, "b": 0.8, "a": 1});
    let mut entity = json!({
        "timestamp": at.json(),
        "frame_id": FRAME_ID,
        "id": "twin",
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": true,
        "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": [],
        "lines": [], "triangles": [], "texts": [], "models": [],
    });
    if scene.triangles().is_empty() {
        entity["lines"] = json!([{
            "type": LINE_LIST, "pose": identity(), "thickness": SPRING_M, "scale_invariant": false,
            "points": points, "color": color, "colors": [],
            "indices": scene.lines().as_flattened(),
        }]);
    } else {
        entity["triangles"] = json!([{
            "pose": identity(), "points": points, "color": color, "colors": [],
            "indices": scene.triangles().as_flattened(),
        }]);
    }
    json!({"deletions": [], "entities": [entity]})
}

#[cfg(test)]
mod tests;
