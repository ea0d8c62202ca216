use super::*;
use crate::{
    Appearance, FastVariant, Identifiability, Splats,
    settings::MOST_MEMBERS,
    twin::{Member, identifiability::Region},
};

use proptest::prelude::*;

fn twin() -> Twin {
    let graph = Graph {
        rest_positions: vec![[0.0, 0.0, 0.1], [0.1, 0.0, 0.1], [0.2, 0.0, 0.1]],
        kinds: vec![NodeKind::Observed, NodeKind::Completed, NodeKind::Interior],
        masses: vec![1.0; 3],
        object_ids: vec![0; 3],
        observed_points: vec![0, Graph::NOT_OBSERVED, Graph::NOT_OBSERVED],
        control_rest: vec![[0.3, 0.0, 0.1]],
        springs: vec![[0, 1], [1, 2], [2, 3]],
        triplets: vec![[0, 1, 2]],
        pins: vec![Pin { node: 2, control: 0, offset_m: [-0.1, 0.0, 0.0] }],
        rods: Vec::new(),
    };
    Twin::new(
        graph,
        Params {
            spring_stiffness: vec![1e3, 2e3, 3e3],
            spring_dashpot: vec![1.0; 3],
            rest_lengths_m: vec![0.1; 3],
            bend_stiffness: vec![0.5],
            bend_damping: vec![0.01],
            rest_angles_rad: vec![std::f32::consts::PI],
            drag: 1.0,
            ..Params::default()
        },
        Timing { fps: 30.0, substeps: 50 },
    )
}

#[test]
fn a_twin_survives_its_file() {
    let bytes = twin().encode().unwrap();
    assert_eq!(Twin::decode(&bytes).unwrap(), twin());
    assert_eq!(bytes, twin().encode().unwrap(), "encoding is deterministic");
}

#[test]
fn frame_rates_of_no_camera_are_refused() {
    for fps in [1e-300, 1e300, 0.0, -30.0, f64::NAN, f64::INFINITY] {
        let twin = Twin { timing: Timing { fps, substeps: 50 }, ..twin() };
        assert!(twin.check().is_err(), "{fps}");
    }
}

/// Written by the first release; must be readable for ever. To add one for a new version, write
/// `encode()` of one that needs it to `testdata/twin-v{VERSION}.safetensors` and keep the old ones.
#[test]
fn released_files_stay_readable() {
    let first = include_bytes!("../../../testdata/twin-v1.safetensors");
    assert_eq!(Twin::decode(first).unwrap(), twin());
    let second = include_bytes!("../../../testdata/twin-v2.safetensors");
    assert_eq!(Twin::decode(second).unwrap(), cable());
}

#[test]
fn mass_and_hands_survive_their_file_and_are_checked() {
    let known = Twin { mass_kg: Some(0.25), control_hands: vec![1], ..twin() };
    assert_eq!(Twin::decode(&known.encode().unwrap()).unwrap(), known);
    for mass in [0.0, -1.0, f64::NAN, 1e9] {
        let wrong = Twin { mass_kg: Some(mass), ..twin() };
        assert!(wrong.encode().unwrap_err().to_string().contains("mass"), "{mass}");
    }
    let wrong = Twin { control_hands: vec![0, 0], ..twin() };
    assert!(wrong.encode().unwrap_err().to_string().contains("2 hands for 1"));
}

