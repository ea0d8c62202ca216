//! The demo's steps and their texts.

use std::{path::PathBuf, time::Instant};

use anyhow::Context as _;
use bendtwin_client::{CaptureId, Cost, Fit, Rollout, TwinId, TwinModel};
use bendtwin_core::{CancelToken, Capture, FitSettings, Quality};
use bendtwin_eval::{EvaluateOptions, TableStyle, evaluate, format_table};
use bendtwin_synth::MakeOptions;
use serde_json::json;

use super::{
    candidates::{KNOTS, candidates, displacement},
    object::Object,
    server::{Connection, DemoServer},
    verdict,
};
use crate::{
    backend::BackendArgs,
    capture, failure, fit, output,
    quality::{self, picture},
};

/// Candidate actions of the batch.
const CANDIDATES: usize = 64;
/// Their horizon [frames].
const HORIZON: u32 = 30;

/// The demo under way.
pub(super) struct DemoRun {
    pub(super) quiet: bool,
    pub(super) seed: u64,
    pub(super) object: Object,
    pub(super) picture: PathBuf,
    folder: PathBuf,
    started: Instant,
    steps: u32,
    /// The document of `--json`, printed at the end.
    pub(super) report: serde_json::Map<String, serde_json::Value>,
    /// True once there is nothing to sum up.
    pub(super) is_told: bool,
}

/// The two fits of the same nodes.
struct FittedPair {
    bending: TwinModel,
    axial: TwinModel,
    name: TwinId,
}

impl DemoRun {
    pub(super) fn new(
        quiet: bool,
        seed: u64,
        object: Object,
        picture: PathBuf,
        folder: PathBuf,
    ) -> Self {
        let report = serde_json::Map::new();
        let (started, steps, is_told) = (Instant::now(), 0, false);
        Self { quiet, seed, object, picture, folder, started, steps, report, is_told }
    }

    /// Step 1: a server with a worker.
    pub(super) async fn start_server(
        &mut self,
        backend: &BackendArgs,
    ) -> anyhow::Result<DemoServer> {
        self.print("BendTwin turns a recording of a soft object into a physical twin and predicts");
        self.print(
            "what robot actions do to it. This is the whole system at work on this machine.",
        );
        self.step("Start a server; it starts its own worker process", "bendtwin server");
        let server = DemoServer::start(&self.folder, backend).await?;
        self.print(&format!("  it answers HTTP and gRPC at {}", server.connection.url));
        Ok(server)
    }

    /// Steps 2 to 7.
    pub(super) async fn run(&mut self, connection: &Connection) -> anyhow::Result<()> {
        let (observed, capture) = self.record(connection).await?;
        let pair = self.fit(connection, capture).await?;
        self.compare(&pair, &observed).await?;
        self.plan(connection, &pair, &observed).await?;
        self.draw(pair, observed).await
    }

    pub(super) async fn record(
        &mut self,
        connection: &Connection,
    ) -> anyhow::Result<(Capture, CaptureId)> {
        let file = format!("{}.zip", self.object.name());
        self.step(
            self.object.recording(),
            &format!("bendtwin capture make {} {file}", self.object.name()),
        );
        let path = self.folder.join(&file);
        let options = MakeOptions::full(self.seed);
        let observed = capture::make::write(self.object.scene(), options, &path).await?;
        self.print(&format!("  {}", Object::split(&observed)));
        self.step("Upload it over HTTP", &format!("bendtwin capture push {file}"));
        let facts = format!("demo {}", self.object.name()).as_str().into();
        let stored =
            capture::push::upload(&connection.client.captures(), &path, facts, self.quiet).await?;
        self.print(&format!("  {} ({})", stored.name, output::bytes(stored.size_bytes)));
        Ok((observed, stored.name))
    }

