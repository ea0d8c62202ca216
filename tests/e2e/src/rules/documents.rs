//! Documents about the code agree with the code.

use std::collections::{BTreeMap, BTreeSet};

use bendtwin_core::{
    Appearance, Contact, Environment, FitSettings, Graph, Identifiability, NodeKind, Params, Pin,
    PlannerQuality, PlannersTwin, Quality, Skin, Splats, Surface, Timing, Tube, Twin,
    capture::Subject,
    identifiability::Region,
    settings::{Conditions, DeviceKind, Effort, ingest::IngestSettings},
    twin::Member,
};
use serde_json::Value;

use super::workspace;

/// Rows of docs/use/settings.md whose field has no default.
const ALTERNATIVES: [&str; 1] = ["substeps.fixed"];

fn document(name: &str) -> String {
    std::fs::read_to_string(workspace::root().join("docs").join(name)).unwrap()
}

#[test]
fn every_setting_is_documented_with_its_default() {
    let text = document("use/settings.md");
    let (fit, ingest) = text.split_once("\n# Settings of an ingest\n").unwrap();
    agree(fit, serde_json::to_value(FitSettings::default()).unwrap());
    agree(ingest, serde_json::to_value(IngestSettings::default()).unwrap());
}

/// Settings that are left open and follow more than effort, object and device.
const OF_THE_CAPTURE: [&str; 4] = ["graph.radius_m", "refine.batch", "start_from", "within_s"];
/// Head of the table of what other open settings become.
const EFFORTS: &str = "| left open | body on a CPU | body on a GPU | cable |\n|---|---|---|---|\n";

#[test]
fn settings_that_are_left_open_are_documented_with_what_they_become() {
    let old = document("use/settings.md");
    let (before, rest) = old.split_once(EFFORTS).expect("the table of efforts");
    let rows = rest.split_inclusive('\n').take_while(|line| line.starts_with('|')).map(str::len);
    let after = &rest[rows.sum()..];
    let new = format!("{before}{EFFORTS}{}{after}", what_open_settings_become());
    if std::env::var_os("BENDTWIN_BLESS").is_some() {
        std::fs::write(workspace::root().join("docs/use/settings.md"), new).unwrap();
    } else {
        assert_eq!(old, new, "`BENDTWIN_BLESS=1 cargo test -p bendtwin-e2e left_open` updates it");
    }
}

/// The rows of that table.
fn what_open_settings_become() -> String {
    let flat = |settings: FitSettings| {
        let mut all = BTreeMap::new();
        flatten("", &serde_json::to_value(settings).unwrap(), &mut all);
        all
    };
    let cell = |name: &str, subject, device| {
        let conditions = Conditions { subject, device, sequences: 1, is_weighed: false };
        let values = [Effort::Draft, Effort::Standard, Effort::Best].map(|effort| {
            let settings = FitSettings { effort, ..FitSettings::default() };
            match &flat(settings.filled(conditions))[name] {
                Value::Number(most) if most.as_u64() == Some(usize::MAX as u64) => "all".to_owned(),
                value => value.to_string().replace('"', ""),
            }
        });
        if values.iter().all(|value| *value == values[0]) {
            values[0].clone()
        } else {
            values.join(", ")
        }
    };
    let mut rows = String::new();
    for (name, value) in flat(FitSettings::default()) {
        if value.is_null() && !OF_THE_CAPTURE.contains(&&*name) {
            let body = |device| cell(&name, Subject::Body, device);
            let cable = [DeviceKind::Cpu, DeviceKind::Gpu].map(|d| cell(&name, Subject::Cable, d));
            assert_eq!(cable[0], cable[1], "{name} of a cable depends on the device");
            let [cpu, gpu] = [body(DeviceKind::Cpu), body(DeviceKind::Gpu)];
            rows += &format!("| {name} | {cpu} | {gpu} | {} |\n", cable[0]);
        }
    }
    rows
}

