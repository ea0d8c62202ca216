//! Inputs to start from: for each target valid files, and each fault that hostile files of its
//! format have.

use bendtwin_contract_kit::{registration, rollout};
use bendtwin_hostile::{
    Fault, Rng, arrays, calibrations, damage, documents, images, markers, masks as mask_files,
    meshes, messages, pickles, recordings, requests, samples, splats, torch_files, twin_files,
};
use bendtwin_proto::{json::Read, v1::RollOutRequest};
use prost::Message as _;
use rand::SeedableRng as _;

use crate::{requests::SHAPE, twins::CHECKPOINT};

/// Longest seed: the fuzzer learns little from longer ones.
const MOST_BYTES: usize = 64 << 10;
/// Files of each fault.
const EACH: usize = 3;

fn rng() -> Rng {
    Rng::seed_from_u64(0)
}

/// The valid files, and files with each fault.
fn with_faults(valid: Vec<Vec<u8>>, faults: &[Fault]) -> Vec<Vec<u8>> {
    let mut rng = rng();
    let mut all = valid;
    all.extend(faults.iter().flat_map(|fault| [*fault; EACH]).map(|fault| (fault.make)(&mut rng)));
    all.retain(|seed| seed.len() <= MOST_BYTES);
    all
}

/// The valid files, and these with other numbers and with damage.
fn with_damage(valid: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    let mut rng = rng();
    let mut all = valid.clone();
    for file in &valid {
        for _ in 0..EACH {
            all.push(documents::numbers(&mut rng, file));
            all.push(damage::any(&mut rng, file));
        }
    }
    all
}

/// A file of a sample.
fn file(mut files: samples::FileMap, name: &str) -> Vec<u8> {
    files.remove(name).unwrap_or_default()
}

pub(crate) fn zip() -> Vec<Vec<u8>> {
    let valid =
        [samples::observation(), samples::case(), samples::raw_bundle(), samples::raw_case()];
    let valid = valid.iter().map(bendtwin_hostile::archives::pack).collect();
    with_faults(valid, bendtwin_hostile::archives::FAULTS)
}

pub(crate) fn tar() -> Vec<Vec<u8>> {
    use bendtwin_hostile::tars;
    let valid = [samples::observation(), samples::case(), samples::raw_case()];
    let plain = valid.iter().map(tars::pack);
    let packed = valid.iter().map(|files| tars::gzip(&tars::pack(files)));
    with_faults(plain.chain(packed).collect(), tars::FAULTS)
}

pub(crate) fn case() -> Vec<Vec<u8>> {
    with_faults(vec![pickles::valid()], pickles::FAULTS)
}

pub(crate) fn pickle() -> Vec<Vec<u8>> {
    let calibration = file(samples::raw_case(), "calibrate.pkl");
    with_faults(vec![calibration, pickles::valid()], pickles::FAULTS)
}

pub(crate) fn pth() -> Vec<Vec<u8>> {
    let program = torch_files::valid_program();
    with_faults(vec![torch_files::valid(), program], torch_files::FAULTS)
}

pub(crate) fn npy() -> Vec<Vec<u8>> {
    with_faults(vec![arrays::valid(), file(samples::raw_case(), "depth/0/1.npy")], arrays::FAULTS)
}

pub(crate) fn masks() -> Vec<Vec<u8>> {
    let images = [samples::png(), samples::jpeg()];
    with_faults([mask_files::valid(), images.to_vec()].concat(), mask_files::FAULTS)
}

pub(crate) fn manifest() -> Vec<Vec<u8>> {
    let documents = [samples::observation(), samples::raw_bundle()];
    with_damage(documents.map(|files| file(files, "capture.json")).to_vec())
}

pub(crate) fn transforms() -> Vec<Vec<u8>> {
    with_damage(vec![documents::transforms()])
}

pub(crate) fn grippers() -> Vec<Vec<u8>> {
    with_damage(documents::grippers())
}

pub(crate) fn metadata() -> Vec<Vec<u8>> {
    with_damage(documents::metadata())
}

pub(crate) fn png() -> Vec<Vec<u8>> {
    with_faults(vec![samples::png(), samples::depth_png()], images::PNG)
}

pub(crate) fn jpeg() -> Vec<Vec<u8>> {
    with_faults(vec![samples::jpeg()], images::JPEG)
}

pub(crate) fn mcap() -> Vec<Vec<u8>> {
    let [lz4, zstd] = samples::mcap();
    let plain = recordings::file(&recordings::records(&lz4));
    let faults = [recordings::FAULTS, messages::FAULTS].concat();
    with_faults(vec![lz4, zstd, plain], &faults)
}

pub(crate) fn ros_image() -> Vec<Vec<u8>> {
    with_damage(messages::valid())
}

pub(crate) fn lz4() -> Vec<Vec<u8>> {
    packed("lz4")
}

pub(crate) fn zstd() -> Vec<Vec<u8>> {
    packed("zstd")
}