    async fn fit(
        &mut self,
        connection: &Connection,
        capture: CaptureId,
    ) -> anyhow::Result<FittedPair> {
        let settings = self.object.settings(self.seed);
        let bending = self.bending_fit(connection, capture).await?;
        self.step(
            "Fit the same nodes once more without bending, for comparison",
            &format!(
                "bendtwin fit start {capture} {} --set bending=false --watch",
                self.object.flags()
            ),
        );
        let without = FitSettings { bending: false, ..settings };
        let axial = self.one_fit(connection, capture, &without, "axial_fit_s").await?;
        let twins = connection.client.twins();
        let name = bending.twin.context("the fit has no twin")?;
        let axial = axial.twin.context("the fit has no twin")?;
        Ok(FittedPair {
            bending: twins.download(name).await?,
            axial: twins.download(axial).await?,
            name,
        })
    }

    /// The fit that all else is about.
    pub(super) async fn bending_fit(
        &mut self,
        connection: &Connection,
        capture: CaptureId,
    ) -> anyhow::Result<Fit> {
        self.step(
            &self.object.fitting(),
            &format!("bendtwin fit start {capture} {} --watch", self.object.flags()),
        );
        self.one_fit(connection, capture, &self.object.settings(self.seed), "fit_s").await
    }

    pub(super) async fn one_fit(
        &mut self,
        connection: &Connection,
        capture: CaptureId,
        settings: &FitSettings,
        key: &str,
    ) -> anyhow::Result<Fit> {
        let started = Instant::now();
        let job = connection.client.fits().create(capture, settings, 0).await?;
        let fit = fit::watch(&connection.client, job.name, self.quiet).await?;
        fit::ended_well(&fit)?;
        let took = started.elapsed().as_secs_f64();
        self.report.insert(key.to_owned(), json!(took));
        let twin = fit.twin.map(|t| t.to_string()).unwrap_or_default();
        self.print(&format!("  {twin} after {}", output::duration(took)));
        Ok(fit)
    }

    async fn compare(&mut self, pair: &FittedPair, observed: &Capture) -> anyhow::Result<()> {
        self.step(
            "How good is it? Errors in mm against what was recorded; `future` frames were never seen",
            &format!("bendtwin eval {}.zip --axial {}", self.object.name(), self.object.flags()),
        );
        let (twin, axial, observed) = (pair.bending.clone(), pair.axial.clone(), observed.clone());
        let scored = tokio::task::spawn_blocking(move || {
            let options = EvaluateOptions { axial: Some(&axial), per_frame: false };
            let backend = bendtwin_engine::cpu();
            evaluate(&*backend, &twin, &observed, &options, &CancelToken::default())
        });
        let quality: Quality = scored.await?.map_err(failure::failed)?;
        for line in format_table(&quality, TableStyle::Plain).lines() {
            self.print(&format!("  {line}"));
        }
        for paragraph in verdict::paragraphs(&quality).unwrap_or_default() {
            self.print("");
            paragraph.lines().for_each(|line| self.print(&format!("  {line}")));
        }
        let assessment = quality::of_twin(&pair.bending, &quality);
        self.print(&format!("\n  {assessment}"));
        self.report.insert("quality".to_owned(), serde_json::to_value(&quality)?);
        Ok(())
    }

