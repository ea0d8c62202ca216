use tracing::Level;
use tracing_subscriber::filter::LevelFilter;

use super::filter;

#[test]
fn targets_have_levels_of_their_own() {
    let targets = filter(Some("warn,audit=info,bendtwin_worker=debug"), LevelFilter::INFO);
    assert!(targets.would_enable("audit", &Level::INFO));
    assert!(targets.would_enable("bendtwin_worker::leasing", &Level::DEBUG));
    assert!(targets.would_enable("hyper", &Level::WARN));
    assert!(!targets.would_enable("hyper", &Level::INFO));
    assert!(!filter(Some("off"), LevelFilter::INFO).would_enable("hyper", &Level::ERROR));
}

#[test]
fn the_standard_level_counts_without_a_filter_that_can_be_read() {
    for asked in [None, Some("audit=loud")] {
        let targets = filter(asked, LevelFilter::WARN);
        assert!(targets.would_enable("hyper", &Level::WARN));
        assert!(!targets.would_enable("hyper", &Level::INFO));
    }
}