fn packed(compression: &str) -> Vec<Vec<u8>> {
    let [lz4, _] = samples::mcap();
    let records = recordings::plain(&recordings::records(&lz4));
    let chunks = [records.as_slice(), &records[..300], &[0; 5000], b""].map(|content| {
        let size = (content.len() as u32).to_le_bytes();
        [size.as_slice(), &recordings::pack(compression, content)].concat()
    });
    let mut rng = rng();
    let damaged = chunks.iter().map(|chunk| damage::any(&mut rng, chunk)).collect();
    [chunks.to_vec(), damaged].concat()
}

pub(crate) fn markers() -> Vec<Vec<u8>> {
    with_faults(markers::all(), markers::FAULTS)
}

pub(crate) fn glb() -> Vec<Vec<u8>> {
    with_faults(vec![meshes::glb()], meshes::GLB)
}

pub(crate) fn obj() -> Vec<Vec<u8>> {
    with_faults(vec![meshes::OBJ_TEXT.to_vec()], meshes::OBJ)
}

pub(crate) fn ply() -> Vec<Vec<u8>> {
    with_faults(vec![meshes::PLY_TEXT.to_vec(), meshes::binary_ply()], meshes::PLY)
}

pub(crate) fn calibration() -> Vec<Vec<u8>> {
    let texts = [calibrations::JSON, calibrations::KALIBR, calibrations::OPENCV, calibrations::XML];
    with_faults(texts.map(|text| text.as_bytes().to_vec()).to_vec(), calibrations::FAULTS)
}

pub(crate) fn colmap() -> Vec<Vec<u8>> {
    let texts = [
        "1 PINHOLE 640 480 600 600 320 240\n",
        "1 1 0 0 0 0.1 0.2 0.3 1 0/0.png\n1 2 1 3 4 -1\n",
        "1 0 0 1 1 2 3 0.5 1 0\n",
    ];
    let valid = calibrations::parts().into_iter().chain(texts.map(|t| t.as_bytes().to_vec()));
    with_faults(valid.collect(), calibrations::MODELS)
}

pub(crate) fn splats() -> Vec<Vec<u8>> {
    let spz = |version| splats::spz(version, 3, &splats::body(version));
    with_faults(vec![splats::ply(), spz(2), spz(3), splats::spz_4(3, 1, 12)], splats::FAULTS)
}

pub(crate) fn twin() -> Vec<Vec<u8>> {
    let valid = [samples::twin(), samples::cable()].iter().map(twin_files::encoded).collect();
    with_faults(valid, twin_files::FAULTS)
}

pub(crate) fn checkpoint() -> Vec<Vec<u8>> {
    let (kind, owner) = CHECKPOINT;
    with_damage(vec![kind.seal(&owner, b"payload"), kind.seal(&owner, b"")])
}

pub(crate) fn rollout_json() -> Vec<Vec<u8>> {
    with_faults(vec![requests::valid()], requests::FAULTS)
}

pub(crate) fn rollout_message() -> Vec<Vec<u8>> {
    let read = serde_json::from_slice::<Read<RollOutRequest>>(&requests::valid());
    let malformed = rollout::malformed(&SHAPE).into_iter().map(|case| case.request);
    let all = read.into_iter().map(|Read(request)| request).chain([rollout::sound(&SHAPE)]);
    let mut all: Vec<Vec<u8>> =
        all.chain(malformed).map(|request| request.encode_to_vec()).collect();
    all.retain(|seed| seed.len() <= MOST_BYTES);
    all
}

pub(crate) fn registration_message() -> Vec<Vec<u8>> {
    let malformed = registration::malformed(&SHAPE).into_iter().map(|case| case.request);
    let all = malformed.chain([registration::sound()]);
    all.map(|request| request.encode_to_vec()).filter(|seed| seed.len() <= MOST_BYTES).collect()
}

pub(crate) fn settings() -> Vec<Vec<u8>> {
    let fit = serde_json::to_vec(&bendtwin_core::FitSettings::default());
    let ingest = serde_json::to_vec(&bendtwin_core::settings::ingest::IngestSettings::default());
    with_damage(fit.into_iter().chain(ingest).chain([b"{\"seed\": 1}".to_vec()]).collect())
}

#[cfg(feature = "uploads")]
pub(crate) fn tus() -> Vec<Vec<u8>> {
    let headers = [
        "upload-length: 1000\nupload-metadata: filename cm9wZS56aXA=,display_name w4Q=,confidential",
        "upload-defer-length: 1\nupload-metadata: ingest e30=, digest YWE=",
        "upload-offset: 0\ncontent-type: application/offset+octet-stream\n\
         upload-checksum: sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=\ncontent-length: 11",
        "upload-offset: 18446744073709551615\nupload-checksum: blake3 AAAA",
        "upload-length: -1\nupload-length: 2\nupload-defer-length: 0",
    ];
    headers.map(|text| text.as_bytes().to_vec()).to_vec()
}

pub(crate) fn report() -> Vec<Vec<u8>> {
    let cancel = bendtwin_core::CancelToken::default();
    let inspected =
        bendtwin_inspect::inspect(&samples::recording(), &Default::default(), &cancel, &mut |_| {});
    let reports = inspected.into_iter().map(|found| bendtwin_inspect::Report::new(found, None));
    let mut all: Vec<Vec<u8>> = reports.map(|report| report.to_json().into_bytes()).collect();
    all.push(b"{\"format\": \"bendtwin-report\", \"version\": 1}".to_vec());
    with_damage(all)
}
