use super::*;

#[test]
fn what_was_not_written_to_its_end_is_not_read() {
    let folder = std::env::temp_dir().join(format!("bendtwin-cache-{}", std::process::id()));
    let path = folder.join("kernel.cubin");
    write(&path, b"machine code").expect("the folder can be written");
    assert_eq!(read(&path).as_deref(), Some(&b"machine code"[..]));
    let bytes = fs::read(&path).expect("it was just written");
    for length in [0, 3, blake3::OUT_LEN, bytes.len() - 1] {
        fs::write(&path, &bytes[..length]).expect("the folder can be written");
        assert_eq!(read(&path), None, "{length} bytes");
    }
    fs::remove_dir_all(folder).expect("it was just made");
}
