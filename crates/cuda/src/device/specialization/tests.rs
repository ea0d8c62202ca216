//! The kernels go through NVRTC wherever it is, with or without a GPU.

use super::*;
use crate::device::compile;

/// Set where NVRTC has been installed for these tests.
const REQUIRED: &str = "BENDTWIN_NVRTC";

fn specializations() -> Vec<Specialization> {
    let base = Specialization { ground: true, ..Specialization::small(Source::Integrate) };
    let everything =
        WorldParts { grasps: true, colliders: true, smooth: true, rolls: true, forces: true };
    let small = Source::SMALL.into_iter().chain([Source::Splat]);
    let mut specializations: Vec<Specialization> = small.map(Specialization::small).collect();
    let forward = [
        Specialization {
            threads: 1024,
            lanes: 2,
            half_springs_in_shared: true,
            uniform_dashpot: true,
            ..base
        },
        Specialization { threads: 1024, instances: 4, one_row: false, bending: true, ..base },
        Specialization {
            shape: TeamShape::Cluster,
            blocks: 16,
            lanes: 4,
            threads: 512,
            held: 6,
            ..base
        },
        Specialization {
            shape: TeamShape::Grid,
            blocks: 132,
            one_row: false,
            skin_contact: true,
            tape: true,
            ..base
        },
        Specialization {
            shape: TeamShape::Cluster,
            blocks: 8,
            bending: true,
            tape: true,
            held: 4,
            ..base
        },
        Specialization {
            shape: TeamShape::Cluster,
            blocks: 4,
            bending: true,
            one_row: false,
            ..base
        },
        Specialization {
            shape: TeamShape::Cluster,
            blocks: 2,
            contact: true,
            bending: true,
            ..base
        },
        Specialization {
            threads: 128,
            lanes: 8,
            bending: true,
            rods: 1,
            bend_in_shared: true,
            tape: true,
            ..base
        },
        Specialization {
            threads: 64,
            instances: 4,
            bending: true,
            rods: 3,
            bend_in_shared: true,
            ..base
        },
        Specialization {
            threads: 256,
            one_row: false,
            bending: true,
            rods: 16,
            contact: true,
            ..base
        },
        Specialization {
            threads: 512,
            lanes: 4,
            instances: 2,
            bending: true,
            held: 2,
            world: WorldParts { grasps: true, colliders: true, ..WorldParts::default() },
            ..base
        },
        Specialization {
            threads: 256,
            one_row: false,
            bending: true,
            rods: 2,
            contact: true,
            skin_contact: true,
            tape: true,
            half_springs_in_shared: true,
            world: everything,
            ..base
        },
        Specialization {
            shape: TeamShape::Cluster,
            blocks: 4,
            tape: true,
            world: WorldParts { forces: true, smooth: true, ..WorldParts::default() },
            ..base
        },
        Specialization {
            shape: TeamShape::Grid,
            blocks: 66,
            ground: false,
            world: WorldParts { colliders: true, smooth: true, ..everything },
            ..base
        },
    ];
    for forward in forward {
        let held_sums = forward.held / 2;
        specializations.push(forward);
        let (source, instances) = (Source::Adjoint, 1);
        let threads = forward.threads.min(512);
        specializations.push(Specialization {
            source,
            instances,
            threads,
            held_sums,
            tape: false,
            ..forward
        });
    }
    specializations
}

#[test]
fn nvrtc_takes_all_kernels() {
    if !compile::is_present() {
        assert!(std::env::var_os(REQUIRED).is_none(), "NVRTC was installed but cannot be loaded");
        eprintln!("SKIPPED: NVRTC is not on this machine, the kernels were not compiled");
        return;
    }
    for architecture in [80, 90] {
        for specialization in specializations() {
            if specialization.shape == TeamShape::Cluster && architecture < 90 {
                continue;
            }
            let cubin = compile::compile(&specialization.text(), &options(architecture));
            let cubin =
                cubin.unwrap_or_else(|e| panic!("{specialization:?} for sm_{architecture}: {e}"));
            assert!(!cubin.is_empty());
        }
    }
}

#[test]
fn a_compile_error_names_its_place() {
    if !compile::is_present() {
        return;
    }
    let text = Specialization::small(Source::Outputs).text();
    let checks = "#line 1 \"arguments\"";
    assert!(text.contains(checks), "{checks}");
    let text = text.replace(checks, &format!("nonsense\n{checks}"));
    let error = compile::compile(&text, &options(90)).expect_err("nonsense").to_string();
    assert!(error.contains("outputs.cu") && error.contains("nonsense"), "{error}");
}

/// A kernel whose struct has other fields than the host's, or the same in another order.
#[test]
fn a_struct_that_differs_from_the_hosts_is_refused() {
    let sources = [
        (Source::Optimizer, "double unbias1, unbias2;", "double unbias2, unbias1;", "StepAdamArgs"),
        (
            Source::Params,
            "float3 normal;\n    float offset;",
            "float offset;\n    float3 normal;",
            "Ground",
        ),
        (Source::Params, "float4* bar_v;", "float4* bar_v, *more;", "AdjointArgs"),
        (Source::Loss, "u32 kind, frame;", "u32 frame, kind;", "Term"),
        (Source::Splat, "float fx, fy, cx, cy;", "float cx, cy, fx, fy;", "SplatCamera"),
    ];
    if !compile::is_present() {
        return;
    }
    for (source, declared, changed, name) in sources {
        let text = Specialization::small(source).text();
        assert!(text.contains(declared), "{declared}");
        let changed = compile::compile(&text.replace(declared, changed), &options(90)).map(|_| ());
        let error = changed.expect_err(name).to_string();
        assert!(
            error.contains(&format!("{name} has ")) || error.contains(&format!("{name}::")),
            "{error}"
        );
        assert!(error.contains("on the host"), "{error}");
    }
}

#[test]
fn every_source_checks_the_structs_of_its_kernels() {
    for source in
        Source::SMALL.into_iter().chain([Source::Integrate, Source::Adjoint, Source::Splat])
    {
        let text = Specialization::small(source).text();
        let (kernels, checks) = text.split_once("#line 1 \"arguments\"").expect("there are checks");
        for kernel in kernels.split("__global__").skip(1) {
            let taken = kernel
                .split_once("(const __grid_constant__ ")
                .and_then(|(_, rest)| rest.split_once(" args)"));
            let (name, _) = taken.expect("a kernel takes one struct");
            assert!(checks.contains(&format!("sizeof({name}) ==")), "{name}");
        }
    }
}
