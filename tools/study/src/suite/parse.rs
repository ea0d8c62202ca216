//! Reads a suite's file and finds everything that is wrong with it.

use std::{
    collections::{BTreeSet, HashSet},
    path::Path,
};

use bendtwin_core::quality::ErrorSummary;
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::{Map, Value};

use super::{BASELINES, CaptureEntry, Configuration, Reference, Suite, faults_of_layer, in_force};

/// The format that this build reads.
const VERSION: u64 = 1;
/// No suite needs more runs than this.
const MAX_RUNS: usize = 100_000;

const FIELDS: [&str; 10] = [
    "version",
    "name",
    "about",
    "captures",
    "base",
    "configurations",
    "seeds",
    "compare",
    "references",
    "figure",
];

/// Figures as a file gives them [mm].
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Millimetres {
    cd_l1_mm: Option<f64>,
    cd_l2_mm: Option<f64>,
    track_mm: Option<f64>,
    coordinate_mm: Option<f64>,
    padded_rms_mm: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct ReferenceEntry {
    name: String,
    capture: Option<String>,
    #[serde(default)]
    train: Millimetres,
    #[serde(default)]
    future: Millimetres,
}

pub(super) fn parse(file: &Path, text: &str) -> Result<Suite, Vec<String>> {
    let document: Value = serde_json::from_str(text).map_err(|e| vec![e.to_string()])?;
    let Value::Object(document) = document else {
        return Err(vec!["a suite is an object".to_owned()]);
    };
    let mut reader = Reader { faults: Vec::new() };
    reader.only("", &document, &FIELDS);
    match document.get("version") {
        Some(version) if version.as_u64() == Some(VERSION) => {}
        Some(version) => {
            reader.fault(format!("version is {version}, this build reads {VERSION}"));
        }
        None => reader.fault(format!("version is missing: write \"version\": {VERSION}")),
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let references = reader.list(&document, "references", &["name", "capture", "train", "future"]);
    let suite = Suite {
        file: file.to_owned(),
        name: reader.value(&document, "name").unwrap_or(stem),
        about: reader.value(&document, "about").unwrap_or_default(),
        captures: reader.list(&document, "captures", &["name", "path", "group", "settings"]),
        base: document.get("base").cloned().unwrap_or(Value::Null),
        configurations: reader.list(&document, "configurations", &["name", "groups", "settings"]),
        seeds: reader.value(&document, "seeds").unwrap_or_else(|| vec![0]),
        compare: reader.list(&document, "compare", &["of", "against"]),
        references: references.into_iter().map(ReferenceEntry::into_reference).collect(),
        figure: reader.value(&document, "figure"),
    };
    reader.check(&suite);
    if reader.faults.is_empty() { Ok(suite) } else { Err(reader.faults) }
}

struct Reader {
    faults: Vec<String>,
}

impl Reader {
    fn fault(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.faults.contains(&text) {
            self.faults.push(text);
        }
    }

    /// Refuses fields that there are not.
    fn only(&mut self, at: &str, object: &Map<String, Value>, known: &[&str]) {
        for field in object.keys().filter(|k| !known.contains(&k.as_str())) {
            self.fault(format!("{at}there is no field `{field}`; there is {}", known.join(", ")));
        }
    }

    fn value<T: DeserializeOwned>(
        &mut self,
        object: &Map<String, Value>,
        field: &str,
    ) -> Option<T> {
        match serde_json::from_value(object.get(field)?.clone()) {
            Ok(value) => Some(value),
            Err(e) => {
                self.fault(format!("{field}: {e}"));
                None
            }
        }
    }

    fn list<T: DeserializeOwned>(
        &mut self,
        document: &Map<String, Value>,
        field: &str,
        known: &[&str],
    ) -> Vec<T> {
        let Some(values) = self.value::<Vec<Value>>(document, field) else { return Vec::new() };
        let mut list = Vec::with_capacity(values.len());
        for (index, value) in values.into_iter().enumerate() {
            let at = format!("{field}[{index}]");
            if let Value::Object(object) = &value {
                self.only(&format!("{at}: "), object, known);
            }
            match serde_json::from_value(value) {
                Ok(value) => list.push(value),
                Err(e) => self.fault(format!("{at}: {e}")),
            }
        }
        list
    }

    fn check(&mut self, suite: &Suite) {
        self.names("capture", suite.captures.iter().map(|c| c.name.as_str()));
        self.names("configuration", suite.configurations.iter().map(|c| c.name.as_str()));
        if suite.seeds.iter().collect::<HashSet<_>>().len() != suite.seeds.len() {
            self.fault("a seed stands twice in `seeds`");
        }
        if suite.seeds.is_empty() {
            self.fault("`seeds` is empty: leave it out for seed 0");
        }
        let runs = suite.captures.len().saturating_mul(suite.configurations.len());
        if runs.saturating_mul(suite.seeds.len()) > MAX_RUNS {
            self.fault(format!("more than {MAX_RUNS} runs: cut the suite into several"));
        }
        self.groups(suite);
        self.settings(suite);
        self.references(suite);
        self.comparisons(suite);
        let figure = suite.figure.iter().flat_map(|f| f.faults(&suite.configurations));
        figure.for_each(|fault| self.fault(fault));
    }

    /// A group of configurations is one of captures.
    fn groups(&mut self, suite: &Suite) {
        let known: BTreeSet<&str> =
            suite.captures.iter().filter_map(|c| c.group.as_deref()).collect();
        if known.iter().any(|group| group.is_empty() || group.contains(['|', '\n'])) {
            self.fault("a group of captures has a name without `|`");
        }
        for configuration in &suite.configurations {
            for group in configuration.groups.iter().filter(|g| !known.contains(g.as_str())) {
                self.fault(format!(
                    "{}: no capture is of the group `{group}`",
                    of_configuration(configuration)
                ));
            }
        }
    }

    /// Names become names of files and parts of commands.
    fn names<'a>(&mut self, what: &str, names: impl Iterator<Item = &'a str>) {
        let mut seen = HashSet::new();
        for name in names {
            let plain = |c: char| c.is_ascii_alphanumeric() || "._-+=".contains(c);
            let starts_well = name.chars().next().is_some_and(|c| c.is_ascii_alphanumeric());
            if !starts_well || !name.chars().all(plain) || name.len() > 64 {
                self.fault(format!(
                    "{what} `{name}`: a name begins with a letter or digit and has letters, digits and . _ - + = \
                     alone, 64 at most"
                ));
            }
            if !seen.insert(name) {
                self.fault(format!("{what} `{name}` stands twice"));
            }
        }
        if seen.is_empty() {
            self.fault(format!("there is no {what}"));
        }
    }

    /// Each layer by itself, then each configuration, then what captures make of them.
    fn settings(&mut self, suite: &Suite) {
        let before = self.faults.len();
        let layers = std::iter::once(("base".to_owned(), &suite.base))
            .chain(suite.configurations.iter().map(|c| (of_configuration(c), &c.settings)))
            .chain(suite.captures.iter().map(|c| (of_capture(c), &c.settings)));
        for (at, layer) in layers {
            for fault in faults_of_layer(layer) {
                self.fault(format!("{at}: {fault}"));
            }
        }
        if self.faults.len() > before {
            return;
        }
        for configuration in &suite.configurations {
            let layers = [&suite.base, &configuration.settings];
            if let Err(faults) = in_force(&layers, 0) {
                let at = of_configuration(configuration);
                faults.into_iter().for_each(|f| self.fault(format!("{at}: {f}")));
                continue;
            }
            let own = |c: &&CaptureEntry| !c.settings.is_null() && configuration.is_for(c);
            for capture in suite.captures.iter().filter(own) {
                if let Err(faults) = suite.settings(capture, configuration, 0) {
                    let at = format!("{} under {}", of_capture(capture), configuration.name);
                    faults.into_iter().for_each(|f| self.fault(format!("{at}: {f}")));
                }
            }
        }
    }

    fn references(&mut self, suite: &Suite) {
        let captures: HashSet<&str> = suite.captures.iter().map(|c| c.name.as_str()).collect();
        let configurations: HashSet<&str> =
            suite.configurations.iter().map(|c| c.name.as_str()).collect();
        let mut seen = HashSet::new();
        for reference in &suite.references {
            let (name, capture) = (reference.name.as_str(), reference.capture.as_deref());
            if name.is_empty() || name.contains([':', '|', '\n']) || configurations.contains(name) {
                self.fault(format!(
                    "reference `{name}`: give it a name without `:` and `|` that no configuration has"
                ));
            }
            if let Some(capture) = capture.filter(|c| !captures.contains(c)) {
                self.fault(format!("reference `{name}`: there is no capture `{capture}`"));
            }
            if !seen.insert((name, capture)) {
                self.fault(format!("reference `{name}` stands twice for the same capture"));
            }
            let errors = [&reference.train, &reference.future];
            let figures = errors.into_iter().flat_map(figures_of).flatten();
            if figures.clone().any(|x| !(x.is_finite() && x > 0.0)) {
                self.fault(format!("reference `{name}`: errors are positive"));
            }
            if figures.count() == 0 {
                self.fault(format!("reference `{name}` has no figure"));
            }
        }
    }

    fn comparisons(&mut self, suite: &Suite) {
        let mut rows: BTreeSet<String> = suite.references.iter().map(|r| r.name.clone()).collect();
        for configuration in &suite.configurations {
            let name = &configuration.name;
            rows.insert(name.clone());
            rows.extend(BASELINES.iter().map(|(baseline, _)| format!("{name}:{baseline}")));
        }
        for side in suite.compare.iter().flat_map(|c| [&c.of, &c.against]) {
            if !rows.contains(side) {
                let names = suite.configurations.iter().map(|c| c.name.as_str());
                self.fault(format!(
                    "compare: there is no `{side}`; there is {}, a reference, or configuration:baseline with {}",
                    names.collect::<Vec<_>>().join(", "),
                    BASELINES.map(|b| b.0).join(", ")
                ));
            }
        }
    }
}

impl ReferenceEntry {
    fn into_reference(self) -> Reference {
        let metres = |e: Millimetres| {
            let m = |mm: Option<f64>| mm.map(|x| 1e-3 * x);
            ErrorSummary {
                chamfer_l1_m: m(e.cd_l1_mm),
                chamfer_l2_m: m(e.cd_l2_mm),
                track_m: m(e.track_mm),
                coordinate_m: m(e.coordinate_mm),
                padded_rms_m: m(e.padded_rms_mm),
            }
        };
        Reference {
            name: self.name,
            capture: self.capture,
            train: metres(self.train),
            future: metres(self.future),
        }
    }
}

fn figures_of(e: &ErrorSummary) -> [Option<f64>; 5] {
    [e.chamfer_l1_m, e.chamfer_l2_m, e.track_m, e.coordinate_m, e.padded_rms_m]
}

fn of_configuration(configuration: &Configuration) -> String {
    format!("configuration `{}`", configuration.name)
}

fn of_capture(capture: &CaptureEntry) -> String {
    format!("capture `{}`", capture.name)
}
