//! Page-locked host memory through which large results come back: the device copies one half while
//! the host empties the other.

use std::sync::{Mutex, PoisonError};

use bendtwin_engine::Error;
use bytemuck::Pod;
use cudarc::driver::{CudaEvent, PinnedHostSlice, result};

use super::{fault, memory::Buffer, queue::Queue};

/// Bytes of each half.
const HALF_BYTES: usize = 8 << 20;
/// Smaller results come back directly.
const DIRECT_BYTES: usize = 64 << 10;

/// The two halves; made when first needed.
#[derive(Default)]
pub(crate) struct Staging(Mutex<Option<[PinnedHostSlice<u8>; 2]>>);

impl Queue {
    /// The values of a buffer; waits for the work before.
    pub(crate) fn fetch<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, Error> {
        let bytes = buffer.len() * size_of::<T>();
        if bytes < DIRECT_BYTES {
            return buffer.read();
        }
        let mut staging = self.staging.0.lock().unwrap_or_else(PoisonError::into_inner);
        let halves = match &mut *staging {
            Some(halves) => halves,
            none => none.insert([self.pinned()?, self.pinned()?]),
        };
        let mut values = vec![T::zeroed(); buffer.len()];
        let into: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        let starts: Vec<usize> = (0..bytes).step_by(HALF_BYTES).collect();
        let mut under_way: Option<(usize, CudaEvent)> = None;
        for (k, &start) in starts.iter().enumerate() {
            let length = HALF_BYTES.min(bytes - start);
            let half = halves[k % 2].as_mut_slice().map_err(|e| fault("pinned memory", e))?;
            // SAFETY: the range is the buffer's; the half is not touched until its event has come.
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

    fn pinned(&self) -> Result<PinnedHostSlice<u8>, Error> {
        let context = &self.device.context;
        // SAFETY: bytes have no invalid values. Flags 0: cached, for the host reads it.
        unsafe { context.alloc_pinned_with_flags(HALF_BYTES, 0) }
            .map_err(|e| fault("allocating pinned memory", e))
    }
}
