//! Conformance suite of backends, as one list of named cases. A backend's crate turns each case
//! into a separate test:
//!
//! ```ignore
//! bendtwin_engine_kit::conformance_tests!(MyBackend::new());
//! ```
//!
//! A case derives the physics from first principles (closed forms, `f64` energies, conservation
//! laws) or compares a backend with itself (batches, repeats, finite differences of its
//! losses). Every tolerance is stated at its use, with its reason.

mod differences;
mod energy;
mod expect;
mod interface;
mod physics;
mod random;
mod scene;

use bendtwin_engine::Backend;

use self::{
    interface::{batches, degenerate, gradients, objectives, optimizer, refusals, tasks},
    physics::{
        bending, clamps, colliders, conservation, contact, forces, grasps, ground, rest, skin,
        skin_contact, smooth, springs, twist,
    },
};
pub use self::{
    physics::skin::in_frames,
    random::{
        RandomOptions, random_model, random_motion,
        tasks::task_terms,
        world::{WorldOptions, count_forces, random_world},
    },
};

/// A named case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name, unique within the suite.
    pub name: &'static str,
    /// Runs the case; the error states the expected and the actual values.
    pub check: fn(&dyn Backend) -> Result<(), String>,
}

/// Result of the suite on one backend.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Cases that passed.
    pub passed: Vec<&'static str>,
    /// Failed cases, with the expected and the actual result.
    pub failed: Vec<(&'static str, String)>,
}

impl Report {
    /// True if all cases passed.
    pub fn is_ok(&self) -> bool {
        self.failed.is_empty()
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} passed, {} failed", self.passed.len(), self.failed.len())?;
        self.failed.iter().try_for_each(|(name, why)| writeln!(f, "{name}: {why}"))
    }
}

/// Runs all cases on a backend. A panic counts as a failure of its case.
pub fn run(backend: &dyn Backend) -> Report {
    let mut report = Report::default();
    for case in cases() {
        match run_case(&case, backend) {
            Ok(()) => report.passed.push(case.name),
            Err(why) => report.failed.push((case.name, why)),
        }
    }
    report
}

/// Runs one case; a panic becomes an error.
///
/// # Errors
/// The message gives the expected and the actual result.
pub fn run_case(case: &Case, backend: &dyn Backend) -> Result<(), String> {
    let check = std::panic::AssertUnwindSafe(|| (case.check)(backend));
    std::panic::catch_unwind(check).unwrap_or_else(|_| Err("the backend panicked".into()))
}

/// The case of that name.
pub fn case(name: &str) -> Option<Case> {
    cases().into_iter().find(|c| c.name == name)
}

