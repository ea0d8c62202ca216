use bendtwin_core::views::Label;
use bendtwin_splat::Cpu;

use super::*;
use crate::testing::{Ball, motion_of};

/// Pixels that a camera would see are as good as they can be, and worse where the twin goes astray.
#[test]
fn a_rendering_equals_itself_and_no_other() {
    let ball = Ball::new(3);
    let dressed = Dressed::new(&ball.twin.graph, &ball.splats).unwrap();
    let motion = motion_of(&ball.nodes, 2);
    let scene = Scene { dressed: &dressed, motion, views: &ball.views, held_out: &[1] };
    let scored = score(&scene, &mut Cpu::default(), true, &mut || true).unwrap().unwrap();
    let [train, future] = [scored.train, scored.future];
    // Masks cut the soft rim off.
    assert!(train.iou.unwrap() > 0.99 && future.iou.unwrap() > 0.99, "{train:?}");
    assert!(train.psnr_db.unwrap() > 29.0 && train.ssim.unwrap() > 0.94, "{train:?}");
    assert!(train.flip.unwrap() < 0.03, "{train:?}");
    assert_eq!(scored.cameras.iter().map(|c| c.held_out).collect::<Vec<_>>(), [false, true]);
    assert_eq!(scored.per_frame.len(), 3);
    // The last frame is predicted 3 cm beside where it was.
    let mut astray = ball.nodes.clone();
    let count = ball.twin.graph.node_count();
    astray[2 * count..].iter_mut().for_each(|p| p[0] += 0.03);
    let scene = Scene { motion: motion_of(&astray, 2), ..scene };
    let scored = score(&scene, &mut Cpu::default(), false, &mut || true).unwrap().unwrap();
    assert_eq!(scored.train, train);
    assert!(scored.future.iou.unwrap() < 0.7, "{:?}", scored.future);
    assert!(scored.future.psnr_db.unwrap() < future.psnr_db.unwrap() - 6.0);
    assert_eq!(score(&scene, &mut Cpu::default(), false, &mut || false).unwrap(), None);
}

#[test]
fn pixels_of_a_hand_do_not_count() {
    let mut ball = Ball::new(1);
    let dressed = Dressed::new(&ball.twin.graph, &ball.splats).unwrap();
    for camera in &mut ball.views.cameras {
        for view in &mut camera.views {
            let half = view.labels.len() / 2;
            view.labels[..half].fill(Label::Hand);
            view.colors[..half].fill([9, 200, 9]);
        }
    }
    let motion = motion_of(&ball.nodes, 1);
    let scene = Scene { dressed: &dressed, motion, views: &ball.views, held_out: &[] };
    let scored = score(&scene, &mut Cpu::default(), false, &mut || true).unwrap().unwrap();
    assert!(scored.train.iou.unwrap() > 0.99 && scored.train.psnr_db.unwrap() > 29.0);
    assert_eq!(scored.future, Likeness::default());
}
