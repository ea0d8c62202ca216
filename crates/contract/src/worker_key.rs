//! Keys of workers. A worker chooses a key at its start, and its id follows from the key: a caller
//! that shows the key is that worker, without any stored state, also across restarts of the server.
//! The id is public, the key stands in the metadata of every call to the server.

use bendtwin_core::ids::WorkerId;
use uuid::Uuid;

/// Metadata entry with the key.
pub const METADATA: &str = "worker-key";

/// Purpose of the hash, so that no other use of BLAKE3 gives the same.
const PURPOSE: &str = "bendtwin.worker.v1 2026 id of a worker from its key";
/// Leading bytes of an id that are its time of creation.
const TIME_BYTES: usize = 6;
/// Bits of the bytes after them that are not random in a UUID: its version and its variant.
const FIXED: u128 = 0x0000_0000_0000_f000_c000_0000_0000_0000;
/// All bits of a UUID but those of the time.
const AFTER_TIME: u128 = u128::MAX >> (8 * TIME_BYTES);

/// A fresh key, and the id of its worker.
pub fn generate() -> (String, WorkerId) {
    // 244 random bits from the system.
    let key = format!("{}{}", Uuid::new_v4().simple(), Uuid::new_v4().simple());
    let id = id_at(Uuid::now_v7(), &key);
    (key, id)
}

/// True if the id follows from the key.
pub fn proves(key: &str, worker: WorkerId) -> bool {
    id_at(worker.uuid(), key) == worker
}

/// The id of a key at the time of another id.
fn id_at(time: Uuid, key: &str) -> WorkerId {
    let mut hasher = blake3::Hasher::new_derive_key(PURPOSE);
    hasher.update(time.as_bytes().get(..TIME_BYTES).unwrap_or_default());
    hasher.update(key.as_bytes());
    let mut hash = [0; 16];
    hasher.finalize_xof().fill(&mut hash);
    let taken = AFTER_TIME & !FIXED;
    let bits = (time.as_u128() & !taken) | (u128::from_be_bytes(hash) & taken);
    Uuid::from_u128(bits).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_proves_its_own_id_and_no_other() {
        let (key, id) = generate();
        let (other_key, other_id) = generate();
        assert_ne!((&key, id), (&other_key, other_id));
        assert!(proves(&key, id) && proves(&other_key, other_id));
        assert!(!proves(&key, other_id) && !proves(&other_key, id) && !proves("", id));
        assert_eq!(id.uuid().get_version_num(), 7, "it sorts by creation");
        assert!(id.uuid().get_variant() == uuid::Variant::RFC4122);
        assert!(!proves(&key, WorkerId::generate()));
    }
}
