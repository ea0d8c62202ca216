//! The part of a glTF document that is read. Unknown keys are passed over, as the format asks.

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::Error;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<MeshEntry>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub(super) mesh: Option<usize>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    /// Column-major. Rare, so that a node without it stays small.
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<[f64; 3]>,
    /// x, y, z, w.
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
pub(super) struct MeshEntry {
    #[serde(default)]
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    #[serde(default)]
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) mode: Option<u32>,
    #[serde(default)]
    extensions: Map<String, Value>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Value>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(default)]
    extensions: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
struct Buffer {
    uri: Option<Value>,
}

/// Extensions that do not change a mesh's shape, or in a way that is handled here.
const SUPPORTED_EXTENSIONS: [&str; 2] = ["KHR_mesh_quantization", "KHR_texture_transform"];

impl Document {
    /// Refuses compression and data elsewhere, in words that say so.
    pub(super) fn check(&self, at: &str) -> Result<(), Error> {
        let of_primitives =
            self.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.extensions.keys());
        let of_views = self.buffer_views.iter().flat_map(|v| v.extensions.keys());
        let mut all = self.extensions_required.iter().chain(of_primitives).chain(of_views);
        if let Some(name) =
            all.find(|e| e.ends_with("_draco_mesh_compression") || e.contains("meshopt"))
        {
            return Err(Error::Compressed { at: at.to_owned(), extension: name.clone() });
        }
        let strange = |e: &&String| {
            !SUPPORTED_EXTENSIONS.contains(&e.as_str())
                && !e.starts_with("KHR_materials_")
                && !e.contains("texture")
        };
        if let Some(name) = self.extensions_required.iter().find(strange) {
            return Err(Error::Unsupported { at: at.to_owned(), what: name.clone() });
        }
        let used = self.accessors.iter().filter_map(|a| self.buffer_views.get(a.buffer_view?));
        if used.into_iter().any(|v| self.buffers.get(v.buffer).is_some_and(|b| b.uri.is_some())) {
            return Err(Error::External { at: at.to_owned() });
        }
        Ok(())
    }
}
