//! The adjoint of a surrounded frame, substep by substep from the tape in exactly the reverse order.

use super::{Frame, scene};
use crate::cpu::{
    arithmetic::{Machine, Node, Quad, Real, Work, add, add_scaled, dot, scale, sub},
    collision::{
        clearance::{Clearance, ClearanceAdjoint},
        contact::{collide, collide_adjoint},
        impulse::Law,
        meet::Meeting,
    },
    elements::{bend_adjoint, bend_forces, rod_adjoint, rod_forces, spring_adjoint, spring_forces},
    frame::{
        adjoint::{Adjoint, BackSubsteps, accelerate_adjoint},
        control::progress,
        integrate::Workspace,
    },
    surroundings::{
        Around, Surroundings,
        clamp::hold_rods_adjoint,
        force::{ForceSeeds, free_momentum},
        grasp::AroundAdjoint,
    },
    system::System,
};

/// The substeps on tape, backward. `seeds` are d loss / d mean forces of the frame, if it has any.
pub(crate) struct BackSurrounded<'a, T> {
    pub(crate) of: &'a Surroundings<T>,
    pub(crate) seeds: Option<&'a ForceSeeds<T>>,
    pub(crate) plain: BackSubsteps<'a, T>,
}

impl<T: Real> Work<T> for BackSurrounded<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<M: Machine<T>>(self, m: M) {
        let Self { of, seeds, plain } = self;
        let BackSubsteps { system, workspace: w, start, adjoint: a } = plain;
        let own = w.around.system.clone();
        let system = own.as_deref().unwrap_or(system);
        let (e, n, r) = (system.endpoints(), system.nodes, system.rods.rods.len());
        let share = T::from_f64(1.0 / system.substeps as f64);
        let by_grasp: Vec<Quad<T>> =
            seeds.map_or_else(Vec::new, |s| s.grasps.iter().map(|&f| scale(f, share)).collect());
        let mut meetings = Vec::new();
        for on_tape in (0..a.tape.substeps).rev() {
            let substep = start + on_tape;
            let nodes = &a.tape.nodes[on_tape * e..(on_tape + 1) * e];
            let before = &a.tape.before[on_tape * n..(on_tape + 1) * n];
            let twists = &a.tape.twists[on_tape * r..(on_tape + 1) * r];
            let t = progress(system, substep);
            a.around.hold_nodes((of, &w.around), system, t, &mut a.bar);
            a.controls.pin_nodes(system, substep, &mut a.bar);
            w.around.place_obstacles(of, system, substep);
            let touches = !w.candidates.is_empty();
            if touches {
                collide(system, &w.candidates, nodes, before, &mut w.after);
            }
            let velocities = if touches { &w.after } else { before };
            let travel = Travel { of, system, seeds, clearance: &w.clearance, around: &w.around };
            let state = (nodes, velocities);
            let bars = (&mut *a.bar, &mut *a.start_bar);
            let surfaces = (&mut a.around, &mut a.clearance);
            travel.back(state, bars, &mut a.ground, surfaces, &mut meetings);
            if touches {
                let bars = (&mut *a.bar, &mut *a.start_bar);
                let (scratch, law_bar) = (&mut w.after, &mut a.object);
                collide_adjoint(system, &w.candidates, nodes, before, bars, scratch, law_bar);
            }
            if let Some(seeds) = seeds {
                let rate = T::from_f64(1.0 / system.frame_s);
                for (node, seed) in seeds.held(of, system, &w.around) {
                    let bar = &mut a.bar[node].v;
                    *bar = add_scaled(*bar, system.masses[node] * rate, seed);
                }
            }
            a.around.hold_velocities((of, &w.around), system, &mut a.bar);
            a.controls.pin_velocities(system, &mut a.bar);
            let bars = (&mut *a.bar, &mut *a.start_bar);
            a.drag += accelerate_adjoint(system, before, bars, &mut a.lambda);
            if let Some(seeds) = seeds {
                a.drag +=
                    seed_held(m, seeds, of, system, (nodes, twists), w, &mut a.bar, &mut a.lambda);
                for (lambda, &seed) in a.lambda[n..].iter_mut().zip(&seeds.controls) {
                    *lambda = scale(seed, -share);
                }
            }
            let pulls = (&*a.lambda, &*by_grasp);
            a.around.pull((of, &w.around), system, substep, pulls, &mut a.bar);
            spring_adjoint(m, &system.springs, nodes, &a.lambda, &mut a.bar, &mut a.springs);
            bend_adjoint(m, &system.triplets, nodes, &a.lambda, &mut a.bar, &mut a.triplets);
            let (rods, gradients) = (&system.rods, &mut a.rods);
            let twists = (twists, &*w.around.roll_rates);
            let twist_bars = (&mut *a.twist_bar, &mut *a.around.roll_rates);
            let (lambda, bar) = (&a.lambda, &mut a.bar);
            rod_adjoint(m, rods, system.dt, nodes, twists, lambda, bar, twist_bars, gradients);
            a.controls.place(system, substep, &mut a.bar);
        }
        a.lambda[n..].fill([T::ZERO; 4]);
    }
}

