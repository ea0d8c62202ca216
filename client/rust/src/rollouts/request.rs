//! A rollout request, built step by step.

use bendtwin_core::{
    Fidelity, Point,
    ids::{CaptureId, SessionId, TwinId},
};
use bendtwin_proto::v1::{
    self, ControlTrajectories, InitialState, Interpolation, KnotTimes, Plausibility, PointSet,
    Returns, RollOutRequest, Tensor,
    initial_state::{CaptureFrame, GivenState, SessionSlots, Settled, State as Initial},
    knot_times::Times,
    returns::Encoding,
    roll_out_request::Actions,
};

use super::{Cost, Grasp, State, Statistic, Vary, World};
use crate::Error;

/// A batch of rollouts of one twin.
#[derive(Clone, Debug)]
pub struct Rollout {
    request: RollOutRequest,
    returns: Returns,
    /// The first argument that cannot be sent.
    fault: Option<Error>,
}

/// Poses of rigid grippers that carry the control points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GripperPoses {
    /// Instances B, knots K, grippers G.
    pub shape: [usize; 3],
    /// x, y, z [m], quaternion x, y, z, w; shape [B, K, G].
    pub poses: Vec<[f32; 7]>,
    /// The gripper of each control point, shape [C]; empty means gripper 0 for all.
    pub gripper_of_control: Vec<u32>,
}

impl Rollout {
    /// A rollout of a twin from its rest shape, which returns costs and diagnostics.
    pub fn of(twin: TwinId) -> Self {
        let request = RollOutRequest { twin: twin.to_string(), ..RollOutRequest::default() };
        Self { request, returns: Returns::default(), fault: None }
    }

    /// Positions of every control point [m], shape [instances B, knots K, control points C].
    /// Knots are spread evenly over the horizon; without [`Rollout::frames`] there is one a frame.
    #[must_use]
    pub fn trajectories(mut self, shape: [usize; 3], positions: Vec<Point>) -> Self {
        if self.fits("trajectories", &shape, positions.len()) {
            self.request.actions = Some(Actions::Trajectories(ControlTrajectories {
                positions: Some(Tensor::pack_points(&shape, &positions)),
                interpolation: Interpolation::Linear.into(),
            }));
        }
        self
    }

    /// Poses of grippers instead of control points.
    #[must_use]
    pub fn poses(mut self, poses: GripperPoses) -> Self {
        let [b, k, g] = poses.shape;
        if self.fits("poses", &poses.shape, poses.poses.len()) {
            let grippers = &poses.gripper_of_control;
            self.request.actions = Some(Actions::Poses(v1::GripperPoses {
                poses: Some(Tensor::pack(&[b, k, g, 7], poses.poses.as_flattened())),
                gripper_of_control: (!grippers.is_empty())
                    .then(|| Tensor::pack(&[grippers.len()], grippers)),
                interpolation: Interpolation::Linear.into(),
            }));
        }
        self
    }

    /// Smooth curves through the knots instead of straight lines.
    #[must_use]
    pub fn cubic(self) -> Self {
        self.interpolated("cubic", Interpolation::Cubic)
    }

    /// Each knot holds until the next.
    #[must_use]
    pub fn zero(self) -> Self {
        self.interpolated("zero", Interpolation::Zero)
    }

    fn interpolated(mut self, called: &str, interpolation: Interpolation) -> Self {
        match &mut self.request.actions {
            Some(Actions::Trajectories(t)) => t.interpolation = interpolation.into(),
            Some(Actions::Poses(p)) => p.interpolation = interpolation.into(),
            None => {
                let advice = "needs actions: call trajectories() or poses() before it";
                self.refuse(&format!("{called}() {advice}"));
            }
        }
        self
    }

    /// Times of the knots, rising from 0 [s]; the last holds until the end of the horizon, which
    /// [`Rollout::frames`] says.
    #[must_use]
    pub fn at_s(mut self, times: &[f32]) -> Self {
        let times = Some(Times::AtS(Tensor::pack(&[times.len()], times)));
        self.request.knot_times = Some(KnotTimes { times });
        self
    }

    /// Sets the seconds from knot to knot, independent of the twin's frame rate; the horizon is
    /// that of [`Rollout::frames`].
    #[must_use]
    pub fn period_s(mut self, period: f64) -> Self {
        self.request.knot_times = Some(KnotTimes { times: Some(Times::PeriodS(period)) });
        self
    }

    /// Starts where the twin comes to rest in the request's world, without what grippers carry.
    #[must_use]
    pub fn settled(self) -> Self {
        self.start(Initial::Settled(Settled {}))
    }

    /// Starts all instances from a whole state, such as [`Reply::state`](super::Reply::state).
    #[must_use]
    pub fn going_on(self, state: &State) -> Self {
        self.start(Initial::Given(state.into()))
    }

    /// Starts where the twin is after following the controls of a capture (by default the twin's
    /// own) up to a frame.
    #[must_use]
    pub fn from_capture_frame(self, capture: Option<CaptureId>, sequence: u32, frame: u32) -> Self {
        let capture = capture.map(|c| c.to_string()).unwrap_or_default();
        self.start(Initial::CaptureFrame(CaptureFrame { capture, sequence, frame }))
    }

