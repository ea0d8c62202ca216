//! The three folders of this crate use each other in one direction: run, then plan, then device.

use std::{fs, path::Path};

/// Source files of a folder and the file beside it, with their text.
fn sources(folder: &Path) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let beside = folder.with_extension("rs");
    let mut open = vec![folder.to_path_buf(), beside];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).expect("the crate's sources are here");
            open.extend(entries.map(|e| e.expect("a readable folder").path()));
        } else {
            let text = fs::read_to_string(&path).expect("sources are text");
            found.push((path.display().to_string(), text));
        }
    }
    found
}

#[test]
fn folders_use_those_below_them_only() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (folder, above) in [("device", &["plan", "run"][..]), ("plan", &["run"])] {
        let sources = sources(&src.join(folder));
        assert!(sources.len() > 1, "{folder} has moved");
        for (path, text) in sources {
            for name in above {
                let used = text.contains(&format!("crate::{name}"))
                    || text.contains(&format!("    {name}::"));
                assert!(!used, "{path} uses {name}");
            }
        }
    }
}
