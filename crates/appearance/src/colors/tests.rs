use super::*;
use crate::testing::{Ball, motion_of};

fn off(a: [u8; 3], b: [u8; 3]) -> i32 {
    a.iter().zip(b).map(|(a, b)| (i32::from(*a) - i32::from(b)).abs()).max().unwrap()
}

#[test]
fn points_that_a_camera_sees_get_their_colours() {
    let ball = Ball::new(2);
    let rest = ball.twin.skin.positions(&ball.twin.graph.rest_positions);
    let motion = motion_of(&ball.nodes, 2);
    let colors = skin_colors(&ball.twin, &motion, &ball.views, &[]).unwrap();
    // Towards the camera in front, at -y, and the one beside, at +x.
    let faces = |p: &Point| p[1] < -0.035 || p[0] > 0.035;
    let seen: Vec<usize> = (0..rest.len()).filter(|p| faces(&rest[*p])).collect();
    assert!(seen.len() > 50);
    let worst = seen.iter().map(|p| off(colors[*p], ball.colors[*p])).max();
    assert!(worst < Some(30), "{worst:?}");
}

#[test]
fn held_out_cameras_are_not_used() {
    let ball = Ball::new(1);
    let rest = ball.twin.skin.positions(&ball.twin.graph.rest_positions);
    let motion = motion_of(&ball.nodes, 1);
    let colors = skin_colors(&ball.twin, &motion, &ball.views, &[1]).unwrap();
    let beside = (0..rest.len()).max_by(|a, b| rest[*a][0].total_cmp(&rest[*b][0])).unwrap();
    assert!(off(colors[beside], ball.colors[beside]) > 5, "it has the nearest seen one's");
    let nothing = skin_colors(&ball.twin, &motion, &ball.views, &[0, 1]);
    assert_eq!(nothing, Err(Error::NoViews));
}

#[test]
fn what_lies_behind_gets_nothing_from_the_camera_in_front() {
    let mut ball = Ball::new(1);
    ball.views.cameras.truncate(1);
    for view in &mut ball.views.cameras[0].views {
        // Depth is not known: the skin itself says what is hidden.
        view.depths_mm.fill(0);
    }
    let rest = ball.twin.skin.positions(&ball.twin.graph.rest_positions);
    let camera = &ball.views.cameras[0];
    let seen = SkinView::new(camera, &camera.views[0], &rest, &spacings(&rest));
    for p in rest.iter().filter(|p| p[1] > 0.02) {
        assert!(seen.sample(*p, [0.0, 1.0, 0.0]).is_none(), "{p:?} is at the back");
    }
    let front = rest.iter().filter(|p| p[1] < -0.04);
    assert!(front.filter(|p| seen.sample(**p, [0.0, 1.0, 0.0]).is_some()).count() > 20);
}
