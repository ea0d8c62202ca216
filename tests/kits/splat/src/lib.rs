//! Conformance suite of rasterisers, as one list of named cases. The crate of a rasteriser turns
//! each case into a separate test:
//!
//! ```ignore
//! bendtwin_splat_kit::conformance_tests!(MyRasteriser::new());
//! ```
//!
//! A case compares with a plain second implementation in f64, whose gradients are finite
//! differences, or compares a rasteriser with itself. Every tolerance is stated at its use, with
//! its reason.

mod degenerate;
mod expect;
mod gradients;
mod images;
mod reference;
mod refusals;
mod scene;

use bendtwin_splat::Rasteriser;

pub use self::scene::{SceneOptions, random_bar, random_camera, random_gaussians};

/// A named case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Name, unique within the suite.
    pub name: &'static str,
    /// Runs the case; the error states the expected and the actual values.
    pub check: fn(&mut dyn Rasteriser) -> Result<(), String>,
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

        /// Makes one `#[test]` of every case of the conformance suite, on the rasteriser that the
        /// expression gives. Attributes behind it are put on every test:
        /// `conformance_tests!(rasteriser(), #[ignore = "..."])`.
        #[macro_export]
        macro_rules! conformance_tests {
            ($d rasteriser:expr $d(, #[$d attribute:meta])*) => {
                $($(
                    #[test]
                    $d(#[$d attribute])*
                    fn $case() {
                        let case = $d crate::case(stringify!($case));
                        let case = case.expect("the suite has a case of this name");
                        if let Err(why) = (case.check)(&mut $d rasteriser) {
                            panic!("{why}");
                        }
                    }
                )+)+
            };
        }
    };
}

suite! { ($)
    images:
        images_are_those_of_a_plain_rasteriser,
        one_gaussian_has_its_closed_form,
        the_order_of_the_set_does_not_matter,
        crops_are_parts_of_the_whole,
        repeats_are_identical;
    gradients:
        gradients_match_finite_differences,
        gradients_of_needles_and_plates,
        gradients_of_an_opaque_pile,
        gradients_beside_the_image,
        gradients_stand_by_themselves;
    degenerate:
        an_empty_set_is_black,
        nothing_in_view_is_black,
        behind_the_camera_is_black,
        one_huge_gaussian_fills_the_image,
        thousands_in_one_pixel,
        degenerate_scales_stay_exact,
        absurd_numbers_stay_finite;
    refusals:
        wrong_gaussians_are_refused,
        wrong_cameras_are_refused,
        wrong_derivatives_are_refused,
        too_much_work_is_refused;
}
