//! The source tree of the tests.

use std::path::{Path, PathBuf};

/// Folders and files at the root that have the project's own text.
const PARTS: [&str; 19] = [
    "proto",
    "crates",
    "server",
    "worker",
    "client",
    "tools",
    "console",
    "tests",
    "docs",
    "studies",
    "deploy",
    ".ci",
    ".cargo",
    "Cargo.toml",
    "README.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
];

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().and_then(Path::parent).unwrap().to_owned()
}

/// Every file written by hand, with its path from the root.
pub(crate) fn files() -> Vec<(String, PathBuf)> {
    let root = root();
    let mut found = Vec::new();
    for part in PARTS {
        walk(&root.join(part), &mut found);
    }
    let mut files: Vec<_> = found
        .into_iter()
        .map(|path| (path.strip_prefix(&root).unwrap().to_string_lossy().into_owned(), path))
        .filter(|(name, _)| !is_generated(name))
        .collect();
    files.sort();
    files
}

fn is_generated(name: &str) -> bool {
    let parts = [
        "proto/src/generated/",
        "client/python/src/bendtwin/v1/",
        "client/python/src/bendtwin/aio/client.py",
        "client/python/src/bendtwin/aio/session.py",
        "client/python/src/bendtwin/aio/twin.py",
        "console/built/",
        "console/screenshots/",
        "client/typescript/src/schema.ts",
        "console/package-lock.json",
    ];
    parts.iter().any(|part| name.starts_with(part)) || name.ends_with("Cargo.lock")
}

fn walk(path: &Path, found: &mut Vec<PathBuf>) {
    if path.is_file() {
        found.push(path.to_owned());
        return;
    }
    for entry in std::fs::read_dir(path).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // A link leads to a file that is found where it is.
        let ours = !path.is_symlink()
            && !name.starts_with('.')
            && !name.ends_with(".egg-info")
            && !["target", "node_modules", "__pycache__", "dist"].contains(&name.as_str());
        if ours {
            walk(&path, found);
        }
    }
}
