//! The dependency rules of ARCHITECTURE.md, checked with `cargo metadata`: crates that others must
//! not reach, directly or indirectly. Dependencies of tests do not count.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use cargo_metadata::{DependencyKind, MetadataCommand, PackageId, camino::Utf8Path};

use super::{rust_code::code_only, workspace};

/// Crates that talk to a network or wait for one.
const NETWORK: [&str; 7] = ["tokio", "tonic", "hyper", "axum", "reqwest", "object_store", "quinn"];
const DATABASE: [&str; 5] = ["sqlx", "sqlx-core", "rusqlite", "libsqlite3-sys", "bendtwin-store"];
const PHYSICS: [&str; 26] = [
    "bendtwin-backends",
    "bendtwin-bench",
    "bendtwin-calibrate",
    "bendtwin-capture",
    "bendtwin-cuda",
    "bendtwin-engine",
    "bendtwin-eval",
    "bendtwin-exchange",
    "bendtwin-fit",
    "bendtwin-flow",
    "bendtwin-graph",
    "bendtwin-identify",
    "bendtwin-ingest",
    "bendtwin-inspect",
    "bendtwin-lift",
    "bendtwin-mesh",
    "bendtwin-near",
    "bendtwin-picture",
    "bendtwin-register",
    "bendtwin-render",
    "bendtwin-rollout",
    "bendtwin-segment",
    "bendtwin-splat",
    "bendtwin-study",
    "bendtwin-surface",
    "bendtwin-synth",
];
/// Crates that read, judge and lift captures, or write twins, without physics.
const CAMERA_SIDE: [&str; 11] = [
    "bendtwin-calibrate",
    "bendtwin-capture",
    "bendtwin-exchange",
    "bendtwin-flow",
    "bendtwin-graph",
    "bendtwin-ingest",
    "bendtwin-inspect",
    "bendtwin-lift",
    "bendtwin-mesh",
    "bendtwin-picture",
    "bendtwin-segment",
];
/// Crates that open captures.
const CAPTURE_READERS: [&str; 5] = [
    "bendtwin-capture",
    "bendtwin-ingest",
    "bendtwin-inspect",
    "bendtwin-lift",
    "bendtwin-segment",
];
const SIMULATION: [&str; 8] = [
    "bendtwin-backends",
    "bendtwin-cuda",
    "bendtwin-engine",
    "bendtwin-eval",
    "bendtwin-fit",
    "bendtwin-identify",
    "bendtwin-register",
    "bendtwin-synth",
];

struct Rule {
    /// Crates that the rule applies to.
    of: &'static [&'static str],
    because: &'static str,
    never: &'static [&'static [&'static str]],
}

