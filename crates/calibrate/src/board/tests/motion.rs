//! Boards that are moved, hidden or seen by one camera at a time.

use super::*;

fn shifted(x: f64, y: f64, degrees: f64) -> Pose {
    let (s, c) = degrees.to_radians().sin_cos();
    Pose { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], translation: [x, y, 0.0] }
}

#[test]
fn cameras_that_see_the_board_at_different_places_are_joined() {
    let truth = cameras();
    let mut film = SheetFilm::still(sheet(&charuco()), truth.clone(), 6);
    for (frame, place) in film.places.iter_mut().enumerate() {
        *place = Some(if frame < 3 { Pose::IDENTITY } else { shifted(0.05, -0.04, 35.0) });
    }
    let found = run(&uncalibrated(film_sheet(film)), &charuco());
    assert!(found.findings.is_empty(), "{:?}", found.findings);
    let [metres, degrees] = errors(&found, &truth);
    assert!(metres < 1e-3 && degrees < 0.1, "{metres} {degrees}");
}

#[test]
fn a_board_that_never_rests_is_used_frame_by_frame() {
    let truth = cameras();
    let mut film = SheetFilm::still(sheet(&charuco()), truth.clone(), 5);
    for (frame, place) in film.places.iter_mut().enumerate() {
        *place = Some(shifted(0.01 * frame as f64, 0.0, 4.0 * frame as f64));
    }
    // The world is the board's at one of these times: poses are compared with each other.
    let found = run(&uncalibrated(film_sheet(film)), &charuco());
    let codes: Vec<&str> = found.findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["BOARD_MOVES"]);
    let poses: Vec<_> =
        found.calibration.unwrap().cameras.iter().map(|c| c.pose.unwrap()).collect();
    for (a, b) in [(0, 1), (1, 2)] {
        let apart = |a: &Pose, b: &Pose| place::motion(a).inverse() * place::motion(b);
        let error =
            apart(&poses[a], &poses[b]).inverse() * apart(truth[a].pose(0), truth[b].pose(0));
        assert!(error.translation.vector.norm() < 1.5e-3, "{error}");
        assert!(error.rotation.angle().to_degrees() < 0.15, "{error}");
    }
}

#[test]
fn a_board_half_hidden_is_enough() {
    let truth = cameras();
    let mut film = SheetFilm::still(sheet(&charuco()), truth.clone(), 1);
    // A third of the print is covered by white paper.
    let columns = film.sheet.columns;
    for row in film.sheet.black.chunks_exact_mut(columns) {
        row[..columns / 3].fill(false);
    }
    let found = run(&uncalibrated(film_sheet(film)), &charuco());
    let [metres, degrees] = errors(&found, &truth);
    assert!(metres < 1.5e-3 && degrees < 0.2, "{metres} {degrees}");
    assert!(
        found.cameras.iter().all(|view| (12..24).contains(&view.corners)),
        "{:?}",
        found.cameras
    );
}

#[test]
fn work_is_cancelled() {
    let film = film_sheet(SheetFilm::still(sheet(&charuco()), cameras(), 1));
    let cancel = CancelToken::default();
    cancel.cancel();
    let ended = calibrate(&film, &charuco(), &mut |_| {}, &cancel);
    assert!(matches!(ended, Err(Error::Cancelled)));
}
