use super::*;

fn base() -> Params {
    Params {
        spring_stiffness: vec![100.0, 2000.0],
        spring_dashpot: vec![1.0, 0.0],
        rest_lengths_m: vec![0.01, 0.02],
        bend_stiffness: vec![0.5],
        bend_damping: vec![1e-3],
        rest_angles_rad: vec![std::f32::consts::PI],
        drag: 1.5,
        ..Params::default()
    }
}

/// Every parameter, positive ones by their logarithm.
fn parameterization() -> Parameterization {
    Parameter::ALL.into_iter().fold(Parameterization::new(base()), |parameterization, parameter| {
        let scale = match parameter {
            Parameter::SpringStiffness | Parameter::RestLength | Parameter::Drag => {
                Scale::Logarithmic
            }
            Parameter::SpringDashpot => Scale::Logarithmic,
            _ => Scale::Linear,
        };
        parameterization.with(parameter, scale, 1.0, |x| [x - 1.0, x + 1.0])
    })
}

#[test]
fn parameters_survive_the_way_to_coordinates_and_back() {
    let theta = parameterization().start();
    assert_eq!(theta.len(), parameterization().len());
    let back = parameterization().params(&theta);
    let pairs = [
        (&back.spring_stiffness, &base().spring_stiffness),
        (&back.rest_angles_rad, &base().rest_angles_rad),
    ];
    for (a, b) in pairs {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b), "{a:?} {b:?}");
    }
    assert!(back.spring_dashpot[1] <= 1e-8, "zero stays next to zero");
    assert!((back.drag - 1.5).abs() < 1e-5);
    assert_eq!(back.contact, base().contact);
}

#[test]
fn the_chain_rule_matches_finite_differences() {
    let parameterization = parameterization();
    let theta: Vec<f64> = parameterization.start().iter().map(|x| x - 0.01).collect();
    // A loss whose gradient by parameter is known: the sum of all squares.
    let loss = |theta: &[f64]| {
        let p = parameterization.params(theta);
        let values = Parameter::ALL.iter().flat_map(|parameter| parameter.values(&p).to_vec());
        values.map(|x| f64::from(x).powi(2)).sum::<f64>()
    };
    let p = parameterization.params(&theta);
    let mut norm = p.clone();
    for parameter in Parameter::ALL {
        parameter.values_mut(&mut norm).iter_mut().for_each(|x| *x *= 2.0);
    }
    let gradient = parameterization.gradient(&p, &norm);
    for i in 0..theta.len() {
        let step = |h: f64| {
            let mut moved = theta.clone();
            moved[i] += h;
            loss(&moved)
        };
        let (h, scale) = (1e-3, loss(&theta));
        let numeric = (step(h) - step(-h)) / (2.0 * h);
        assert!(
            (numeric - gradient[i]).abs() <= 1e-2 * gradient[i].abs() + 1e-3 * scale,
            "coordinate {i}: {numeric} against {}",
            gradient[i]
        );
    }
}

#[test]
fn sections_follow_each_other_and_bounds_hold_the_start() {
    let parameterization =
        parameterization().with(Parameter::Drag, Scale::Linear, 5.0, |_| [7.0, 8.0]);
    let mut end = 0;
    for section in parameterization.sections() {
        assert_eq!(section.range.start, end);
        end = section.range.end;
    }
    assert_eq!(
        (end, parameterization.rates().count()),
        (parameterization.len(), parameterization.len()),
        "a second time is ignored"
    );
    // However wrong the wish.
    let odd =
        Parameterization::new(base()).with(Parameter::Drag, Scale::Linear, 1.0, |_| [7.0, -3.0]);
    assert_eq!(odd.bounds(), [[1.5, 1.5]]);
    let odd =
        Parameterization::new(base()).with(Parameter::Drag, Scale::Linear, 1.0, |_| [f64::NAN; 2]);
    assert_eq!(odd.bounds(), [[1.5, 1.5]]);
}

#[test]
fn positions_of_other_charts_are_refused() {
    let parameterization = parameterization();
    assert_eq!(
        parameterization.check_position(&parameterization.at_rest(parameterization.start())),
        Ok(())
    );
    let mut wrong = parameterization.start();
    wrong.pop();
    assert!(parameterization.check_position(&parameterization.at_rest(wrong)).is_err());
    let mut wrong = parameterization.at_rest(parameterization.start());
    wrong.adam.second[3] = f64::NAN;
    assert!(parameterization.check_position(&wrong).is_err());
}
