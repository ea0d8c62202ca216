//! Plans made at the server: actions that lower the costs of a rollout.

use std::time::Duration;

use bendtwin_plan::{Bounds, Limit, Method, Movement, Origin};
use bendtwin_proto::v1::{
    self, ActionSpace, GraspSearch, PlanBounds, PlanMethod, PlanRequest, Tensor,
    action_space::Coordinates, plan_method, planning_service_client::PlanningServiceClient,
};
use futures::{Stream, StreamExt as _};

use crate::{Error, Reply, Rollout, client::Channel, resources::resource};

/// Calls for plans.
#[derive(Clone, Debug)]
pub struct Plans {
    service: PlanningServiceClient<Channel>,
}

/// A plan to be made: the rollout whose costs are to be lowered, and how to search. The actions of
/// the rollout, of one instance, are the nominal plan.
#[derive(Clone, Debug)]
pub struct Planning {
    rollout: Rollout,
    request: PlanRequest,
}

resource! { v1::PlanUpdate =>
/// The best plan so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanUpdate {
    /// Knots: control points or poses one after another, shape [K, C, 3] or [K, G, 7].
    pub knots: Vec<f32>,
    /// Knots in the coordinates of the action space, shape [K, D].
    pub coordinates: Vec<f64>,
    /// Cost of exactly these knots, as simulated.
    pub cost: f64,
    /// Weighted terms of the cost by name.
    pub cost_terms: Vec<(String, f64)> = cost_names, cost_terms,
    /// Source of the plan.
    pub origin: Origin,
    /// Cost of the nominal plan, of the place of the best plan if places are searched; infinite if it
    /// diverges.
    pub nominal_cost: f64,
    /// Iterations that were finished.
    pub iterations: usize,
    /// Plans that were simulated.
    pub simulated: usize,
    /// Plans among them that diverged.
    pub diverged: usize,
    /// True if the deadline ended the search before all iterations were done.
    pub stopped_by_deadline: bool,
    /// Time since planning began at the server.
    pub time: Duration = time_s,
    /// True for the last update.
    pub last: bool,
    /// The rollout of the best plan, in the last update, if the rollout asked for returns.
    pub rollout: Option<Reply>,
    /// Largest strain of the material in the plan's motion.
    pub strain: f64,
    /// Limit of the strain: a plan beyond it, or beyond that of the force of grasps, is worse than every
    /// plan that keeps both, at any cost.
    pub strain_limit: f64,
    /// Plans that did not diverge and were beyond a limit.
    pub overstrained: usize,
    /// The place of the best plan, if places to grasp are searched.
    pub grasp: Option<usize>,
    /// Cost of the best plan of each place, shape [P]; infinite where every plan diverged or grasped
    /// nothing.
    pub grasp_costs: Vec<f64>,
    /// Largest mean force of a grasp over a frame in the plan's motion [N], if there is a limit or places
    /// are searched.
    pub grasp_force_n: Option<f64>,
    /// Limit of that force.
    pub grasp_force_limit_n: Option<f64>,
}
}

impl Plans {
    pub(crate) fn new(service: PlanningServiceClient<Channel>) -> Self {
        Self { service }
    }

    /// Has the server search to the end. Dropping the future stops the work.
    ///
    /// # Errors
    /// If the request is wrong or too large, every plan diverges, or the server cannot be asked.
    pub async fn run(&self, planning: Planning) -> Result<PlanUpdate, Error> {
        let mut updates = std::pin::pin!(self.stream(planning).await?);
        while let Some(update) = updates.next().await {
            let update = update?;
            if update.last {
                return Ok(update);
            }
        }
        Err(Error::malformed("a plan without a last update"))
    }

    /// The best so far after each iteration. Dropping the stream stops the work.
    ///
    /// # Errors
    /// Those of [`Plans::run`].
    pub async fn stream(
        &self,
        planning: Planning,
    ) -> Result<impl Stream<Item = Result<PlanUpdate, Error>> + use<>, Error> {
        let request = planning.into_request()?;
        let updates = self.service.clone().plan(request).await?.into_inner();
        Ok(updates.map(|update| PlanUpdate::try_from(update?)))
    }
}

impl Planning {
    /// Path integral control with the server's settings.
    pub fn of(rollout: Rollout) -> Self {
        Self { rollout, request: PlanRequest::default() }
    }

