use super::*;

#[test]
fn cells_are_found_again_and_know_their_neighbours() {
    let volume = Volume::around(&[[0.0; 3], [0.1, 0.05, 0.0]], 0.01).unwrap();
    assert!(volume.count() > 1000);
    for cell in [0, 17, volume.count() / 2, volume.count() - 1] {
        assert_eq!(volume.cell(volume.centre(cell)), Some(cell));
        for (other, way_m) in volume.around_cell(cell) {
            assert!(volume.around_cell(other).contains(&(cell, way_m)));
        }
    }
    let middle = volume.cell([0.05, 0.02, 0.0]).unwrap();
    assert_eq!(volume.around_cell(middle).len(), 26);
    assert!(volume.faces(middle).iter().all(Option::is_some));
    assert!(volume.faces(0).iter().any(Option::is_none));
    assert_eq!(volume.cell([1.0, 0.0, 0.0]), None);
}

#[test]
fn cells_grow_where_there_would_be_too_many() {
    for far in [[1e6, 0.0, 0.0], [1e9, 1e9, 0.0], [3e3, 3e3, 3e3]] {
        let volume = Volume::around(&[[0.0; 3], far], 0.006).unwrap();
        assert!(volume.count() as f64 <= 3.0 * MAX_CELLS, "{} cells", volume.count());
        assert!(volume.cell([0.0; 3]).is_some());
    }
    assert!(Volume::around(&[], 0.006).is_none());
    assert!(Volume::around(&[[f32::NAN; 3]], 0.006).is_none());
}
