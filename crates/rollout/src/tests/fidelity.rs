//! Exact or fast.

use bendtwin_contract::rollout;
use bendtwin_core::{FastVariant, Fidelity};
use bendtwin_proto::v1;

use super::*;

#[test]
fn a_fast_rollout_uses_the_variant_and_says_how_far_it_strays() {
    let mut bench = Bench::new();
    let mut twin = twin();
    twin.quality.fast = Some(FastVariant {
        substeps: 20,
        rate_limit: Some(0.5),
        mean_deviation_m: 5e-4,
        max_deviation_m: 2e-3,
        mean_travel_m: 0.1,
        frames: 30,
    });
    let (id, loaded) = (bench.warm.id, bench.warm.loaded.clone());
    bench.warm = Arc::new(Warm::new(id, twin, loaded, None));
    let choose = |fidelity| Served::choose(Arc::clone(&bench.warm), fidelity, &bench.backend);
    let (exact, fast) = (choose(Fidelity::Exact).unwrap(), choose(Fidelity::Fast).unwrap());
    let run = |served: Served| {
        let mut request = request(2);
        request.returns = Some(Returns { final_state: true, ..Returns::default() });
        let (plan, wanted) = bench.plan_for(request, 0, served).unwrap();
        let Wanted::Ready(starts) = wanted else { panic!("no captures here") };
        bench.execute(&plan, &starts).unwrap().remove(0)
    };
    let (exact, fast) = (run(exact), run(fast));
    assert_eq!((exact.fidelity(), exact.substeps), (v1::Fidelity::Exact, 60));
    assert_eq!((fast.fidelity(), fast.substeps), (v1::Fidelity::Fast, 20));
    assert_eq!(exact.deviation, None);
    let deviation = fast.deviation.unwrap();
    assert_eq!((deviation.mean_m, deviation.frames), (5e-4, 30));
    assert_ne!(exact.final_positions, fast.final_positions);
}

#[test]
fn a_twin_without_a_fast_variant_says_what_to_do() {
    let bench = Bench::new();
    let refused =
        Served::choose(Arc::clone(&bench.warm), Fidelity::Fast, &bench.backend).err().unwrap();
    assert_eq!(refused.category(), Category::FailedPrecondition);
    assert_eq!(refused.reason(), "FAST_VARIANT_UNKNOWN");
    assert!(refused.to_string().contains("ask for EXACT"), "{refused}");
    let error = rollout::fidelity(7).unwrap_err();
    assert!(error.to_string().contains("fidelity"), "{error}");
}
