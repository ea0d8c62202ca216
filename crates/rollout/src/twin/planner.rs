//! Rollouts of a planner's twin in the words of its twin. Requests and replies name the twin's nodes;
//! what is simulated are some of them.
//!
//! - A state of the twin is one of the planner's twin by leaving out the other nodes, and back each node
//!   is carried as a point of the skin is. The way back and forth changes nothing, so a session keeps
//!   states of the twin, whichever of the two simulates.
//! - Nodes that are recorded, and keypoints at nodes, are points of the planner's skin, which has the
//!   twin's nodes behind the points of the twin's own skin.
//! - Nodes of grasps and of costs of depth and place are the nearest of the planner's nodes; those of
//!   order and winding too, in their order. Costs of all nodes are of the planner's.

use std::sync::Arc;

use bendtwin_contract::rollout;
use bendtwin_core::PlannersTwin;
use bendtwin_engine::{
    Backend, Loaded, Model,
    model::State,
    planner::{carried, lost_grasp, thinned},
    world::Grasping,
};
use bendtwin_proto::v1::{
    self, PointSet, RollOutRequest, Tensor, cost::Kind, grasp::Region, initial_state,
};

use crate::{
    error::Error,
    request::{
        grasping,
        initial::{Start, Starts},
    },
    twin::warm::Warm,
};

/// A planner's twin on the device.
pub(crate) struct PlannersWarm {
    /// The small twin; its skin has the twin's nodes behind the twin's own points.
    pub(crate) warm: Arc<Warm>,
    /// The model with the whole of this skin; that of `warm` has only the twin's points.
    with_nodes: Loaded,
    planner: PlannersTwin,
    /// Number of nodes of the twin, and of points of its skin.
    nodes: usize,
    skin_points: usize,
    /// The planner's node for each node of the twin, shape [N].
    nearest: Vec<u32>,
}

impl PlannersWarm {
    /// Loads the planner's twin of a loaded twin.
    ///
    /// # Errors
    /// If the twin has none, or the backend fails.
    pub(crate) fn load(of: &Warm, backend: &dyn Backend) -> Result<Self, Error> {
        let missing = || rollout::Error::NoPlannersTwin { twin: of.id.to_string() };
        let planner = of.twin.planner.clone().ok_or_else(missing)?;
        let (nodes, skin_points) = (of.twin.graph.node_count(), of.twin.skin.len());
        let whole = Model::from(&*planner.twin);
        let own = Model { skin: Arc::new(planner.own_skin(skin_points)), ..whole.clone() };
        let loaded = backend.load(Arc::new(own))?;
        // Its memory is in that of the twin.
        let warm = Warm::new(of.id, (*planner.twin).clone(), loaded, None);
        let nearest = planner.nearest(&of.twin.graph.rest_positions);
        let with_nodes = backend.load(Arc::new(whole))?;
        Ok(Self { warm: Arc::new(warm), with_nodes, planner, nodes, skin_points, nearest })
    }

    /// The twin's number of one of the planner's nodes.
    pub(crate) fn node(&self, own: usize) -> usize {
        self.planner.nodes.get(own).map_or(own, |&node| node as usize)
    }

    /// A state of the twin, of one of the planner's.
    pub(crate) fn carried(&self, state: &State) -> State {
        carried(&self.planner, self.skin_points, state)
    }

    /// Values of the twin's nodes: zero for all but the planner's.
    pub(crate) fn spread(&self, own: &[[f32; 3]]) -> Vec<[f32; 3]> {
        if own.is_empty() {
            return Vec::new();
        }
        let mut all = vec![[0.0; 3]; self.nodes];
        for (&node, value) in self.planner.nodes.iter().zip(own) {
            if let Some(to) = all.get_mut(node as usize) {
                *to = *value;
            }
        }
        all
    }

    /// Starts of the planner's twin in those of the twin.
    ///
    /// # Errors
    /// If a grasp of one holds only nodes that the planner's twin has not.
    pub(crate) fn thinned(&self, starts: Starts) -> Result<Starts, Error> {
        let of = |start: Start| {
            self.keeps_grasps(&start.state.grasping)?;
            Ok(Start { state: Arc::new(thinned(&self.planner, &start.state)), ..start })
        };
        Ok(match starts {
            Starts::Shared(start) => Starts::Shared(of(start)?),
            Starts::Each(starts) => {
                Starts::Each(starts.into_iter().map(of).collect::<Result<_, Error>>()?)
            }
        })
    }

