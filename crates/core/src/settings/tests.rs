use super::*;

#[test]
fn defaults_are_valid_and_survive_json() {
    for settings in [FitSettings::default(), FitSettings::phystwin()] {
        assert_eq!(settings.validate(), Ok(()));
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<FitSettings>(&json).unwrap(), settings);
    }
}

#[test]
fn all_faults_come_in_one_report() {
    let mut settings = FitSettings::default();
    settings.graph.sampling_ratio = 0.0;
    settings.refine.learning_rate = f64::NAN;
    settings.substeps = Substeps::Fixed(0);
    settings.refine.reach = Some(1_000_001);
    settings.start_from = Some("captures/x".into());
    assert_eq!(settings.validate().unwrap_err().len(), 5);
}

#[test]
fn unknown_fields_are_refused() {
    assert!(serde_json::from_str::<FitSettings>(r#"{"graph":{"radius":1}}"#).is_err());
}

/// Pointers to the values of a document that are null.
fn nulls(document: &serde_json::Value) -> Vec<String> {
    match document {
        serde_json::Value::Null => vec![String::new()],
        serde_json::Value::Object(fields) => fields
            .iter()
            .flat_map(|(name, value)| {
                nulls(value).into_iter().map(move |rest| format!("/{name}{rest}"))
            })
            .collect(),
        _ => Vec::new(),
    }
}

#[test]
fn nothing_is_left_open_for_a_fit() {
    use crate::capture::Subject;
    for subject in [Subject::Cable, Subject::Body] {
        for device in [DeviceKind::Cpu, DeviceKind::Gpu] {
            let conditions = Conditions { subject, device, sequences: 77, is_weighed: false };
            let of = |effort| FitSettings { effort, ..FitSettings::default() }.filled(conditions);
            let [draft, standard, best] = [Effort::Draft, Effort::Standard, Effort::Best].map(of);
            let work = |s: &FitSettings| {
                let (search, nodes) = (&s.search, s.graph.max_nodes.unwrap() as f64);
                let population = search.population.unwrap() as f64;
                let candidates = f64::from(search.generations.unwrap()) * population;
                let passes = f64::from(s.refine.passes.unwrap());
                assert_eq!(s.graph.interior, Some(true));
                assert_eq!(s.validate(), Ok(()));
                let is_cable = subject == Subject::Cable;
                let weighed = Conditions { is_weighed: true, ..conditions };
                let open = FitSettings::default();
                assert_eq!(open.filled(weighed).search.gravity, Some(false));
                assert_eq!(s.search.gravity, Some(is_cable));
                assert_eq!(s.search.prior, Some(if is_cable { 0.0 } else { 0.4 }));
                let is_small = device == DeviceKind::Cpu && s.effort == Effort::Draft;
                let is_held = is_cable || is_small;
                assert_eq!(s.refine.prior, Some(if is_held { 0.3 } else { 0.05 }));
                assert!(s.loss.sequences.is_some());
                let batch = if device == DeviceKind::Gpu { 20 } else { 8 };
                assert_eq!(s.refine.batch, Some(batch));
                nodes * f64::from(search.starts.unwrap()) * (candidates + 3.0 * passes)
            };
            assert!(work(&draft) < work(&standard) && work(&standard) < work(&best));
            let planner = [&draft, &standard, &best].map(|s| s.planner.nodes);
            assert_eq!(planner, [Some(0), Some(0), Some(80)]);
            let open = nulls(&serde_json::to_value(&standard).unwrap());
            assert_eq!(open, ["/graph/radius_m", "/start_from", "/within_s"]);
            // What is given stays.
            let mut given = FitSettings::phystwin();
            given.search.starts = Some(1);
            given.search.prior = Some(2.0);
            given.search.gravity = Some(subject == Subject::Body);
            given.loss.sequences = Some(SequenceMean::Arithmetic);
            given.refine.batch = Some(0);
            given.appearance.gaussians = Some(7);
            (given.planner.nodes, given.planner.substeps) = (Some(7), Some(9));
            assert_eq!(given.filled(conditions), given);
        }
    }
}
