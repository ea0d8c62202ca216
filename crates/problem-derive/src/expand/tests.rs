use syn::parse_quote;

use super::*;

/// The message of a refusal, or nothing.
fn refusal(input: &DeriveInput) -> String {
    problem(input).map_or_else(|error| error.to_string(), |_| String::new())
}

#[track_caller]
fn refused(input: &DeriveInput, because: &str) {
    let found = refusal(input);
    assert!(found.contains(because), "{found:?} instead of {because:?}");
}

#[test]
fn a_variant_without_category_and_reason_is_named() {
    let silent: DeriveInput = parse_quote! {
        enum Error { #[problem(NotFound, "GONE")] Gone, Silent }
    };
    refused(&silent, "`Silent` has no category and reason: say `#[problem(");
    refused(&parse_quote! { struct Silent; }, "`Silent` has no category and reason");
}

#[test]
fn a_type_may_speak_for_its_variants() {
    let spoken: DeriveInput = parse_quote! {
        #[problem(Internal, "BROKEN")]
        enum Error { One, #[error(transparent)] Two(Cause) }
    };
    assert_eq!(refusal(&spoken), "");
}

#[test]
fn half_of_it_is_refused() {
    for half in [
        parse_quote! { #[problem(NotFound)] struct E; },
        parse_quote! { #[problem("GONE")] struct E; },
        parse_quote! { #[problem(transparent, "GONE")] struct E(Cause); },
        parse_quote! { #[problem()] struct E; },
    ] {
        refused(&half, "expected a category and a reason, like");
    }
}

#[test]
fn arguments_are_known_and_said_once() {
    refused(
        &parse_quote! { #[problem(NotFound, "GONE", delay = SOON)] struct E; },
        "expected `retry` or `fault`",
    );
    refused(&parse_quote! { #[problem(NotFound, "GONE", "LOST")] struct E; }, "said twice");
    refused(&parse_quote! { #[problem(NotFound, Internal, "GONE")] struct E; }, "said twice");
}

#[test]
fn a_reason_is_a_word_in_capitals() {
    for reason in ["gone", "", "GONE_", "NOT FOUND"] {
        let input: DeriveInput = parse_quote! { #[problem(NotFound, #reason)] struct E; };
        refused(&input, "UPPER_SNAKE_CASE");
    }
}

#[test]
fn conditions_leave_one_case_for_all_others() {
    let open: DeriveInput = parse_quote! {
        enum Error { #[problem(NotFound, "GONE", if *is_gone)] Gone { is_gone: bool } }
    };
    refused(&open, "the last `#[problem]` is for all other cases");
    let hidden: DeriveInput = parse_quote! {
        enum Error {
            #[problem(NotFound, "GONE")]
            #[problem(Internal, "BROKEN")]
            Gone
        }
    };
    refused(&hidden, "hides those after it");
}

#[test]
fn a_cause_is_found_or_asked_for() {
    for named in [
        parse_quote! { #[problem(transparent)] struct E { fault: Cause } },
        parse_quote! { #[problem(transparent)] struct E { name: String, error: Cause } },
        parse_quote! { #[problem(transparent)] struct E { name: String, source: Cause } },
        parse_quote! { #[problem(transparent)] struct E(Cause); },
    ] {
        assert_eq!(refusal(&named), "");
    }
    for unnamed in [
        parse_quote! { #[problem(transparent)] struct E { name: String, fault: Cause } },
        parse_quote! { #[problem(transparent)] struct E(String, Cause); },
        parse_quote! { #[problem(transparent)] struct E; },
    ] {
        refused(&unnamed, "the cause is the only field, or the one that is named");
    }
    refused(&parse_quote! { union E { a: u8 } }, "a union is no error");
}