    /// Starts where slots of a session are, which stay there: one slot for all instances (none: slot
    /// 0), or one for each.
    #[must_use]
    pub fn from_session(self, session: SessionId, slots: &[u32]) -> Self {
        let session = session.to_string();
        self.start(Initial::Session(SessionSlots { session, slots: slots.to_vec() }))
    }

    /// Starts all instances from given positions [m] and velocities [m/s], shape [N].
    #[must_use]
    pub fn from_state(self, positions: &[Point], velocities: &[Point]) -> Self {
        self.start(Initial::Given(GivenState {
            positions: Some(Tensor::pack_points(&[positions.len()], positions)),
            velocities: Some(Tensor::pack_points(&[velocities.len()], velocities)),
            twists: None,
            ..GivenState::default()
        }))
    }

    /// Twists all instances' rods by these angles [rad], shape [rods], where they start from a
    /// given state.
    #[must_use]
    pub fn twisted(mut self, twists: &[f32]) -> Self {
        let state = self.request.initial.as_mut().and_then(|i| i.state.as_mut());
        if let Some(Initial::Given(given)) = state {
            given.twists = Some(Tensor::pack(&[twists.len()], twists));
        }
        self
    }

    /// Follows the twin exactly, which is the default, by its fast variant or by its planner's twin;
    /// [`Reply::deviation`] says how far that strays.
    ///
    /// [`Reply::deviation`]: super::Reply::deviation
    #[must_use]
    pub fn fidelity(mut self, fidelity: Fidelity) -> Self {
        self.request.fidelity = match fidelity {
            Fidelity::Exact => v1::Fidelity::Exact.into(),
            Fidelity::Fast => v1::Fidelity::Fast.into(),
            Fidelity::Planner => v1::Fidelity::Planner.into(),
        };
        self
    }

    /// The horizon in frames.
    #[must_use]
    pub fn frames(mut self, frames: u32) -> Self {
        self.request.frames = frames;
        self
    }

    /// Adds a cost.
    #[must_use]
    pub fn cost(mut self, cost: Cost) -> Self {
        self.request.costs.push(cost.0);
        self
    }

    /// Asks for the positions of every k-th frame.
    #[must_use]
    pub fn record_every(mut self, frames: u32) -> Self {
        self.returns.every_frames = frames;
        self
    }

    /// Records only these nodes.
    #[must_use]
    pub fn record_nodes(mut self, nodes: &[u32]) -> Self {
        self.returns.nodes = Some(Tensor::pack(&[nodes.len()], nodes));
        self
    }

    /// Records the skin instead of nodes.
    #[must_use]
    pub fn record_skin(mut self) -> Self {
        self.returns.point_set = PointSet::Skin.into();
        self
    }

    /// Records only these points of the skin, instead of nodes.
    #[must_use]
    pub fn record_skin_points(mut self, points: &[u32]) -> Self {
        self.returns.skin_points = Some(Tensor::pack(&[points.len()], points));
        self.record_skin()
    }

    /// Positions as scaled 16-bit integers on the wire: half the size.
    #[must_use]
    pub fn int16(mut self) -> Self {
        self.returns.encoding = Encoding::Int16.into();
        self
    }

    /// Asks for the arrays of only the best `count` instances by cost.
    #[must_use]
    pub fn best(mut self, count: u32) -> Self {
        self.returns.best = count;
        self
    }

    /// Asks for parts of at most `frames` frames, each as soon as it is simulated; only for
    /// [`Rollouts::stream`].
    ///
    /// [`Rollouts::stream`]: super::Rollouts::stream
    #[must_use]
    pub fn part_frames(mut self, frames: u32) -> Self {
        self.returns.part_frames = frames;
        self
    }

    /// Limits the time to `seconds` from when the server has the request; instances that are not
    /// done by then are in [`Reply::unfinished`].
    ///
    /// [`Reply::unfinished`]: super::Reply::unfinished
    #[must_use]
    pub fn time_limit_s(mut self, seconds: f64) -> Self {
        self.request.time_limit_s = Some(seconds);
        self
    }

    /// Asks for the final states.
    #[must_use]
    pub fn final_state(mut self) -> Self {
        self.returns.final_state = true;
        self
    }

    /// Asks for strains, speeds and energies.
    #[must_use]
    pub fn diagnostics(mut self) -> Self {
        self.returns.diagnostics = true;
        self
    }

    /// Asks for the gradients of the cost with respect to the control positions of every frame.
    #[must_use]
    pub fn control_gradients(mut self) -> Self {
        self.returns.control_gradients = true;
        self
    }

    /// Asks for the gradients of the cost with respect to the initial positions and velocities.
    #[must_use]
    pub fn initial_gradients(mut self) -> Self {
        self.returns.initial_gradients = true;
        self
    }

