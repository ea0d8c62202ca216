use std::{fmt, path::PathBuf};

use bendtwin_server::{ClientTokenPolicy, Options};
use clap::{Args as _, Command, FromArgMatches as _};
use serde::{
    Deserializer as _,
    de::{IgnoredAny, MapAccess, Visitor},
};

use super::*;
use crate::worker::Worker;

/// Flags of a command line; the environment of the tests has no effect.
fn flags(args: &[&str]) -> Server {
    let command = Server::augment_args(Command::new("server"));
    let command = command.mut_args(|arg| arg.env(None::<&str>));
    let matches = command.try_get_matches_from([&["server"], args].concat()).unwrap();
    Server::from_arg_matches(&matches).unwrap()
}

/// Options of a command line.
fn options(args: &[&str]) -> anyhow::Result<Options> {
    flags(args).options()
}

/// Writes an options file.
fn file(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.toml");
    std::fs::write(&path, text).unwrap();
    let path = path.display().to_string();
    (folder, path)
}

#[test]
fn flags_win_over_the_file_and_the_file_over_defaults() {
    let (_guard, path) =
        file("data_dir = \"from-file\"\nlease_s = 12.0\n[workers]\ncount = 3\ndevices = [1]\n");
    let options = options(&["--config", &path, "--workers", "2", "--backend", "cuda"]).unwrap();
    assert_eq!(options.data_dir, PathBuf::from("from-file"));
    assert_eq!(options.workers.count, 2);
    assert_eq!(
        (options.workers.backend.as_str(), &options.workers.devices[..]),
        ("cuda", &[1][..])
    );
    assert!((options.lease_s - 12.0).abs() < 1e-9);
    assert_eq!(options.listen, Options::default().listen);
    assert_eq!(options.workers.args, ["worker", END_WITH_SERVER]);
}

#[test]
fn access_is_set_by_flags_and_checked() {
    let options = |host| options(&["--allowed-host", host, "--client-token", "none"]);
    let set = options("twin.example,b").unwrap();
    assert_eq!(set.allowed_hosts, ["twin.example", "b"]);
    assert_eq!(set.client_token, ClientTokenPolicy::None);
    assert!(options("http://twin").unwrap_err().to_string().contains("allowed_hosts"));
}

#[test]
fn openness_is_set_by_flags() {
    let options = |more: &[&str]| options(&[&["--listen", "0.0.0.0:7070"], more].concat());
    let error = options(&[]).unwrap_err();
    assert!(error.is::<Usage>() && error.to_string().contains("--insecure"), "{error}");
    assert!(options(&["--tls-terminated-by-proxy"]).unwrap().tls_terminated_by_proxy);
    assert!(options(&["--insecure=true"]).unwrap().insecure);
    assert!(options(&["--insecure=false"]).is_err());
}

#[test]
fn certificates_of_flags_take_the_place_of_the_file() {
    let (_guard, path) = file(
        "worker_token = \"sixteen-or-more-letters\"\n[tls]\ncertificate = \"a\"\nkey = \"b\"\n",
    );
    let mut args = vec!["--config", &path, "--tls-certificate", "c", "--tls-key", "d"];
    args.extend(["--listen-workers-tls", "127.0.0.1:0", "--worker-tls-certificate", "e"]);
    args.extend(["--worker-tls-key", "f", "--worker-tls-ca", "g"]);
    let set = options(&args).unwrap();
    let tls = set.tls.unwrap();
    assert_eq!([tls.certificate, tls.key], ["c", "d"].map(PathBuf::from));
    let workers = set.worker_tls.unwrap();
    assert_eq!([workers.certificate, workers.key], ["e", "f"].map(PathBuf::from));
    assert_eq!((workers.client_ca, workers.crl), (PathBuf::from("g"), None));
}

