//! The rollout of a plan: the request without its actions, for batches of any size.

use bendtwin_proto::v1::{
    Ensemble, KnotTimes, Plausibility, Returns, RollOutRequest, Tensor, ensemble::Statistic,
    knot_times::Times, roll_out_request::Actions,
};
use prost::Message as _;

use super::GraspPlaces;
use crate::rollout::{self, Batch, ImplausibleReason, Limits, TwinShape, within};

/// A rollout of one instance whose actions are to be replaced.
#[derive(Clone, Debug)]
pub struct Template {
    /// Without returns; what it says of one instance holds for all.
    request: RollOutRequest,
    /// Size of the actions of one instance, shape [1, K, ...].
    shape: Vec<usize>,
    /// Those that were asked for of the best plan.
    returns: Option<Returns>,
    /// True if what is beyond the limits of plausibility is to be refused.
    refuses: bool,
    /// Strain of the material beyond which a plan is worse than all that keep it.
    strain_limit: f64,
    /// The forces of grasps that plans are judged by; none: they are not measured.
    force: Option<Force>,
}

/// Forces of grasps that plans are judged by.
#[derive(Clone, Debug, PartialEq)]
pub struct Force {
    /// Force beyond which a plan is worse than all that keep it [N]; infinite without a limit.
    pub limit_n: f64,
    /// Grasps, by their numbers, of which one must exert a force in a plan; none: a plan need not grasp
    /// anything.
    pub takes: Option<Vec<usize>>,
}

impl Template {
    /// The template of a checked request of one instance, whose places to grasp may be searched.
    pub(super) fn new(mut request: RollOutRequest, places: Option<&GraspPlaces>) -> Self {
        let shape = actions(&request).map(|t| t.shape.iter().map(|d| *d as usize).collect());
        // An encoding or a point set alone asks for nothing.
        let asks =
            |r: &Returns| Returns { encoding: 0, point_set: 0, ..r.clone() } != Returns::default();
        let returns = request.returns.take().filter(asks);
        let refuses = request.plausibility.as_ref().is_some_and(|p| p.refuse);
        let limits = request.plausibility.unwrap_or_default();
        let strain_limit = ImplausibleReason::Strain.limit_or_default(&limits);
        let limit_n = ImplausibleReason::GraspForce.limit_or_default(&limits);
        let takes = places.map(|places| places.grasps(&request).collect());
        let is_judged = limit_n < f64::INFINITY || takes.is_some();
        let force = is_judged.then_some(Force { limit_n, takes });
        rollout::split::by_instance(&mut request, shared);
        // Factors for one instance are those of an ensemble with one member.
        if request.vary.is_some() && request.ensemble.is_none() {
            let statistic = Statistic::Mean.into();
            request.ensemble = Some(Ensemble { members: 1, statistic, share: 0.0 });
        }
        Self { request, shape: shape.unwrap_or_default(), returns, refuses, strain_limit, force }
    }

    /// Checks a batch of `instances` against the limits, with or without gradients by actions.
    pub(super) fn check(
        &self,
        batch: &Batch,
        iterations: u64,
        gradients: bool,
        twin: &TwinShape,
        limits: &Limits,
    ) -> Result<(), rollout::Error> {
        let instances = u128::from(batch.instances);
        within(
            "the number of instances (samples x members)",
            instances * u128::from(rollout::members(&self.request)),
            limits.instances,
            "use fewer samples or members",
        )?;
        within(
            "the size of a batch in bytes",
            self.request.encoded_len() as u128 + instances * self.row_bytes() as u128,
            limits.request_bytes,
            "use fewer samples or knots",
        )?;
        let request = self.unset_batch(gradients);
        rollout::sizes(&request, batch, twin, limits, 0)?;
        within(
            "the work of all iterations (instances x frames x substeps x (nodes + springs + triplets))",
            rollout::work(&request, batch, twin).saturating_mul(u128::from(iterations)),
            limits.work,
            "use fewer samples or iterations, a shorter horizon or a coarser twin",
        )
    }

    /// The rollout of plans, shape [S, K, ...] of the actions; with gradients by them if requested.
    /// The reply lists the strain of each, and the forces of grasps that plans are judged by, as implausible,
    /// regardless of their values.
    pub fn batch(&self, plans: &[Vec<f64>], gradients: bool) -> RollOutRequest {
        let mut request = self.unset_batch(gradients);
        self.set(&mut request, plans);
        request
    }