    /// Refuses a state whose grasps the planner's twin would open.
    fn keeps_grasps(&self, grasping: &Grasping) -> Result<(), Error> {
        let Some(grasp) = lost_grasp(&self.planner, grasping) else { return Ok(()) };
        let fault = format!(
            "is PLANNER, but all nodes that grasp {grasp} holds are left out of the planner's twin, so it would let go: ask for EXACT, or grasp more nodes"
        );
        Err(Error::field("fidelity", fault))
    }

    /// Rewrites a checked request for the planner's twin. Returns the model that answers it.
    ///
    /// # Errors
    /// If it has keypoints at nodes beside a target cloud for the skin, or in a twin whose skin touches
    /// things; or if a grasp of its state holds only nodes that the planner's twin has not.
    pub(crate) fn rewrite(&self, request: &mut RollOutRequest) -> Result<Loaded, Error> {
        if let Some(returns) = &mut request.returns {
            self.rewrite_returns(returns)?;
        }
        if let Some(initial_state::State::Given(given)) =
            request.initial.as_mut().and_then(|initial| initial.state.as_mut())
        {
            self.rewrite_state(given)?;
        }
        for grasp in &mut request.grasps {
            if let Some(Region::Nodes(nodes)) = &mut grasp.region {
                *nodes = self.nearest(nodes, "grasps.nodes")?;
            }
        }
        let mut model = &self.warm.loaded;
        let mut cloud = None;
        for (index, cost) in request.costs.iter_mut().enumerate() {
            match &mut cost.kind {
                Some(Kind::Keypoints(keypoints)) => {
                    let given = keypoints.nodes.take().filter(|nodes| !nodes.is_absent());
                    if let Some(nodes) = given {
                        if self.warm.twin.params.contact.skin {
                            // The skin with the nodes would touch things elsewhere: a cost must not
                            // change the motion that it measures.
                            let fault = "are keypoints at nodes, and the skin of this twin touches ground and colliders (`skin_contact`), to which the planner's twin cannot add the nodes: name keypoints by `skin_points`, or ask for EXACT or FAST";
                            let field = format!("costs[{index}].keypoints.nodes");
                            return Err(Error::field(field, fault));
                        }
                        keypoints.skin_points = Some(self.points(&nodes, "keypoints.nodes")?);
                        model = &self.with_nodes;
                    }
                }
                Some(Kind::Height(height)) => self.rewrite_nodes(&mut height.nodes)?,
                Some(Kind::Within(within)) => self.rewrite_nodes(&mut within.nodes)?,
                Some(Kind::Order(order)) => {
                    self.rewrite_chain(&mut order.nodes, &format!("costs[{index}].order.nodes"))?;
                }
                Some(Kind::Winding(winding)) => {
                    let field = format!("costs[{index}].winding.nodes");
                    self.rewrite_chain(&mut winding.nodes, &field)?;
                }
                Some(Kind::TargetCloud(of)) if is_at_skin(of.point_set()) => {
                    cloud.get_or_insert_with(|| format!("costs[{index}].target_cloud"));
                }
                Some(Kind::Coverage(of)) if is_at_skin(of.point_set()) => {
                    cloud.get_or_insert_with(|| format!("costs[{index}].coverage"));
                }
                _ => {}
            }
        }
        match cloud {
            Some(field) if Arc::ptr_eq(model.model(), self.with_nodes.model()) => {
                let fault = "is beside keypoints at nodes, which the planner's twin does not measure together: name keypoints by `skin_points`";
                Err(Error::field(field, fault))
            }
            _ => Ok(model.clone()),
        }
    }

    fn rewrite_returns(&self, returns: &mut v1::Returns) -> Result<(), Error> {
        let points = match rollout::recorded(returns) {
            PointSet::Skin => {
                let given = returns.skin_points.take().filter(|points| !points.is_absent());
                let all = || (0..self.skin_points as u32).collect::<Vec<u32>>();
                given.unwrap_or_else(|| Tensor::pack(&[self.skin_points], &all()))
            }
            _ => {
                let given = returns.nodes.take().filter(|nodes| !nodes.is_absent());
                let all = || (0..self.nodes as u32).collect::<Vec<u32>>();
                let nodes = given.unwrap_or_else(|| Tensor::pack(&[self.nodes], &all()));
                self.points(&nodes, "returns.nodes")?
            }
        };
        returns.set_point_set(PointSet::Skin);
        (returns.nodes, returns.skin_points) = (None, Some(points));
        Ok(())
    }