const RULES: [Rule; 17] = [
    Rule {
        of: &["bendtwin-store"],
        because: "the control plane knows no physics",
        never: &[&PHYSICS, &["bendtwin-worker"]],
    },
    Rule {
        of: &["bendtwin-server"],
        because: "the server shows twins and writes them for other programs, but simulates and fits nothing",
        never: &[
            &SIMULATION,
            &["bendtwin-ingest", "bendtwin-inspect", "bendtwin-lift", "bendtwin-segment"],
            &["bendtwin-rollout", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-worker"],
        because: "a worker knows no database",
        never: &[&DATABASE, &["bendtwin-server"]],
    },
    Rule {
        of: &["bendtwin-client", "bendtwin-store", "bendtwin-worker"],
        because: "only the server reads what an identity provider signs",
        never: &[&["jsonwebtoken"]],
    },
    Rule {
        of: &[
            "bendtwin-engine",
            "bendtwin-fit",
            "bendtwin-eval",
            "bendtwin-identify",
            "bendtwin-bench",
            "bendtwin-backends",
            "bendtwin-synth",
        ],
        because: "physics knows no network and no database",
        never: &[&NETWORK, &DATABASE, &["bendtwin-proto", "bendtwin-server", "bendtwin-worker"]],
    },
    Rule {
        of: &["bendtwin-cuda", "bendtwin-bench", "bendtwin-study"],
        because: "physics knows no network and no database",
        never: &[&NETWORK, &DATABASE, &["bendtwin-proto", "bendtwin-server", "bendtwin-worker"]],
    },
    Rule {
        of: &CAMERA_SIDE,
        because: "captures are read, judged and lifted, and twins written, without physics, network or database",
        never: &[
            &SIMULATION,
            &NETWORK,
            &DATABASE,
            &["bendtwin-proto", "bendtwin-server", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-image-metrics"],
        because: "images are compared without knowing where they come from",
        never: &[&NETWORK, &DATABASE, &PHYSICS, &["bendtwin-proto", "bendtwin-core"]],
    },
    Rule {
        of: &["bendtwin-plan"],
        because: "planners lower an abstract cost",
        never: &[&NETWORK, &DATABASE, &PHYSICS, &["bendtwin-proto", "bendtwin-core"]],
    },
    Rule {
        of: &["bendtwin-core"],
        because: "the nouns know neither I/O nor any other part",
        never: &[&NETWORK, &DATABASE, &PHYSICS, &["bendtwin-proto", "zip"]],
    },
    Rule {
        of: &["bendtwin-proto", "bendtwin-contract", "bendtwin-client"],
        because: "the contract and its client know neither physics nor a database",
        never: &[&PHYSICS, &DATABASE, &["bendtwin-server", "bendtwin-worker"]],
    },
    Rule {
        of: &["bendtwin-proto"],
        because: "messages are not built again when a rule changes",
        never: &[&["bendtwin-contract", "bendtwin-plan"]],
    },
    Rule {
        of: &["bendtwin-rollout"],
        because: "what a rollout computes is the same in every process",
        never: &[
            &CAPTURE_READERS,
            &DATABASE,
            &["bendtwin-backends", "bendtwin-cuda", "bendtwin-fit"],
            &["bendtwin-server", "bendtwin-telemetry", "bendtwin-tls", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-play"],
        because: "a play knows sessions and plans, not how they are reached",
        never: &[
            &PHYSICS,
            &DATABASE,
            &["bendtwin-contract", "bendtwin-plan", "bendtwin-server", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-register"],
        because: "registration takes points, from wherever they come",
        never: &[
            &CAPTURE_READERS,
            &NETWORK,
            &DATABASE,
            &["bendtwin-proto", "bendtwin-server", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-splat"],
        because: "a rasteriser draws Gaussians, wherever they come from",
        never: &[
            &SIMULATION,
            &CAPTURE_READERS,
            &NETWORK,
            &DATABASE,
            &["bendtwin-proto", "bendtwin-server", "bendtwin-worker"],
        ],
    },
    Rule {
        of: &["bendtwin-eval"],
        because: "scores must not know how a twin was fitted",
        never: &[&["bendtwin-fit"]],
    },
];

#[test]
fn no_crate_reaches_what_it_must_not_know() {
    let graph = Graph::read();
    let mut broken = Vec::new();
    for rule in &RULES {
        for from in rule.of {
            for to in rule.never.iter().flat_map(|names| names.iter()) {
                if let Some(path) = graph.path(from, to) {
                    broken.push(format!("{}: {}", rule.because, path.join(" -> ")));
                }
            }
        }
    }
    assert!(broken.is_empty(), "forbidden dependencies:\n{}", broken.join("\n"));
}

#[test]
fn rules_rollouts_and_plays_name_no_transport() {
    let graph = Graph::read();
    // They reach it through the messages, which implement its traits.
    for transport in ["axum", "http", "http-body-util", "hyper", "reqwest", "tonic"] {
        let users = graph.users(transport);
        for name in ["bendtwin-contract", "bendtwin-play", "bendtwin-rollout"] {
            assert!(!users.contains(&name), "{name} names {transport}");
        }
    }
    // A play waits for time and messages.
    for name in ["bendtwin-contract", "bendtwin-rollout"] {
        assert!(!graph.users("futures").contains(&name), "{name} names futures");
    }
    assert!(graph.users("tonic").contains(&"bendtwin-worker"));
}

/// The fields of `App` are private; this is for what could be reached around it.
#[test]
fn transports_call_the_use_cases_alone() {
    let mut found = Vec::new();
    for (file, path) in workspace::files() {
        let is_below = |folders: &[&str]| folders.iter().any(|f| file.starts_with(f));
        let around: &[&str] = if is_below(&["server/src/grpc", "server/src/http"]) {
            &["dispatch::", "KeyRing", "Tokens", "Plays", "Store::", "Memory::"]
        } else if is_below(&["server/src/app/", "server/src/app.rs"]) {
            // The use cases know no transport.
            &["axum", "tonic", "refusal::"]
        } else {
            continue;
        };
        if !file.ends_with(".rs") {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        let code = code_only(&text);
        found.extend(around.iter().filter(|a| code.contains(**a)).map(|a| format!("{file}: {a}")));
    }
    assert!(found.is_empty(), "these belong on the other side of a method of `App`: {found:?}");
}

#[test]
fn no_crate_of_the_product_reaches_tools_or_tests() {
    let graph = Graph::read();
    let is_outside = |name: &str| {
        let folder = &graph.folders[name];
        folder.starts_with("tools/") || folder.starts_with("tests/")
    };
    let (outside, product): (Vec<&str>, Vec<&str>) =
        graph.folders.keys().map(String::as_str).partition(|name| is_outside(name));
    for name in ["bendtwin-lab", "bendtwin-study", "bendtwin-engine-kit", "bendtwin-harness"] {
        assert!(outside.contains(&name), "{outside:?}");
    }
    assert!(product.contains(&"bendtwin-cli") && product.len() > 30, "{product:?}");
    let mut broken = Vec::new();
    for from in product {
        broken.extend(outside.iter().filter_map(|to| graph.path(from, to)));
    }
    assert!(broken.is_empty(), "only tools and tests may depend on these: {broken:?}");
}

#[test]
fn the_search_sees_indirect_dependencies() {
    let graph = Graph::read();
    let path = graph.path("bendtwin-cli", "bendtwin-store").unwrap();
    assert!(path.len() > 2, "{path:?}");
    assert_eq!(graph.path("bendtwin-core", "bendtwin-cli"), None);
}

#[test]
fn only_one_crate_names_cuda_and_only_one_opens_it() {
    let graph = Graph::read();
    let strangers = |to: &str, allowed: &[&str]| {
        let mut users = graph.users(to);
        users.retain(|name| name.starts_with("bendtwin-") && !allowed.contains(name));
        users
    };
    let users = strangers("cudarc", &["bendtwin-cuda"]);
    assert!(users.is_empty(), "cudarc belongs behind bendtwin-cuda, not in {users:?}");
    let users = strangers("bendtwin-cuda", &["bendtwin-backends"]);
    assert!(users.is_empty(), "a backend is opened by bendtwin-backends, not in {users:?}");
}

#[test]
fn the_command_line_names_the_worker_only_where_it_starts_or_asks_one() {
    let name = concat!("bendtwin", "_worker::");
    let mut found = Vec::new();
    for (file, path) in workspace::files() {
        let is_code = file.starts_with("client/cli/") && file.ends_with(".rs");
        if is_code && std::fs::read_to_string(path).unwrap().contains(name) {
            found.push(file);
        }
    }
    assert_eq!(found, ["client/cli/src/server/healthcheck.rs", "client/cli/src/worker.rs"]);
}

#[test]
fn only_the_cuda_crate_is_unsafe() {
    let has_word =
        |line: &str| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "unsafe");
    let mut found = Vec::new();
    for (name, path) in workspace::files() {
        if !name.ends_with(".rs") || name.starts_with("crates/cuda/") {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        let code = code_only(&text);
        let lines = code.lines().enumerate().filter(|(_, line)| has_word(line));
        found.extend(lines.map(|(number, _)| format!("{name}:{}", number + 1)));
    }
    assert!(found.is_empty(), "only crates/cuda may, where a kernel is launched: {found:?}");
}

/// A release gives every crate that is not listed `opt-level = "z"`. Kits of tests are in none.
#[test]
fn what_is_fast_in_tests_is_fast_in_a_release() {
    let text = std::fs::read_to_string(workspace::root().join("Cargo.toml")).unwrap();
    let manifest: toml::Table = text.parse().unwrap();
    let fast = |profile: &str| -> BTreeSet<String> {
        let packages = manifest["profile"][profile]["package"].as_table().unwrap();
        let is_fast = |options: &toml::Value| options.get("opt-level") == Some(&3.into());
        packages.iter().filter(|(_, o)| is_fast(o)).map(|(name, _)| name.clone()).collect()
    };
    let (dev, release) = (fast("dev"), fast("release"));
    assert!(dev.contains("bendtwin-engine"), "{dev:?}");
    let slow: Vec<_> = dev.difference(&release).filter(|name| !name.ends_with("-kit")).collect();
    assert!(slow.is_empty(), "fast in tests and slow in a release: {slow:?}");
}

/// Dependencies between crates, without those of tests.
struct Graph {
    names: BTreeMap<PackageId, String>,
    /// Folders of the crates of the workspace, relative to its root.
    folders: BTreeMap<String, String>,
    edges: BTreeMap<PackageId, Vec<PackageId>>,
}

impl Graph {
    fn read() -> Self {
        let metadata = MetadataCommand::new()
            .current_dir(workspace::root())
            .other_options(["--locked".to_owned()])
            .exec()
            .unwrap();
        let names = metadata.packages.iter().map(|p| (p.id.clone(), p.name.to_string())).collect();
        let folder = |path: &Utf8Path| {
            path.parent()?.strip_prefix(&metadata.workspace_root).ok().map(ToString::to_string)
        };
        let folders = metadata
            .workspace_packages()
            .into_iter()
            .filter_map(|p| Some((p.name.to_string(), folder(&p.manifest_path)?)))
            .collect();
        let nodes = metadata.resolve.unwrap().nodes;
        let edges = nodes
            .into_iter()
            .map(|node| {
                let used = node
                    .deps
                    .into_iter()
                    .filter(|d| d.dep_kinds.iter().any(|k| k.kind != DependencyKind::Development));
                (node.id, used.map(|d| d.pkg).collect())
            })
            .collect();
        Self { names, folders, edges }
    }

    /// Crates that depend on a crate directly.
    fn users(&self, of: &str) -> Vec<&str> {
        let uses = |to: &Vec<PackageId>| to.iter().any(|id| self.names[id] == of);
        let users = self.edges.iter().filter(|(_, to)| uses(to));
        users.map(|(from, _)| self.names[from].as_str()).collect()
    }

    /// The shortest chain of dependencies between two crates, if one exists.
    fn path(&self, from: &str, to: &str) -> Option<Vec<&str>> {
        let start = self.names.iter().find(|(_, name)| *name == from).map(|(id, _)| id)?;
        let mut came_from = BTreeMap::from([(start, None)]);
        let mut queue = VecDeque::from([start]);
        while let Some(id) = queue.pop_front() {
            if self.names[id] == to {
                let chain = std::iter::successors(Some(id), |id| came_from[*id]);
                let mut path: Vec<_> = chain.map(|id| self.names[id].as_str()).collect();
                path.reverse();
                return Some(path);
            }
            for next in self.edges.get(id).into_iter().flatten() {
                if !came_from.contains_key(next) {
                    came_from.insert(next, Some(id));
                    queue.push_back(next);
                }
            }
        }
        None
    }
}
