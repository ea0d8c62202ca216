use super::*;

type Change = fn(&mut Gaussians, f32);

fn one() -> Gaussians {
    Gaussians {
        means_m: vec![[0.0, 0.0, 1.0]],
        scales_m: vec![[0.01; 3]],
        rotations: vec![[0.0, 0.0, 0.0, 1.0]],
        opacities: vec![0.5],
        colors: vec![[0.5; 3]],
    }
}

#[test]
fn sound_gaussians_pass() {
    assert_eq!(one().check(), Ok(()));
    assert_eq!(Gaussians::default().check(), Ok(()));
}

#[test]
fn every_parameter_is_checked() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let changes: [(&str, Change); 5] = [
            ("mean", |g, x| g.means_m[0][1] = x),
            ("scale", |g, x| g.scales_m[0][2] = x),
            ("quaternion", |g, x| g.rotations[0][3] = x),
            ("opacity", |g, x| g.opacities[0] = x),
            ("colour", |g, x| g.colors[0][0] = x),
        ];
        for (name, change) in changes {
            let mut gaussians = one();
            change(&mut gaussians, bad);
            let error = gaussians.check().expect_err(name).to_string();
            assert!(error.contains("Gaussian 0") && error.contains(name), "{bad}: {error}");
        }
    }
}

#[test]
fn scales_are_positive_and_opacities_fractions() {
    for change in [
        (|g| g.scales_m[0][0] = 0.0) as fn(&mut Gaussians),
        |g| g.scales_m[0][0] = -0.1,
        |g| g.opacities[0] = -0.1,
        |g| g.opacities[0] = 1.1,
        |g| g.rotations[0] = [0.0; 4],
    ] {
        let mut gaussians = one();
        change(&mut gaussians);
        assert!(matches!(gaussians.check(), Err(Error::Gaussian { index: 0, .. })));
    }
}

#[test]
fn arrays_have_one_length() {
    let mut gaussians = one();
    gaussians.colors.clear();
    assert!(matches!(gaussians.check(), Err(Error::Lengths { expected: 1, got: 0, .. })));
}
