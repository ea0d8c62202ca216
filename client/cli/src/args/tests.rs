use clap::CommandFactory as _;

use super::*;

fn parse(line: &str) -> Result<Arguments, clap::Error> {
    Arguments::try_parse_from(line.split_whitespace())
}

#[test]
fn the_definition_is_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn what_the_readme_shows_parses() {
    let id = "0199aaaa-0000-7000-8000-000000000001";
    for line in [
        "bendtwin demo --keep out --out p.png --seed 3".to_owned(),
        "bendtwin server --listen 127.0.0.1:0 --data-dir d --workers 2".to_owned(),
        "bendtwin worker --server http://127.0.0.1:7070 --token 0123456789abcdef".to_owned(),
        "bendtwin capture make rope rope.zip".to_owned(),
        "bendtwin capture check rope.zip --json".to_owned(),
        "bendtwin capture push rope.zip --server http://127.0.0.1:1".to_owned(),
        format!("bendtwin fit start captures/{id} --watch --set graph.max_nodes=9 --axial"),
        format!("bendtwin fit start {id} --priority -5"),
        format!("bendtwin fit cancel fits/{id}"),
        format!("bendtwin twin export twins/{id} a.safetensors"),
        format!("bendtwin rollout twins/{id} --shift -0.1,0,0.2 --out p.npy"),
        "bendtwin eval a b.zip --axial --json".to_owned(),
        "bendtwin eval a --twin t.safetensors --picture p.png".to_owned(),
        "bendtwin bench --twin t.safetensors --sizes 1x1,48x15 --out b.json".to_owned(),
        "bendtwin store check --data-dir d --sizes --json".to_owned(),
        "bendtwin store repair".to_owned(),
        "bendtwin store backup copy --data-dir d".to_owned(),
        "bendtwin healthcheck --listen 0.0.0.0:7070 --without workers,disk".to_owned(),
        "bendtwin healthcheck worker --worker-listen 0.0.0.0:7072".to_owned(),
    ] {
        if let Err(error) = parse(&line) {
            panic!("{line}: {error}");
        }
    }
}

#[test]
fn wrong_usage_is_refused() {
    for line in [
        "bendtwin",
        "bendtwin capture make spaghetti",
        "bendtwin twin show twins/none",
        "bendtwin fit cancel",
        "bendtwin eval",
        "bendtwin eval a --twin t --axial",
        "bendtwin rollout twins/none",
        "bendtwin bench",
        "bendtwin store backup",
        "bendtwin bench --twin t --sizes 0x1",
        "bendtwin bench --twin t --seconds nan",
        "bendtwin rollout 0199aaaa-0000-7000-8000-000000000001 --frames 9999999",
    ] {
        assert!(parse(line).is_err(), "{line}");
    }
}

/// Every command in the documents exists, with all options that are written there.
#[test]
fn commands_in_documents_exist() {
    let (count, wrong) = bendtwin_documents_kit::compare("bendtwin", Arguments::command());
    assert!(count > 150, "only {count} commands were found");
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
