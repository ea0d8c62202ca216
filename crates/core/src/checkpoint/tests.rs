use super::*;

const KIND: Kind = Kind { name: "test", magic: *b"TEST", version: 7 };

#[test]
fn a_payload_comes_back() {
    let bytes = KIND.seal(&[3; 32], b"payload");
    assert_eq!(KIND.open(&bytes, &[3; 32]), Ok(b"payload".as_slice()));
    assert_eq!(KIND.open(&KIND.seal(&[3; 32], b""), &[3; 32]), Ok(b"".as_slice()));
}

#[test]
fn what_is_not_its_own_is_refused() {
    let bytes = KIND.seal(&[3; 32], b"");
    assert_eq!(KIND.open(&bytes, &[4; 32]), Err(Refusal::OtherWork));
    let other = Kind { magic: *b"ELSE", ..KIND };
    assert_eq!(other.open(&bytes, &[3; 32]), Err(Refusal::Kind("test")));
    let newer = Kind { version: 8, ..KIND };
    assert_eq!(newer.open(&bytes, &[3; 32]), Err(Refusal::Version { found: 7, read: 8 }));
    for end in 0..bytes.len() {
        let refused = KIND.open(&bytes[..end], &[3; 32]).unwrap_err();
        let expected = if end < 4 { Refusal::Kind("test") } else { Refusal::CutShort };
        assert_eq!(refused, expected, "{end}");
    }
}

#[test]
fn another_build_resumes_from_it() {
    let mut bytes = KIND.seal(&[3; 32], b"");
    let build = bytes.len() - BUILD.len()..;
    bytes[build].copy_from_slice(BUILD.replace("bendtwin", "otherone").as_bytes());
    bytes.extend(b"payload");
    assert_eq!(KIND.open(&bytes, &[3; 32]), Ok(b"payload".as_slice()));
}
