use super::*;

fn params() -> Params {
    Params {
        spring_stiffness: vec![100.0, 200.0],
        spring_dashpot: vec![1.0, 2.0],
        bend_stiffness: vec![3.0],
        bend_damping: vec![4.0],
        twist_stiffness: vec![5.0],
        twist_damping: vec![6.0],
        drag: 7.0,
        ..Params::default()
    }
}

#[test]
fn each_factor_scales_its_own_parameters() {
    let with = |factors: Factors| {
        let mut params = params();
        factors.apply(&mut params);
        params
    };
    assert_eq!(with(Factors::ONE), params());
    let stiff = with(Factors { stiffness: 2.0, ..Factors::ONE });
    assert_eq!(stiff, Params { spring_stiffness: vec![200.0, 400.0], ..params() });
    let damped = with(Factors { damping: 2.0, ..Factors::ONE });
    assert_eq!((damped.spring_dashpot[1], damped.bend_damping[0]), (4.0, 8.0));
    assert_eq!((damped.twist_damping[0], damped.drag), (12.0, 14.0));
    let bent = with(Factors { bending: 2.0, ..Factors::ONE });
    let expected = Params { bend_stiffness: vec![6.0], twist_stiffness: vec![10.0], ..params() };
    assert_eq!(bent, expected);
    let rough = with(Factors { friction: 100.0, ..Factors::ONE });
    assert_eq!(rough.contact.ground_friction, 2.0);
    assert!(rough.check(&bendtwin_core::Graph::default()).is_err_and(|e| !e.contains("friction")));
}

#[test]
fn a_restitution_takes_the_place_of_the_twins_own() {
    let mut bouncy = params();
    let factors = Factors { ground_restitution: Some(0.5), ..Factors::ONE };
    factors.apply(&mut bouncy);
    assert_eq!(bouncy.contact.ground_restitution, 0.5);
    assert_eq!(bouncy.contact.object_restitution, params().contact.object_restitution);
    let between = Factors { object_restitution: Some(0.25), ..Factors::ONE };
    between.apply(&mut bouncy);
    assert_eq!(bouncy.contact.object_restitution, 0.25);
    assert_ne!(factors.bits(), between.bits());
}

#[test]
fn a_mass_divides_all_that_exerts_forces() {
    let mut heavy = params();
    Factors { mass: 2.0, ..Factors::ONE }.apply(&mut heavy);
    let expected = Params {
        spring_stiffness: vec![50.0, 100.0],
        spring_dashpot: vec![0.5, 1.0],
        bend_stiffness: vec![1.5],
        bend_damping: vec![2.0],
        twist_stiffness: vec![2.5],
        twist_damping: vec![3.0],
        drag: 3.5,
        ..params()
    };
    assert_eq!(heavy, expected);
}
