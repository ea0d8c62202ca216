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
fn chart() -> Chart {
    Parameter::ALL.into_iter().fold(Chart::new(base()), |chart, parameter| {
        let scale = match parameter {
            Parameter::SpringStiffness | Parameter::RestLength | Parameter::Drag => {
                Scale::Logarithmic
            }
            Parameter::SpringDashpot => Scale::Logarithmic,
            _ => Scale::Linear,
        };
        chart.with(parameter, scale, 1.0, |x| [x - 1.0, x + 1.0])
    })
}

#[test]
fn parameters_survive_the_way_to_coordinates_and_back() {
    let theta = chart().start();
    assert_eq!(theta.len(), chart().len());
    let back = chart().params(&theta);
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
    let chart = chart();
    let theta: Vec<f64> = chart.start().iter().map(|x| x - 0.01).collect();
    // A loss whose gradient by parameter is known: the sum of all squares.
    let loss = |theta: &[f64]| {
        let p = chart.params(theta);
        let values = Parameter::ALL.iter().flat_map(|parameter| parameter.values(&p).to_vec());
        values.map(|x| f64::from(x).powi(2)).sum::<f64>()
    };
    let p = chart.params(&theta);
    let mut slope = p.clone();
    for parameter in Parameter::ALL {
        parameter.values_mut(&mut slope).iter_mut().for_each(|x| *x *= 2.0);
    }
    let gradient = chart.gradient(&p, &slope);
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
    let chart = chart().with(Parameter::Drag, Scale::Linear, 5.0, |_| [7.0, 8.0]);
    let mut end = 0;
    for section in chart.sections() {
        assert_eq!(section.range.start, end);
        end = section.range.end;
    }
    assert_eq!(
        (end, chart.rates().count()),
        (chart.len(), chart.len()),
        "a second time is ignored"
    );
    // However wrong the wish.
    let odd = Chart::new(base()).with(Parameter::Drag, Scale::Linear, 1.0, |_| [7.0, -3.0]);
    assert_eq!(odd.bounds(), [[1.5, 1.5]]);
    let odd = Chart::new(base()).with(Parameter::Drag, Scale::Linear, 1.0, |_| [f64::NAN; 2]);
    assert_eq!(odd.bounds(), [[1.5, 1.5]]);
}

#[test]
fn positions_of_other_charts_are_refused() {
    let chart = chart();
    assert_eq!(chart.check_position(&Position::at_rest(chart.start())), Ok(()));
    let mut wrong = chart.start();
    wrong.pop();
    assert!(chart.check_position(&Position::at_rest(wrong)).is_err());
    let mut wrong = Position::at_rest(chart.start());
    wrong.adam.second[3] = f64::NAN;
    assert!(chart.check_position(&wrong).is_err());
}
