//! The positions of a rollout as a file: of all instances as .npy, of one in a format of another
//! program.

use std::{
    path::{Path, PathBuf},
    str::FromStr,
};

use bendtwin_capture::npy::Floats;
use bendtwin_client::{Client, Reply, Rollout, TwinId};
use bendtwin_exchange::{Error, Format, Motion};
use clap::Args;

use super::npy;
use crate::{
    failure::{self, Usage},
    twin::exchange::{self, Points},
};

#[derive(Debug, Args)]
pub(super) struct RecordingOptions {
    /// Write the recorded positions to this file; its extension sets the format: .npy (all
    /// instances, [R, frames, points, 3]), .zip (PLY), .glb, .npz, .usda, .xml (MuJoCo), .mcap
    /// (docs/formats/exchange.md)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write this format, regardless of the file's name: npy, ply-sequence, glb, npz, usda, mujoco
    /// or mcap
    #[arg(long, requires = "out")]
    format: Option<RecordingFormat>,
    /// Instance to write, of several; formats except npy hold one [default: the only one]
    #[arg(long, value_name = "I", requires = "out")]
    instance: Option<usize>,
    #[command(flatten)]
    points: Points,
}

/// A format of recorded positions.
#[derive(Clone, Copy, Debug)]
enum RecordingFormat {
    /// All instances as one array.
    Npy,
    /// A single instance.
    Of(Format),
}

impl FromStr for RecordingFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("npy") {
            return Ok(Self::Npy);
        }
        text.parse().map(Self::Of).map_err(|e| format!("{e}, and npy"))
    }
}

/// A file that is to hold recorded positions.
#[derive(Debug)]
pub(super) struct Recording {
    path: PathBuf,
    format: RecordingFormat,
    instance: Option<usize>,
    points: Points,
}