/// A twin with rods and two members: one of other numbers, one of other springs.
fn with_members() -> Twin {
    let mut twin = cable();
    twin.graph.springs = vec![[0, 1], [1, 2], [2, 3]];
    twin.graph.triplets = vec![[0, 1, 2]];
    let Params { spring_stiffness, spring_dashpot, rest_lengths_m, .. } = self::twin().params;
    let Params { bend_stiffness, bend_damping, rest_angles_rad, .. } = self::twin().params;
    twin.params = Params {
        spring_stiffness,
        spring_dashpot,
        rest_lengths_m,
        bend_stiffness,
        bend_damping,
        rest_angles_rad,
        ..twin.params
    };
    let first = Twin {
        params: Params { drag: 2.0, spring_stiffness: vec![9.0; 3], ..twin.params.clone() },
        environment: Environment { gravity: [0.0, 0.0, -9.0], ..twin.environment },
        ..twin.clone()
    };
    let params = Params {
        spring_stiffness: vec![5.0],
        spring_dashpot: vec![6.0],
        rest_lengths_m: vec![0.3],
        bend_stiffness: Vec::new(),
        bend_damping: Vec::new(),
        rest_angles_rad: Vec::new(),
        rest_twists_rad: vec![0.7, 0.8],
        ..twin.params.clone()
    };
    let graph = Graph { springs: vec![[0, 2]], triplets: Vec::new(), ..twin.graph.clone() };
    let timing = Timing { substeps: 7, ..twin.timing };
    let second = Twin { graph, params, timing, ..twin.clone() };
    let members = [first, second].iter().map(|fit| Member::of(fit, &twin).unwrap()).collect();
    Twin { members, ..twin }
}

#[test]
fn members_survive_their_file() {
    let twin = with_members();
    let bytes = twin.encode().unwrap();
    assert_eq!(Twin::decode(&bytes).unwrap(), twin);
    let fourth = include_bytes!("../../../testdata/twin-v4.safetensors");
    assert_eq!(Twin::decode(fourth).unwrap(), twin);
}

#[test]
fn losses_of_fits_survive_their_file_and_are_checked() {
    let mut known = with_members();
    known.provenance.loss = Some(1.5e-4);
    for (member, loss) in known.members.iter_mut().zip([Some(0.0), Some(2e-4)]) {
        member.loss = loss;
    }
    assert_eq!(Twin::decode(&known.encode().unwrap()).unwrap(), known);
    assert!(!String::from_utf8_lossy(&with_members().encode().unwrap()).contains("loss"));
    for loss in [-1.0, f64::NAN, f64::INFINITY] {
        let mut wrong = known.clone();
        wrong.members[1].loss = Some(loss);
        let fault = wrong.encode().unwrap_err().to_string();
        assert!(fault.contains("member 2") && fault.contains("loss"), "{loss}: {fault}");
        wrong = Twin {
            provenance: Provenance { loss: Some(loss), ..wrong.provenance },
            ..known.clone()
        };
        assert!(wrong.encode().unwrap_err().to_string().contains("loss"), "{loss}");
    }
}

#[test]
fn members_are_checked_as_twins_are() {
    let refusal = |change: fn(&mut Member)| {
        let mut twin = with_members();
        change(&mut twin.members[1]);
        twin.encode().unwrap_err().to_string()
    };
    assert!(refusal(|m| m.springs.push([0, 99])).contains("member 2"));
    assert!(refusal(|m| m.params.rest_twists_rad.clear()).contains("member 2"));
    assert!(refusal(|m| m.substeps = 0).contains("0 substeps"));
    assert!(refusal(|m| m.environment.gravity[0] = f32::NAN).contains("member 2"));
    let mut many = with_members();
    many.members = vec![many.members[0].clone(); MOST_MEMBERS + 1];
    assert!(many.encode().unwrap_err().to_string().contains("16 members"));
}

#[test]
fn a_fit_of_other_nodes_is_no_member() {
    let (twin, cable) = (twin(), cable());
    assert_eq!(Member::of(&twin, &cable), None);
    let moved =
        Graph { rest_positions: vec![[0.5; 3]; cable.graph.node_count()], ..cable.graph.clone() };
    assert_eq!(Member::of(&Twin { graph: moved, ..cable.clone() }, &cable), None);
    let faster = Timing { fps: 60.0, ..cable.timing };
    assert_eq!(Member::of(&Twin { timing: faster, ..cable.clone() }, &cable), None);
}

