//! The program, and what the machine lends it: processor, memory, CUDA devices, confinement.

use std::env::consts::{ARCH, OS};

use bendtwin_backends as backends;
use bendtwin_core::BUILD;

use super::check::Check;
use crate::{output, worker};

/// Most CUDA devices that are looked for.
const MAX_DEVICES: usize = 16;
/// Memory below which a fit of default size may be refused [bytes].
const LITTLE_MEMORY: u64 = 4 << 30;

/// All checks of the machine. Devices are opened for them, one after another.
pub(super) fn checks() -> Vec<Check> {
    let mut checks = vec![Check::ok("program", format!("{BUILD} for {OS} on {ARCH}")), processor()];
    checks.push(memory());
    checks.extend(cuda());
    checks.push(confinement());
    checks
}

fn processor() -> Check {
    Check::ok("processor", bendtwin_engine::cpu().device().name)
}

fn memory() -> Check {
    match bendtwin_budget::machine_bytes() {
        None => Check::note("memory", "the memory of this machine is unknown"),
        Some(bytes) if bytes < LITTLE_MEMORY => Check::note(
            "memory",
            format!(
                "{}: little for fits; --memory-mib says how much they take",
                output::bytes(bytes)
            ),
        ),
        Some(bytes) => Check::ok("memory", output::bytes(bytes)),
    }
}

/// Every device that opens, or the reason for which none does.
fn cuda() -> Vec<Check> {
    let open = |device| {
        let choice = backends::Choice::Cuda;
        backends::open(&backends::Options { choice, device, ..Default::default() })
    };
    let mut checks = Vec::new();
    for device in 0..MAX_DEVICES {
        let check = match open(device) {
            Ok(backend) => {
                let free = backend.memory().map(|m| m.total.saturating_sub(m.used));
                let free =
                    free.map_or_else(String::new, |f| format!(", {} free", output::bytes(f)));
                Check::ok("cuda", format!("device {device}: {}{free}", backend.device().name))
            }
            Err(error) if device == 0 => {
                Check::note("cuda", format!("{error}; fits and rollouts run on the processor"))
            }
            Err(_) => break,
        };
        checks.push(check);
    }
    checks
}

fn confinement() -> Check {
    match worker::lacking_confinement() {
        None => Check::ok("sandbox", "the process that reads captures is confined"),
        Some(lacking) => Check::note(
            "sandbox",
            format!(
                "the system confines the process that reads captures less than it could: {lacking}"
            ),
        ),
    }
}
