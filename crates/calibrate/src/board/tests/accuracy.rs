use super::*;

#[test]
fn cameras_stand_where_they_stood() {
    for settings in [charuco(), april_grid()] {
        let truth = cameras();
        let film = film_sheet(SheetFilm::still(sheet(&settings), truth.clone(), 3));
        let found = run(&uncalibrated(film), &settings);
        let [metres, degrees] = errors(&found, &truth);
        println!(
            "{:?} {:.3} mm {degrees:.4} degrees {:?}",
            settings.pattern,
            1e3 * metres,
            found.cameras
        );
        assert!(found.findings.is_empty(), "{:?}", found.findings);
        assert!(metres < 1e-3 && degrees < 0.1);
    }
}