#[test]
fn tensors_of_members_that_contradict_their_counts_are_refused() {
    let changed = |name: &str, change: fn(&mut Vec<u8>)| {
        let bytes = with_members().encode().unwrap();
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        let file = SafeTensors::deserialize(&bytes).unwrap();
        let tensors: Vec<_> = file
            .tensors()
            .into_iter()
            .map(|(own, view)| {
                let mut data = view.data().to_vec();
                if own == name {
                    change(&mut data);
                }
                let raw =
                    Raw { dtype: view.dtype(), shape: view.shape().to_vec(), bytes: data.into() };
                (own, raw)
            })
            .collect();
        let bytes = safetensors::serialize(tensors, header.metadata().clone()).unwrap();
        Twin::decode(&bytes).unwrap_err().to_string()
    };
    // Counts of more rows than there are, with any sum.
    let most = |data: &mut Vec<u8>| data.fill(0xff);
    assert!(changed("members.springs.count", most).contains("members.springs.ends"));
    assert!(changed("members.triplets.count", most).contains("members.triplets.ends"));
    assert!(changed("members.springs.stiffness", most).contains("member 1"));
}

/// A twin with two rods between clamps.
fn cable() -> Twin {
    let mut twin = twin();
    let n = 9;
    twin.graph = Graph {
        rest_positions: (0..n).map(|i| [0.1 * i as f32, 0.0, 0.1]).collect(),
        kinds: vec![NodeKind::Observed; n],
        masses: vec![1.0; n],
        object_ids: vec![0; n],
        observed_points: (0..n as u32).collect(),
        control_rest: vec![[0.0; 3]],
        pins: [0, 1, 3, 4, 7, 8].map(|node| Pin { node, control: 0, offset_m: [0.0; 3] }).to_vec(),
        rods: vec![vec![0, 1, 2, 3, 4], vec![4, 3, 5, 6, 7, 8]],
        ..Graph::default()
    };
    twin.skin = Skin::of_nodes(&twin.graph);
    twin.params = Params {
        twist_stiffness: vec![0.1, 0.2],
        twist_damping: vec![0.01, 0.02],
        rest_twists_rad: vec![-7.0, 0.5],
        ..Params::default()
    };
    twin
}

/// A twin with a skin finer than its nodes.
fn skinned() -> Twin {
    let mut twin = twin();
    twin.skin = Skin::default();
    twin.skin.push(4, &[(0, 0.25), (1, 0.75)], [Skin::NO_FRAME; 3], [0.0, 0.01, 0.0]);
    twin.skin.push(Graph::NOT_OBSERVED, &[(2, 1.0)], [0, 1, 2], [0.0, 0.0, 0.02]);
    twin
}

#[test]
fn a_skin_survives_its_file() {
    let bytes = skinned().encode().unwrap();
    assert_eq!(Twin::decode(&bytes).unwrap(), skinned());
    assert!(String::from_utf8_lossy(&bytes).contains("{\\\"version\\\":3,"));
}

#[test]
fn a_skin_that_contradicts_itself_is_refused() {
    let bytes = skinned().encode().unwrap();
    let spoilt = [
        ("skin.weight_count", bytemuck::cast_slice(&[2_u32, 2]).to_vec()),
        ("skin.weight_count", bytemuck::cast_slice(&[u32::MAX, 4]).to_vec()),
        ("skin.weight_node", bytemuck::cast_slice(&[0_u32, 9, 2]).to_vec()),
        ("skin.weight", bytemuck::cast_slice(&[f32::NAN, 0.75, 1.0]).to_vec()),
        ("skin.frame", bytemuck::cast_slice(&[3_u32; 6]).to_vec()),
    ];
    for (name, data) in spoilt {
        let fault = Twin::decode(&replaced(&bytes, name, &data)).unwrap_err().to_string();
        assert!(fault.contains("skin"), "{name}: {fault}");
    }
}

