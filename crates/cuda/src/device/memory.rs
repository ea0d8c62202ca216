//! Device memory: typed buffers on a stream, and what becomes of them where there is too little.

use std::sync::Arc;

use bendtwin_engine::Error;
use bytemuck::Pod;
use cudarc::driver::{CudaStream, result, sys};

use super::{args::Pointer, fault};

/// End of arrays that follow each other, from where each starts and the last one ends.
pub(crate) fn end_of(starts: &[usize]) -> usize {
    starts.last().copied().unwrap_or(0)
}

/// `len` values on the device; freed in the stream's order when dropped. Never null, even if empty.
pub(crate) struct Buffer<T> {
    address: u64,
    len: usize,
    stream: Arc<CudaStream>,
    values: std::marker::PhantomData<T>,
}

impl<T: Pod> Buffer<T> {
    /// Memory with nothing in it.
    pub(crate) fn empty(stream: &Arc<CudaStream>, len: usize) -> Result<Self, Error> {
        let bytes = len.checked_mul(size_of::<T>()).filter(|&b| b < isize::MAX as usize);
        let bytes = bytes.ok_or_else(|| Error::Device("a buffer beyond all memory".into()))?;
        let context = stream.context();
        context.bind_to_thread().map_err(|e| fault("the CUDA context", e))?;
        // SAFETY: the stream is alive; the memory is freed once, by `drop`.
        let address = unsafe { result::malloc_async(stream.cu_stream(), bytes.max(16)) };
        let address = address.map_err(|e| match e.0 {
            sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY => Error::OutOfMemory {
                needed: bytes as u64,
                available: context.mem_get_info().map_or(0, |(free, _)| free as u64),
            },
            _ => fault("allocating device memory", e),
        })?;
        Ok(Self { address, len, stream: stream.clone(), values: std::marker::PhantomData })
    }

    /// Memory full of zero bytes.
    pub(crate) fn zeros(stream: &Arc<CudaStream>, len: usize) -> Result<Self, Error> {
        let buffer = Self::empty(stream, len)?;
        buffer.clear()?;
        Ok(buffer)
    }

    /// A copy of the host's values.
    pub(crate) fn of(stream: &Arc<CudaStream>, values: &[T]) -> Result<Self, Error> {
        let buffer = Self::empty(stream, values.len())?;
        buffer.write(0, values)?;
        Ok(buffer)
    }

    /// Sets all bytes to zero.
    pub(crate) fn clear(&self) -> Result<(), Error> {
        self.fill(0)
    }

    /// Sets all bytes.
    pub(crate) fn fill(&self, byte: u8) -> Result<(), Error> {
        let bytes = self.len * size_of::<T>();
        if bytes == 0 {
            return Ok(());
        }
        self.bind()?;
        // SAFETY: the memory is ours and so long.
        unsafe { result::memset_d8_async(self.address, byte, bytes, self.stream.cu_stream()) }
            .map_err(|e| fault("filling device memory", e))
    }

    /// Copies the host's values to `at` and following; they may be dropped when this returns.
    pub(crate) fn write(&self, at: usize, values: &[T]) -> Result<(), Error> {
        if at + values.len() > self.len {
            return Err(Error::Device("a write behind the end of a buffer".into()));
        }
        if values.is_empty() {
            return Ok(());
        }
        self.bind()?;
        // SAFETY: the range is ours; pageable host memory is staged before the call returns.
        unsafe { result::memcpy_htod_async(self.at(at).address(), values, self.stream.cu_stream()) }
            .map_err(|e| fault("copying to the device", e))
    }

    /// Copies `count` values from another buffer on the same stream.
    pub(crate) fn copy_from(
        &self,
        at: usize,
        from: &Self,
        first: usize,
        count: usize,
    ) -> Result<(), Error> {
        if at + count > self.len || first + count > from.len {
            return Err(Error::Device("a copy behind the end of a buffer".into()));
        }
        if count == 0 {
            return Ok(());
        }
        self.bind()?;
        let (bytes, stream) = (count * size_of::<T>(), self.stream.cu_stream());
        // SAFETY: both ranges are inside their buffers.
        unsafe {
            result::memcpy_dtod_async(
                self.at(at).address(),
                from.at(first).address(),
                bytes,
                stream,
            )
        }
        .map_err(|e| fault("copying on the device", e))
    }

    /// The values; waits for the stream.
    pub(crate) fn read(&self) -> Result<Vec<T>, Error> {
        self.read_from(0, self.len)
    }

    /// `count` values from `at` on; waits for the stream.
    pub(crate) fn read_from(&self, at: usize, count: usize) -> Result<Vec<T>, Error> {
        if at + count > self.len {
            return Err(Error::Device("a read behind the end of a buffer".into()));
        }
        let mut values = vec![T::zeroed(); count];
        if count > 0 {
            // The copy to pageable memory would wait in the driver.
            super::synchronize(&self.stream)?;
            let stream = self.stream.cu_stream();
            // SAFETY: the range is ours; the host's memory lives until the stream has been waited
            // for.
            unsafe { result::memcpy_dtoh_async(&mut values, self.at(at).address(), stream) }
                .map_err(|e| fault("copying from the device", e))?;
        }
        self.stream.synchronize().map_err(|e| fault("the device's work", e))?;
        Ok(values)
    }
}

impl<T> Buffer<T> {
    /// Address of the first value.
    pub(crate) fn address(&self) -> Pointer<T> {
        Pointer::new(self.address)
    }

    /// Address of a value.
    pub(crate) fn at(&self, index: usize) -> Pointer<T> {
        self.address().add(index)
    }

    /// Number of values.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    fn bind(&self) -> Result<(), Error> {
        self.stream.context().bind_to_thread().map_err(|e| fault("the CUDA context", e))
    }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        if self.bind().is_ok() {
            // SAFETY: allocated by `empty`, freed only here, behind all work that the stream has. A
            // failure means that the context is gone, and the memory with it.
            let _ = unsafe { result::free_async(self.address, self.stream.cu_stream()) };
        }
    }
}
