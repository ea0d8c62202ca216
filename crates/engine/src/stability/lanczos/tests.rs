use super::*;

/// With 2 on the diagonal and 1 beside it the largest eigenvalue is `2 + 2 cos(pi / (n + 1))`.
#[test]
fn a_tridiagonal_matrix_is_solved() {
    for n in [1_usize, 2, 3, 16] {
        let (diagonal, beside) = (vec![2.0; n], vec![1.0; n - 1]);
        let angle = std::f64::consts::PI / (n as f64 + 1.0);
        let exact = 2.0 + 2.0 * angle.cos();
        let largest = largest_eigenvalue(&diagonal, &beside);
        assert!((largest - exact).abs() < 1e-9, "{n}: {largest} {exact}");
        let x = eigenvector(&diagonal, &beside, largest);
        for i in 0..n {
            let wanted = (angle * (i as f64 + 1.0)).sin() * x[0] / angle.sin();
            assert!((x[i] - wanted).abs() < 1e-6, "{n}: {x:?}");
        }
    }
}

#[test]
fn a_start_of_nothing_stays_nothing() {
    let system =
        Linear { roots: vec![1.0; 2], bars: Vec::new(), hinges: Vec::new(), twists: Vec::new() };
    let operator = Operator::new(&system, 1.0);
    assert_eq!(operator.stiffest(&[[0.0; 3]; 2], 8), [[0.0; 3]; 2]);
    assert_eq!(operator.stiffest(&[[1.0, 0.0, 0.0]; 2], 8).len(), 2);
}
