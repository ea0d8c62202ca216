use super::*;

fn report() -> Identifiability {
    let region = Region { name: "free end".into(), center: [0.0; 3], nodes: 2 };
    let group = |quantity, region, hand| Group {
        quantity,
        region,
        hand,
        prior_sd: 0.7,
        relative_sd: 0.5,
        certainty: Certainty::of(0.5),
    };
    Identifiability {
        regions: vec![region],
        groups: vec![
            group(Quantity::Stiffness, Some(0), None),
            group(Quantity::Grip, None, Some(0)),
            group(Quantity::Drag, None, None),
        ],
        node_regions: vec![0, 0],
        point_sd_m: vec![0.001; 3],
        ..Identifiability::default()
    }
}

#[test]
fn groups_are_named_by_where_they_are() {
    let mut of = report();
    let names = |of: &Identifiability| of.groups.iter().map(|g| of.name(g)).collect::<Vec<_>>();
    assert_eq!(names(&of), ["stiffness, free end", "grip of the hand", "drag"]);
    let second = Group { hand: Some(1), ..of.groups[1].clone() };
    of.groups.push(second);
    assert_eq!(names(&of)[1..], ["grip of hand 1", "drag", "grip of hand 2"]);
}

#[test]
fn contradictions_are_found() {
    assert_eq!(report().check(2, 3), Ok(()));
    assert_eq!(Identifiability::default().check(2, 3), Ok(()));
    type Break = fn(&mut Identifiability);
    let breaks: [(Break, &str); 6] = [
        (|r| r.node_regions.push(0), "regions of nodes"),
        (|r| r.point_sd_m.push(0.0), "deviations of skin points"),
        (|r| r.node_regions[1] = 1, "in region 1"),
        (|r| r.groups[0].region = Some(3), "region 3"),
        (|r| r.point_sd_m[1] = f32::NAN, "NaN"),
        (
            |r| {
                r.motions.push(MotionUncertainty {
                    motion: "hang".into(),
                    sd_m: 0.0,
                    prior_sd_m: 0.0,
                    shares: vec![0.0],
                });
            },
            "shares",
        ),
    ];
    for (spoil, reported) in breaks {
        let mut of = report();
        spoil(&mut of);
        let fault = of.check(2, 3).unwrap_err();
        assert!(fault.contains(reported), "{fault}");
    }
}

#[test]
fn a_table_in_json_has_no_arrays_of_points() {
    let json = serde_json::to_string(&report()).unwrap();
    assert!(!json.contains("point_sd") && !json.contains("node_regions"), "{json}");
    let read: Identifiability = serde_json::from_str(&json).unwrap();
    let bare = Identifiability { node_regions: Vec::new(), point_sd_m: Vec::new(), ..report() };
    assert_eq!(read, bare);
}
