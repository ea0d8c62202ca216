//! The engine's conformance suite on a device.

use std::sync::{Arc, OnceLock};

use bendtwin_cuda::{Options, cuda};
use bendtwin_engine::Backend;

/// The backend of all cases, opened as a worker does.
fn backend() -> Arc<dyn Backend> {
    static BACKEND: OnceLock<Arc<dyn Backend>> = OnceLock::new();
    BACKEND.get_or_init(|| cuda(&Options::default()).expect("a CUDA device")).clone()
}

bendtwin_engine_kit::conformance_tests!(*backend(), #[ignore = "needs a CUDA device"]);
