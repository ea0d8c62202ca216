use super::*;

fn texts(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn cameras_are_found_by_number_name_or_order() {
    for (names, cameras, expected, by_order) in [
        (&["0", "1"], &["left", "right"], [Some(0), Some(1)], false),
        (&["right", "left"], &["left", "right"], [Some(1), Some(0)], false),
        (&["camera_right", "camera_left"], &["left", "right"], [Some(1), Some(0)], false),
        (&["cam00", "cam01"], &["a", "b"], [Some(0), Some(1)], false),
        // Counted from 1: no rule but the order finds both.
        (&["cam1", "cam2"], &["a", "b"], [Some(0), Some(1)], true),
        (&["cam10", "cam9"], &["a", "b"], [Some(1), Some(0)], true),
        (
            &["123622270882", "023622270881"],
            &["023622270881", "123622270882"],
            [Some(1), Some(0)],
            false,
        ),
    ] {
        let found = assign(&texts(names), &texts(cameras));
        assert_eq!((found.0.as_slice(), found.1), (expected.as_slice(), by_order), "{names:?}");
    }
    let found = assign(&texts(&["0", "1", "2"]), &texts(&["0", "1"]));
    assert_eq!(found.0, [Some(0), Some(1)]);
    assert_eq!(assign(&texts(&["x"]), &texts(&["a", "b"])).0, [None, None]);
}

#[test]
fn a_case_has_colour_or_folders_of_cameras() {
    let folder = |folders: &[&str], files: &[&str]| Contents {
        folders: texts(folders),
        files: texts(files),
    };
    for folders in
        [["color", "x"], ["RGB", "x"], ["cam0", "cam1"], ["023622270881", "x"], ["left", "x"]]
    {
        assert!(is_case(&folder(&folders, &[MARKER])), "{folders:?}");
        assert!(!is_case(&folder(&folders, &[])), "{folders:?}");
    }
    assert!(!is_case(&folder(&["shape", "12"], &[MARKER])));
}

#[test]
fn one_of_several_depths_is_taken_and_the_others_are_named() {
    let folders = texts(&["depth", "depth_ffs", "color"]);
    for (chosen, taken, other) in
        [(None, "depth", "depth_ffs"), (Some("depth_ffs"), "depth_ffs", "depth")]
    {
        let mut sources = Sources::default();
        assert_eq!(depth(&folders, "", chosen, &mut sources).unwrap(), taken);
        assert_eq!(sources.left_out[0].from, other);
    }
    let mut sources = Sources::default();
    let text = depth(&folders, "", Some("deep"), &mut sources).unwrap_err().to_string();
    assert!(text.contains("`depth_folder` is `deep`") && text.contains("depth_ffs"), "{text}");
    assert_eq!(depth(&texts(&["depth_ffs"]), "", None, &mut sources).unwrap(), "depth_ffs");
    assert_eq!(depth(&[], "", None, &mut sources).unwrap(), "depth");
}
