//! What pictures are drawn with: threads, and a device for Gaussians if there is one.

use std::sync::{Mutex, PoisonError};

use bendtwin_engine::backend;
use bendtwin_splat::{OpenRasteriser, Rasteriser};

use crate::error::Error;

/// Threads of this process for pictures, and the rasteriser of a device.
pub struct Painter {
    /// `None` on a machine that gives no threads: then the caller's own does everything.
    pool: Option<rayon::ThreadPool>,
    threads: usize,
    /// Opens the rasteriser of a device; `None` if Gaussians are drawn by the threads.
    open: Option<OpenRasteriser>,
    device: Mutex<Option<Box<dyn Rasteriser>>>,
}

impl Painter {
    /// A painter with a number of threads (at least one), and the rasteriser of a device, which is opened when it is first needed.
    pub fn new(threads: usize, open: Option<OpenRasteriser>) -> Self {
        let threads = threads.max(1);
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = builder.thread_name(|i| format!("bendtwin-picture-{i}")).build();
        Self { pool: pool.ok(), threads, open, device: Mutex::default() }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs work on the threads.
    pub(super) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// True if the rasteriser of a device draws Gaussians.
    pub(super) fn has_device(&self) -> bool {
        self.open.is_some()
    }

    /// Uses the rasteriser of the device, one caller at a time. One that failed is not used again.
    ///
    /// # Errors
    /// If it cannot be opened, or the use fails.
    pub(super) fn on_device<R>(
        &self,
        work: impl FnOnce(&mut dyn Rasteriser) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let none = || backend::Error::Device("there is no rasteriser".to_owned());
        let open = self.open.as_ref().ok_or_else(none)?;
        let mut device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        let mut rasteriser = match device.take() {
            Some(rasteriser) => rasteriser,
            None => open().map_err(backend::Error::Device)?,
        };
        let done = work(&mut *rasteriser)?;
        *device = Some(rasteriser);
        Ok(done)
    }
}
