//! The conformance suite on the CPU.

use bendtwin_splat::Cpu;

bendtwin_splat_kit::conformance_tests!(Cpu::default());
