//! Launching a kernel: the one place where arguments meet CUDA.

use std::ffi::c_void;

use bendtwin_engine::Error;
use bytemuck::Pod;
use cudarc::driver::{CudaFunction, CudaStream, sys};

use super::{fault, kernel::Variant, team::Meeting};

/// Most blocks of a grid's second and third dimension.
pub(crate) const MOST_BLOCKS: usize = 65_535;

/// A loaded kernel.
pub(crate) struct Function {
    function: CudaFunction,
    meeting: Meeting,
    blocks: u32,
    threads: u32,
}

/// Values that a kernel takes, in order.
#[derive(Default)]
pub(crate) struct Arguments {
    /// Each in eight bytes of its own, which every type here fits.
    values: Vec<u64>,
}

impl Arguments {
    /// Adds a number or an address of at most eight bytes.
    pub(crate) fn with<T: Pod>(mut self, value: T) -> Self {
        let mut bytes = [0_u8; 8];
        let given = bytemuck::bytes_of(&value);
        bytes[..given.len()].copy_from_slice(given);
        self.values.push(u64::from_ne_bytes(bytes));
        self
    }
}

impl Function {
    /// Blocks may have up to `shared_bytes` of dynamic shared memory.
    pub(crate) fn new(
        function: CudaFunction,
        variant: &Variant,
        shared_bytes: u32,
    ) -> Result<Self, Error> {
        let this = Self {
            function,
            meeting: variant.meeting,
            blocks: variant.blocks,
            threads: variant.threads,
        };
        if variant.source.is_persistent() {
            this.allow_shared(shared_bytes)?;
        }
        if variant.meeting == Meeting::Cluster && variant.blocks > 8 {
            let allowed =
                sys::CUfunction_attribute::CU_FUNC_ATTRIBUTE_NON_PORTABLE_CLUSTER_SIZE_ALLOWED;
            this.set(allowed, 1)?;
        }
        Ok(this)
    }

    fn set(&self, attribute: sys::CUfunction_attribute, value: i32) -> Result<(), Error> {
        // SAFETY: the function is loaded, and stays so while `self` lives.
        unsafe { sys::cuFuncSetAttribute(self.function.cu_function(), attribute, value) }
            .result()
            .map_err(|e| fault("setting up a kernel", e))
    }

    /// Lets blocks have so much dynamic shared memory. Once for all launches: they share the function.
    pub(crate) fn allow_shared(&self, bytes: u32) -> Result<(), Error> {
        let attribute = sys::CUfunction_attribute::CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES;
        self.set(attribute, bytes as i32)
    }

    /// How many teams run at the same time.
    pub(crate) fn resident_teams(&self, shared_bytes: u32, processors: u32) -> Result<u32, Error> {
        if self.meeting == Meeting::Cluster {
            let mut attributes = [self.cluster()];
            let config = self.config(
                (self.blocks, 1, 1),
                shared_bytes,
                std::ptr::null_mut(),
                &mut attributes,
            );
            let mut clusters = 0;
            // SAFETY: the function is loaded, the configuration is complete and outlives the call.
            let asked = unsafe {
                sys::cuOccupancyMaxActiveClusters(
                    &raw mut clusters,
                    self.function.cu_function(),
                    &raw const config,
                )
            };
            asked.result().map_err(|e| fault("asking for the clusters that fit", e))?;
            return Ok(clusters.max(0) as u32);
        }
        let blocks = self
            .function
            .occupancy_max_active_blocks_per_multiprocessor(
                self.threads,
                shared_bytes as usize,
                None,
            )
            .map_err(|e| fault("asking for the blocks that fit", e))?;
        Ok(blocks * processors / self.blocks.max(1))
    }

    /// Launches a grid of blocks.
    ///
    /// # Safety
    /// The arguments must be what the kernel takes, and addresses among them valid for what it does
    /// with them until it has ended.
    pub(crate) unsafe fn launch(
        &self,
        stream: &CudaStream,
        grid: (u32, u32, u32),
        shared_bytes: u32,
        arguments: &Arguments,
    ) -> Result<(), Error> {
        if grid.0 == 0 || grid.1 == 0 || grid.2 == 0 {
            return Ok(());
        }
        stream.context().bind_to_thread().map_err(|e| fault("the CUDA context", e))?;
        let mut attributes = Vec::new();
        match self.meeting {
            Meeting::Block => {}
            Meeting::Cluster => attributes.push(self.cluster()),
            Meeting::Grid => attributes.push(cooperative()),
        }
        let config = self.config(grid, shared_bytes, stream.cu_stream(), &mut attributes);
        let mut pointers: Vec<*mut c_void> =
            arguments.values.iter().map(|v| std::ptr::from_ref(v).cast_mut().cast()).collect();
        // SAFETY: the configuration and the arguments outlive the call, which copies them; the rest
        // is the caller's promise.
        unsafe {
            sys::cuLaunchKernelEx(
                &raw const config,
                self.function.cu_function(),
                pointers.as_mut_ptr(),
                std::ptr::null_mut(),
            )
        }
        .result()
        .map_err(|e| fault("launching a kernel", e))
    }

    fn config(
        &self,
        grid: (u32, u32, u32),
        shared_bytes: u32,
        stream: sys::CUstream,
        attributes: &mut [sys::CUlaunchAttribute],
    ) -> sys::CUlaunchConfig {
        sys::CUlaunchConfig {
            gridDimX: grid.0,
            gridDimY: grid.1,
            gridDimZ: grid.2,
            blockDimX: self.threads,
            blockDimY: 1,
            blockDimZ: 1,
            sharedMemBytes: shared_bytes,
            hStream: stream,
            attrs: attributes.as_mut_ptr(),
            numAttrs: attributes.len() as u32,
        }
    }

    fn cluster(&self) -> sys::CUlaunchAttribute {
        attribute(sys::CUlaunchAttributeID::CU_LAUNCH_ATTRIBUTE_CLUSTER_DIMENSION, |value| {
            value.clusterDim =
                sys::CUlaunchAttributeValue_union__bindgen_ty_1 { x: self.blocks, y: 1, z: 1 };
        })
    }
}

fn cooperative() -> sys::CUlaunchAttribute {
    attribute(sys::CUlaunchAttributeID::CU_LAUNCH_ATTRIBUTE_COOPERATIVE, |value| {
        value.cooperative = 1;
    })
}

fn attribute(
    id: sys::CUlaunchAttributeID,
    set: impl FnOnce(&mut sys::CUlaunchAttributeValue),
) -> sys::CUlaunchAttribute {
    let mut value = sys::CUlaunchAttributeValue { pad: [0; 64] };
    set(&mut value);
    sys::CUlaunchAttribute { id, pad: [0; 4], value }
}