impl Recording {
    /// The requested file; at most `best` instances are returned. A file that cannot be written is
    /// refused before anything is computed.
    pub(super) fn of(
        options: RecordingOptions,
        instances: usize,
        best: Option<u32>,
    ) -> anyhow::Result<Option<Self>> {
        let RecordingOptions { out, format, instance, points } = options;
        let Some(path) = out else {
            if points != Points::default() {
                let fault = "--nodes, --skin, --surface and --mesh say what to write: name a file with --out";
                return Err(Usage::error(fault));
            }
            return Ok(None);
        };
        let is_npy = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npy"));
        let format = match format {
            Some(format) => format,
            None if is_npy => RecordingFormat::Npy,
            None => RecordingFormat::Of(exchange::format_of(&path)?),
        };
        match format {
            RecordingFormat::Npy
                if instance.is_some() || points.surface || points.mesh.is_some() =>
            {
                let fault = "npy holds the nodes or the skin of all instances: omit --instance, --surface and --mesh";
                return Err(Usage::error(fault));
            }
            RecordingFormat::Of(format) if !format.holds_motion() => {
                return Err(failure::failed(Error::NoMotion { format }));
            }
            RecordingFormat::Of(format)
                if instance.is_none() && instances > 1 && best != Some(1) =>
            {
                return Err(Usage::error(format!(
                    "there are {instances} instances, and {format} holds one: choose it with \
                     --instance, take --best 1, or write all of them as .npy"
                )));
            }
            RecordingFormat::Of(format) if format == Format::Mujoco && points.are_others() => {
                return Err(failure::failed(Error::NodesOnly { format }));
            }
            _ => {}
        }
        if let Some(instance) = instance.filter(|i| *i >= instances) {
            let fault = format!("there is no instance {instance} of {instances}, counted from 0");
            return Err(Usage::error(fault));
        }
        Ok(Some(Self { path, format, instance, points }))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Asks for what the file needs of a rollout whose positions are recorded.
    pub(super) fn ask(&self, request: Rollout) -> Rollout {
        match self.format {
            RecordingFormat::Npy if self.points.skin => request.record_skin(),
            RecordingFormat::Npy => request,
            // A skin or a mesh is made of the nodes here.
            RecordingFormat::Of(_) => request.executed_controls(),
        }
    }

    /// Writes the file.
    pub(super) async fn write(
        &self,
        client: &Client,
        twin: TwinId,
        reply: &Reply,
    ) -> anyhow::Result<()> {
        let RecordingFormat::Of(format) = self.format else {
            return npy::write(&self.path, &all(reply));
        };
        let row = match self.instance {
            None => 0,
            Some(instance) => {
                let row = reply.instances.iter().position(|i| *i == instance);
                row.ok_or_else(|| {
                    Usage::error(format!(
                        "instance {instance} is not among the best that were kept"
                    ))
                })?
            }
        };
        let name = twin.to_string();
        let twin = client.twins().download(twin).await?;
        let motion = motion(reply, row, twin.graph.control_count(), twin.timing.fps);
        self.points.write(&name, &twin, Some(&motion), format, &self.path)
    }
}

/// Positions of all instances.
fn all(reply: &Reply) -> Floats {
    let (rows, frames) = (reply.instances.len(), reply.frames.len());
    let points = reply.positions.len().checked_div(rows * frames).unwrap_or(0);
    Floats { shape: vec![rows, frames, points, 3], values: reply.positions.as_flattened().to_vec() }
}

/// The motion of one row of the recorded instances.
fn motion(reply: &Reply, row: usize, control_count: usize, fps: f64) -> Motion {
    let nodes = |f| reply.recorded(row, f).unwrap_or_default();
    let boundaries = reply.controls.len().checked_div(reply.instances.len() * control_count);
    let controls = |frame: &usize| {
        let start = (row * boundaries.unwrap_or(0) + frame) * control_count;
        reply.controls.get(start..start + control_count).unwrap_or_default()
    };
    Motion {
        times_s: reply.frames.iter().map(|f| *f as f64 / fps).collect(),
        nodes: (0..reply.frames.len()).flat_map(nodes).copied().collect(),
        controls: reply.frames.iter().flat_map(controls).copied().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(out: &str) -> RecordingOptions {
        let points = Points::default();
        RecordingOptions { out: Some(out.into()), format: None, instance: None, points }
    }

    #[test]
    fn what_cannot_be_written_is_refused_before_anything_is_computed() {
        let refused = |options, instances, best| {
            Recording::of(options, instances, best).unwrap_err().to_string()
        };
        assert!(refused(options("a.obj"), 1, None).contains(".glb"));
        assert!(refused(options("a.twin"), 1, None).contains("no motion"));
        assert!(refused(options("a.ply"), 1, None).contains(".zip"));
        assert!(refused(options("a.glb"), 2, None).contains("--instance"));
        let beyond = RecordingOptions { instance: Some(2), ..options("a.glb") };
        assert!(refused(beyond, 2, None).contains("no instance 2"));
        let one = RecordingOptions { instance: Some(0), ..options("a.npy") };
        assert!(refused(one, 2, None).contains("all instances"));
        for (out, instances, best) in
            [("a.npy", 4, None), ("a.glb", 1, None), ("a.glb", 4, Some(1))]
        {
            assert!(Recording::of(options(out), instances, best).unwrap().is_some(), "{out}");
        }
        let said =
            RecordingOptions { format: Some(RecordingFormat::Of(Format::Npz)), ..options("a.b") };
        assert!(Recording::of(said, 1, None).unwrap().is_some());
    }

    #[test]
    fn a_motion_is_one_row_of_the_reply() {
        let point = |x: usize| [x as f32, 0.0, 0.0];
        let reply = Reply {
            instances: vec![4, 7],
            frames: vec![2, 4],
            positions: (0..2 * 2 * 3).map(point).collect(),
            controls: (0..2 * 5 * 2).map(|x| point(100 + x)).collect(),
            ..Reply::default()
        };
        let motion = motion(&reply, 1, 2, 10.0);
        assert_eq!(motion.times_s, [0.2, 0.4]);
        assert_eq!(motion.nodes, (6..12).map(point).collect::<Vec<_>>());
        assert_eq!(motion.controls, [114, 115, 118, 119].map(point));
    }
}