    /// Asks for the norm of the gradient with respect to positions, by frame.
    #[must_use]
    pub fn gradient_norms(mut self) -> Self {
        self.returns.gradient_norms = true;
        self
    }

    /// Asks for velocities where positions are recorded.
    #[must_use]
    pub fn velocities(mut self) -> Self {
        self.returns.velocities = true;
        self
    }

    /// Asks for costs by frame and by name.
    #[must_use]
    pub fn frame_costs(mut self) -> Self {
        self.returns.frame_costs = true;
        self
    }

    /// Asks for the control positions that were simulated.
    #[must_use]
    pub fn executed_controls(mut self) -> Self {
        self.returns.controls = true;
        self
    }

    /// Surrounds the object by this.
    #[must_use]
    pub fn world(mut self, world: World) -> Self {
        self.request.world = Some(world.0);
        self
    }

    /// Adds a hold of a gripper, which needs [`Rollout::poses`].
    #[must_use]
    pub fn grasp(mut self, grasp: Grasp) -> Self {
        self.request.grasps.push(grasp.0);
        self
    }

    /// Parameters by instance.
    #[must_use]
    pub fn vary(mut self, vary: Vary) -> Self {
        self.request.vary = Some(vary.into());
        self
    }

    /// Simulates every action on `count` fits of the twin, the first being the twin itself: at most
    /// [`Geometry::fits`](crate::Geometry::fits). The cost is a statistic over these fits, or that
    /// of their mean motion.
    #[must_use]
    pub fn on_fits(mut self, count: u32, statistic: Statistic) -> Self {
        self.request.vary.get_or_insert_default().fits = true;
        self.ensemble(count, statistic)
    }

    /// Returns how far the recorded points of the members of an ensemble are apart. Arrays beside
    /// that are of the first member of each action alone, or of their mean motion.
    #[must_use]
    pub fn spread(mut self) -> Self {
        self.returns.spread = true;
        self
    }

    /// Simulates every action under the `members` sets of parameters of [`Rollout::vary`]; the cost
    /// is a statistic over these.
    #[must_use]
    pub fn ensemble(mut self, members: u32, statistic: Statistic) -> Self {
        self.request.ensemble = Some(statistic.of(members));
        self
    }

    /// Lets gradients reach back through `reach_frames` frames (0: all), and smooths the contact
    /// that they go through over a layer of this width [m].
    #[must_use]
    pub fn gradient(mut self, reach_frames: u32, smoothing_m: f64) -> Self {
        self.request.gradient = Some(v1::GradientOptions { reach_frames, smoothing_m });
        self
    }

    /// Refuses motion that is not plausible, which is otherwise in [`Reply::implausible`].
    ///
    /// [`Reply::implausible`]: super::Reply::implausible
    #[must_use]
    pub fn refuse_implausible(mut self) -> Self {
        self.request.plausibility.get_or_insert_default().refuse = true;
        self
    }

    /// Limits the mean force of each grasp over a frame [N]: instances beyond it are implausible, and plans
    /// beyond it worse than all within.
    #[must_use]
    pub fn grasp_force_limit(mut self, newtons: f64) -> Self {
        self.request.plausibility.get_or_insert_default().grasp_force_n = Some(newtons);
        self
    }

    /// Accepts any motion as plausible: [`Reply::implausible`] stays empty, and nothing is refused.
    ///
    /// [`Reply::implausible`]: super::Reply::implausible
    #[must_use]
    pub fn allow_any_motion(mut self) -> Self {
        let refuse = self.request.plausibility.is_some_and(|p| p.refuse);
        let none = Some(f64::INFINITY);
        self.request.plausibility = Some(Plausibility {
            start_gap_m: none,
            control_speed_m_s: none,
            strain: none,
            control_depth_m: none,
            grasp_force_n: none,
            refuse,
        });
        self
    }

    /// Asks for forces by frame.
    #[must_use]
    pub fn forces(mut self) -> Self {
        self.returns.forces = true;
        self
    }

    /// Asks for the gradients of the cost with respect to the knots or poses of the request.
    #[must_use]
    pub fn action_gradients(mut self) -> Self {
        self.returns.action_gradients = true;
        self
    }

    /// The message of the request.
    ///
    /// # Errors
    /// If an array does not have its shape.
    pub fn into_request(self) -> Result<RollOutRequest, Error> {
        match self.fault {
            Some(fault) => Err(fault),
            None => Ok(RollOutRequest { returns: Some(self.returns), ..self.request }),
        }
    }

    fn start(mut self, state: Initial) -> Self {
        self.request.initial = Some(InitialState { state: Some(state) });
        self
    }

    fn fits(&mut self, what: &str, shape: &[usize], len: usize) -> bool {
        let product = shape.iter().try_fold(1usize, |p, d| p.checked_mul(*d));
        let fits = product == Some(len);
        if !fits {
            self.refuse(&format!("{what} have shape {shape:?} but {len} elements"));
        }
        fits
    }

    fn refuse(&mut self, message: &str) {
        self.fault.get_or_insert_with(|| Error::invalid(message));
    }
}