    /// The rollout of the best plan with the returns that were asked for, if any were.
    pub fn last(&self, plan: &[f64]) -> Option<RollOutRequest> {
        let returns = Some(self.returns.clone()?);
        let mut request = RollOutRequest { returns, ..self.request.clone() };
        self.set(&mut request, &[plan.to_vec()]);
        Some(request)
    }

    /// The rollout of the first frames of a plan whose knots are `between_s` seconds apart, if the request
    /// does not say when they are.
    pub(super) fn first_frames(
        &self,
        plan: &[f64],
        frames: u32,
        between_s: f64,
        returns: Option<Returns>,
    ) -> RollOutRequest {
        let mut request = self.request.clone();
        Self::put(&mut request, self.actions(plan));
        let times = || KnotTimes { times: Some(Times::PeriodS(between_s)) };
        // A mean prediction of several members is that of the object, a member is not.
        let own = match rollout::has_mean_prediction(&request) {
            true => true,
            false => request.ensemble.take().is_none_or(|ensemble| ensemble.members == 1),
        };
        RollOutRequest {
            frames,
            costs: Vec::new(),
            returns,
            vary: request.vary.take().filter(|_| own),
            gradient: None,
            knot_times: Some(request.knot_times.take().unwrap_or_else(times)),
            time_limit_s: None,
            ..request
        }
    }

    /// A plan as the actions of a request.
    pub fn actions(&self, plan: &[f64]) -> Tensor {
        pack(&self.shape, &[plan.to_vec()])
    }

    /// True if an implausible plan counts as one that diverges.
    pub fn refuses(&self) -> bool {
        self.refuses
    }

    /// Strain of the material beyond which a plan is worse than all that keep it.
    pub fn strain_limit(&self) -> f64 {
        self.strain_limit
    }

    /// The forces of grasps that plans are judged by, if they are.
    pub fn force(&self) -> Option<&Force> {
        self.force.as_ref()
    }

    /// The request, with the nominal plan as its actions.
    pub fn request(&self) -> &RollOutRequest {
        &self.request
    }

    /// Bytes of the actions of one instance.
    pub(super) fn row_bytes(&self) -> usize {
        4 * self.shape.iter().product::<usize>()
    }

    /// The rollout of a batch before it has plans.
    fn unset_batch(&self, gradients: bool) -> RollOutRequest {
        let plausibility = self.request.plausibility.unwrap_or_default();
        let grasp_force_n = self.force.is_some().then_some(0.0);
        let strain = Some(0.0);
        let plausibility = Plausibility { refuse: false, strain, grasp_force_n, ..plausibility };
        let mut request = self.request.clone();
        // Plans are compared by their costs alone.
        request.costs.iter_mut().for_each(|cost| cost.success_at_most = None);
        RollOutRequest { returns: returns(gradients), plausibility: Some(plausibility), ..request }
    }

    fn set(&self, request: &mut RollOutRequest, plans: &[Vec<f64>]) {
        Self::put(request, pack(&self.shape, plans));
    }

    /// Puts other knots in the place of a request's actions.
    pub fn put(request: &mut RollOutRequest, knots: Tensor) {
        match &mut request.actions {
            Some(Actions::Trajectories(t)) => t.positions = Some(knots),
            Some(Actions::Poses(p)) => p.poses = Some(knots),
            None => {}
        }
    }
}

/// The tensor of the actions.
pub(super) fn actions(request: &RollOutRequest) -> Option<&Tensor> {
    match &request.actions {
        Some(Actions::Trajectories(t)) => t.positions.as_ref(),
        Some(Actions::Poses(p)) => p.poses.as_ref(),
        None => None,
    }
}

fn returns(gradients: bool) -> Option<Returns> {
    gradients.then(|| Returns { action_gradients: true, ..Returns::default() })
}

/// Plans of one shape in single precision.
fn pack(shape: &[usize], plans: &[Vec<f64>]) -> Tensor {
    let values: Vec<f32> = plans.iter().flatten().map(|x| *x as f32).collect();
    let shape: Vec<usize> = [plans.len()].iter().chain(shape.iter().skip(1)).copied().collect();
    Tensor::pack(&shape, &values)
}

/// Makes a tensor of one instance one for all.
fn shared(tensor: Option<&mut Tensor>, rank: usize) {
    let Some(tensor) = tensor.filter(|t| rank > 1 && t.shape.len() == rank) else { return };
    tensor.shape.remove(0);
    // Targets [1, 1, M, 3] are those of all frames.
    if rank == 4 && tensor.shape.first() == Some(&1) {
        tensor.shape.remove(0);
    }
}
