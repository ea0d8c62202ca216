//! `bendtwin capture make`.

use std::path::{Path, PathBuf};

use bendtwin_capture::raw;
use bendtwin_synth::{FilmOptions, MakeOptions, Scene, Shape, Substance, film, make};
use clap::Args;
use serde_json::json;

use crate::{
    failure::{self, Usage},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(crate) struct Make {
    /// Scene to simulate: rope, bar, thick_bar, toy, ring or cable
    #[arg(value_parser = scene)]
    scene: Scene,
    /// ZIP archive to write [default: {scene}.zip, or {scene}_raw.zip]
    file: Option<PathBuf>,
    /// Seed of noise, occlusion and motion
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of frames [default: that of the scene]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    frames: usize,
    /// Use a coarse version of a few dozen points
    #[arg(long)]
    tiny: bool,
    /// Recording of the scene's body: 0 is the usual one, others hold and move the body elsewhere
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "raw")]
    take: u32,
    /// Material of the body: foam, plush, rubber or cord
    #[arg(long, default_value = "foam", value_parser = substance, conflicts_with = "raw")]
    material: Substance,
    /// Film the scene: images, depth, masks and 2D tracks of three cameras (two small ones with
    /// --tiny). Writes a PhysTwin case, or a BendTwin bundle if the name ends with .zip
    #[arg(long)]
    raw: bool,
    /// With --raw, leave out the mesh of the body
    #[arg(long, requires = "raw")]
    no_mesh: bool,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

fn scene(name: &str) -> Result<Scene, String> {
    Scene::from_name(name).ok_or_else(|| {
        let names = Scene::ALL.map(Scene::name).join(", ");
        format!("there is no scene `{name}`: take one of {names}")
    })
}

fn substance(name: &str) -> Result<Substance, String> {
    Substance::from_name(name).ok_or_else(|| {
        let names = Substance::ALL.map(Substance::name).join(", ");
        format!("there is no material `{name}`: take one of {names}")
    })
}

pub(super) async fn run(args: Make, global: &Global) -> anyhow::Result<()> {
    if args.raw {
        return run_raw(args, global).await;
    }
    if args.take > 0 && args.scene == Scene::Cable {
        return Err(Usage::error("a cable has several sequences in one capture: leave out --take"));
    }
    if args.material != Substance::Foam && args.scene == Scene::Cable {
        return Err(Usage::error("the material of a cable is fixed: leave out --material"));
    }
    let named = || format!("{}.zip", args.scene.name()).into();
    let path = args.file.clone().unwrap_or_else(named);
    expect_free(&path, args.force)?;
    let Make { seed, frames, tiny, take, material, .. } = args;
    let options = MakeOptions { seed, frames, tiny, take, material };
    let capture = write(args.scene, options, &path).await?;
    let sequence = capture.sequences.first();
    let frames = sequence.map_or(0, |s| s.frame_count);
    let controls = sequence.map_or(0, bendtwin_core::Sequence::control_count);
    let summary = json!({
        "path": path,
        "points": capture.object.point_count,
        "sequences": capture.sequences.len(),
        "frames": frames,
        "control_points": controls,
    });
    output::print(global, &summary, || {
        format!(
            "{}: {} points over {frames} frames, moved by {controls} control points\n\
             next: bendtwin capture push {}",
            path.display(),
            capture.object.point_count,
            path.display()
        )
    })
}

/// Refuses to overwrite an existing file, unless forced.
fn expect_free(path: &Path, force: bool) -> anyhow::Result<()> {
    let is_free = match std::fs::read_dir(path) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !path.exists(),
    };
    if is_free || force {
        return Ok(());
    }
    let at = path.display();
    Err(Usage::error(format!("{at} exists: give another name, or replace it with --force")))
}

/// Simulates and films a scene.
async fn run_raw(args: Make, global: &Global) -> anyhow::Result<()> {
    let path = args.file.unwrap_or_else(|| format!("{}_raw.zip", args.scene.name()).into());
    expect_free(&path, args.force)?;
    let base = if args.tiny { FilmOptions::tiny(args.seed) } else { FilmOptions::full(args.seed) };
    let shape = if args.no_mesh { Shape::Absent } else { base.shape };
    let options = FilmOptions { frames: args.frames, shape, ..base };
    let target = path.clone();
    let made = tokio::task::spawn_blocking(move || {
        let recording = film(args.scene, &options)?;
        match target.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("zip") => {
                raw::write_bundle(&recording, &target)?;
            }
            _ => raw::write_case(&recording, &target)?,
        }
        Ok::<_, bendtwin_synth::Error>(recording)
    });
    let recording = made.await?.map_err(failure::failed)?;
    let (cameras, frames) = (recording.cameras.len(), recording.frame_count);
    let summary = json!({"path": path, "cameras": cameras, "frames": frames});
    output::print(global, &summary, || {
        format!(
            "{0}: {cameras} cameras, {frames} frames\nnext: bendtwin capture push {0}",
            path.display()
        )
    })
}

/// Simulates a scene and writes it as a bundle.
pub(crate) async fn write(
    scene: Scene,
    options: MakeOptions,
    path: &Path,
) -> anyhow::Result<bendtwin_core::Capture> {
    let path = path.to_owned();
    let made = tokio::task::spawn_blocking(move || {
        let capture = make(scene, &options)?;
        bendtwin_capture::write_bundle_file(&capture, &path)?;
        Ok::<_, bendtwin_synth::Error>(capture)
    });
    made.await?.map_err(failure::failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_written_over_unless_that_is_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let (file, inner) = (folder.path().join("rope.zip"), folder.path().join("toy"));
        assert!(expect_free(&file, false).is_ok());
        std::fs::write(&file, "mine").unwrap();
        std::fs::create_dir(&inner).unwrap();
        assert!(expect_free(&inner, false).is_ok(), "an empty folder has nothing to lose");
        std::fs::write(inner.join("metadata.json"), "mine").unwrap();
        for path in [&file, &inner] {
            assert!(expect_free(path, false).is_err_and(|e| e.is::<Usage>()));
            assert!(expect_free(path, true).is_ok());
        }
    }
}
