//! Page-locked host memory: large results are copied through two halves, of which the device fills
//! one while the host empties the other, and large input goes to the device without the driver's
//! copy.

use std::sync::{Mutex, PoisonError};

use bendtwin_engine::Error;
use bytemuck::Pod;
use cudarc::driver::{CudaEvent, DeviceRepr, PinnedHostSlice, result};
use rayon::prelude::*;

use super::{fault, memory::Buffer, queue::Queue};

/// Bytes of each half.
const HALF_BYTES: usize = 8 << 20;
/// Smaller results are copied directly.
const DIRECT_BYTES: usize = 64 << 10;

/// Numbers of input that a thread copies or compares at a time.
const PIECE: usize = 1 << 14;

/// The two halves; made when first needed.
#[derive(Default)]
pub(crate) struct Staging(Mutex<Option<[PinnedHostSlice<u8>; 2]>>);

/// Input that was copied to the device last; grows as needed.
#[derive(Default)]
pub(crate) struct Upload {
    memory: Option<PinnedHostSlice<f32>>,
    /// Numbers that are in it.
    len: usize,
    /// The end of its copy.
    copied: Option<CudaEvent>,
}

impl Upload {
    /// True if it is made of these parts, one behind the other.
    pub(crate) fn holds(&self, parts: &[&[f32]]) -> bool {
        let own = self.memory.as_ref().and_then(|memory| memory.as_slice().ok());
        let Some(mut rest) = own.map(|all| &all[..self.len]) else { return false };
        let is_next = |part: &&[f32]| match rest.split_at_checked(part.len()) {
            Some((own, after)) => {
                rest = after;
                let pieces = own.par_chunks(PIECE).zip(part.par_chunks(PIECE));
                pieces.all(|(own, part)| own == part)
            }
            None => false,
        };
        parts.iter().all(is_next) && rest.is_empty()
    }
}

impl Drop for Upload {
    fn drop(&mut self) {
        // A failure means that the context is gone, and its work with it.
        let _ = self.copied.take().map(|copied| copied.synchronize());
    }
}

impl Queue {
    /// Copies parts, one behind the other, to the start of a buffer behind the work before; they may
    /// be dropped when this returns.
    pub(crate) fn send(
        &self,
        upload: &mut Upload,
        parts: &[&[f32]],
        buffer: &Buffer<f32>,
    ) -> Result<(), Error> {
        let len = parts.iter().map(|part| part.len()).sum();
        if len > buffer.len() {
            return Err(Error::Device("a write behind the end of a buffer".into()));
        }
        // The device may still be reading the previous data.
        if let Some(copied) = upload.copied.take() {
            self.wait_for(&copied)?;
        }
        upload.len = 0;
        let memory = match &mut upload.memory {
            Some(memory) if memory.len() >= len => memory,
            outgrown => outgrown.insert(self.pinned(len.next_power_of_two())?),
        };
        let mut rest = &mut memory.as_mut_slice().map_err(|e| fault("pinned memory", e))?[..len];
        for part in parts {
            let (to, after) = rest.split_at_mut(part.len());
            rest = after;
            let pieces = to.par_chunks_mut(PIECE).zip(part.par_chunks(PIECE));
            pieces.for_each(|(to, from)| to.copy_from_slice(from));
        }
        let sent = &memory.as_slice().map_err(|e| fault("pinned memory", e))?[..len];
        // SAFETY: the range is the buffer's; the memory is not touched until its event has completed.
        let result = unsafe {
            result::memcpy_htod_async(buffer.address().address(), sent, self.stream.cu_stream())
        };
        result.map_err(|e| fault("copying to the device", e))?;
        upload.copied = Some(self.mark()?);
        upload.len = len;
        Ok(())
    }

    /// The values of a buffer; waits for the work before.
    pub(crate) fn fetch<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, Error> {
        let bytes = buffer.len() * size_of::<T>();
        if bytes < DIRECT_BYTES {
            return buffer.read();
        }
        let mut staging = self.staging.0.lock().unwrap_or_else(PoisonError::into_inner);
        let halves = match &mut *staging {
            Some(halves) => halves,
            none => none.insert([self.pinned(HALF_BYTES)?, self.pinned(HALF_BYTES)?]),
        };
        let mut values = vec![T::zeroed(); buffer.len()];
        let into: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        let starts: Vec<usize> = (0..bytes).step_by(HALF_BYTES).collect();
        let mut under_way: Option<(usize, CudaEvent)> = None;
        for (k, &start) in starts.iter().enumerate() {
            let length = HALF_BYTES.min(bytes - start);
            let half = halves[k % 2].as_mut_slice().map_err(|e| fault("pinned memory", e))?;
            // SAFETY: the range is the buffer's; the half is not touched until its event has completed.
            unsafe {
                result::memcpy_dtoh_async(
                    &mut half[..length],
                    buffer.address().address() + start as u64,
                    self.stream.cu_stream(),
                )
            }
            .map_err(|e| fault("copying from the device", e))?;
            let copied = self.mark()?;
            if let Some((before, event)) = under_way.replace((start, copied)) {
                self.empty(&halves[(k + 1) % 2], &event, &mut into[before..before + HALF_BYTES])?;
            }
        }
        if let Some((start, event)) = under_way {
            self.empty(&halves[(starts.len() + 1) % 2], &event, &mut into[start..])?;
        }
        Ok(values)
    }

    fn empty(
        &self,
        half: &PinnedHostSlice<u8>,
        copied: &CudaEvent,
        into: &mut [u8],
    ) -> Result<(), Error> {
        self.wait_for(copied)?;
        let from = half.as_slice().map_err(|e| fault("pinned memory", e))?;
        into.copy_from_slice(&from[..into.len()]);
        Ok(())
    }

    /// Page-locked memory for `len` values, which the host writes before it reads.
    fn pinned<T: DeviceRepr>(&self, len: usize) -> Result<PinnedHostSlice<T>, Error> {
        let context = &self.device.context;
        // SAFETY: no bits are invalid values. Flags 0: cached, for the host reads it.
        unsafe { context.alloc_pinned_with_flags(len.max(1), 0) }
            .map_err(|e| fault("allocating pinned memory", e))
    }
}