/// A twin with colours and two Gaussians.
fn painted() -> Twin {
    let mut carriers = Skin::default();
    carriers.push(Graph::NOT_OBSERVED, &[(0, 0.25), (1, 0.75)], [Skin::NO_FRAME; 3], [0.0; 3]);
    carriers.push(Graph::NOT_OBSERVED, &[(2, 1.0)], [0, 1, 2], [0.0, 0.0, 0.02]);
    let splats = Splats {
        carriers,
        scales_m: vec![[0.01, 0.02, 0.03], [0.01; 3]],
        rotations: vec![[0.0, 0.0, 0.0, 1.0], [0.6, 0.0, 0.8, 0.0]],
        opacities: vec![0.0, 1.0],
        colors: vec![[0.5, 1.2, -0.1], [0.0; 3]],
    };
    let skin_colors = vec![[255, 0, 7], [1, 2, 3]];
    let appearance = Some(Appearance { skin_colors, splats: Some(splats) });
    Twin { appearance, ..skinned() }
}

#[test]
fn contact_of_the_skin_survives_its_file_with_an_appearance_and_without() {
    for mut twin in [skinned(), painted(), with_members()] {
        let before = twin.encode().unwrap();
        assert!(!String::from_utf8_lossy(&before).contains("skin\\\":"), "older programs read it");
        twin.params.contact.skin = true;
        let bytes = twin.encode().unwrap();
        assert_eq!(Twin::decode(&bytes).unwrap(), twin);
        assert!(String::from_utf8_lossy(&bytes).contains("{\\\"version\\\":6,"));
    }
    let mut twin = with_members();
    twin.members[0].params.contact.skin = true;
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
    assert_eq!(twin.version(), 6);
}

#[test]
fn an_appearance_survives_its_file_with_members_and_without() {
    let mut twin = painted();
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
    twin.appearance = Some(Appearance::default());
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
    let twin = Twin { appearance: Some(Appearance::default()), ..with_members() };
    assert!(!twin.members.is_empty());
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
}

#[test]
fn an_appearance_that_contradicts_itself_is_refused() {
    let bytes = painted().encode().unwrap();
    let spoilt = [
        ("splats.weight_count", bytemuck::cast_slice(&[u32::MAX, 4]).to_vec()),
        ("splats.weight_node", bytemuck::cast_slice(&[0_u32, 9, 2]).to_vec()),
        ("splats.scale", bytemuck::cast_slice(&[-1.0_f32; 6]).to_vec()),
        ("splats.scale", bytemuck::cast_slice(&[f32::INFINITY; 6]).to_vec()),
        ("splats.rotation", bytemuck::cast_slice(&[0.0_f32; 8]).to_vec()),
        ("splats.opacity", bytemuck::cast_slice(&[f32::NAN, 0.5]).to_vec()),
        ("splats.color", bytemuck::cast_slice(&[f32::NAN; 6]).to_vec()),
    ];
    for (name, data) in spoilt {
        let fault = Twin::decode(&replaced(&bytes, name, &data)).unwrap_err().to_string();
        assert!(fault.contains("Gaussian") || fault.contains("splats"), "{name}: {fault}");
    }
    let mut twin = painted();
    if let Some(appearance) = &mut twin.appearance {
        appearance.skin_colors.pop();
    }
    assert!(twin.encode().unwrap_err().to_string().contains("1 colours for 2 skin points"));
}

/// The file with the bytes of one tensor replaced.
fn replaced(bytes: &[u8], tensor: &str, data: &[u8]) -> Vec<u8> {
    let container = SafeTensors::deserialize(bytes).unwrap();
    let (_, header) = SafeTensors::read_metadata(bytes).unwrap();
    let tensors = container.tensors().into_iter().map(|(name, view)| {
        let own = if name == tensor { data } else { view.data() };
        let (dtype, shape) = (view.dtype(), view.shape().to_vec());
        (name, Raw { dtype, shape, bytes: Cow::Owned(own.to_vec()) })
    });
    safetensors::serialize(tensors, header.metadata().clone()).unwrap()
}

