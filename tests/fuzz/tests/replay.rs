//! Every file of every corpus, and every seed, without a panic and without a long wait.

use std::{
    collections::BTreeSet,
    panic::catch_unwind,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use bendtwin_fuzz::{TARGETS, Target};

/// Far more than a file may take, because a busy machine is no fault of a reader. The fuzzer looks
/// for slow files with a nearer limit.
const LONGEST: Duration = Duration::from_secs(30);

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// The faults that an input meets.
fn faults(target: &Target, name: &str, bytes: &[u8]) -> Option<String> {
    let start = Instant::now();
    let run = target.run;
    let panicked = catch_unwind(|| run(bytes)).is_err();
    let took = start.elapsed();
    (panicked || took > LONGEST).then(|| {
        format!("{}: {name} ({} bytes), panicked: {panicked}, {took:?}", target.name, bytes.len())
    })
}

#[test]
fn corpora_are_read_without_a_fault() {
    let mut found = Vec::new();
    for target in TARGETS {
        let corpus = folder("corpus").join(target.name);
        let files = names(&corpus);
        assert!(
            !files.is_empty(),
            "the corpus of `{}` is empty: {}",
            target.name,
            corpus.display()
        );
        for name in files {
            let bytes = std::fs::read(corpus.join(&name)).unwrap();
            found.extend(faults(target, &name, &bytes));
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn seeds_are_read_without_a_fault() {
    let mut found = Vec::new();
    for target in TARGETS {
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "`{}` has no seeds", target.name);
        for (index, bytes) in seeds.iter().enumerate() {
            found.extend(faults(target, &format!("seed {index}"), bytes));
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn each_target_has_a_binary_and_a_corpus_and_nothing_else_has() {
    let targets: BTreeSet<String> = TARGETS.iter().map(|target| target.name.to_owned()).collect();
    assert_eq!(targets.len(), TARGETS.len(), "names repeat");
    assert_eq!(names(&folder("corpus")), targets);
    let binaries = names(&folder("fuzz/targets")).into_iter();
    let binaries: BTreeSet<String> =
        binaries.map(|name| name.trim_end_matches(".rs").to_owned()).collect();
    assert_eq!(binaries, targets);
    let manifest = std::fs::read_to_string(folder("fuzz/Cargo.toml")).unwrap();
    for target in &targets {
        assert!(manifest.contains(&format!("name = \"{target}\"")), "fuzz/Cargo.toml: {target}");
        let code = std::fs::read_to_string(folder("fuzz/targets").join(format!("{target}.rs")));
        assert!(
            code.unwrap().contains(&format!("::{target}(")),
            "{target}.rs calls another target"
        );
    }
    for dictionary in names(&folder("dictionaries")) {
        assert!(targets.contains(dictionary.trim_end_matches(".dict")), "{dictionary}");
    }
}

#[test]
fn corpora_stay_small() {
    let size = |target: &Target| -> u64 {
        let corpus = folder("corpus").join(target.name);
        names(&corpus).iter().map(|name| corpus.join(name).metadata().unwrap().len()).sum()
    };
    let bytes: u64 = TARGETS.iter().map(size).sum();
    assert!(bytes < 2 << 20, "{bytes} bytes: keep what `tests/fuzz/run --keep` keeps");
}
