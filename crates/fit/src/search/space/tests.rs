use bendtwin_core::{FitSettings, settings::DeviceKind};
use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;

#[test]
fn damping_is_drawn_to_where_the_search_starts_and_stiffness_is_not() {
    let capture = make(Scene::Rope, &MakeOptions::tiny(1)).unwrap();
    let task = Task::new(
        &capture,
        &FitSettings::default(),
        DeviceKind::Cpu,
        &bendtwin_core::CancelToken::default(),
    )
    .unwrap();
    let space = Space::new(&task, &task.settings);
    let start = space.start();
    assert_eq!(space.penalty(&start, 0.4), 1.0);
    let decade_off = |variable: Variable| {
        let at = space.axes.iter().position(|a| a.variable == variable).unwrap();
        let axis = &space.axes[at];
        let mut point = start.clone();
        point[at] -= 1.0 / (axis.high / axis.low).log10();
        space.penalty(&point, 0.4)
    };
    assert_eq!(decade_off(Variable::Stiffness), 1.0);
    for variable in [Variable::Dashpot, Variable::Drag, Variable::BendStiffness] {
        assert!((decade_off(variable) - 1.4).abs() < 1e-9, "{variable}");
    }
    let at = space.axes.iter().position(|a| a.variable == Variable::GroundRestitution).unwrap();
    assert_eq!(space.axes[at].start, SOFT_RESTITUTION);
    let mut point = start.clone();
    point[at] += RESTITUTION_DECADE;
    assert!((space.penalty(&point, 0.4) - 1.4).abs() < 1e-9, "{}", space.penalty(&point, 0.4));
}
