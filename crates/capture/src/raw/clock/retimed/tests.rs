use super::*;

fn clocks(rates: &[f64], offsets: &[i64]) -> Option<(f64, Vec<Clock>)> {
    Clock::of(rates, offsets).unwrap()
}

#[test]
fn cameras_of_one_rate_without_offsets_need_no_clock() {
    assert_eq!(clocks(&[30.0; 3], &[0; 3]), None);
    let (fps, found) = clocks(&[30.0, 15.0, 30.0], &[0, 3, -1]).unwrap();
    assert_eq!(fps, 30.0);
    assert_eq!(found[1], Clock { frames_per_image: 2.0, offset: 3 });
    assert_eq!((found[1].frame(0), found[1].frame(5), found[2].frame(0)), (3, 13, -1));
}

#[test]
fn rates_and_offsets_that_no_camera_has_are_refused() {
    for rate in [0.0, -30.0, f64::NAN, f64::INFINITY, 1e-9] {
        assert!(Clock::of(&[30.0, rate], &[0, 0]).is_err(), "{rate}");
    }
    assert!(Clock::of(&[30.0; 2], &[0, i64::MIN + 1]).is_err());
}

#[test]
fn the_shared_frames_are_those_of_all_cameras() {
    let whole = Clock { frames_per_image: 1.0, offset: 0 }.by_frame(10, 10);
    let half = Clock { frames_per_image: 2.0, offset: 3 }.by_frame(3, 10);
    assert_eq!(half[3..8], [Some(0), None, Some(1), None, Some(2)]);
    assert_eq!(shared(&vec![whole.clone(), half]).unwrap(), 3..8);
    assert!(shared(&vec![whole, vec![None; 10]]).is_err());
    // A rate that is no whole share of the recording's.
    let odd = Clock { frames_per_image: 2.4, offset: 0 }.by_frame(4, 9);
    let frames: Vec<usize> = (0..9).filter(|f| odd[*f].is_some()).collect();
    assert_eq!(frames, [0, 2, 5, 7]);
}

#[derive(Debug)]
struct Numbered;

impl Source for Numbered {
    fn frames(&self, _: usize) -> Result<Box<dyn Frames + '_>, Error> {
        Ok(Box::new(Self))
    }

    fn color_stem(&self, camera: usize, frame: usize) -> Option<String> {
        Some(format!("{camera}_{frame}"))
    }
}

impl Frames for Numbered {
    fn color(&mut self, frame: usize) -> Result<Option<ColorImage>, Error> {
        Ok(Some(ColorImage::filled(1, 1, [frame as u8; 3])))
    }
    fn depth(&mut self, frame: usize) -> Result<Option<DepthImage>, Error> {
        Ok(Some(DepthImage::filled(1, 1, frame as f32)))
    }
    fn mask(&mut self, _: usize, _: Region) -> Result<Option<Mask>, Error> {
        Ok(None)
    }
    fn tracks(&mut self) -> Result<Option<Tracks>, Error> {
        let points = vec![[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]];
        Ok(Some(Tracks { count: 1, points, visible: vec![true, true, false] }))
    }
}

#[test]
fn images_and_tracks_go_to_their_frames() {
    let images = vec![vec![Some(2), None, Some(1), Some(7)]];
    let limits = Limits { recording_frames: 10, ..Limits::default() };
    let source = Retimed::new(Arc::new(Numbered), images, &limits).unwrap();
    let mut frames = source.frames(0).unwrap();
    assert_eq!(frames.color(0).unwrap().unwrap().pixels, [[2; 3]]);
    assert!(frames.color(1).unwrap().is_none() && frames.depth(9).unwrap().is_none());
    assert_eq!(frames.depth(2).unwrap().unwrap().pixels, [1.0]);
    let tracks = frames.tracks().unwrap().unwrap();
    assert_eq!((tracks.points[0], tracks.points[2]), ([4.0, 5.0], [2.0, 3.0]));
    assert_eq!(tracks.visible, [false, false, true, false]);
    assert_eq!(source.color_stem(0, 2).as_deref(), Some("0_1"));
    assert_eq!([(0, 1), (0, 9), (1, 0)].map(|(c, f)| source.color_stem(c, f)), [None, None, None]);
    assert!(source.frames(1).is_err());
    assert!(Retimed::new(Arc::new(Numbered), vec![vec![None; 11]], &limits).is_err());
    let tight = Limits { total_bytes: 20, ..limits };
    let source = Retimed::new(Arc::new(Numbered), vec![vec![None; 5]], &tight).unwrap();
    assert!(source.frames(0).unwrap().tracks().is_err());
}