/// Lists the cases once, for [`cases`] and for [`conformance_tests!`] alike.
/// `$d` is a dollar sign, which the inner macro needs and cannot be written here.
macro_rules! suite {
    (($d:tt) $($module:ident: $($case:ident),+;)+) => {
        /// All cases.
        pub fn cases() -> Vec<Case> {
            vec![$($(Case { name: stringify!($case), check: $module::$case },)+)+]
        }

        /// Makes one `#[test]` of every case of the conformance suite, on the
        /// backend that the expression gives. Attributes behind it are put on
        /// every test: `conformance_tests!(backend(), #[ignore = "..."])`.
        #[macro_export]
        macro_rules! conformance_tests {
            ($d backend:expr $d(, #[$d attribute:meta])*) => {
                $($(
                    #[test]
                    $d(#[$d attribute])*
                    fn $case() {
                        let case = $d crate::case(stringify!($case));
                        let case = case.expect("the suite has a case of this name");
                        if let Err(why) = (case.check)(&$d backend) {
                            panic!("{why}");
                        }
                    }
                )+)+
            };
        }
    };
}

suite! { ($)
    springs:
        oscillator_frequency,
        damped_oscillator_decays,
        hanging_chain_stretches,
        drag_decays_exponentially,
        pinned_node_follows_its_control,
        control_spring_drags_a_node,
        ignored_control_velocity_leaves_a_lag;
    bending:
        forces_are_minus_the_energy_gradient,
        damping_forces_take_power,
        cantilever_bends_like_the_discrete_beam,
        straight_rod_stays_smooth_through_pi;
    twist:
        clamps_twist_by_the_solid_angle,
        energy_of_a_twisted_rod,
        twist_damping_never_raises_energy,
        twist_turns_a_bow_out_of_its_plane,
        a_branch_swings_about_its_rod,
        rods_without_stiffness_change_nothing;
    ground:
        bouncing_node_loses_restitution_squared,
        sliding_node_stops_by_coulomb_friction,
        friction_holds_on_a_slope,
        smooth_contact_is_near_the_hard_one,
        what_lies_still_reports_no_speed;
    rest:
        what_is_pressed_does_not_bounce,
        what_rests_does_not_creep,
        what_lies_on_nodes_does_not_sink,
        gradients_through_resting_contact;
    contact:
        colliding_objects_exchange_momentum,
        a_node_takes_the_mean_of_its_contacts,
        self_contact_keeps_distance,
        self_contact_spares_neighbours;
    grasps:
        a_held_node_follows_its_body,
        a_spring_hold_has_its_frequency,
        a_hand_takes_what_is_inside,
        opening_lets_fall,
        control_points_release,
        a_hand_slips_above_its_force,
        grasps_resume_exactly,
        a_rolling_clamp_twists_its_rod;
    clamps:
        an_opened_clamp_lets_the_twist_out,
        a_hand_takes_a_cable_anywhere,
        a_hand_rolls_what_it_holds,
        hands_that_turn_a_cable_do_not_twist_it,
        twist_spreads_over_a_longer_span,
        gradients_through_regrasps;
    colliders:
        a_node_rests_on_a_box,
        friction_on_an_inclined_box,
        a_moving_tray_carries_by_friction,
        a_moving_wall_gives_momentum,
        capsules_reflect_along_their_normals,
        colliders_push_out;
    forces:
        a_chain_hangs_by_its_weight,
        contact_carries_the_weight,
        forces_balance_momentum,
        measuring_changes_nothing;
    conservation:
        energy_of_an_undamped_network,
        momentum_of_a_free_body,
        axial_dashpots_never_raise_energy,
        bend_damping_never_raises_energy;
    objectives:
        losses_match_their_definitions,
        frame_costs_match_their_definitions,
        outputs_are_as_asked,
        velocities_are_those_of_the_states,
        diagnostics_match_the_motion,
        extremes_are_those_of_all_diagnostics;
    tasks:
        a_helix_winds_as_often_as_it_turns,
        points_on_the_line_have_no_angle,
        only_the_ends_of_a_chain_turn,
        points_in_order_cost_nothing,
        covered_points_cost_nothing;
    skin:
        skins_follow_affine_motions,
        skins_follow_rigid_motions,
        frames_without_a_triangle_hold_nothing_off,
        gradients_of_skin_terms,
        a_skin_of_nodes_is_the_nodes;
    skin_contact:
        a_skin_does_not_sink,
        what_rests_on_its_skin_does_not_creep,
        the_ground_bears_what_lies_on_its_skin,
        a_skin_at_its_nodes_touches_as_they_do,
        gradients_through_skin_contact;
    gradients:
        gradients_match_finite_differences,
        gradients_of_a_straight_rod,
        gradients_of_a_twisting_rod,
        gradients_of_a_rolling_clamp,
        gradients_through_grasps,
        gradients_through_ground_contact,
        gradients_through_object_contact,
        gradients_of_every_term,
        norms_are_those_of_restarts,
        cut_gradients_are_sums_of_windows;
    smooth:
        gradients_through_smooth_ground,
        gradients_through_smooth_colliders,
        gradients_of_a_hand_over_the_ground;
    batches:
        batch_equals_one_by_one,
        repeats_are_identical,
        resuming_continues_exactly,
        new_params_equal_a_new_model,
        cancellation_stops_everything;
    optimizer:
        optimizer_measures_gradients,
        optimizer_steps_like_adam,
        optimizer_slices_equal_one_batch,
        optimizer_hands_out_its_model,
        optimizer_goes_back_exactly,
        optimizer_stays_within_bounds,
        optimizer_refuses_nonsense,
        overflowing_gradients_say_so;
    degenerate:
        random_graphs_stay_finite,
        random_worlds_stay_finite,
        degenerate_geometry_stays_finite,
        empty_and_lonely_graphs_work,
        divergence_says_where;
    refusals:
        unstable_substeps_are_refused,
        wrong_models_are_refused,
        wrong_inputs_are_refused,
        wrong_surroundings_are_refused;
}
