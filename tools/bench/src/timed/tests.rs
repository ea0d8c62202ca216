/// Names of the methods that the text of a trait or of its implementation has.
fn methods(text: &str, from: &str) -> Vec<String> {
    let block = text.split(from).nth(1).and_then(|rest| rest.split("\n}").next()).unwrap();
    let lines = block.lines().filter_map(|line| line.strip_prefix("    fn "));
    lines.map(|line| line.split(['(', '<']).next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn every_method_of_a_backend_is_passed_on() {
    let wanted = methods(
        include_str!("../../../../crates/engine/src/backend.rs"),
        "pub trait Backend: Send + Sync {",
    );
    assert!(wanted.len() >= 6, "{wanted:?}");
    assert_eq!(methods(include_str!("../timed.rs"), "impl Backend for TimedBackend {"), wanted);
}

#[test]
fn every_method_of_an_optimizer_is_passed_on() {
    let wanted = methods(
        include_str!("../../../../crates/engine/src/optimizer.rs"),
        "pub trait Optimizer: Send {",
    );
    assert!(wanted.len() >= 4, "{wanted:?}");
    assert_eq!(
        methods(include_str!("optimizer.rs"), "impl Optimizer for TimedOptimizer {"),
        wanted
    );
}
