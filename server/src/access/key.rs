//! The text of a key: `bt_{id}_{secret}{checksum}`, in hexadecimal digits. The checksum tells a
//! mistyped key from one that is not known.

use bendtwin_core::ids::KeyId;
use blake3::Hash;
use uuid::Uuid;

const PREFIX: &str = "bt_";
/// Digits of the secret: 256 bits.
const SECRET: usize = 64;
/// Digits of the checksum.
const CHECKSUM: usize = 8;

/// A key that was just made. Its text is shown once.
pub(crate) struct Made {
    pub(crate) id: KeyId,
    pub(crate) text: String,
    pub(crate) hash: Hash,
}

/// A key that a client shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) id: KeyId,
    pub(crate) hash: Hash,
}

/// Text that is no key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unreadable {
    /// Not in the form of a key.
    Other,
    /// A key with missing or wrong letters.
    Mistyped,
}

/// Makes a key with 256 random bits of the system.
pub(crate) fn make() -> Result<Made, getrandom::Error> {
    let mut secret = [0; SECRET / 2];
    getrandom::fill(&mut secret)?;
    let id = KeyId::generate();
    let secret: String = secret.iter().map(|byte| format!("{byte:02x}")).collect();
    let body = format!("{PREFIX}{}_{secret}", id.uuid().simple());
    let text = format!("{body}{}", checksum(&body));
    Ok(Made { id, hash: blake3::hash(text.as_bytes()), text })
}

/// Reads the text of a key.
pub(crate) fn read(text: &str) -> Result<Shown, Unreadable> {
    let rest = text.strip_prefix(PREFIX).ok_or(Unreadable::Other)?;
    let is_digit = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
    let (id, secret) = rest.split_once('_').ok_or(Unreadable::Mistyped)?;
    if secret.len() != SECRET + CHECKSUM || !secret.bytes().all(is_digit) {
        return Err(Unreadable::Mistyped);
    }
    let (body, sum) = text.split_at(text.len() - CHECKSUM);
    if sum != checksum(body) {
        return Err(Unreadable::Mistyped);
    }
    let id = Uuid::try_parse(id).map_err(|_| Unreadable::Mistyped)?;
    Ok(Shown { id: id.into(), hash: blake3::hash(text.as_bytes()) })
}

fn checksum(body: &str) -> String {
    blake3::hash(body.as_bytes()).to_hex()[..CHECKSUM].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_read_as_it_was_made() {
        let made = make().unwrap();
        assert_eq!(read(&made.text), Ok(Shown { id: made.id, hash: made.hash }));
        assert_ne!(made.text, make().unwrap().text);
    }

    #[test]
    fn every_letter_counts() {
        let text = make().unwrap().text;
        for (place, letter) in text.char_indices().skip(PREFIX.len()) {
            let other = if letter == '0' { '1' } else { '0' };
            let mut mistyped = text.clone();
            mistyped.replace_range(place..=place, &other.to_string());
            assert_eq!(read(&mistyped), Err(Unreadable::Mistyped), "{place}");
        }
        assert_eq!(read(&text[..text.len() - 1]), Err(Unreadable::Mistyped));
        assert_eq!(read("bt_"), Err(Unreadable::Mistyped));
        for other in ["", "b", "another token", "bt-1"] {
            assert_eq!(read(other), Err(Unreadable::Other), "{other}");
        }
    }
}
