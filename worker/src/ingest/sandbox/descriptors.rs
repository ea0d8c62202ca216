//! Descriptors that came from the parent. Rust opens its own so that programs do not inherit them,
//! but the worker's parent may have left others to it, and those pass on.

/// Descriptors that are checked where the system does not list them.
const MOST_DESCRIPTORS: i32 = 1024;

/// Closes all descriptors but standard input, output and error.
pub(super) fn close_inherited() {
    for descriptor in open_descriptors() {
        // Those that are not open do not matter, among them the one that the listing used.
        let _ = nix::unistd::close(descriptor);
    }
}

fn open_descriptors() -> Vec<i32> {
    let listed = std::fs::read_dir("/proc/self/fd").ok().map(|entries| {
        let names = entries.flatten().filter_map(|e| e.file_name().to_str()?.parse().ok());
        names.filter(|d| *d > 2).collect()
    });
    listed.unwrap_or_else(|| (3..MOST_DESCRIPTORS).collect())
}
