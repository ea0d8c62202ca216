//! The kernels go through NVRTC wherever it is, with or without a GPU.

use super::*;
use crate::device::compile;

/// Set where NVRTC has been installed for these tests.
const REQUIRED: &str = "BENDTWIN_NVRTC";

fn variants() -> Vec<Variant> {
    let base = Variant { ground: true, ..Variant::small(Source::Integrate) };
    let mut variants: Vec<Variant> = Source::SMALL.map(Variant::small).to_vec();
    let forward = [
        Variant {
            threads: 1024,
            lanes: 2,
            half_springs_in_shared: true,
            uniform_dashpot: true,
            ..base
        },
        Variant { threads: 1024, instances: 4, one_row: false, bending: true, ..base },
        Variant { meeting: Meeting::Cluster, blocks: 16, lanes: 4, threads: 512, held: 6, ..base },
        Variant { meeting: Meeting::Grid, blocks: 132, one_row: false, tape: true, ..base },
        Variant {
            meeting: Meeting::Cluster,
            blocks: 8,
            bending: true,
            tape: true,
            held: 4,
            ..base
        },
        Variant { meeting: Meeting::Cluster, blocks: 4, bending: true, one_row: false, ..base },
        Variant { meeting: Meeting::Cluster, blocks: 2, contact: true, bending: true, ..base },
        Variant {
            threads: 128,
            lanes: 8,
            bending: true,
            rods: 1,
            bend_in_shared: true,
            tape: true,
            ..base
        },
        Variant { threads: 64, instances: 4, bending: true, rods: 3, bend_in_shared: true, ..base },
        Variant { threads: 256, one_row: false, bending: true, rods: 16, contact: true, ..base },
    ];
    for forward in forward {
        let held_sums = forward.held / 2;
        variants.push(forward);
        let (source, instances) = (Source::Adjoint, 1);
        let threads = forward.threads.min(512);
        variants.push(Variant { source, instances, threads, held_sums, tape: false, ..forward });
    }
    variants
}

#[test]
fn nvrtc_takes_all_kernels() {
    if !compile::is_present() {
        assert!(std::env::var_os(REQUIRED).is_none(), "NVRTC was installed but cannot be loaded");
        eprintln!("SKIPPED: NVRTC is not on this machine, the kernels were not compiled");
        return;
    }
    for architecture in [80, 90] {
        for variant in variants() {
            if variant.meeting == Meeting::Cluster && architecture < 90 {
                continue;
            }
            let cubin = compile::compile(&variant.text(), &options(architecture));
            let cubin = cubin.unwrap_or_else(|e| panic!("{variant:?} for sm_{architecture}: {e}"));
            assert!(!cubin.is_empty());
        }
    }
}

#[test]
fn a_fault_in_a_kernel_is_told_with_its_place() {
    if !compile::is_present() {
        return;
    }
    let text = format!("{}\nnonsense", Variant::small(Source::Record).text());
    let error = compile::compile(&text, &options(90)).expect_err("nonsense").to_string();
    assert!(error.contains("record.cu") && error.contains("nonsense"), "{error}");
}
