use super::*;

#[test]
fn names_select_formats_in_any_case() {
    for format in Format::ALL {
        for extension in format.extensions() {
            for name in [format!("a.b.{extension}"), format!("A.{}", extension.to_uppercase())] {
                assert_eq!(Format::of_path(Path::new(&name)).unwrap(), format, "{name}");
            }
        }
        assert_eq!(format.name().parse(), Ok(format));
    }
    assert_eq!(Format::of_path(Path::new("frames/")).unwrap(), Format::PlySequence);
}

#[test]
fn a_name_of_no_format_is_refused_with_all_of_them() {
    for name in ["rope", "rope.fbx", "rope.usd", ".glb", ""] {
        let message = Format::of_path(Path::new(name)).unwrap_err().to_string();
        for format in Format::ALL {
            assert!(message.contains(format.extensions()[0]), "{name}: {message}");
        }
    }
    assert!("gltf".parse::<Format>().unwrap_err().contains("glb"));
}
