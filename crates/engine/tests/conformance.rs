//! The conformance suite on the CPU backend, a test line per case.

use bendtwin_engine::CpuBackend;

bendtwin_engine_kit::conformance_tests!(CpuBackend::new(2));
