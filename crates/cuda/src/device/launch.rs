//! Launching kernels: the one place where arguments meet CUDA.

use std::{ffi::c_void, fmt};

use bendtwin_engine::Error;
use bytemuck::Pod;
use cudarc::driver::{CudaFunction, CudaStream, sys};

use super::{
    Device, fault,
    specialization::{Source, Specialization},
    team::TeamShape,
};

/// Most blocks of a grid's second and third dimension.
pub(crate) const MOST_BLOCKS: usize = 65_535;

/// A grid of blocks on a stream.
pub(crate) struct Launch<'a> {
    device: &'a Device,
    stream: &'a CudaStream,
    grid: [u32; 3],
    specialized: Option<(&'a Specialization, u32)>,
}

impl<'a> Launch<'a> {
    /// A grid for a kernel without specialization.
    pub(crate) fn new(device: &'a Device, stream: &'a CudaStream, grid: [u32; 3]) -> Self {
        Self { device, stream, grid, specialized: None }
    }

    /// A launch of a specialized kernel with the given dynamic shared memory a block [bytes].
    pub(crate) fn specialized(self, to: &'a Specialization, shared_bytes: u32) -> Self {
        Self { specialized: Some((to, shared_bytes)), ..self }
    }

    /// Launches a kernel of a source, compiled and loaded at first use.
    ///
    /// # Safety
    /// The struct must be what the kernel takes, and addresses in it valid for what the kernel does
    /// with them until it has ended.
    pub(super) unsafe fn run<A: Pod>(
        &self,
        source: Source,
        kernel: &'static str,
        args: &A,
    ) -> Result<(), Error> {
        let small = Specialization::small(source);
        let (specialization, shared_bytes) = self.specialized.unwrap_or((&small, 0));
        if specialization.source != source {
            let other = specialization.source;
            return Err(Error::Device(format!("{kernel} is no kernel of {other:?}")));
        }
        let function = self.device.function(specialization, kernel)?;
        // SAFETY: the caller's promise.
        unsafe { function.launch(self.stream, self.grid, shared_bytes, args) }
    }
}

/// A loaded kernel.
pub(crate) struct Function {
    kernel: &'static str,
    function: CudaFunction,
    shape: TeamShape,
    blocks: u32,
    threads: u32,
}

/// The numbers of a launch, as errors name them.
#[derive(Clone, Copy, Debug)]
struct LaunchShape {
    grid: [u32; 3],
    threads: u32,
    shared_bytes: u32,
    /// Blocks of a cluster, where there are clusters.
    cluster: Option<u32>,
}

impl fmt::Display for LaunchShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { grid: [x, y, z], threads, shared_bytes, cluster } = self;
        write!(f, "grid {x} x {y} x {z}, block {threads}, {shared_bytes} bytes of shared memory")?;
        match cluster {
            Some(blocks) => write!(f, ", cluster {blocks}"),
            None => Ok(()),
        }
    }
}

impl Function {
    /// A loaded kernel, whose blocks may have up to `shared_bytes` of dynamic shared memory.
    pub(crate) fn new(
        kernel: &'static str,
        function: CudaFunction,
        specialization: &Specialization,
        shared_bytes: u32,
    ) -> Result<Self, Error> {
        let this = Self {
            kernel,
            function,
            shape: specialization.shape,
            blocks: specialization.blocks,
            threads: specialization.threads,
        };
        if specialization.source.is_persistent() {
            this.allow_shared(shared_bytes)?;
        }
        if specialization.shape == TeamShape::Cluster && specialization.blocks > 8 {
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
            .map_err(|e| fault(&format!("setting up {}", self.kernel), e))
    }

    /// Allows blocks this much dynamic shared memory. Once for all launches: they share the
    /// function.
    pub(crate) fn allow_shared(&self, bytes: u32) -> Result<(), Error> {
        let attribute = sys::CUfunction_attribute::CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES;
        self.set(attribute, bytes as i32)
    }

    /// Number of teams that run at the same time.
    pub(crate) fn resident_teams(&self, shared_bytes: u32, processors: u32) -> Result<u32, Error> {
        let grid = [self.blocks, 1, 1];
        let failed = |e| {
            let launch = self.launch_shape(grid, shared_bytes);
            fault(&format!("occupancy of {} ({launch})", self.kernel), e)
        };
        if self.shape == TeamShape::Cluster {
            let mut attributes = [self.cluster()];
            let config = self.config(grid, shared_bytes, std::ptr::null_mut(), &mut attributes);
            let mut clusters = 0;
            // SAFETY: the function is loaded, the configuration is complete and outlives the call.
            let asked = unsafe {
                sys::cuOccupancyMaxActiveClusters(
                    &raw mut clusters,
                    self.function.cu_function(),
                    &raw const config,
                )
            };
            asked.result().map_err(failed)?;
            return Ok(clusters.max(0) as u32);
        }
        let (threads, shared) = (self.threads, shared_bytes as usize);
        let asked =
            self.function.occupancy_max_active_blocks_per_multiprocessor(threads, shared, None);
        Ok(asked.map_err(failed)? * processors / self.blocks.max(1))
    }

    /// Launches a grid of blocks.
    ///
    /// # Safety
    /// Those of [`Launch::run`].
    unsafe fn launch<A: Pod>(
        &self,
        stream: &CudaStream,
        grid: [u32; 3],
        shared_bytes: u32,
        args: &A,
    ) -> Result<(), Error> {
        if grid.contains(&0) {
            return Ok(());
        }
        stream.context().bind_to_thread().map_err(|e| fault("the CUDA context", e))?;
        let mut attributes = Vec::new();
        match self.shape {
            TeamShape::Block => {}
            TeamShape::Cluster => attributes.push(self.cluster()),
            TeamShape::Grid => attributes.push(cooperative()),
        }
        let config = self.config(grid, shared_bytes, stream.cu_stream(), &mut attributes);
        let mut parameters: [*mut c_void; 1] = [std::ptr::from_ref(args).cast_mut().cast()];
        // SAFETY: the configuration and the struct outlive the call, which copies them; the rest
        // is the caller's promise.
        unsafe {
            sys::cuLaunchKernelEx(
                &raw const config,
                self.function.cu_function(),
                parameters.as_mut_ptr(),
                std::ptr::null_mut(),
            )
        }
        .result()
        .map_err(|e| {
            let launch = self.launch_shape(grid, shared_bytes);
            fault(&format!("launching {} ({launch})", self.kernel), e)
        })
    }

    fn launch_shape(&self, grid: [u32; 3], shared_bytes: u32) -> LaunchShape {
        let cluster = (self.shape == TeamShape::Cluster).then_some(self.blocks);
        LaunchShape { grid, threads: self.threads, shared_bytes, cluster }
    }

    fn config(
        &self,
        grid: [u32; 3],
        shared_bytes: u32,
        stream: sys::CUstream,
        attributes: &mut [sys::CUlaunchAttribute],
    ) -> sys::CUlaunchConfig {
        sys::CUlaunchConfig {
            gridDimX: grid[0],
            gridDimY: grid[1],
            gridDimZ: grid[2],
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

#[cfg(test)]
mod tests;
