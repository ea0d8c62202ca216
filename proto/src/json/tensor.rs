//! Tensors as JSON: nested lists of numbers where they are small and read by people, base64 of the
//! raw bytes where they are not. Lists are read straight into the bytes of the tensor.

use base64::{Engine as _, prelude::BASE64_STANDARD};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer},
    ser::{Error as _, SerializeMap, SerializeSeq as _},
};

use crate::{
    tensor::MOST_DIMENSIONS,
    v1::{Tensor, tensor::Dtype},
};

/// Most bytes of a tensor that lists make. Bodies are bounded, too, so this is only reached by
/// lists of short numbers.
const MOST_BYTES: usize = 1 << 30;

/// Form of the tensors that are written.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum TensorFormat {
    /// Nested lists of numbers; null stands for what is no finite number.
    #[default]
    Lists,
    /// Objects with type, shape and bytes in base64.
    Base64,
}

/// A tensor, if one is given; lists make a tensor of this type.
pub(super) fn tensor<'de, A: MapAccess<'de>>(
    map: &mut A,
    dtype: Dtype,
) -> Result<Option<Tensor>, A::Error> {
    map.next_value_seed(Given(dtype))
}

/// Writes a tensor that is there.
pub(super) fn write_tensor<M: SerializeMap>(
    map: &mut M,
    name: &'static str,
    tensor: Option<&Tensor>,
    format: TensorFormat,
) -> Result<(), M::Error> {
    let Some(tensor) = tensor.filter(|t| !t.is_absent()) else { return Ok(()) };
    match format {
        TensorFormat::Base64 => map.serialize_entry(name, &Packed::from(tensor)),
        TensorFormat::Lists => {
            tensor.checked_shape(name).map_err(M::Error::custom)?;
            map.serialize_entry(name, &Rows { tensor, shape: &tensor.shape, data: &tensor.data })
        }
    }
}

/// A tensor as raw bytes.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Packed {
    dtype: String,
    #[serde(deserialize_with = "shape")]
    shape: Vec<u64>,
    data: String,
    #[serde(default, skip_serializing_if = "is_zero")]
    scale: f32,
    #[serde(default, skip_serializing_if = "is_zero")]
    offset: f32,
}

/// A shape: a few lengths, however many the body has.
fn shape<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u64>, D::Error> {
    deserializer.deserialize_seq(Lengths)
}

struct Lengths;

impl<'de> Visitor<'de> for Lengths {
    type Value = Vec<u64>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a list of lengths")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut lengths = Vec::new();
        while let Some(length) = seq.next_element()? {
            if lengths.len() == MOST_DIMENSIONS {
                let fault = format!("has a shape of more than {MOST_DIMENSIONS} lengths");
                return Err(A::Error::custom(fault));
            }
            lengths.push(length);
        }
        Ok(lengths)
    }
}

fn is_zero(x: &f32) -> bool {
    *x == 0.0
}

impl From<&Tensor> for Packed {
    fn from(tensor: &Tensor) -> Self {
        Self {
            dtype: tensor.dtype().as_str_name().to_owned(),
            shape: tensor.shape.clone(),
            data: BASE64_STANDARD.encode(&tensor.data),
            scale: tensor.scale,
            offset: tensor.offset,
        }
    }
}

impl Packed {
    fn unpack<E: Error>(self) -> Result<Tensor, E> {
        let dtype = Dtype::from_str_name(&self.dtype)
            .ok_or_else(|| E::custom(format!("has the unknown dtype {:?}", self.dtype)))?;
        let data = BASE64_STANDARD
            .decode(self.data)
            .map_err(|e| E::custom(format!("has data that is no base64: {e}")))?;
        Ok(Tensor {
            dtype: dtype.into(),
            shape: self.shape,
            data: data.into(),
            scale: self.scale,
            offset: self.offset,
        })
    }
}

/// A tensor in either form, or null.
struct Given(Dtype);

impl<'de> DeserializeSeed<'de> for Given {
    type Value = Option<Tensor>;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Given {
    type Value = Option<Tensor>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("nested lists of numbers, or an object with dtype, shape and data")
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        Packed::deserialize(MapAccessDeserializer::new(map))?.unpack().map(Some)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        let mut lists = Lists { dtype: self.0, rank: None, lengths: Vec::new(), data: Vec::new() };
        Level { lists: &mut lists, depth: 0 }.visit_seq(seq)?;
        Ok(Some(Tensor {
            dtype: self.0.into(),
            shape: lists.lengths.into_iter().map_while(|length| length).collect(),
            data: lists.data.into(),
            ..Tensor::default()
        }))
    }
}

/// Numbers and lengths read so far of nested lists.
struct Lists {
    dtype: Dtype,
    /// Depth at which the numbers stand, once there was one.
    rank: Option<usize>,
    /// Length of the lists at each depth, once one has ended.
    lengths: Vec<Option<u64>>,
    data: Vec<u8>,
}

