//! Boards that are not as they were described, and recordings that do not show them.

use bendtwin_core::Severity;

use super::*;

fn two() -> Vec<Camera> {
    cameras().into_iter().take(2).collect()
}

fn filmed(printed: &BoardSettings) -> Recording {
    uncalibrated(film_sheet(SheetFilm::still(sheet(printed), two(), 2)))
}

#[track_caller]
fn only(found: &BoardCalibration, code: &str) -> Finding {
    let codes: Vec<&str> = found.findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, [code], "{:?}", found.findings);
    found.findings[0].clone()
}

#[test]
fn another_board_is_named() {
    let stated = charuco();
    let other = |change: fn(&mut BoardSettings)| {
        let mut other = charuco();
        change(&mut other);
        other
    };
    for (printed, spec) in [
        (other(|b| b.dictionary = "DICT_4X4_50".to_owned()), "DICT_4X4_50"),
        (other(|b| (b.columns, b.rows) = (5, 7)), "charuco:5x7:"),
        (other(|b| b.columns = 9), "charuco:9x"),
    ] {
        let found = run(&filmed(&printed), &stated);
        assert!(found.calibration.is_none());
        let finding = only(&found, "BOARD_NOT_SEEN");
        println!("{}", finding.sentence());
        assert_eq!((finding.severity, &finding.cameras[..]), (Severity::Error, &[0, 1][..]));
        assert!(finding.advice.contains(spec), "{spec}: {}", finding.sentence());
        assert!(finding.advice.contains("docs/use/cameras.md#calibration"));
    }
}

#[test]
fn a_board_in_the_layout_of_an_older_opencv_is_read_if_that_is_stated() {
    let even = BoardSettings { columns: 8, rows: 6, ..charuco() };
    let legacy = BoardSettings { legacy: true, ..even.clone() };
    let truth = two();
    let recording = filmed(&legacy);
    let found = run(&recording, &legacy);
    let [metres, degrees] = errors(&found, &truth);
    assert!(metres < 1e-3 && degrees < 0.1, "{metres} {degrees}");
    let finding = only(&run(&recording, &even), "BOARD_NOT_SEEN");
    assert!(finding.advice.contains(":legacy"), "{}", finding.sentence());
}

#[test]
fn mirrored_images_are_named() {
    let mut mirrored = sheet(&charuco());
    let columns = mirrored.columns;
    mirrored.black.chunks_exact_mut(columns).for_each(<[bool]>::reverse);
    let film = film_sheet(SheetFilm::still(mirrored, two(), 1));
    let finding = only(&run(&uncalibrated(film), &charuco()), "BOARD_NOT_SEEN");
    assert!(finding.message.contains("mirrored"), "{}", finding.sentence());
}

#[test]
fn an_empty_table_shows_no_board() {
    let mut film = SheetFilm::still(sheet(&charuco()), two(), 2);
    film.places = vec![None; 2];
    let finding = only(&run(&uncalibrated(film_sheet(film)), &charuco()), "BOARD_NOT_SEEN");
    assert!(finding.message.contains("camera 0 (cam0) in 0"), "{}", finding.sentence());
}

#[test]
fn a_board_that_was_printed_larger_is_noticed_by_depth() {
    let printed = BoardSettings { square_m: 0.0309, marker_m: 0.02266, ..charuco() };
    let found = run(&filmed(&printed), &charuco());
    let finding = only(&found, "BOARD_SIZE");
    assert_eq!(finding.severity, Severity::Warning);
    assert!((finding.numbers["ratio"] - 1.03).abs() < 0.004, "{}", finding.sentence());
    assert!(found.calibration.is_some());
}

#[test]
fn a_wrong_lens_bends_the_board() {
    let mut recording = filmed(&charuco());
    recording.cameras[1].distortion =
        Distortion::BrownConrady([3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let found = run(&recording, &charuco());
    let finding = found.findings.iter().find(|f| f.code == "BOARD_MISFIT").unwrap();
    assert_eq!(finding.cameras, [1], "{}", finding.sentence());
}

#[test]
fn a_board_that_leans_against_the_table_is_noticed() {
    let leaning = Pose {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.940, -0.342], [0.0, 0.342, 0.940]],
        translation: [0.0, 0.0, 0.05],
    };
    let mut film = SheetFilm::still(sheet(&charuco()), two(), 2);
    film.places = vec![Some(leaning); 2];
    let finding = only(&run(&uncalibrated(film_sheet(film)), &charuco()), "BOARD_TILTED");
    assert!((finding.numbers["angle_deg"] - 20.0).abs() < 1.0, "{}", finding.sentence());
}
