use super::*;

#[test]
fn results_of_slices_side_by_side_are_in_order() {
    let cancel = CancelToken::default();
    for count in [0, 1, 3, 4, 5, 1_000] {
        let batch: Vec<usize> = (0..count).collect();
        let double = |slice: &[usize]| Ok(slice.iter().map(|x| 2 * x).collect());
        let alone = sliced(&batch, 3, &cancel, double).unwrap();
        assert_eq!(in_pairs(&batch, 3, &cancel, double).unwrap(), alone, "{count}");
    }
}

#[test]
fn an_error_of_a_slice_ends_the_batch() {
    let batch: Vec<usize> = (0..1_000).collect();
    let submit = |slice: &[usize]| match slice.contains(&700) {
        true => Err(Error::InvalidInput("700".into())),
        false => Ok(slice.to_vec()),
    };
    let failed = in_pairs(&batch, 3, &CancelToken::default(), submit);
    assert_eq!(failed, Err(Error::InvalidInput("700".into())));
}

#[test]
fn a_cancelled_batch_is_not_begun() {
    let cancel = CancelToken::default();
    cancel.cancel();
    let never = |_: &[usize]| -> Result<Vec<usize>, Error> { panic!("it is cancelled") };
    assert_eq!(in_pairs(&[1, 2, 3], 1, &cancel, never), Err(Error::Cancelled));
}