    fn rewrite_state(&self, given: &mut initial_state::GivenState) -> Result<(), Error> {
        let n = self.nodes.max(1);
        if let Some(grasping) = &given.grasping {
            let held = grasping.holders.as_ref().filter(|t| !t.is_absent());
            let numbers = held.map_or(0, |t| t.shape.iter().product::<u64>());
            for of_state in grasping::read(grasping, numbers as usize / n, n)? {
                self.keeps_grasps(&of_state)?;
            }
        }
        let points = |tensor: &mut Option<Tensor>, field: &str| -> Result<(), Error> {
            let Some(of) = tensor.take().filter(|t| !t.is_absent()) else { return Ok(()) };
            let (mut shape, values) = of.unpack_points(field)?;
            let own: Vec<_> =
                values.chunks_exact(n).flat_map(|row| self.planner.select(row)).collect();
            shape.pop();
            shape.push(self.planner.nodes.len());
            *tensor = Some(Tensor::pack_points(&shape, &own));
            Ok(())
        };
        points(&mut given.positions, "initial.given.positions")?;
        points(&mut given.velocities, "initial.given.velocities")?;
        if let Some(grasping) = &mut given.grasping {
            points(&mut grasping.places, "initial.given.grasping.places")?;
            if let Some(holders) = grasping.holders.take().filter(|t| !t.is_absent()) {
                let (mut shape, values) =
                    holders.unpack::<u32>("initial.given.grasping.holders")?;
                let own: Vec<u32> =
                    values.chunks_exact(n).flat_map(|row| self.planner.select(row)).collect();
                shape.pop();
                shape.push(self.planner.nodes.len());
                grasping.holders = Some(Tensor::pack(&shape, &own));
            }
        }
        Ok(())
    }

    fn rewrite_nodes(&self, nodes: &mut Option<Tensor>) -> Result<(), Error> {
        if let Some(given) = nodes.take().filter(|nodes| !nodes.is_absent()) {
            *nodes = Some(self.nearest(&given, "costs.nodes")?);
        }
        Ok(())
    }

    /// Replaces the nodes of a chain by the nearest of the planner's nodes, each run of equal ones by one.
    fn rewrite_chain(&self, nodes: &mut Option<Tensor>, field: &str) -> Result<(), Error> {
        let Some(given) = nodes.take().filter(|nodes| !nodes.is_absent()) else { return Ok(()) };
        let mut own = self.each_nearest(&given, field)?;
        own.dedup();
        if own.len() < 2 {
            let fault = "are all nearest to the same node of the planner's twin: name `skin_points`, or ask for EXACT";
            return Err(Error::field(field, fault));
        }
        *nodes = Some(Tensor::pack(&[own.len()], &own));
        Ok(())
    }

    /// The points of the skin that are nodes of the twin.
    fn points(&self, nodes: &Tensor, field: &str) -> Result<Tensor, Error> {
        let (shape, nodes) = nodes.unpack::<u32>(field)?;
        let points: Vec<u32> = nodes.iter().map(|&node| self.skin_points as u32 + node).collect();
        Ok(Tensor::pack(&shape, &points))
    }

    /// The planner's nodes that stand for nodes of the twin, each once.
    fn nearest(&self, nodes: &Tensor, field: &str) -> Result<Tensor, Error> {
        let mut own = self.each_nearest(nodes, field)?;
        own.sort_unstable();
        own.dedup();
        Ok(Tensor::pack(&[own.len()], &own))
    }

    /// The planner's node nearest to each of these nodes of the twin.
    fn each_nearest(&self, nodes: &Tensor, field: &str) -> Result<Vec<u32>, Error> {
        let (_, nodes) = nodes.unpack::<u32>(field)?;
        let own = |node: &u32| self.nearest.get(*node as usize).copied();
        Ok(nodes.iter().filter_map(own).collect())
    }
}

/// True if targets are measured to the skin.
fn is_at_skin(of: PointSet) -> bool {
    rollout::measured(of) != PointSet::Nodes
}
