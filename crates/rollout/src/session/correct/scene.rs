//! Surroundings of the slots of a session at the moment of a correction: those that the request gives,
//! or those in which a slot was advanced last, where that ended, or before an advance the session's.

use bendtwin_core::{Environment, Twin};
use bendtwin_engine::{
    model::State,
    world::{Phase, Pose},
};
use bendtwin_proto::v1::{self, Tensor, grasp::Region};
use bendtwin_register::Around;

use super::super::Setup;
use crate::{
    error::Error,
    request::{actions::pose, initial::Start},
    world::Still,
};

/// Surroundings of slots.
pub(super) struct Scene {
    given: Option<Still>,
    session: Still,
    /// Poses of the first grippers.
    grippers: Vec<Pose>,
    /// Control points of each grasp of the session, shape [G].
    hands: Vec<Vec<u32>>,
}

impl Scene {
    pub(super) fn read(
        options: &v1::CorrectOptions,
        setup: &Setup,
        twin: &Twin,
    ) -> Result<Self, Error> {
        let grippers = grippers(options.grippers.as_ref(), "options.grippers")?;
        let given = options.world.as_ref().map(|world| Still::among(Some(world), &grippers));
        let hands = twin.hands();
        let controls = |hand: u32| {
            let own = hands.iter().zip(0..).filter(move |(of, _)| **of == hand);
            own.map(|(_, control)| control).collect()
        };
        let of_grasp = |grasp: &v1::Grasp| match &grasp.region {
            Some(Region::Hand(hand)) => controls(hand.hand),
            _ => Vec::new(),
        };
        Ok(Self {
            given: given.transpose()?,
            session: Still::among(setup.world.as_ref(), &grippers)?,
            grippers,
            hands: setup.grasps.iter().map(of_grasp).collect(),
        })
    }

    /// The environment of a slot, of a twin with this one, and what is around it.
    pub(super) fn of(&self, start: &Start, own: Environment) -> (Environment, Around) {
        let advanced = start.around.as_ref();
        let around = advanced.map(|ended| ended.around(&start.state, &self.grippers));
        let loose = match &around {
            Some(around) => around.loose.clone(),
            None => self.open(&start.state),
        };
        let (environment, around) = match (&self.given, advanced.zip(around)) {
            (None, Some((ended, around))) => (ended.environment, around),
            (given, _) => {
                let world = given.as_ref().unwrap_or(&self.session);
                (world.environment(own).unwrap_or(own), world.around_now())
            }
        };
        (environment, Around { loose, ..around })
    }

    /// Control points of hands that a state has open, by the grasps of the session.
    fn open(&self, state: &State) -> Vec<u32> {
        let phases = state.grasping.phases.iter().zip(&self.hands);
        let open = phases.filter(|(phase, _)| **phase == Phase::Open);
        open.flat_map(|(_, controls)| controls).copied().collect()
    }
}

/// Poses of grippers of a checked request, shape [G]; none if it has none.
pub(crate) fn grippers(wire: Option<&Tensor>, field: &str) -> Result<Vec<Pose>, Error> {
    let Some(tensor) = wire.filter(|t| !t.is_absent()) else { return Ok(Vec::new()) };
    let (_, rows) = tensor.unpack::<f32>(field)?;
    Ok(rows.as_chunks::<7>().0.iter().map(|row| pose(*row)).collect())
}
