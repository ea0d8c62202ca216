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
fn wrong_usage_is_refused() {
    for line in [
        "bendtwin-lab",
        "bendtwin-lab suite s.json",
        "bendtwin-lab suite s.json --out o --jobs 0",
        "bendtwin-lab bench n1",
        "bendtwin-lab bench --batches 0",
        "bendtwin-lab bench --seconds nan",
        "bendtwin-lab bench --passes 3",
        "bendtwin-lab bench store",
        "bendtwin-lab corrections a.zip --at 3",
        "bendtwin-lab corrections a.zip --twin a.twin",
    ] {
        assert!(parse(line).is_err(), "{line}");
    }
}

/// Every command in the documents exists, with all options that are written there.
#[test]
fn commands_in_documents_exist() {
    let (count, wrong) = bendtwin_documents_kit::compare("cargo lab", Arguments::command());
    assert!(count > 30, "only {count} commands were found");
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