/// Adjoint of the impulses with which nodes are held in a substep, but for the velocities that they
/// are held with; gives d loss / d drag. With `J = m v_held - decay (m v + (f + m g) dt)`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn seed_held<T: Real, M: Machine<T>>(
    m: M,
    seeds: &ForceSeeds<T>,
    of: &Surroundings<T>,
    system: &System<T>,
    (nodes, twists): (&[Node<T>], &[T]),
    w: &mut Workspace<T>,
    bar: &mut [Node<T>],
    lambda: &mut [Quad<T>],
) -> T {
    let held = seeds.held(of, system, &w.around);
    if held.iter().all(|(_, seed)| *seed == [T::ZERO; 4]) {
        return T::ZERO;
    }
    // Forces on prescribed nodes are not on tape.
    spring_forces(m, &system.springs, nodes, &mut w.forces);
    bend_forces(m, &system.triplets, nodes, &mut w.forces);
    let mut twists = twists.to_vec();
    let both = (&mut *twists, &*w.around.roll_rates);
    rod_forces(m, &system.rods, system.dt, nodes, both, &mut w.forces);
    let rate = system.decay * T::from_f64(1.0 / system.frame_s);
    let mut drag = T::ZERO;
    for (node, seed) in held {
        let free = free_momentum(system, node, nodes[node].v, w.forces[node]);
        drag += system.dt * rate * dot(seed, free);
        lambda[node] = add_scaled(lambda[node], -(rate * system.dt), seed);
        bar[node].v = add_scaled(bar[node].v, -(rate * system.masses[node]), seed);
    }
    w.forces.fill([T::ZERO; 4]);
    drag
}

/// Adjoint of what nodes meet in a substep.
struct Travel<'a, T> {
    of: &'a Surroundings<T>,
    system: &'a System<T>,
    seeds: Option<&'a ForceSeeds<T>>,
    clearance: &'a Clearance<T>,
    around: &'a Around<T>,
}

impl<T: Real> Travel<'_, T> {
    #[inline(always)]
    fn back(
        &self,
        (nodes, velocities): (&[Node<T>], &[Quad<T>]),
        (bar, start_bar): (&mut [Node<T>], &mut [Quad<T>]),
        law_bar: &mut Law<T>,
        (around_bar, clearance_bar): (&mut AroundAdjoint<T>, &mut ClearanceAdjoint<T>),
        meetings: &mut Vec<Meeting<T>>,
    ) {
        let Self { of, system, seeds, clearance, around } = *self;
        let scene = scene(of, system, &around.obstacles, clearance);
        let rate = T::from_f64(1.0 / system.frame_s);
        for (i, (node, &v)) in nodes.iter().zip(velocities).enumerate() {
            if system.inverse_mass[i] == T::ZERO {
                continue;
            }
            meetings.clear();
            scene.advance(i, *node, v, |m| meetings.push(*m));
            let seed = |with: Option<usize>| {
                let Some(seeds) = seeds else { return [T::ZERO; 4] };
                let by = match with {
                    None => seeds.ground,
                    Some(o) => seeds.colliders[around.obstacles[o].collider],
                };
                scale(by, system.masses[i] * rate)
            };
            let state = (node.x, &**meetings);
            let surfaces = (&mut *around_bar, &mut *clearance_bar);
            (bar[i], start_bar[i]) =
                scene.advance_adjoint(i, state, bar[i], seed, law_bar, surfaces);
        }
    }
}

/// Adjoint of the beginning of a frame; `nodes` that were taken are where they are then.
///
/// Returns, by node, what d loss / d forces adds to the velocities with which held nodes arrive.
pub(crate) fn begin_adjoint<T: Real>(
    at: Frame<'_, T>,
    system: &System<T>,
    around: &Around<T>,
    seeds: Option<&ForceSeeds<T>>,
    a: &mut Adjoint<T>,
) -> Vec<(usize, Quad<T>)> {
    let of = at.of;
    let system = around.system.as_deref().unwrap_or(system);
    let rate = T::from_f64(1.0 / system.frame_s);
    let jumps: Vec<(usize, Quad<T>)> = seeds.map_or_else(Vec::new, |seeds| {
        let held = seeds.held(of, system, around);
        held.into_iter().map(|(i, seed)| (i, scale(seed, system.masses[i] * rate))).collect()
    });
    for &(node, jump) in &jumps {
        a.bar[node].v = add(a.bar[node].v, jump);
    }
    a.around.hold_nodes((of, around), system, T::ZERO, &mut a.bar);
    a.controls.begin(system, &mut a.bar);
    a.around.roll_rates(of, around, system);
    hold_rods_adjoint(around, &mut a.twist_bar, &mut a.rods);
    a.around.taken(of, around, &mut a.bar);
    jumps.into_iter().map(|(node, jump)| (node, sub([T::ZERO; 4], jump))).collect()
}
