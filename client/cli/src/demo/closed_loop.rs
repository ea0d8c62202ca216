//! `bendtwin demo --plan`: a planner and a twin bring the end of a rope to a goal, on a rope that is
//! not quite the twin's.

mod picture;
mod rope;

use std::time::Instant;

use anyhow::Context as _;
use bendtwin_client::{Cost, Point, Reply, Rollout, TwinId, TwinModel};
use bendtwin_core::FitSettings;
use bendtwin_plan::{Bounds, Evaluation, Knots, Limit, Method, Plan, Planner, Settings};
use serde_json::json;

use self::{picture::Scene, rope::Rope};
use super::{server::Connection, steps::DemoRun};

/// Frames that a plan looks ahead.
const HORIZON: usize = 15;
/// Frames that are executed before the next plan.
const STEP: usize = 3;
/// Plans that are made: two seconds at 30 frames a second.
const STEPS: usize = 20;
/// A fit in a hurry.
const GENERATIONS: u32 = 6;
const PASSES: u32 = 3;
/// Way of the hands that makes a goal within the reach of the rope [m].
const DETOUR: Point = [0.12, 0.06, 0.06];

impl DemoRun {
    /// Steps 2 to 6 of the closed loop.
    pub(super) async fn run_closed_loop(&mut self, connection: &Connection) -> anyhow::Result<()> {
        let (_, capture) = self.record(connection).await?;
        let mut settings = self.object.settings(self.seed);
        (settings.search.generations, settings.refine.passes) = (Some(GENERATIONS), Some(PASSES));
        let name = self.quick_fit(connection, capture, &settings).await?;
        let model = connection.client.twins().download(name).await?;
        self.step(
            "Make the rope to be moved: the twin with springs 1.3 times as stiff and 0.6 of its bending\n   \
             stiffness, as a twin never fits its object exactly",
            "bendtwin twin import real.safetensors",
        );
        let file = rope::altered(&model).encode().context("the altered twin cannot be written")?;
        let real = connection.client.twins().import(file, "real rope").await?;
        self.print(&format!("  {}", real.name));
        let mut rope = Rope::lying_still(connection.client.rollouts(), real.name, &model).await?;
        let goal = rope.after(DETOUR).await?;
        let scene = self.bring(connection, name, &model, &mut rope, goal).await?;
        self.step("Draw the path of the rope's end", "");
        let path = self.picture.clone();
        let png = scene.to_png().context("the picture cannot be drawn")?;
        tokio::fs::write(&path, png)
            .await
            .with_context(|| format!("cannot write {}", path.display()))?;
        self.print(&format!("  {}", path.display()));
        self.report.insert("picture".to_owned(), json!(path));
        Ok(())
    }

    async fn quick_fit(
        &mut self,
        connection: &Connection,
        capture: bendtwin_client::CaptureId,
        settings: &FitSettings,
    ) -> anyhow::Result<TwinId> {
        let flags = format!(
            "{} --set search.generations={} --set refine.passes={}",
            self.object.flags(),
            GENERATIONS,
            PASSES
        );
        self.step(
            "Fit a coarse twin quickly: planners need a coarse one, and a loop tolerates its errors",
            &format!("bendtwin fit start {capture} {flags} --watch"),
        );
        let fit = self.one_fit(connection, capture, settings, "fit_s").await?;
        fit.twin.context("the fit has no twin")
    }

    /// The closed loop: plan with the twin, execute a tenth of a second on the rope, see where it is.
    async fn bring(
        &mut self,
        connection: &Connection,
        twin: TwinId,
        model: &TwinModel,
        rope: &mut Rope,
        goal: Point,
    ) -> anyhow::Result<Scene> {
        self.step(
            &format!(
                "Bring the end of the rope to a goal: every {STEP} frames a plan of {HORIZON} frames, from where\n   \
                 the rope really is; path integral control (MPPI) over rollouts of the twin"
            ),
            "see docs/use/planning.md",
        );
        let mut settings = Settings::new(Method::MPPI, 3, HORIZON);
        settings.frame_s = model.timing.frame_s();
        settings.knots = 4;
        settings.samples = 48;
        settings.sigma = vec![0.06];
        settings.correlation = 0.5;
        settings.bounds = Bounds { speed: Limit::All(1.0), ..Bounds::default() };
        settings.seed = self.seed;
        let mut planner = Planner::new(settings)?;
        let mut scene = Scene::new(model, rope, goal);
        let mut times_ms = Vec::with_capacity(STEPS);
        for step in 1..=STEPS {
            let started = Instant::now();
            let ask = |plans: &[Knots]| {
                rope.ahead(twin, plans, HORIZON).cost(
                    Cost::keypoints("end of the rope", 1.0 / HORIZON as f64, &[rope.end], &[goal])
                        .every_frame(),
                )
            };
            let plan = planned(&mut planner, connection, ask).await?;
            times_ms.push(1000.0 * started.elapsed().as_secs_f64());
            let path = planner.settings().curve.path(&plan.knots, 3, HORIZON);
            rope.follow(&path[..3 * (STEP + 1)]).await?;
            planner.shift(STEP as f64);
            scene.record(rope);
            if step % 4 == 0 || step == 1 {
                let at = (step * STEP) as f64 * model.timing.frame_s();
                let apart = 1000.0 * rope.distance_to(goal);
                self.print(&format!("  after {at:.1} s: {apart:5.1} mm from the goal"));
            }
        }
        let mean_ms = times_ms.iter().sum::<f64>() / times_ms.len() as f64;
        let apart_mm = 1000.0 * rope.distance_to(goal);
        self.print(&format!(
            "  {apart_mm:.1} mm at the end, {:.1} mm at the nearest; {mean_ms:.0} ms a plan",
            scene.nearest_mm()
        ));
        self.report.insert(
            "closed_loop".to_owned(),
            json!({
                "distances_mm": scene.distances_mm(),
                "step_ms": times_ms,
                "mean_step_ms": mean_ms,
                "final_mm": apart_mm,
            }),
        );
        Ok(scene)
    }
}

/// Makes a plan: batch by batch to the server and back.
async fn planned(
    planner: &mut Planner,
    connection: &Connection,
    ask: impl Fn(&[Knots]) -> Rollout,
) -> anyhow::Result<Plan> {
    let rollouts = connection.client.rollouts();
    let began = Instant::now();
    let mut search = planner.search();
    while let Some(plans) = search.propose(began.elapsed()) {
        let Reply { costs, implausible, .. } = rollouts.run(ask(plans)).await?;
        let mut excess = vec![0.0; costs.len()];
        for found in implausible.iter().filter(|found| found.reason == "STRAIN") {
            if let Some(excess) = excess.get_mut(found.instance) {
                *excess = found.found - found.limit;
            }
        }
        let evaluation = Evaluation { costs, excess, ..Evaluation::default() };
        search.learn::<std::convert::Infallible>(evaluation, began.elapsed())?;
    }
    search.finish(began.elapsed()).context("no plan was simulated")
}
