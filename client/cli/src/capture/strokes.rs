//! Clicks in the images of a recording, as options of commands: `--object 0:120,88`.

use std::str::FromStr;

use bendtwin_core::settings::ingest::{Part, Stroke};
use clap::Args;

/// Clicks from which masks are made.
#[derive(Debug, Default, Args)]
pub(super) struct StrokeArgs {
    /// Mark the object with a click: camera, column and row in frame 0 (`0:120,88`), or in another
    /// frame (`0@12:120,88`). One in one camera is enough; repeat it for more
    #[arg(long, value_name = "CAMERA:X,Y")]
    object: Vec<Click>,
    /// Mark a hand or gripper in the same way
    #[arg(long, value_name = "CAMERA:X,Y")]
    hand: Vec<Click>,
    /// Mark what was taken for object or hand by mistake
    #[arg(long, value_name = "CAMERA:X,Y")]
    background: Vec<Click>,
}

impl StrokeArgs {
    /// The clicks as strokes.
    pub(super) fn strokes(&self) -> impl Iterator<Item = Stroke> {
        let parts = [
            (Part::Object, &self.object),
            (Part::Hand, &self.hand),
            (Part::Background, &self.background),
        ];
        parts.into_iter().flat_map(|(part, clicks)| {
            clicks.iter().map(move |click| {
                let Click { camera, frame, x, y } = *click;
                Stroke { frame, ..Stroke::click(part, camera, x, y) }
            })
        })
    }
}

/// Camera, frame and pixel of a click as text: `CAMERA[@FRAME]:X,Y`. A camera's name may have colons.
pub(super) fn parse(text: &str) -> Option<(&str, &str, [f64; 2])> {
    let (image, pixel) = text.rsplit_once(':')?;
    let (camera, frame) = image.rsplit_once('@').unwrap_or((image, "0"));
    let (x, y) = pixel.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    Some((camera, frame, [number(x)?, number(y)?]))
}

/// A pixel of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Click {
    camera: u32,
    frame: u32,
    x: f64,
    y: f64,
}

impl FromStr for Click {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (camera, frame, [x, y]) = parse(text)?;
            let index = |text: &str| text.trim().parse().ok();
            Some(Self { camera: index(camera)?, frame: index(frame)?, x, y })
        };
        read().ok_or_else(|| {
            "write CAMERA:X,Y or CAMERA@FRAME:X,Y, for example 0:120,88: cameras, frames, columns and \
             rows are counted from 0"
                .to_owned()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_click_names_its_image_and_its_pixel() {
        let click = |camera, frame, x, y| Ok(Click { camera, frame, x, y });
        assert_eq!("0:120,88".parse(), click(0, 0, 120.0, 88.0));
        assert_eq!("2@30:0.5, 7".parse(), click(2, 30, 0.5, 7.0));
        for wrong in ["", "120,88", "0:120", "0:a,1", "-1:2,3", "0@x:1,2", "0:nan,1", "0@-1:1,2"] {
            let fault = wrong.parse::<Click>().unwrap_err();
            assert!(fault.contains("0:120,88"), "{wrong}: {fault}");
        }
    }

    #[test]
    fn clicks_are_strokes_of_their_parts() {
        let args = StrokeArgs {
            object: vec!["0:1,2".parse().unwrap(), "1:3,4".parse().unwrap()],
            hand: vec!["0@5:6,7".parse().unwrap()],
            background: Vec::new(),
        };
        let strokes: Vec<_> = args.strokes().collect();
        let parts: Vec<_> = strokes.iter().map(|s| (s.part, s.camera, s.frame)).collect();
        assert_eq!(parts, [(Part::Object, 0, 0), (Part::Object, 1, 0), (Part::Hand, 0, 5)]);
        assert_eq!(strokes[2].points, [[6.0, 7.0]]);
    }
}
