//! Compiles the .proto files with protox, so no protoc is needed, and writes how rollouts look in
//! JSON.

#[path = "build/json.rs"]
mod json;

use prost::Message as _;

const FILES: [&str; 9] = [
    "bendtwin/v1/tensor.proto",
    "bendtwin/v1/fault.proto",
    "bendtwin/v1/capture.proto",
    "bendtwin/v1/job.proto",
    "bendtwin/v1/fit.proto",
    "bendtwin/v1/twin.proto",
    "bendtwin/v1/worker.proto",
    "bendtwin/v1/rollout.proto",
    "bendtwin/worker/v1/worker_link.proto",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo:rerun-if-changed=bendtwin");
    println!("cargo:rerun-if-changed=build");
    let descriptors = protox::compile(FILES, ["."])?;
    let out = std::path::PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("descriptors.bin"), descriptors.encode_to_vec())?;
    let rollout = descriptors.file.iter().find(|f| f.name() == "bendtwin/v1/rollout.proto");
    std::fs::write(out.join("json.rs"), json::implementations(rollout.ok_or("no rollout.proto")?))?;
    tonic_prost_build::configure().bytes(".").compile_fds(descriptors)?;
    Ok(())
}
