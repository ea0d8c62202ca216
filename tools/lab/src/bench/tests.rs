use clap::Parser as _;

use super::*;

#[derive(Debug, clap::Parser)]
struct Line {
    #[command(flatten)]
    bench: Bench,
}

fn parse(line: &str) -> Bench {
    Line::try_parse_from(line.split_whitespace()).unwrap().bench
}

#[test]
fn nothing_named_means_everything_but_fits() {
    let plan = parse("bench").plan();
    assert_eq!(plan.scenes.len(), 10);
    assert_eq!(plan.batches, [1, 100, 132, 1000]);
    assert_eq!(plan.windows, plan.batches);
    assert!(plan.fits.is_empty());
}

#[test]
fn quick_is_small_but_what_is_said_holds() {
    let plan = parse("bench --quick --fit frame,pass,cut --passes 7").plan();
    assert_eq!(plan.scenes.len(), 4);
    assert!(plan.measurement < Duration::from_secs(1));
    let fits: Vec<_> = plan.fits.iter().map(|f| (f.scheme, f.generations, f.passes)).collect();
    assert_eq!(fits, [Scheme::Frame, Scheme::Pass, Scheme::Cut].map(|scheme| (scheme, 2, 7)));
}

#[test]
fn a_whole_fit_is_counted_as_phystwin_does() {
    let plan = parse("bench n2000 --bending without --fit frame").plan();
    assert_eq!(plan.scenes, [(SceneName::N2000, false)]);
    assert_eq!(plan.fits, [FitPlan::phystwin(Scheme::Frame)]);
}

/// The command from end to end, with its tables.
#[test]
fn a_tiny_run_has_a_row_for_every_measurement() {
    let line = "bench rope --batches 1,2 --windows 1 --horizon 1 --seconds 0 --quick --fit pass \
                --generations 1 --passes 1 --frames 2";
    let (report, result) =
        measure(&parse(line).plan(), &bendtwin_engine::cpu(), &CancelToken::default(), true);
    result.unwrap();
    let text = tables::report(&report);
    let rows = text.lines().filter(|l| l.starts_with("| rope"));
    // Sizes, two batches, one window and a fit, each without and with bending.
    assert_eq!(rows.count(), 10, "{text}");
    assert!(
        text.contains("Issue bound") && text.contains("432") && !text.contains("NaN"),
        "{text}"
    );
}

#[test]
fn a_cancelled_run_still_reports() {
    let cancel = CancelToken::default();
    cancel.cancel();
    let plan = parse("bench rope --quick").plan();
    let (report, result) = measure(&plan, &bendtwin_engine::cpu(), &cancel, true);
    assert!(result.is_err() && report.scenes.is_empty());
    assert!(tables::report(&report).contains("cpu"));
}