#[test]
fn faults_are_usage_and_name_the_option() {
    let (_guard, path) = file("lise_s = 1.0");
    let error = options(&["--config", &path]).unwrap_err();
    assert!(error.is::<Usage>() && error.to_string().contains("lise_s"), "{error}");
    let error = options(&["--worker-token", "short"]).unwrap_err();
    assert!(error.is::<Usage>() && error.to_string().contains("worker_token"), "{error}");
}

#[test]
fn a_wrong_url_is_not_repeated() {
    for flag in ["--database", "--objects"] {
        let error = options(&[flag, "mysql://user:secret@host"]).unwrap_err();
        assert!(error.is::<Usage>() && !error.to_string().contains("secret"), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn a_path_that_is_not_utf_8_is_refused_by_its_flag() {
    use std::os::unix::ffi::OsStringExt as _;
    let path = PathBuf::from(std::ffi::OsString::from_vec(b"caf\xe9".to_vec()));
    let given = Server { worker_tls_crl: Some(path), ..flags(&[]) };
    let error = given.options().unwrap_err();
    assert!(error.is::<Usage>(), "{error}");
    let text = error.to_string();
    assert!(text.contains("--worker-tls-crl") && text.contains("caf"), "{text}");
}

/// Reads the keys of a map in their order.
struct Keys;

impl<'de> Visitor<'de> for Keys {
    type Value = Vec<String>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
        let mut keys = Vec::new();
        while let Some((key, IgnoredAny)) = map.next_entry()? {
            keys.push(key);
        }
        Ok(keys)
    }
}

/// Keys of the flags in the file, in the order of the flags.
fn keys() -> Vec<String> {
    let json = serde_json::to_string(&flags(&[])).unwrap();
    serde_json::Deserializer::from_str(&json).deserialize_map(Keys).unwrap()
}

#[test]
fn every_flag_sets_a_key_of_the_file() {
    for key in keys() {
        let mut table = Table::new();
        put(&mut table, &key, Value::Boolean(true));
        let read = table.try_into::<Options>().map_err(|e| e.to_string());
        assert!(!read.is_err_and(|fault| fault.contains("unknown field")), "{key}");
    }
}

/// A table of options as documents have it, with what the last column says of each.
fn described(command: &Command, last: impl Fn(&clap::Arg) -> String) -> String {
    let cell = |text: String| if text.is_empty() { text } else { format!(" {text}") };
    let row = |arg: &clap::Arg| {
        let env = arg.get_env().map(|env| format!("`{}`", env.display())).unwrap_or_default();
        let flag = arg.get_long()?;
        Some(format!("| `--{flag}` |{} |{} |\n", cell(env), cell(last(arg))))
    };
    command.get_arguments().filter_map(row).collect()
}

fn document(name: &str) -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/run");
    std::fs::read_to_string(root.join(name)).unwrap()
}

#[test]
fn documents_have_every_option() {
    let server = Server::augment_args(Command::new("server"));
    let keys = keys();
    let with_key: Vec<&clap::Arg> = server
        .get_arguments()
        .filter(|a| !["config", "port_file", "exit_with_parent"].contains(&a.get_id().as_str()))
        .collect();
    assert_eq!(with_key.len(), keys.len());
    let key = |arg: &clap::Arg| {
        let place = with_key.iter().position(|a| a.get_id() == arg.get_id());
        place.map(|place| format!("`{}`", keys[place])).unwrap_or_default()
    };
    let table = described(&server, key);
    assert!(document("server.md").contains(&table), "docs/run/server.md:\n{table}");
    let worker = Worker::augment_args(Command::new("worker"));
    let default = |arg: &clap::Arg| {
        let values = arg.get_default_values().iter().map(|v| v.display().to_string());
        let takes = arg.get_action().takes_values();
        values.filter(|_| takes).collect::<Vec<_>>().join(", ")
    };
    let table = described(&worker, default);
    assert!(document("workers.md").contains(&table), "docs/run/workers.md:\n{table}");
}