#[test]
fn rods_survive_their_file() {
    let bytes = cable().encode().unwrap();
    assert_eq!(Twin::decode(&bytes).unwrap(), cable());
    let version = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        [1, 2].map(|v| text.contains(&format!("{{\\\"version\\\":{v},")))
    };
    assert_eq!(version(&bytes), [false, true]);
    assert_eq!(version(&twin().encode().unwrap()), [true, false], "older programs read it");
}

#[test]
fn rods_of_impossible_lengths_are_refused() {
    let bytes = cable().encode().unwrap();
    for lengths in [[5_u32, 5], [5, 7], [u32::MAX, 6], [11, 0]] {
        let file = replaced(&bytes, "rods.lengths", bytemuck::cast_slice(&lengths));
        let fault = Twin::decode(&file).unwrap_err().to_string();
        assert!(fault.contains("rod"), "{lengths:?}: {fault}");
    }
}

#[test]
fn a_fast_variant_survives_its_file_and_is_checked() {
    let fast = FastVariant {
        substeps: 12,
        rate_limit: Some(0.25),
        mean_deviation_m: 4e-4,
        max_deviation_m: 3e-3,
        mean_travel_m: 0.1,
        frames: 30,
    };
    let mut twin = twin();
    twin.quality.fast = Some(fast);
    assert_eq!(Twin::decode(&twin.encode().unwrap()).unwrap(), twin);
    for bad in [
        FastVariant { substeps: 0, ..fast },
        FastVariant { rate_limit: Some(0.0), ..fast },
        FastVariant { mean_deviation_m: f64::NAN, ..fast },
    ] {
        twin.quality.fast = Some(bad);
        assert!(twin.encode().unwrap_err().to_string().contains("fast variant"));
    }
}

#[test]
fn an_identifiability_report_survives_its_file_and_is_checked() {
    let mut twin = twin();
    let version = twin.version();
    let (nodes, points) = (twin.graph.node_count(), twin.skin.len());
    let region = Region { name: "near the hand".into(), center: [0.1; 3], nodes: nodes as u32 };
    twin.quality.identifiability = Some(Identifiability {
        summary: vec!["Nothing is open.".into()],
        regions: vec![region],
        node_regions: vec![0; nodes],
        point_sd_m: (0..points).map(|i| 1e-3 * i as f32).collect(),
        ..Identifiability::default()
    });
    let file = twin.encode().unwrap();
    assert_eq!(Twin::decode(&file).unwrap(), twin);
    assert_eq!(twin.version(), version, "older programs read it too");
    let far = replaced(&file, "identifiability.node_region", &vec![7; nodes]);
    assert!(Twin::decode(&far).unwrap_err().to_string().contains("region 7 of 1"));
    let nan = vec![f32::NAN; points];
    let nan = replaced(&file, "identifiability.point_sd", bytemuck::cast_slice(&nan));
    assert!(Twin::decode(&nan).unwrap_err().to_string().contains("standard deviation"));
    if let Some(report) = &mut twin.quality.identifiability {
        report.point_sd_m.pop();
    }
    assert!(twin.encode().unwrap_err().to_string().contains("skin points"));
}

#[test]
fn contradictions_are_named() {
    let mut bad = twin();
    bad.graph.springs[1] = [1, 9];
    assert!(bad.encode().unwrap_err().to_string().contains("spring 1"));
    let mut bad = twin();
    bad.params.bend_stiffness[0] = f32::NAN;
    assert!(bad.encode().unwrap_err().to_string().contains("bend stiffness 0"));
}

proptest! {
    /// A damaged file never panics, and what it decodes to is consistent.
    #[test]
    fn damage_is_an_error_or_harmless(at in 0usize..4096, byte: u8, cut in 0usize..4096) {
        let mut bytes = twin().encode().unwrap();
        let at = at % bytes.len();
        bytes[at] = byte;
        bytes.truncate(bytes.len() - cut % 64);
        if let Ok(twin) = Twin::decode(&bytes) {
            prop_assert!(twin.check().is_ok());
        }
    }
}