    /// Another method.
    #[must_use]
    pub fn method(mut self, method: &Method) -> Self {
        use plan_method::Method as Wire;
        let method = match method {
            Method::Mppi { temperature } => {
                Wire::Mppi(plan_method::Mppi { temperature: *temperature })
            }
            Method::Cem { elites, memory, smallest } => Wire::Cem(plan_method::Cem {
                elites: count(*elites),
                memory: Some(*memory),
                smallest: Some(*smallest),
            }),
            Method::PredictiveSampling => {
                Wire::PredictiveSampling(plan_method::PredictiveSampling {})
            }
            Method::Gradient { rate } => {
                Wire::Gradient(plan_method::Gradient { rate: Some(numbers(rate)) })
            }
        };
        self.request.method = Some(PlanMethod { method: Some(method) });
        self
    }

    /// Plans that are simulated in an iteration, and iterations.
    #[must_use]
    pub fn samples(mut self, samples: usize, iterations: usize) -> Self {
        (self.request.samples, self.request.iterations) = (count(samples), count(iterations));
        self
    }

    /// Standard deviations of samples [m or rad]: one, by coordinate [D], or by knot and coordinate
    /// [K, D]; and the correlation of neighbouring knots, 0..1.
    #[must_use]
    pub fn sigma(mut self, sigma: &[f64], correlation: f64) -> Self {
        (self.request.sigma, self.request.correlation) = (Some(numbers(sigma)), correlation);
        self
    }

    /// Samples have sigma times a factor from 1 to this, above 0 and at most 1.
    #[must_use]
    pub fn finest(mut self, finest: f64) -> Self {
        self.request.finest = Some(finest);
        self
    }

    /// Limits that every plan keeps, counted from the start of the space.
    #[must_use]
    pub fn bounds(mut self, bounds: &Bounds) -> Self {
        let limit = |limit: &Limit| match limit {
            Limit::None => None,
            Limit::All(all) => Some(numbers(&[*all])),
            Limit::Each(each) => Some(numbers(each)),
        };
        self.request.bounds = Some(PlanBounds {
            low: limit(&bounds.low),
            high: limit(&bounds.high),
            speed: limit(&bounds.speed),
        });
        self
    }

    /// Coordinates of the plan, by what they move; without it all control points together, or rigid
    /// grippers.
    #[must_use]
    pub fn moving(mut self, movement: &Movement) -> Self {
        let space = self.request.space.get_or_insert_default();
        space.group_of_control = None;
        let coordinates = match movement {
            Movement::Points(groups) => {
                let groups: Vec<u32> = groups.iter().map(|group| count(*group)).collect();
                space.group_of_control = Some(Tensor::pack(&[groups.len()], &groups));
                Coordinates::PerGroup
            }
            Movement::Translation => Coordinates::Translation,
            Movement::Rigid => Coordinates::Rigid,
        };
        space.coordinates = coordinates.into();
        self
    }

    /// The place that coordinates are counted from: control points, shape [C, 3], or poses, shape [G, 7], one
    /// row after the other. Without it row 0 of the nominal plan.
    #[must_use]
    pub fn starting_at<const N: usize>(mut self, rows: &[[f32; N]]) -> Self {
        let start = Tensor::pack(&[rows.len(), N], rows.as_flattened());
        let space = self.request.space.get_or_insert_default();
        *space = ActionSpace { start: Some(start), ..space.clone() };
        self
    }

    /// Searches places to grasp together with the motion: poses of these grippers, which ascend, at each
    /// place. The samples are shared by all places, and the worse half of these is given up after each round
    /// of iterations. The rollout needs a grasp of each gripper.
    #[must_use]
    pub fn grasping<const G: usize>(
        mut self,
        grippers: [usize; G],
        places: &[[[f32; 7]; G]],
    ) -> Self {
        let poses = places.as_flattened().as_flattened();
        self.request.grasp_search = Some(GraspSearch {
            poses: Some(Tensor::pack(&[places.len(), G, 7], poses)),
            grippers: grippers.map(count).to_vec(),
        });
        self
    }

    /// Moves the nominal plan on by frames that were executed since it was made.
    #[must_use]
    pub fn shifted(mut self, frames: f64) -> Self {
        self.request.shift_frames = frames;
        self
    }

    /// Same seed, same plan.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.request.seed = seed;
        self
    }

    /// Time for the iterations, after which the best plan so far is returned.
    #[must_use]
    pub fn deadline(mut self, deadline: Duration) -> Self {
        self.request.deadline_s = deadline.as_secs_f64();
        self
    }

    /// The message.
    ///
    /// # Errors
    /// If an argument of the rollout cannot be sent.
    pub fn into_request(self) -> Result<PlanRequest, Error> {
        Ok(PlanRequest { rollout: Some(self.rollout.into_request()?), ..self.request })
    }
}

fn numbers(values: &[f64]) -> Tensor {
    let values: Vec<f32> = values.iter().map(|x| *x as f32).collect();
    Tensor::pack(&[values.len()], &values)
}

fn count(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
