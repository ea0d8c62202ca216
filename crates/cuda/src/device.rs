//! A device: its context, what it is able to, its memory, and the kernels loaded on it.

pub(crate) mod args;
pub(crate) mod cache;
pub(crate) mod compile;
pub(crate) mod kernels;
pub(crate) mod launch;
pub(crate) mod memo;
pub(crate) mod memory;
pub(crate) mod queue;
pub(crate) mod specialization;
pub(crate) mod staging;
pub(crate) mod team;
pub(crate) mod throttle;
pub(crate) mod wait;

use std::sync::Arc;

use bendtwin_engine::{Error, backend::Memory};
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaStream, DriverError,
    sys::{self, CUdevice_attribute as Attribute},
};

use self::{
    cache::Cache,
    launch::Function,
    memo::Memo,
    specialization::{Source, Specialization},
    team::{Team, TeamShape},
};
use crate::Options;

/// First architecture with clusters and distributed shared memory.
const CLUSTERS_FROM: u32 = 90;
/// Shared memory that a kernel's static variables may take.
const STATIC_SHARED_BYTES: u32 = 1024;
/// Priorities of streams.
const NORMAL: i32 = 0;
const URGENT: i32 = -5;
/// Most kernels that run concurrently.
const MAX_CONCURRENT: usize = 8;
/// Blocks of the clusters that are tried, the largest first: what runs depends on the chip and on
/// who shares it.
const CLUSTERS: [u32; 4] = [16, 8, 4, 2];

/// Capabilities of a device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capabilities {
    /// Multiprocessors.
    pub(crate) processors: u32,
    /// Shared memory that a block can have [bytes].
    pub(crate) shared_bytes: u32,
    /// Blocks of the largest cluster; 1 without clusters.
    pub(crate) cluster: u32,
}

impl Capabilities {
    /// Dynamic shared memory that a block can have beside its static variables [bytes].
    pub(crate) fn dynamic_shared(&self) -> u32 {
        self.shared_bytes.saturating_sub(STATIC_SHARED_BYTES)
    }
}

/// A device that is in use.
pub(crate) struct Device {
    pub(crate) context: Arc<CudaContext>,
    pub(crate) name: String,
    pub(crate) capabilities: Capabilities,
    /// Bytes that this process may have.
    pub(crate) budget: u64,
    /// Forces this kind of team, in place of the best.
    pub(crate) team: Option<Team>,
    /// Serves requests that must not wait.
    pub(crate) urgent: Arc<CudaStream>,
    pub(crate) normal: Arc<CudaStream>,
    /// Streams of the same priorities for concurrent kernels.
    pub(crate) concurrent_urgent: Vec<Arc<CudaStream>>,
    pub(crate) concurrent_normal: Vec<Arc<CudaStream>>,
    cache: Cache,
    functions: Memo<(Specialization, &'static str), Arc<Function>>,
    modules: Memo<Specialization, Arc<CudaModule>>,
}

impl Device {
    /// Opens a device, or reports in one line what is missing.
    pub(crate) fn open(options: &Options) -> Result<Arc<Self>, Error> {
        // SAFETY: loads a library by its well-known name and unloads it again.
        if !unsafe { sys::is_culib_present() } {
            return Err(Error::Device("no CUDA driver (libcuda.so) on this machine".into()));
        }
        if !compile::is_present() {
            return Err(Error::Device(
                "NVRTC (libnvrtc.so) is missing: install the CUDA toolkit's runtime compiler"
                    .into(),
            ));
        }
        let count = {
            cudarc::driver::result::init().map_err(|e| fault("the CUDA driver", e))?;
            CudaContext::device_count().map_err(|e| fault("counting CUDA devices", e))?
        };
        if options.ordinal >= count.max(0) as usize {
            let ordinal = options.ordinal;
            return Err(Error::Device(format!("no CUDA device {ordinal}: there are {count}")));
        }
        let context =
            CudaContext::new(options.ordinal).map_err(|e| fault("opening the CUDA device", e))?;
        // SAFETY: all work that shares memory is ordered on one stream, or ends with a
        // synchronisation before the memory is used elsewhere.
        unsafe { context.disable_event_tracking() };
        Self::new(context, options)
    }

