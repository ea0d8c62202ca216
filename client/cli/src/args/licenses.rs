//! `bendtwin licenses`: the licence of the program, and the notices of the software in it, which
//! `client/cli/notices/make` collects.

use std::{collections::BTreeMap, io::Read as _};

use anyhow::Context as _;
use clap::Args;
use flate2::read::GzDecoder;
use serde::{Deserialize, Serialize};

use crate::{global::Global, output};

const COLLECTED: &[u8] = include_bytes!("notices.json.gz");
const OWN: &str = "BendTwin is licensed under the MIT License or the Apache License, Version 2.0, at your choice.";
const MIT: &str = include_str!("../../../../LICENSE-MIT");
const APACHE: &str = include_str!("../../../../LICENSE-APACHE");

#[derive(Debug, Args)]
pub(crate) struct Licenses {
    /// Print the notices of this software only, for example `ring` [default: all]
    name: Option<String>,
    /// Print names, versions and licences only
    #[arg(long)]
    list: bool,
}

/// What is in the program: crates, packages of the console, fonts and tables.
#[derive(Debug, Deserialize)]
struct Notices {
    parts: Vec<Part>,
    texts: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Part {
    name: String,
    version: String,
    license: String,
    /// Indices of its texts.
    texts: Vec<usize>,
}

/// A part as `--json` has it.
#[derive(Debug, Serialize)]
struct Notice<'a> {
    name: &'a str,
    version: &'a str,
    license: &'a str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    texts: Vec<&'a str>,
}

pub(crate) fn run(args: &Licenses, global: &Global) -> anyhow::Result<()> {
    let mut notices = Notices::read()?;
    if let Some(name) = &args.name {
        notices.parts.retain(|part| part.name.eq_ignore_ascii_case(name));
        anyhow::ensure!(
            !notices.parts.is_empty(),
            "the program contains no `{name}`: `bendtwin licenses --list` names what it contains"
        );
    }
    output::print(global, &notices.document(!args.list), || {
        if args.list {
            notices.list()
        } else if args.name.is_some() {
            notices.text()
        } else {
            let rule = "=".repeat(80);
            let own = [OWN, MIT.trim_end(), APACHE.trim_end()].join("\n\n");
            format!("{own}\n\n{rule}\n\nIt contains:\n\n{}\n\n{}", notices.list(), notices.text())
        }
    })
}

impl Notices {
    fn read() -> anyhow::Result<Self> {
        let mut text = String::new();
        GzDecoder::new(COLLECTED).read_to_string(&mut text).context("the notices are damaged")?;
        serde_json::from_str(&text).context("the notices are damaged")
    }

    fn document(&self, with_texts: bool) -> Vec<Notice<'_>> {
        let notices = self.parts.iter().map(|part| Notice {
            name: &part.name,
            version: &part.version,
            license: &part.license,
            texts: if with_texts { self.texts_of(part) } else { Vec::new() },
        });
        notices.collect()
    }

    fn texts_of(&self, part: &Part) -> Vec<&str> {
        part.texts.iter().filter_map(|at| self.texts.get(*at)).map(String::as_str).collect()
    }

    fn list(&self) -> String {
        let line = |part: &Part| format!("{} ({})", part.title(), part.license);
        self.parts.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// Each text once, below the parts that it is for.
    fn text(&self) -> String {
        let mut holders: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for part in &self.parts {
            for at in &part.texts {
                holders.entry(*at).or_default().push(part.title());
            }
        }
        let rule = "-".repeat(80);
        let section = |(at, titles): (usize, Vec<String>)| {
            Some(format!("{rule}\n{}\n\n{}", titles.join(", "), self.texts.get(at)?))
        };
        holders.into_iter().filter_map(section).collect::<Vec<_>>().join("\n")
    }
}

impl Part {
    fn title(&self) -> String {
        format!("{} {}", self.name, self.version).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_its_text() {
        let notices = Notices::read().unwrap();
        for part in &notices.parts {
            assert!(!part.license.is_empty(), "{}", part.name);
            let longest = notices.texts_of(part).iter().map(|text| text.len()).max();
            // SQLite's needs no more.
            assert!(longest > Some(if part.name == "SQLite" { 100 } else { 500 }), "{}", part.name);
        }
        let named = |name: &str| notices.parts.iter().any(|part| part.name == name);
        for name in ["ring", "three", "uplot", "SQLite", "rust standard library"] {
            assert!(named(name), "{name}");
        }
        let (list, text) = (notices.list(), notices.text());
        assert!(list.lines().any(|line| line.starts_with("uplot ") && line.ends_with("(MIT)")));
        assert!(text.contains("three.js authors") && text.contains("SIL OPEN FONT LICENSE"));
    }

    #[test]
    fn a_text_of_several_parts_is_printed_once() {
        let part = |name: &str| Part {
            name: name.to_owned(),
            version: "1.0".to_owned(),
            license: "MIT".to_owned(),
            texts: vec![0],
        };
        let notices =
            Notices { parts: vec![part("a"), part("b")], texts: vec!["Permission".to_owned()] };
        assert!(notices.text().ends_with("a 1.0, b 1.0\n\nPermission"), "{}", notices.text());
        assert_eq!(notices.list(), "a 1.0 (MIT)\nb 1.0 (MIT)");
        let document = notices.document(false);
        assert_eq!(
            serde_json::to_string(&document[0]).unwrap(),
            r#"{"name":"a","version":"1.0","license":"MIT"}"#
        );
    }
}
