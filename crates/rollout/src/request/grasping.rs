//! Holds of grasps, as part of a state: the arrays of a message, and the engine's list of holds.

use bendtwin_engine::{
    model::State,
    world::{Grasping, Hold, Phase},
};
use bendtwin_proto::v1::{Grasping as Wire, Tensor};

use crate::error::Error;

/// Reads a checked message of `states` states with `nodes` nodes each.
pub(crate) fn read(wire: &Wire, states: usize, nodes: usize) -> Result<Vec<Grasping>, Error> {
    let tensor = |tensor: &Option<Tensor>| tensor.clone().unwrap_or_default();
    let (_, phases) = tensor(&wire.phases).unpack::<u32>("initial.given.grasping.phases")?;
    let (_, holders) = tensor(&wire.holders).unpack::<u32>("initial.given.grasping.holders")?;
    let (_, places) = tensor(&wire.places).unpack_points("initial.given.grasping.places")?;
    let grasps = phases.len().checked_div(states).unwrap_or(0);
    let of = |state: usize| {
        let held = state * nodes..(state + 1) * nodes;
        let holds = holders[held.clone()].iter().zip(&places[held]).zip(0u32..);
        Grasping {
            phases: phases[state * grasps..(state + 1) * grasps]
                .iter()
                .map(|p| phase(*p))
                .collect(),
            holds: holds
                .filter_map(|((holder, place), node)| {
                    let grasp = holder.checked_sub(1)?;
                    Some(Hold { node, grasp, place: *place })
                })
                .collect(),
        }
    };
    Ok((0..states).map(of).collect())
}

/// The message of the grasps of states with `nodes` nodes each; a state that is not there, as that
/// of an instance that diverged, has open grasps.
pub(crate) fn pack<'s>(
    states: impl ExactSizeIterator<Item = Option<&'s State>>,
    grasps: usize,
    nodes: usize,
) -> Wire {
    let count = states.len();
    let mut phases = vec![Phase::Open as u32; count * grasps];
    let mut holders = vec![0u32; count * nodes];
    let mut places = vec![[0.0f32; 3]; count * nodes];
    for (row, state) in states.enumerate() {
        let Some(Grasping { phases: known, holds }) = state.map(|s| &s.grasping) else { continue };
        for (phase, known) in phases[row * grasps..(row + 1) * grasps].iter_mut().zip(known) {
            *phase = *known as u32;
        }
        for hold in holds.iter().filter(|hold| (hold.node as usize) < nodes) {
            let at = row * nodes + hold.node as usize;
            holders[at] = hold.grasp + 1;
            places[at] = hold.place;
        }
    }
    Wire {
        phases: Some(Tensor::pack(&[count, grasps], &phases)),
        holders: Some(Tensor::pack(&[count, nodes], &holders)),
        places: Some(Tensor::pack_points(&[count, nodes], &places)),
    }
}

fn phase(wire: u32) -> Phase {
    match wire {
        1 => Phase::Closed,
        2 => Phase::Slipped,
        _ => Phase::Open,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_survives_the_wire() {
        let hold = |node, grasp, x| Hold { node, grasp, place: [x, 0.5, -1.0] };
        let first = Grasping {
            phases: vec![Phase::Closed, Phase::Slipped],
            holds: vec![hold(0, 0, 0.1), hold(3, 0, 0.2)],
        };
        let second =
            Grasping { phases: vec![Phase::Open, Phase::Closed], holds: vec![hold(2, 1, 0.3)] };
        let states = [first, second].map(|grasping| State { grasping, ..State::default() });
        let wire = pack(states.iter().map(Some), 2, 4);
        let read = read(&wire, 2, 4).unwrap();
        assert_eq!(read, states.map(|s| s.grasping));
        // A single state has no batch in front.
        let unpacked = |shape: &[usize], of: &Option<Tensor>| {
            let (_, values) = of.as_ref().unwrap().unpack::<u32>("t").unwrap();
            Some(Tensor::pack(shape, &values[..shape[0]]))
        };
        let (_, places) = wire.places.as_ref().unwrap().unpack_points("p").unwrap();
        let single = Wire {
            phases: unpacked(&[2], &wire.phases),
            holders: unpacked(&[4], &wire.holders),
            places: Some(Tensor::pack_points(&[4], &places[..4])),
        };
        assert_eq!(super::read(&single, 1, 4).unwrap(), read[..1]);
        let lost = pack([None].into_iter(), 2, 4);
        assert_eq!(super::read(&lost, 1, 4).unwrap()[0].holds, []);
    }
}
