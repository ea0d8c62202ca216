//! Typed views into a GLB file's data: all bounds are checked when a view is made, so that reading
//! it cannot fail.

use super::{
    damaged,
    document::{Document, Primitive},
};
use crate::Error;

pub(super) struct Data<'a> {
    pub(super) at: &'a str,
    pub(super) document: &'a Document,
    pub(super) binary: &'a [u8],
}

/// Elements at equal distances in the data.
pub(super) struct View<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    normalized: bool,
    /// Number of elements; never more than there are bytes.
    pub(super) count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value, and what it is divided by if it stands for -1..1.
    fn read(self, b: [u8; 4]) -> (f64, f64) {
        match self {
            Self::I8 => (f64::from(b[0] as i8), 127.0),
            Self::U8 => (f64::from(b[0]), 255.0),
            Self::I16 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => (f64::from(u32::from_le_bytes(b)), 1.0),
            Self::F32 => (f64::from(f32::from_le_bytes(b)), 1.0),
        }
    }
}

impl<'a> Data<'a> {
    pub(super) fn positions(&self, primitive: &Primitive) -> Result<View<'a>, Error> {
        let position = primitive.attributes.position;
        self.view(position.ok_or_else(|| self.fault("a part of it has no positions"))?, "VEC3", 3)
    }

    pub(super) fn indices(&self, accessor: usize) -> Result<View<'a>, Error> {
        let view = self.view(accessor, "SCALAR", 1)?;
        match view.component {
            Component::U8 | Component::U16 | Component::U32 => Ok(view),
            _ => Err(self.fault("its indices are not unsigned integers")),
        }
    }

    fn view(&self, accessor: usize, kind: &str, width: usize) -> Result<View<'a>, Error> {
        let missing = || self.fault("it names an accessor or buffer view that is not there");
        let accessor = self.document.accessors.get(accessor).ok_or_else(missing)?;
        if accessor.sparse.is_some() || accessor.buffer_view.is_none() {
            let what = "sparse accessors".to_owned();
            return Err(Error::Unsupported { at: self.at.to_owned(), what });
        }
        let view = accessor.buffer_view.and_then(|v| self.document.buffer_views.get(v));
        let view = view.ok_or_else(missing)?;
        let component = Component::from_code(accessor.component_type)
            .filter(|_| accessor.kind == kind && view.buffer == 0)
            .ok_or_else(|| self.fault("an accessor has a type that does not belong there"))?;
        let size = component.size() * width;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(self.fault("the elements of a buffer view overlap"));
        }
        let in_view = end(accessor.byte_offset, stride, accessor.count, size);
        let in_data = view.byte_offset.saturating_add(view.byte_length);
        if in_view > view.byte_length || in_data > self.binary.len() {
            return Err(Error::Absurd {
                at: self.at.to_owned(),
                claimed: view.byte_offset.saturating_add(in_view).max(in_data) as u64,
                present: self.binary.len() as u64,
            });
        }
        let bytes = &self.binary[view.byte_offset..in_data][accessor.byte_offset..in_view];
        let normalized = accessor.normalized;
        Ok(View { bytes, stride, component, normalized, count: accessor.count })
    }

    fn fault(&self, fault: &str) -> Error {
        damaged(self.at, fault)
    }
}

/// The end of the last of `count` elements, saturated; of no elements, their start.
fn end(offset: usize, stride: usize, count: usize, size: usize) -> usize {
    match count.checked_sub(1) {
        None => offset,
        Some(last) => offset.saturating_add(stride.saturating_mul(last)).saturating_add(size),
    }
}

impl View<'_> {
    /// Element `i` of three components.
    pub(super) fn vector(&self, i: usize) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let (value, unit) = self.component(i, axis);
            if self.normalized { (value / unit).max(-1.0) } else { value }
        })
    }

    /// Element `i` of one unsigned component.
    pub(super) fn index(&self, i: usize) -> u64 {
        self.component(i, 0).0 as u64
    }

    fn component(&self, i: usize, axis: usize) -> (f64, f64) {
        let size = self.component.size();
        let from = i * self.stride + axis * size;
        let mut bytes = [0; 4];
        if let Some(found) = self.bytes.get(from..from + size) {
            bytes[..size].copy_from_slice(found);
        }
        self.component.read(bytes)
    }
}