/// Compares tables of fields and defaults with the defaults in the code.
fn agree(text: &str, defaults: Value) {
    let mut in_code = BTreeMap::new();
    flatten("", &defaults, &mut in_code);
    let mut documented = BTreeMap::new();
    for line in text.lines() {
        let cells: Vec<_> = line.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        if let ["", field, default, ..] = cells[..]
            && line.starts_with("| `")
            && !ALTERNATIVES.contains(&field)
        {
            let value = serde_json::from_str::<Value>(default);
            documented.insert(field.to_owned(), value.unwrap_or_else(|e| panic!("{field}: {e}")));
        }
    }
    assert_eq!(documented, in_code);
}

#[test]
fn the_example_settings_are_valid() {
    let text = document("use/settings.md");
    let example = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let settings: FitSettings = serde_json::from_str(example).unwrap();
    assert_eq!(settings.validate(), Ok(()));
    // No bound has two spellings.
    let mut published = FitSettings::phystwin();
    published.graph.max_nodes = settings.graph.max_nodes;
    assert_eq!(settings, published);
}

#[test]
fn every_tensor_of_a_twin_file_is_specified_with_type_and_shape() {
    let documented: BTreeSet<_> = document("formats/twin.md")
        .lines()
        .filter(|line| {
            line.starts_with("| `") && line.contains("32 | [") || line.contains(" U8 | [")
        })
        .map(|line| {
            let cells: Vec<_> = line.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
            (cells[1].to_owned(), cells[2].to_owned(), cells[3].matches(',').count() + 1)
        })
        .collect();
    let (tensors, _) = header(&twin());
    let written: BTreeSet<_> = tensors
        .iter()
        .map(|(name, about)| {
            let dtype = about["dtype"].as_str().unwrap().to_owned();
            (name.clone(), dtype, about["shape"].as_array().unwrap().len())
        })
        .collect();
    assert_eq!(documented, written);
}

#[test]
fn every_part_of_a_twin_files_metadata_is_specified() {
    let text = document("formats/twin.md");
    let (_, metadata) = header(&twin());
    let mut fields = BTreeMap::new();
    flatten("", &metadata, &mut fields);
    for path in fields.keys() {
        let name = path.rsplit('.').next().unwrap();
        assert!(
            text.contains(&format!("`{name}`")) || text.contains(&format!("`{path}`")),
            "{path}"
        );
    }
}