    fn new(context: Arc<CudaContext>, options: &Options) -> Result<Arc<Self>, Error> {
        let attribute = |a| context.attribute(a).map_err(|e| fault("a device attribute", e));
        let (major, minor) =
            context.compute_capability().map_err(|e| fault("the compute capability", e))?;
        let architecture = (10 * major + minor).max(0) as u32;
        let capabilities = Capabilities {
            processors: attribute(Attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)?.max(1)
                as u32,
            shared_bytes: attribute(
                Attribute::CU_DEVICE_ATTRIBUTE_MAX_SHARED_MEMORY_PER_BLOCK_OPTIN,
            )?
            .max(0) as u32,
            cluster: 1,
        };
        let name = context.name().map_err(|e| fault("the device's name", e))?;
        let (free, _) = context.mem_get_info().map_err(|e| fault("device memory", e))?;
        let budget = options.memory_limit.unwrap_or(free as u64 / 10 * 9).min(free as u64);
        let stream = |priority| {
            let made = context.new_stream_with_priority(priority);
            made.map_err(|e| fault("making a stream", e))
        };
        keep_freed_memory(&context, budget)?;
        let several =
            |priority| (0..MAX_CONCURRENT).map(|_| stream(priority)).collect::<Result<Vec<_>, _>>();
        // Smaller numbers go first.
        let (normal, urgent) = (stream(NORMAL)?, stream(URGENT)?);
        let mut device = Self {
            cache: Cache::new(options.cache_dir.as_deref(), architecture)?,
            name,
            capabilities,
            budget,
            team: None,
            urgent,
            normal,
            concurrent_urgent: several(URGENT)?,
            concurrent_normal: several(NORMAL)?,
            functions: Memo::default(),
            modules: Memo::default(),
            context,
        };
        for source in Source::SMALL {
            device.module(&Specialization::small(source))?;
        }
        if architecture >= CLUSTERS_FROM {
            device.capabilities.cluster = device.largest_cluster();
        }
        if let Some(name) = &options.team {
            let team = name.parse::<Team>().map_err(Error::InvalidInput)?;
            team.check(&device.capabilities).map_err(Error::InvalidInput)?;
            device.team = Some(team);
        }
        Ok(Arc::new(device))
    }

    /// Blocks of the largest cluster that runs here, 1 if none does.
    fn largest_cluster(&self) -> u32 {
        let runs = |blocks: u32| match self.has_room_for_cluster(blocks) {
            Ok(runs) => runs,
            Err(error) => {
                tracing::debug!(blocks, %error, "no such clusters here");
                false
            }
        };
        CLUSTERS.into_iter().find(|&blocks| runs(blocks)).unwrap_or(1)
    }

    /// True if a cluster runs here whose blocks have all the shared memory that a block can have.
    fn has_room_for_cluster(&self, blocks: u32) -> Result<bool, Error> {
        let shared = self.capabilities.dynamic_shared();
        // Any kernel will do.
        let any = Specialization::small(Source::Start);
        let loaded = self.load(&any, "start")?;
        let cluster = Specialization { shape: TeamShape::Cluster, blocks, ..any };
        let function = Function::new("start", loaded, &cluster, shared)?;
        function.allow_shared(shared)?;
        Ok(function.resident_teams(shared, self.capabilities.processors)? > 0)
    }

    /// Memory of the device, including that of other processes.
    pub(crate) fn memory(&self) -> Option<Memory> {
        let (free, total) = self.context.mem_get_info().ok()?;
        Some(Memory { used: total.saturating_sub(free) as u64, total: total as u64 })
    }

    /// A kernel, compiled and loaded at first use.
    pub(crate) fn function(
        &self,
        specialization: &Specialization,
        kernel: &'static str,
    ) -> Result<Arc<Function>, Error> {
        self.functions.get_or_make((*specialization, kernel), || {
            let loaded = self.load(specialization, kernel)?;
            let shared = self.capabilities.dynamic_shared();
            Ok(Arc::new(Function::new(kernel, loaded, specialization, shared)?))
        })
    }

    fn load(&self, specialization: &Specialization, kernel: &str) -> Result<CudaFunction, Error> {
        let module = self.module(specialization)?;
        // Another thread may have loaded the module.
        self.context.bind_to_thread().map_err(|e| fault("the CUDA context", e))?;
        module.load_function(kernel).map_err(|e| fault(&format!("finding {kernel}"), e))
    }

    fn module(&self, specialization: &Specialization) -> Result<Arc<CudaModule>, Error> {
        self.modules.get_or_make(*specialization, || {
            let cubin = cudarc::nvrtc::Ptx::from_binary(self.cache.cubin(specialization)?);
            let source = specialization.source;
            self.context
                .load_module(cubin)
                .map_err(|e| fault(&format!("loading the kernels of {source:?}"), e))
        })
    }
}

/// Allocations come from the device's pool; freed memory stays there for the next.
fn keep_freed_memory(context: &CudaContext, bytes: u64) -> Result<(), Error> {
    context.bind_to_thread().map_err(|e| fault("the CUDA context", e))?;
    let mut pool = std::ptr::null_mut();
    let mut keep = bytes;
    // SAFETY: the device is open; the attribute is a 64-bit number.
    unsafe {
        sys::cuDeviceGetDefaultMemPool(&raw mut pool, context.cu_device()).result().and_then(|()| {
            let attribute = sys::CUmemPool_attribute::CU_MEMPOOL_ATTR_RELEASE_THRESHOLD;
            sys::cuMemPoolSetAttribute(pool, attribute, (&raw mut keep).cast()).result()
        })
    }
    .map_err(|e| fault("the memory pool", e))
}

/// Driver error, with the failed operation.
pub(crate) fn fault(what: &str, error: DriverError) -> Error {
    Error::Device(format!("{what}: {error}"))
}

/// Waits for a stream's work, as [`wait`] does.
pub(crate) fn synchronize(stream: &CudaStream) -> Result<(), Error> {
    wait::for_stream(stream).map_err(|e| fault("the device's work", e))
}
