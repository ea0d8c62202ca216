//! Twin files, and the envelope of checkpoints.

use bendtwin_core::{Twin, checkpoint::Kind};

/// Kind and owner of the checkpoints that are read.
pub(crate) const CHECKPOINT: (Kind, [u8; 32]) =
    (Kind { name: "fuzz", magic: *b"FUZZ", version: 3 }, [7; 32]);

/// A twin file.
pub fn twin(data: &[u8]) {
    let Ok(twin) = Twin::decode(data) else { return };
    twin.check().expect("what is read can be simulated");
    let written = twin.encode().expect("what was read can be written");
    let again = Twin::decode(&written).expect("what was written is read");
    assert_eq!(again.encode().expect("it can be written again"), written);
}

/// A checkpoint in its envelope.
pub fn checkpoint(data: &[u8]) {
    let (kind, owner) = CHECKPOINT;
    let Ok(payload) = kind.open(data, &owner) else { return };
    let sealed = kind.seal(&owner, payload);
    assert_eq!(kind.open(&sealed, &owner).expect("what was sealed is opened"), payload);
    // Between kind and payload stands the name of the program, which may have been another version.
    let head = kind.magic.len() + size_of_val(&kind.version) + owner.len();
    assert_eq!(sealed[..head], data[..head]);
    assert!(data.ends_with(payload));
}