#[test]
fn the_example_configuration_says_what_holds_by_default() {
    let path = workspace::root().join("deploy/config.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let options: bendtwin_server::Options = toml::from_str(&text).unwrap();
    assert!(options == bendtwin_server::Options::default(), "deploy/config.toml changes a default");
    let mut fields = BTreeMap::new();
    flatten("", &serde_json::to_value(&options).unwrap(), &mut fields);
    let sign_in = bendtwin_server::SignIn::new("", "", "");
    flatten("sign_in", &serde_json::to_value(&sign_in).unwrap(), &mut fields);
    for path in fields.keys() {
        let name = path.rsplit('.').next().unwrap();
        assert!(text.contains(&format!("{name} = ")), "deploy/config.toml does not tell of {path}");
    }
}

/// A twin of the newest version: with a rod, a skin, a member, a look, a report of what is open and a
/// planner's twin.
fn twin() -> Twin {
    let n = Graph::MIN_ROD_NODES;
    let pin = |node| Pin { node, control: 0, offset_m: [0.0; 3] };
    let graph = Graph {
        rest_positions: vec![[0.0; 3]; n],
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: vec![Graph::NOT_OBSERVED; n],
        control_rest: vec![[0.0; 3]],
        pins: (0..n as u32).map(pin).collect(),
        rods: vec![(0..n as u32).collect()],
        ..Graph::default()
    };
    let report = Identifiability {
        regions: vec![Region { name: "free end".into(), center: [0.0; 3], nodes: n as u32 }],
        node_regions: vec![0; n],
        point_sd_m: vec![0.001],
        expected_error_m: Some(0.004),
        ..Identifiability::default()
    };
    let per_rod = vec![0.0];
    let mut skin = Skin::default();
    skin.push(0, &[(0, 0.5), (1, 0.5)], [Skin::NO_FRAME; 3], [0.0; 3]);
    let splats = Splats {
        carriers: skin.clone(),
        scales_m: vec![[0.01; 3]],
        rotations: vec![[0.0, 0.0, 0.0, 1.0]],
        opacities: vec![0.5],
        colors: vec![[0.5; 3]],
    };
    let surface = Surface {
        carriers: skin.clone(),
        triangles: vec![[0, 0, 0]],
        colors: vec![[0; 3]],
        tubes: vec![Tube { nodes: vec![0, 1], radius_m: 0.01 }],
    };
    let twin = Twin {
        skin,
        graph,
        params: Params {
            contact: Contact { skin: true, ..Contact::default() },
            twist_stiffness: per_rod.clone(),
            twist_damping: per_rod.clone(),
            rest_twists_rad: per_rod,
            ..Params::default()
        },
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 1 },
        control_velocity: Default::default(),
        provenance: Default::default(),
        quality: Quality { identifiability: Some(report), ..Quality::default() },
        mass_kg: Some(0.5),
        control_hands: vec![0],
        members: Vec::new(),
        appearance: Some(Appearance { skin_colors: vec![[0; 3]], splats: Some(splats) }),
        surface: Some(surface),
        planner: None,
    };
    let mut small =
        Twin { appearance: None, surface: None, quality: Quality::default(), ..twin.clone() };
    small.skin.append(&Skin::at_nodes(&(0..n as u32).collect::<Vec<_>>()));
    let planner = PlannersTwin { nodes: (0..n as u32).collect(), twin: Box::new(small) };
    let figures = PlannerQuality {
        nodes: n as u32,
        springs: 0,
        triplets: 0,
        substeps: 1,
        mean_deviation_m: 0.0,
        max_deviation_m: 0.0,
        mean_travel_m: 0.1,
        frames: 30,
        actions: 8,
    };
    let members = Member::of(&twin, &twin).into_iter().collect();
    let quality = Quality { planner: Some(figures), ..twin.quality.clone() };
    Twin { members, planner: Some(planner), quality, ..twin }
}

/// The tensors and the metadata that a twin's file declares.
fn header(twin: &Twin) -> (serde_json::Map<String, Value>, Value) {
    let file = twin.encode().unwrap();
    let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
    let mut tensors: serde_json::Map<_, _> = serde_json::from_slice(&file[8..8 + length]).unwrap();
    let metadata = tensors.remove("__metadata__").unwrap();
    (tensors, serde_json::from_str(metadata["bendtwin.twin"].as_str().unwrap()).unwrap())
}

/// JSON as dotted paths.
fn flatten(path: &str, value: &Value, found: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(&format!("{path}{dot}{name}"), value, found);
            }
        }
        _ => {
            found.insert(path.to_owned(), value.clone());
        }
    }
}

#[test]
fn every_metric_of_the_dashboard_is_described() {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let names = |text: &str| -> BTreeSet<String> {
        let words = text.split(|c| !is_name(c)).filter(|word| word.starts_with("bendtwin_"));
        words.map(|word| word.trim_end_matches("_bucket").to_owned()).collect()
    };
    let dashboard = std::fs::read_to_string(workspace::root().join("deploy/grafana/bendtwin.json"));
    let shown = names(&dashboard.unwrap());
    let mut described = names(&document("run/monitoring.md"));
    // Described as those of fits, with another word.
    let of_ingests = described.iter().map(|name| name.replace("_fit_", "_ingest_"));
    described.extend(of_ingests.collect::<Vec<_>>());
    assert!(shown.len() > 10);
    assert_eq!(shown.difference(&described).collect::<Vec<_>>(), Vec::<&String>::new());
}
