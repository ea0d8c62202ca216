use bendtwin_synth::{MakeOptions, Scene, make};

use super::*;
use crate::{
    Verdict, inspect, inspect_observed,
    testing::{filmed, healthy},
};

fn inspected() -> Inspection {
    let (mut scene, mut recording) = healthy();
    scene.moments[1][9] = None;
    recording.name = "<script>alert('1')</script> & \"toy\"".to_owned();
    recording.cameras[0].name = "<b>front</b>".to_owned();
    inspect(&filmed(scene, recording), &Default::default(), &Default::default(), &mut |_| {})
        .unwrap()
}

/// Every element that is opened is closed, in order; nothing is loaded from elsewhere; no script.
#[track_caller]
fn assert_well_formed(html: &str) {
    const VOID: [&str; 3] = ["meta", "img", "!DOCTYPE"];
    let mut open = Vec::new();
    for part in html.split('<').skip(1) {
        let (tag, _) = part.split_once('>').expect("every `<` opens a tag");
        let name = tag.split([' ', '/']).find(|n| !n.is_empty()).unwrap_or_default();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "closing {closed}");
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
    }
    assert!(open.is_empty(), "{open:?}");
    for foreign in ["<script", "http://", "https://", "<link", "<iframe", " onload", "url("] {
        assert!(!html.contains(foreign), "{foreign}");
    }
}

#[test]
fn the_page_is_well_formed_and_escaped() {
    let html = Report::new(inspected(), None).to_html();
    assert_well_formed(&html);
    assert!(html.contains("&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt; &amp; &quot;toy&quot;"));
    assert!(html.contains("&lt;b&gt;front&lt;/b&gt;"));
    assert!(html.contains("FRAMES_DROPPED") && html.contains("class=\"missing\""));
    // Points over time, three of agreement, three of coverage.
    assert_eq!(html.matches("data:image/png;base64,").count(), 7);
}

#[test]
fn the_document_reads_back() {
    let report = Report::new(inspected(), None);
    let text = report.to_json();
    let again = Report::from_json(&text).unwrap();
    assert_eq!(again.to_json(), text);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["format"], FORMAT);
    assert_eq!(document["verdict"], "usable");
    assert_eq!(document["cameras"][1]["missing_frames"][0], 9);
    assert_eq!(document["findings"][0]["code"], "FRAMES_DROPPED");
    assert!(document["first_step"].as_str().unwrap().contains("disk"));
    let newer = text.replacen("\"version\": 1", "\"version\": 2", 1);
    assert!(Report::from_json(&newer).unwrap_err().to_string().contains("version 2"));
}

#[test]
fn an_observed_capture_has_points_and_a_graph() {
    let capture = make(Scene::Toy, &MakeOptions::tiny(1)).unwrap();
    let seen = inspect_observed(&capture);
    assert_eq!(seen.kind, crate::Kind::Observed);
    assert_eq!(seen.observed.as_ref().unwrap().point_count, capture.object.point_count);
    assert!(seen.scene.gap_m.iter().flatten().all(|gap| *gap < 0.1));
    let html = Report::new(seen, None).to_html();
    assert_well_formed(&html);
    assert_eq!(html.matches("data:image/png;base64,").count(), 2);
}

#[test]
fn what_was_lifted_is_judged_and_shown() {
    let mut capture = make(Scene::Toy, &MakeOptions::tiny(1)).unwrap();
    capture.sequences[0].train_frame_count = 1;
    let evidence = serde_json::json!({
        "cameras": [{"name": "<i>a</i>", "lifts": {"object": 12, "off_mask": 3}}],
        "findings": [{"severity": "warning", "code": "FEW_CONTROLS", "message": "few: add some"}],
    });
    let (_, recording) = healthy();
    let seen = inspect(&recording, &Default::default(), &Default::default(), &mut |_| {}).unwrap();
    let report = Report::new(seen, Some(Lifted { capture, evidence: Some(evidence.clone()) }));
    assert_eq!(report.inspection().verdict, Verdict::Unusable);
    assert!(report.inspection().has("SPLIT_EMPTY") && report.inspection().has("FEW_CONTROLS"));
    let html = report.to_html();
    assert_well_formed(&html);
    assert!(html.contains("Lifts: off mask") && html.contains("&lt;i&gt;a&lt;/i&gt;"));
    assert_eq!(Report::from_json(&report.to_json()).unwrap().evidence(), Some(&evidence));
}

#[test]
fn broken_captures_have_a_report_too() {
    let mut capture = make(Scene::Toy, &MakeOptions::tiny(1)).unwrap();
    capture.sequences[0].points.pop();
    let seen = inspect_observed(&capture);
    assert_eq!(seen.verdict, Verdict::Unusable);
    assert_well_formed(&Report::new(seen, None).to_html());
}

#[test]
fn nothing_of_one_recording_follows_from_another() {
    let of = |finding: Finding| {
        let mut inspection = Inspection::unread("one");
        inspection.add([finding]);
        Report::new(inspection, None)
    };
    let mut report = of(Finding::warning("DEPTH_SPARSE", "much has no depth"));
    report.add_recording("two", &of(Finding::error("DEPTH_MISALIGNED", "depth is elsewhere")));
    let codes: Vec<&str> = report.inspection().findings.iter().map(|f| f.code.as_str()).collect();
    assert_eq!(codes, ["DEPTH_MISALIGNED", "DEPTH_SPARSE"]);
    assert_eq!(report.inspection().verdict, Verdict::Unusable);
}

#[test]
fn what_was_read_and_left_out_is_listed() {
    let mut seen = inspected();
    seen.sources.take("depth", Some("<b>"), "/cam0/depth", "16UC1");
    seen.sources.leave_out("/cam0/ir", "infrared");
    let report = Report::new(seen, None);
    let html = report.to_html();
    assert_well_formed(&html);
    assert!(html.contains("&lt;b&gt;") && html.contains("/cam0/ir"), "{html}");
    let document: serde_json::Value = serde_json::from_str(&report.to_json()).unwrap();
    assert_eq!(document["sources"]["left_out"][0]["from"], "/cam0/ir");
}

#[test]
fn a_crowd_is_drawn_in_part() {
    let mut capture = make(Scene::Rope, &MakeOptions::tiny(3)).unwrap();
    let drawn = |capture: &bendtwin_core::Capture| -> usize {
        let html = Report::new(inspect_observed(capture), None).to_html();
        let (before, _) = html.split_once(" nodes (teal").unwrap();
        before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()
    };
    let few = drawn(&capture);
    assert!((10..6_000).contains(&few), "{few}");
    let place = |i: usize| [i % 100, i / 100 % 100, i / 10_000].map(|k| 0.001 * k as f32);
    capture.object.interior = (0..100_000).map(place).collect();
    let many = drawn(&capture);
    assert!((3_000..=6_000).contains(&many), "{many}");
}
