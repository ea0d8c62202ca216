//! Memory of a measurement: the device's if the backend reports it, otherwise this process's.

use std::sync::Arc;

use bendtwin_bench::{DeviceMemory, MemoryProbe};
use bendtwin_engine::Backend;

/// The probe for this backend.
pub(super) fn probe(backend: &Arc<dyn Backend>) -> Box<dyn MemoryProbe> {
    match DeviceMemory::new(backend) {
        Some(device) => Box::new(device),
        None if backend.device().kind == "cpu" => Box::new(ProcessMemory),
        None => Box::new(()),
    }
}

/// Peak of the resident memory of this process. Known on Linux only.
struct ProcessMemory;

impl MemoryProbe for ProcessMemory {
    fn reset(&self) {
        // Sets the peak back to what is resident now; where that is not allowed, the peak is the
        // process's.
        let _ = std::fs::write("/proc/self/clear_refs", "5");
    }

    fn used_bytes(&self) -> Option<u64> {
        peak_bytes(&std::fs::read_to_string("/proc/self/status").ok()?)
    }
}

/// The peak of the resident set in the text of `/proc/self/status`.
fn peak_bytes(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kib.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_read_from_linux_text() {
        let status = "Name:\tbendtwin\nVmHWM:\t    2048 kB\nVmRSS:\t 1024 kB\n";
        assert_eq!(peak_bytes(status), Some(2048 * 1024));
        assert_eq!(peak_bytes("VmHWM: much"), None);
        assert_eq!(peak_bytes(""), None);
    }
}
