//! Compiles the .proto files with protox, so no protoc is needed.

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
    let descriptors = protox::compile(FILES, ["."])?;
    let out = std::path::PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("descriptors.bin"), descriptors.encode_to_vec())?;
    tonic_prost_build::configure().bytes(".").compile_fds(descriptors)?;
    Ok(())
}