    async fn plan(
        &mut self,
        connection: &Connection,
        pair: &FittedPair,
        observed: &Capture,
    ) -> anyhow::Result<()> {
        self.step(
            &format!(
                "Plan with it: {CANDIDATES} robot actions in one gRPC call, scored by where they bring the\n   {}",
                self.object.target()
            ),
            &format!("bendtwin rollout {} --actions actions.npy", pair.name),
        );
        // From the last frame that the fit saw: there the twin has moved, as in a planner's loop.
        let sequence = observed.sequences.first().context("the capture is empty")?;
        let now = sequence.train_frame_count.saturating_sub(1).max(sequence.start_frame());
        let hands = sequence.controls_at(now);
        let from_now =
            || Rollout::of(pair.name).from_capture_frame(None, 0, now as u32).frames(HORIZON);
        // The node farthest from the hands, and a place away from where it comes to be by itself.
        let graph = &pair.bending.graph;
        let end = farthest(&graph.rest_positions, &graph.control_rest);
        let end = end.context("the twin has no nodes")?;
        let still = from_now().trajectories([1, 2, hands.len()], [hands, hands].concat());
        let reply = connection.client.rollouts().run(still.final_state()).await?;
        let idle = reply.final_positions.get(end).context("the reply has no final state")?;
        let goal = idle.map(|x| x + 0.06);
        let batch = candidates(hands, CANDIDATES);
        let request = from_now()
            .trajectories([CANDIDATES, KNOTS, hands.len()], batch.clone())
            .cubic()
            .cost(Cost::keypoints(self.object.target(), 1.0, &[end as u32], &[goal]))
            .diagnostics();
        let started = Instant::now();
        let reply = connection.client.rollouts().run(request).await?;
        let took = started.elapsed().as_secs_f64();
        let best = reply.best().context("the reply is empty")?;
        let worst = reply.costs.iter().copied().filter(|c| c.is_finite()).fold(0.0, f64::max);
        let [x, y, z] = displacement(hands, &batch, best).map(|d| 100.0 * d);
        self.print(&format!(
            "  best: action {best}, hands by ({x:.1}, {y:.1}, {z:.1}) cm; the {} comes within {:.1} cm of its goal (worst action: {:.1} cm)",
            self.object.target(),
            100.0 * reply.costs.get(best).copied().unwrap_or_default(),
            100.0 * worst
        ));
        let frames = CANDIDATES as f64 * f64::from(HORIZON);
        self.print(&format!(
            "  {CANDIDATES} rollouts of {HORIZON} frames in {took:.2} s: {:.0} frames a second",
            frames / took
        ));
        let planned = json!({ "best": best, "costs": reply.costs, "seconds": took });
        self.report.insert("rollout".to_owned(), planned);
        Ok(())
    }

    async fn draw(&mut self, pair: FittedPair, observed: Capture) -> anyhow::Result<()> {
        let path = self.picture.clone();
        let command = format!(
            "bendtwin eval {}.zip --axial {} --picture {}",
            self.object.name(),
            self.object.flags(),
            path.display()
        );
        self.step("Draw predicted against observed", &command);
        tokio::task::spawn_blocking(move || {
            let (backend, token) = (bendtwin_engine::cpu(), CancelToken::default());
            let axial = Some(&pair.axial);
            picture::draw(&path, &pair.bending, axial, &observed, &*backend, &token)
        })
        .await??;
        self.print(&format!("  {}", self.picture.display()));
        self.report.insert("picture".to_owned(), json!(self.picture));
        Ok(())
    }

    /// Prints the summary, once everything has stopped.
    pub(super) fn conclude(mut self, kept: bool) -> anyhow::Result<()> {
        let took = self.started.elapsed().as_secs_f64();
        if self.is_told {
            self.print("\nServer and worker are stopped.");
            return Ok(());
        }
        self.report.insert("seconds".to_owned(), json!(took));
        if self.quiet {
            return output::line(&serde_json::Value::Object(self.report).to_string());
        }
        self.print("");
        self.print(&format!("Done in {}; server and worker are stopped.", output::duration(took)));
        if kept {
            let data = self.folder.join("data");
            self.print(&format!(
                "Everything is in {}; continue with `bendtwin server --data-dir {}`.",
                self.folder.display(),
                data.display()
            ));
        } else {
            self.print(
                "Next: `bendtwin demo --open` to drag a rope in a browser, or `bendtwin server` and the\n\
                 commands above with a capture of your own.",
            );
        }
        Ok(())
    }

    pub(super) fn step(&mut self, what: &str, command: &str) {
        self.steps += 1;
        self.print(&format!("\n{}. {what}\n   $ {command}", self.steps));
    }

    pub(super) fn print(&self, text: &str) {
        if !self.quiet {
            // A closed standard output is reported at the end, if at all.
            let _ = output::line(text);
        }
    }
}

pub(super) fn farthest(nodes: &[[f32; 3]], from: &[[f32; 3]]) -> Option<usize> {
    let distance = |node: &[f32; 3]| {
        let squared = from.iter().map(|f| (0..3).map(|i| (node[i] - f[i]).powi(2)).sum::<f32>());
        squared.fold(f32::INFINITY, f32::min)
    };
    (0..nodes.len()).max_by(|a, b| distance(&nodes[*a]).total_cmp(&distance(&nodes[*b])))
}
