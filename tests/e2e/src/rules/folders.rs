//! Sizes of folders: a folder of product code has at most [`MOST`] files, so that its list can be read.
//! Generated code, kernels, migrations, tests and the messages of a package do not count.

use std::collections::BTreeMap;

use super::workspace;

/// Most files of a folder, without those of the folders in it.
const MOST: usize = 20;

/// Folders at the root that have the product.
const PRODUCT: [&str; 6] = ["client/", "console/", "crates/", "proto/", "server/", "worker/"];

/// Parts of paths of other code in these folders.
const ASIDE: [&str; 5] =
    ["/kernels/", "/migrations/", "/tests/", "console/stories/", "proto/bendtwin/"];

#[test]
fn folders_are_small() {
    let names: Vec<_> = workspace::files().into_iter().map(|(name, _)| name).collect();
    let sizes = sizes(names.iter().map(String::as_str));
    assert!(sizes.contains_key("crates/engine/src/cpu"), "the source tree was not found");
    let large: BTreeMap<_, _> = sizes.into_iter().filter(|(_, files)| *files > MOST).collect();
    assert!(
        large.is_empty(),
        "at most {MOST} files a folder: divide it by what they do: {large:#?}"
    );
}

/// Number of files of each folder of product code.
fn sizes<'a>(names: impl Iterator<Item = &'a str>) -> BTreeMap<&'a str, usize> {
    let mut sizes = BTreeMap::new();
    for name in names {
        let is_product = PRODUCT.iter().any(|part| name.starts_with(part));
        let is_aside = ASIDE.iter().any(|part| name.contains(part))
            || name.ends_with("/tests.rs")
            || name.ends_with(".test.ts");
        if let Some((folder, _)) = name.rsplit_once('/')
            && is_product
            && !is_aside
        {
            *sizes.entry(folder).or_default() += 1;
        }
    }
    sizes
}

#[test]
fn tests_and_files_of_other_folders_do_not_count() {
    let names = [
        "crates/a/src/b.rs",
        "crates/a/src/b/tests.rs",
        "crates/a/src/b/c.rs",
        "crates/a/src/tests.rs",
        "crates/a/tests/it/d.rs",
        "crates/cuda/kernels/e.cu",
        "proto/bendtwin/v1/h.proto",
        "console/src/f.ts",
        "console/src/f.test.ts",
        "docs/g.md",
    ];
    let expected = [("console/src", 1), ("crates/a/src", 1), ("crates/a/src/b", 1)];
    assert_eq!(sizes(names.into_iter()), BTreeMap::from(expected));
}
