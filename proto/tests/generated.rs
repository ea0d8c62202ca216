//! The Rust code of the messages, in `src/generated`, is what the .proto files say.
//!
//! It is kept beside them, so that a build needs neither their compiler nor the forty crates that
//! it is made of. After a change of a .proto file, or of what is generated:
//!
//! ```sh
//! BENDTWIN_BLESS=1 cargo test -p bendtwin-proto --test generated
//! ```

#[path = "generated/contract.rs"]
mod contract;
#[path = "generated/json.rs"]
mod json;
#[path = "generated/openapi.rs"]
mod openapi;
#[path = "generated/routes.rs"]
mod routes;
#[path = "generated/schema.rs"]
mod schema;

use std::{collections::BTreeMap, path::Path};

use contract::Contract;

const FILES: [&str; 20] = [
    "bendtwin/v1/tensor.proto",
    "bendtwin/v1/fault.proto",
    "bendtwin/v1/world.proto",
    "bendtwin/v1/capture.proto",
    "bendtwin/v1/job.proto",
    "bendtwin/v1/fit.proto",
    "bendtwin/v1/twin.proto",
    "bendtwin/v1/trash.proto",
    "bendtwin/v1/retention.proto",
    "bendtwin/v1/worker.proto",
    "bendtwin/v1/key.proto",
    "bendtwin/v1/project.proto",
    "bendtwin/v1/usage.proto",
    "bendtwin/v1/sign_in.proto",
    "bendtwin/v1/rollout.proto",
    "bendtwin/v1/planning.proto",
    "bendtwin/v1/registration.proto",
    "bendtwin/v1/evaluation.proto",
    "bendtwin/v1/session.proto",
    "bendtwin/worker/v1/worker_link.proto",
];

#[test]
fn the_generated_code_is_that_of_the_proto_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let made = generate(root);
    let folder = root.join("src/generated");
    if std::env::var_os("BENDTWIN_BLESS").is_some() {
        std::fs::remove_dir_all(&folder).unwrap();
        std::fs::create_dir(&folder).unwrap();
        for (name, content) in &made {
            std::fs::write(folder.join(name), content).unwrap();
        }
    }
    let kept = read(&folder);
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&kept), names(&made));
    for (name, content) in made {
        assert!(
            kept[&name] == content,
            "src/generated/{name} is not what the .proto files say: \
             BENDTWIN_BLESS=1 cargo test -p bendtwin-proto --test generated"
        );
    }
}

/// Generated files by name.
fn generate(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut compiler = protox::Compiler::new([root]).unwrap();
    compiler.include_imports(true).include_source_info(true).open_files(FILES).unwrap();
    let descriptors = compiler.file_descriptor_set();
    let contract = Contract::read(descriptors.clone(), &compiler.descriptor_pool());
    let by_hand = std::fs::read(root.join("http/by_hand.json")).unwrap();
    let by_hand = serde_json::from_slice(&by_hand).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let write =
        |name: &str, content: &[u8]| std::fs::write(folder.path().join(name), content).unwrap();
    // With the options, which the types of prost do not keep.
    write("descriptors.bin", &compiler.encode_file_descriptor_set());
    write("json.rs", json::implementations(&contract).as_bytes());
    write("routes.rs", routes::table(&contract).as_bytes());
    write("routes_by_hand.rs", routes::by_hand(&contract, &by_hand).as_bytes());
    write("openapi.json", openapi::document(&contract, &by_hand).as_bytes());
    let code = tonic_prost_build::configure().bytes(".").out_dir(folder.path());
    code.compile_fds(descriptors).unwrap();
    read(folder.path())
}

/// Files of a folder by name.
fn read(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap());
    files
        .map(|file| {
            let name = file.file_name().into_string().unwrap();
            (name, std::fs::read(file.path()).unwrap())
        })
        .collect()
}