impl Lists {
    fn number<E: Error>(&mut self, depth: usize, bytes: &[u8]) -> Result<(), E> {
        let is_uneven = self.lengths.get(depth).is_some_and(Option::is_some);
        if *self.rank.get_or_insert(depth) != depth || is_uneven {
            return Err(E::custom("has a number beside a list"));
        }
        if self.data.len() >= MOST_BYTES {
            return Err(E::custom(format!("has more than {MOST_BYTES} bytes")));
        }
        self.data.extend(bytes);
        Ok(())
    }

    fn open<E: Error>(&mut self, depth: usize) -> Result<(), E> {
        if depth == MOST_DIMENSIONS {
            return Err(E::custom(format!("is nested more than {MOST_DIMENSIONS} deep")));
        }
        if self.rank.is_some_and(|rank| depth >= rank) {
            return Err(E::custom("has a list beside a number"));
        }
        if self.lengths.len() <= depth {
            self.lengths.push(None);
        }
        Ok(())
    }

    fn close<E: Error>(&mut self, depth: usize, length: u64) -> Result<(), E> {
        match self.lengths[depth].replace(length) {
            Some(before) if before != length => Err(E::custom("has rows of different lengths")),
            _ => Ok(()),
        }
    }
}

/// A list or a number at some depth.
struct Level<'l> {
    lists: &'l mut Lists,
    depth: usize,
}

impl Level<'_> {
    fn float<E: Error>(self, x: f64) -> Result<(), E> {
        let single = x as f32;
        match self.lists.dtype {
            Dtype::Uint32 => return Err(E::custom("has an entry that is no index")),
            Dtype::Uint8 => return Err(E::custom("has an entry that is no byte")),
            _ => {}
        }
        if !single.is_finite() {
            return Err(E::custom("has an entry that is no finite number"));
        }
        self.lists.number(self.depth, &single.to_le_bytes())
    }
}

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a finite number or a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Self { lists, depth } = self;
        lists.open(depth)?;
        let mut length = 0;
        while seq.next_element_seed(Level { lists, depth: depth + 1 })?.is_some() {
            length += 1;
        }
        lists.close(depth, length)
    }

    fn visit_u64<E: Error>(self, n: u64) -> Result<(), E> {
        match self.lists.dtype {
            Dtype::Uint32 => {
                let index = u32::try_from(n);
                let index = index.map_err(|_| E::custom("has an entry that is no index"))?;
                self.lists.number(self.depth, &index.to_le_bytes())
            }
            Dtype::Uint8 => {
                let byte = u8::try_from(n);
                let byte = byte.map_err(|_| E::custom("has an entry that is no byte"))?;
                self.lists.number(self.depth, &[byte])
            }
            _ => self.float(n as f64),
        }
    }

    fn visit_i64<E: Error>(self, n: i64) -> Result<(), E> {
        self.float(n as f64)
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<(), E> {
        self.float(x)
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Err(E::custom("has an entry that is no finite number"))
    }
}

/// The rows of a tensor whose shape accounts for its bytes, or of a part of it.
struct Rows<'t> {
    tensor: &'t Tensor,
    shape: &'t [u64],
    data: &'t [u8],
}

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Some((length, shape)) = self.shape.split_first() else {
            return number(self.tensor, self.data, serializer);
        };
        let length = usize::try_from(*length).unwrap_or_default();
        let width = self.data.len().checked_div(length).unwrap_or_default();
        let mut rows = serializer.serialize_seq(Some(length))?;
        for row in 0..length {
            let data = &self.data[row * width..(row + 1) * width];
            rows.serialize_element(&Rows { tensor: self.tensor, shape, data })?;
        }
        rows.end()
    }
}

fn number<S: Serializer>(tensor: &Tensor, data: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    match (tensor.dtype(), data) {
        (Dtype::Float32, &[a, b, c, d]) => {
            serializer.serialize_f32(f32::from_le_bytes([a, b, c, d]))
        }
        (Dtype::Float64, &[a, b, c, d, e, f, g, h]) => {
            serializer.serialize_f64(f64::from_le_bytes([a, b, c, d, e, f, g, h]))
        }
        (Dtype::Uint32, &[a, b, c, d]) => {
            serializer.serialize_u32(u32::from_le_bytes([a, b, c, d]))
        }
        (Dtype::Int32, &[a, b, c, d]) => serializer.serialize_i32(i32::from_le_bytes([a, b, c, d])),
        (Dtype::Uint8, &[a]) => serializer.serialize_u8(a),
        (Dtype::Int16Scaled, &[a, b]) => {
            let code = f32::from(i16::from_le_bytes([a, b]));
            serializer.serialize_f32(code * tensor.scale + tensor.offset)
        }
        _ => Err(S::Error::custom("a tensor whose shape and bytes disagree")),
    }
}
