//! `bendtwin twin import`: a twin file, or a fit by PhysTwin, to the server or to a twin file.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context as _;
use bendtwin_capture::{
    Limits,
    phystwin::results::{SearchResult, TrainResult},
};
use bendtwin_core::Twin;
use bendtwin_exchange::{Format, of_phystwin};
use clap::Args;
use serde_json::json;

use super::exchange::Points;
use crate::{
    failure::{self, Usage},
    global::Global,
    output,
};

#[derive(Debug, Args)]
pub(super) struct Import {
    /// The twin file to read
    #[arg(required_unless_present = "phystwin", conflicts_with = "phystwin")]
    file: Option<PathBuf>,
    /// Read a case that PhysTwin has fitted: the folder or archive with final_data.pkl. Its results
    /// are searched beside it and in PhysTwin's usual folders
    #[arg(long, value_name = "CASE")]
    phystwin: Option<PathBuf>,
    /// PhysTwin's optimal_params.pkl [default: in CASE or experiments_optimization/CASE]
    #[arg(long, value_name = "FILE", requires = "phystwin")]
    params: Option<PathBuf>,
    /// PhysTwin's best_*.pth [default: in CASE, CASE/train or experiments/CASE/train]
    #[arg(long, value_name = "FILE", requires = "phystwin")]
    checkpoint: Option<PathBuf>,
    /// Import the result of PhysTwin's search, without the springs of its training
    #[arg(long, requires = "phystwin", conflicts_with = "checkpoint")]
    search_only: bool,
    /// Write a twin file instead of storing it on the server
    #[arg(long, value_name = "FILE", requires = "phystwin")]
    out: Option<PathBuf>,
    /// Display name [default: that of the file or case]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
}

pub(super) async fn run(args: Import, global: &Global) -> anyhow::Result<()> {
    let (content, default_name) = match (&args.file, &args.phystwin) {
        (_, Some(case)) => {
            let twin = read_case(&args, case)?;
            if let Some(path) = &args.out {
                Points::default().write("", &twin, None, Format::Twin, path)?;
                return print_written(global, &twin, path);
            }
            (twin.encode().map_err(failure::failed)?, twin.provenance.capture_name)
        }
        (Some(file), None) => (read(file)?, super::stem(file)),
        (None, None) => return Err(Usage::error("name a twin file, or a case with --phystwin")),
    };
    let name = args.name.unwrap_or(default_name);
    let twin = global.connect().await?.twins().import(content, &name).await?;
    output::print(global, &twin, || twin.name.to_string())
}

fn print_written(global: &Global, twin: &Twin, path: &Path) -> anyhow::Result<()> {
    let (nodes, springs) = (twin.graph.node_count(), twin.graph.springs.len());
    let written = json!({ "path": path, "nodes": nodes, "springs": springs });
    output::print(global, &written, || {
        format!("{} ({nodes} nodes, {springs} springs)", path.display())
    })
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

fn read_case(args: &Import, case: &Path) -> anyhow::Result<Twin> {
    let limits = Limits::default();
    let results = Results::of(case);
    let params = match &args.params {
        Some(path) => path.clone(),
        None => results.params().ok_or_else(|| {
            Usage::error(format!(
                "there is no optimal_params.pkl in {}: name it with --params",
                results.searched()
            ))
        })?,
    };
    let checkpoint = match &args.checkpoint {
        Some(path) => Some(path.clone()),
        None if args.search_only => None,
        None => Some(results.checkpoint()?),
    };
    let capture = bendtwin_capture::read(case, &limits).map_err(failure::failed)?;
    let search = SearchResult::decode(&params.to_string_lossy(), &read(&params)?, &limits);
    let search = search.map_err(failure::failed)?;
    let train = checkpoint
        .map(|path| {
            let bytes = read(&path)?;
            TrainResult::decode(&path.to_string_lossy(), &bytes, &limits).map_err(failure::failed)
        })
        .transpose()?;
    of_phystwin(&capture, &search, train.as_ref()).map_err(failure::failed)
}

/// The folders where results of a case may lie: the case's own, and those of PhysTwin's, which has
/// cases in `data/different_types/CASE` and results in `experiments*/CASE`.
struct Results {
    folders: Vec<PathBuf>,
}

impl Results {
    fn of(case: &Path) -> Self {
        let case = case.canonicalize().unwrap_or_else(|_| case.to_owned());
        let own = if case.is_dir() { Some(case.as_path()) } else { case.parent() };
        let name = case.file_stem().unwrap_or_default();
        let mut folders: Vec<PathBuf> =
            own.iter().flat_map(|f| [f.to_path_buf(), f.join("train")]).collect();
        for root in case.ancestors().skip(1).take(3) {
            folders.push(root.join("experiments_optimization").join(name));
            folders.push(root.join("experiments").join(name).join("train"));
        }
        Self { folders }
    }

    fn params(&self) -> Option<PathBuf> {
        self.folders.iter().map(|f| f.join("optimal_params.pkl")).find(|path| path.is_file())
    }

    /// The one checkpoint of the first folder that has any.
    fn checkpoint(&self) -> anyhow::Result<PathBuf> {
        for folder in &self.folders {
            let mut found: Vec<PathBuf> = fs::read_dir(folder)
                .into_iter()
                .flatten()
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|path| is_checkpoint(path))
                .collect();
            found.sort_unstable();
            match found.as_slice() {
                [] => {}
                [one] => return Ok(one.clone()),
                several => {
                    return Err(Usage::error(format!(
                        "{} has {} files best_*.pth: name one with --checkpoint",
                        folder.display(),
                        several.len()
                    )));
                }
            }
        }
        Err(Usage::error(format!(
            "there is no best_*.pth in {}: name it with --checkpoint, or take the search alone with \
             --search-only",
            self.searched()
        )))
    }

    fn searched(&self) -> String {
        let names: Vec<_> = self.folders.iter().map(|f| f.display().to_string()).collect();
        names.join(", ")
    }
}

fn is_checkpoint(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("best_") && name.ends_with(".pth")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_found_where_phystwin_leaves_them() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().canonicalize().unwrap().join(name);
        let write = |name: &str| {
            fs::create_dir_all(at(name).parent().unwrap()).unwrap();
            fs::write(at(name), "").unwrap();
        };
        write("data/different_types/toy/final_data.pkl");
        let case = at("data/different_types/toy");
        let error = Results::of(&case).checkpoint().unwrap_err().to_string();
        assert!(
            error.contains("--search-only") && error.contains("experiments/toy/train"),
            "{error}"
        );
        assert!(Results::of(&case).params().is_none());
        write("experiments_optimization/toy/optimal_params.pkl");
        write("experiments/toy/train/best_7.pth");
        write("experiments/toy/train/iter_9.pth");
        write("experiments/other/train/best_8.pth");
        let results = Results::of(&case);
        assert_eq!(results.params(), Some(at("experiments_optimization/toy/optimal_params.pkl")));
        assert_eq!(results.checkpoint().unwrap(), at("experiments/toy/train/best_7.pth"));
        // Beside the case they come first.
        write("data/different_types/toy/best_1.pth");
        assert_eq!(Results::of(&case).checkpoint().unwrap(), case.join("best_1.pth"));
        write("data/different_types/toy/best_2.pth");
        assert!(Results::of(&case).checkpoint().unwrap_err().to_string().contains("--checkpoint"));
    }
}
