//! Limits of what the process may take.

use std::io;

use rlimit::Resource;

use super::Resources;

/// Open files: the archive, a checkpoint and a result at a time.
const OPEN_FILES: u64 = 256;
/// Time between the signal at the limit of processor time and the end [s].
const GRACE_S: u64 = 5;

/// Limits this process. Beyond the memory, allocations fail and it aborts.
pub(super) fn limit(resources: &Resources) -> io::Result<()> {
    // Data, not address space: memory that is reserved and never touched costs nothing.
    #[cfg(any(target_os = "linux", target_os = "android"))]
    let memory = Resource::DATA;
    #[cfg(not(any(target_os = "linux", target_os = "android")))]
    let memory = Resource::AS;
    let cpu = resources.processor_s;
    lower(memory, resources.memory_bytes, resources.memory_bytes)?;
    lower(Resource::CPU, cpu, cpu.saturating_add(GRACE_S))?;
    lower(Resource::FSIZE, resources.file_bytes, resources.file_bytes)?;
    lower(Resource::NOFILE, OPEN_FILES, OPEN_FILES)?;
    // A core would hold the stranger's file, and fill the disk.
    lower(Resource::CORE, 0, 0)
}

/// Sets a limit unless a lower one is in force. The number of processes has none: it counts all of
/// a user's, and making any is denied.
fn lower(resource: Resource, soft: u64, hard: u64) -> io::Result<()> {
    let (_, most) = resource.get()?;
    resource.set(soft.min(most), hard.min(most))
}
