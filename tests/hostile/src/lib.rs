//! Hostile files by seed: captures, twins, results of PhysTwin and rollout requests that are damaged
//! or mean harm.
//!
//! Every file is a small valid one with one fault: a fault of its format from the table of that
//! format ([`archives`], [`tars`], [`arrays`], [`pickles`], [`images`], [`recordings`], [`markers`],
//! [`meshes`], [`splats`], [`documents`], [`masks`], [`calibrations`], [`twin_files`],
//! [`torch_files`], [`requests`]), damage to its bytes ([`damage`]), or a number of points without a fault
//! ([`crowds`]). The same seed gives the same files, on every machine; file `n` of a seed does not
//! depend on those before it. Files are small: what they claim is large.

pub mod archives;
pub mod arrays;
pub mod calibrations;
pub mod crowds;
pub mod damage;
pub mod documents;
pub mod images;
pub mod markers;
pub mod masks;
pub mod meshes;
pub mod messages;
pub mod pickles;
pub mod recordings;
pub mod requests;
pub mod samples;
pub mod splats;
pub mod tars;
pub mod torch_files;
pub mod twin_files;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// The source of chance of one file.
pub type Rng = ChaCha8Rng;

/// A hostile file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hostile {
    /// File name, different for each file of a seed.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
    /// The fault.
    pub what: &'static str,
}

/// A kind of hostile file.
#[derive(Clone, Copy)]
pub struct Fault {
    /// The fault in a few words.
    pub what: &'static str,
    /// Makes a file with it.
    pub make: fn(&mut Rng) -> Vec<u8>,
}

/// Captures without end: archives, MCAP files, and markers of motion capture.
pub fn captures(seed: u64) -> impl Iterator<Item = Hostile> {
    let kinds: Vec<(&'static str, Fault)> = [
        named("zip", archives::FAULTS),
        named("tar", tars::FAULTS),
        named("zip", arrays::IN_CAPTURES),
        named("zip", pickles::IN_CAPTURES),
        named("zip", images::IN_CAPTURES),
        named("zip", meshes::IN_CAPTURES),
        named("zip", documents::IN_CAPTURES),
        named("zip", calibrations::IN_CAPTURES),
        named("zip", masks::IN_CAPTURES),
        named("zip", crowds::IN_CAPTURES),
        named("mcap", recordings::FAULTS),
        named("mcap", messages::FAULTS),
        named("markers", markers::FAULTS),
    ]
    .concat();
    files(seed, kinds)
}

/// Twin files without end.
pub fn twins(seed: u64) -> impl Iterator<Item = Hostile> {
    files(seed, named("safetensors", twin_files::FAULTS))
}

/// Results of PhysTwin's training, without end.
pub fn trainings(seed: u64) -> impl Iterator<Item = Hostile> {
    files(seed, named("pth", torch_files::FAULTS))
}

/// Bodies of rollout requests as JSON, without end.
pub fn rollouts(seed: u64) -> impl Iterator<Item = Hostile> {
    files(seed, named("json", requests::FAULTS))
}

fn named(extension: &'static str, faults: &[Fault]) -> Vec<(&'static str, Fault)> {
    faults.iter().map(|fault| (extension, *fault)).collect()
}

/// The kinds in an order by chance, again and again, so that a few files already have most of them.
fn files(seed: u64, kinds: Vec<(&'static str, Fault)>) -> impl Iterator<Item = Hostile> {
    let first = rng(seed, u64::MAX).random_range(0..kinds.len());
    // A step without a common divisor visits every kind once before it comes back to the first.
    let step = (kinds.len() / 2 + 1..).find(|n| gcd(*n, kinds.len()) == 1).unwrap_or(1);
    (0..u64::MAX).map(move |index| {
        let (extension, Fault { what, make }) =
            kinds[(first + index as usize % kinds.len() * step) % kinds.len()];
        let slug: String =
            what.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        Hostile {
            name: format!("{index:04}-{slug}.{extension}"),
            bytes: make(&mut rng(seed, index)),
            what,
        }
    })
}

fn rng(seed: u64, stream: u64) -> Rng {
    let mut rng = Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests;
