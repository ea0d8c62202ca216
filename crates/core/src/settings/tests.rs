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
fn every_fault_is_reported_at_once() {
    let mut settings = FitSettings::default();
    settings.graph.sampling_ratio = 0.0;
    settings.refine.learning_rate = f64::NAN;
    settings.substeps = Substeps::Fixed(0);
    settings.refine.reach = 1_000_001;
    assert_eq!(settings.validate().unwrap_err().len(), 4);
}

#[test]
fn unknown_fields_are_refused() {
    assert!(serde_json::from_str::<FitSettings>(r#"{"graph":{"radius":1}}"#).is_err());
}
