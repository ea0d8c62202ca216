use super::*;

fn sorted(labels: &[&str], chosen: &[&str]) -> Result<Labels, String> {
    let all = labels.iter().map(|label| (*label).to_owned()).collect();
    let chosen: Vec<String> = chosen.iter().map(|label| (*label).to_owned()).collect();
    Labels::sort(&all, &chosen).map_err(|e| e.to_string())
}

#[test]
fn hands_people_and_robots_are_known_by_whole_words() {
    for label in [
        "hand",
        "Left_Hand",
        "hand 2",
        "gripper2",
        "person",
        "human",
        "robot arm",
        "panda arm",
        "Franka Emika",
        "UR5",
        "ur5e",
        "xArm7",
        "kinova gen3",
        "black glove",
        "left hand of person",
        "finger tips",
        "controller",
        "end effector",
        "hand (left)",
    ] {
        assert_eq!(meaning(label), Meaning::Manipulator, "{label}");
    }
    for label in ["toy", "handkerchief", "stuffed animal", "sloth", "armadillo", "humanoid", "rope"]
    {
        assert_eq!(meaning(label), Meaning::Object, "{label}");
    }
    for label in ["hand towel", "toy robot", "panda bear", "finger puppet", "person holding a rope"]
    {
        assert_eq!(meaning(label), Meaning::Unclear, "{label}");
    }
}

#[test]
fn what_is_unclear_is_refused_with_the_labels_and_the_setting() {
    for (labels, fault) in [
        (&["hand towel", "hand"][..], "`hand towel` may be the object or what moves it"),
        (&["panda", "hand"], "none the object"),
        (&["sloth", "rig"], "none of them is known as a hand"),
    ] {
        let text = sorted(labels, &[]).unwrap_err();
        let names = labels.iter().all(|label| text.contains(&format!("`{label}`")));
        assert!(names && text.contains(fault) && text.contains("\"object_labels\""), "{text}");
    }
}

#[test]
fn chosen_labels_override_known_words() {
    let labels = sorted(&["panda", "hand", "sleeve"], &["Panda "]).unwrap();
    assert_eq!(labels.region("panda"), Region::Object);
    assert_eq!(labels.region("hand"), Region::Manipulator);
    assert_eq!(labels.region("sleeve"), Region::Manipulator);
    assert!(
        sorted(&["panda"], &["bear"]).unwrap_err().contains("`bear`, which is not one of them")
    );
}

#[test]
fn a_single_label_is_the_object() {
    let labels = sorted(&["sloth"], &[]).unwrap();
    assert!(labels.note().unwrap().message.contains("`sloth`, and no mask shows what moves it"));
    assert!(sorted(&[], &[]).unwrap().note().is_none());
}
