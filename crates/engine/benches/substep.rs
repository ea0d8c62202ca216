//! Cost of a substep on one core: microseconds by number of nodes, forward and with the gradient,
//! spring evaluations a second, and the share of what a hand count of instructions allows; then what
//! contact of the skin adds, and the cost of checking a model's stability. Prints Markdown tables.
//!
//! `cargo bench -p bendtwin-engine`

#[path = "substep/body.rs"]
mod body;
#[path = "substep/bound.rs"]
mod bound;
#[path = "substep/clock.rs"]
mod clock;
#[path = "substep/limits.rs"]
mod limits;

use std::{hint::black_box, sync::Arc};

use bendtwin_core::CancelToken;
use bendtwin_engine::{
    Backend, Model, Objective, Term,
    backend::{GradientRequest, Instance},
    cpu_with_threads, enough_substeps,
    model::State,
    objective::WeightedTerm,
    stable_substeps,
};

use self::{bound::Elements, clock::best_of};

/// Arithmetic of one spring: 6 differences, length (5, root), inverse, stretch, elastic, damping
/// (5, 3), 3 products and 6 additions to the nodes.
const FLOPS_PER_SPRING: f64 = 33.0;
/// Operations of the AVX2 units in a cycle: two fused multiply-adds of eight lanes.
const FLOPS_PER_CYCLE: f64 = 32.0;

struct Cost {
    elements: Elements,
    forward_us: f64,
    gradient_us: f64,
}

fn main() {
    let backend = cpu_with_threads(1);
    println!("{}; times are processor times\n", backend.device().name);
    let flops = limits::fused_flops_per_s();
    let (far, near) = (limits::bytes_per_s(1 << 26), limits::bytes_per_s(1 << 17));
    println!(
        "one core: {:.1} GFLOP/s fp32 fused multiply-add, {:.1} GB/s from memory, {:.1} GB/s from the L2 cache\n",
        flops / 1e9,
        far / 1e9,
        near / 1e9
    );
    println!(
        "bounds: hand count of vector operations (benches/substep/bound.rs) at {:.2} GHz\n",
        flops / FLOPS_PER_CYCLE / 1e9
    );
    for bending in [false, true] {
        table(&*backend, bending, flops);
    }
    small(&*backend, flops);
    skin(&*backend);
    stability();
}

fn table(backend: &dyn Backend, bending: bool, flops: f64) {
    println!("{}\n", if bending { "With bending triplets" } else { "Axial springs only" });
    println!(
        "| nodes | springs | triplets | M springs/s | of peak arithmetic | forward us/substep | bound | share | forward + backward us/substep | bound | share |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let mut per_spring = Vec::new();
    for nodes in [100, 500, 2000, 6000] {
        let c = cost(backend, body::ellipsoid(nodes, bending));
        let rate = c.elements.springs as f64 / c.forward_us;
        per_spring.push(c.forward_us / c.elements.springs as f64);
        println!(
            "| {nodes} | {} | {} | {rate:.0} | {:.1}% | {} |",
            c.elements.springs,
            c.elements.triplets,
            100.0 * rate * 1e6 * FLOPS_PER_SPRING / flops,
            shares(&c, flops),
        );
    }
    let growth = per_spring[3] / per_spring[1];
    println!("\ncost per spring, 6000 nodes over 500: {growth:.2} (1 is linear growth)\n");
}

/// Times, bounds and shares, forward and with the gradient, as cells of a table.
fn shares(c: &Cost, flops: f64) -> String {
    let us = |cycles: f64| cycles * FLOPS_PER_CYCLE / flops * 1e6;
    let cells = |time: f64, cycles: f64| {
        format!("{time:.2} | {:.2} | {:.0}%", us(cycles), 100.0 * us(cycles) / time)
    };
    let forward = cells(c.forward_us, c.elements.forward_cycles());
    format!("{forward} | {}", cells(c.gradient_us, c.elements.gradient_cycles()))
}

fn small(backend: &dyn Backend, flops: f64) {
    let c = cost(backend, body::cable(13));
    println!(
        "| cable of 13 nodes | forward us/substep | bound | share | forward + backward us/substep | bound | share |"
    );
    println!("|---|---|---|---|---|---|---|");
    println!(
        "| {} springs, {} triplets | {} |",
        c.elements.springs,
        c.elements.triplets,
        shares(&c, flops)
    );
}

/// Cost of a substep of bodies on the ground, with contact of their nodes and with that of their skin;
/// what a frame costs once is in it.
fn skin(backend: &dyn Backend) {
    println!("\nContact of the skin, on the ground\n");
    println!(
        "| nodes | skin points | substeps | forward us/substep | with the skin | ratio | forward + backward us/substep | with the skin | ratio |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for nodes in [100, 200, 600] {
        let mut model = body::lying(nodes, 2000);
        let of_nodes = cost(backend, model.clone());
        model.params.contact.skin = true;
        let of_skin = cost(backend, model.clone());
        let cells = |a: f64, b: f64| format!("{a:.2} | {b:.2} | {:.2}", b / a);
        println!(
            "| {nodes} | {} | {} | {} | {} |",
            model.skin.len(),
            model.timing.substeps,
            cells(of_nodes.forward_us, of_skin.forward_us),
            cells(of_nodes.gradient_us, of_skin.gradient_us),
        );
    }
}

/// Cost of computing how many substeps a model needs, and of checking that those it has are enough.
fn stability() {
    println!("\nStability of a model, checked once\n");
    println!(
        "| nodes | springs | triplets | needed | estimate ms | four times enough ms | 1.5 times enough ms | just enough ms |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (nodes, bending) in [(500, false), (2000, false), (2000, true), (6000, false)] {
        let model = body::ellipsoid(nodes, bending);
        let needed = stable_substeps(&model).needed;
        // The kernel counts in steps of milliseconds.
        let ms = |work: &dyn Fn()| 1e3 / 50.0 * best_of(7, || (0..50).for_each(|_| work()));
        println!(
            "| {nodes} | {} | {} | {needed} | {:.2} | {:.2} | {:.2} | {:.2} |",
            model.graph.springs.len(),
            model.graph.triplets.len(),
            ms(&|| _ = black_box(stable_substeps(&model))),
            ms(&|| _ = black_box(enough_substeps(&model, 4 * needed))),
            ms(&|| _ = black_box(enough_substeps(&model, 3 * needed / 2))),
            ms(&|| _ = black_box(enough_substeps(&model, needed))),
        );
    }
}

fn cost(backend: &dyn Backend, model: Model) -> Cost {
    // Small bodies get more frames, for the clock's sake.
    let frames = (4000 / model.graph.node_count()).clamp(1, 50);
    let substeps = model.timing.substeps as usize * frames;
    let graph = &model.graph;
    let elements = Elements {
        nodes: graph.node_count(),
        springs: graph.springs.len(),
        triplets: graph.triplets.len(),
    };
    let state = State::rest(&model.graph);
    let controls = model.graph.control_rest.repeat(frames + 1);
    let terms = vec![WeightedTerm {
        frame: frames,
        weight: 1.0,
        group: 0,
        term: Term::Chamfer { of: Default::default(), targets: model.graph.rest_positions.clone() },
    }];
    let instance = Instance {
        model: backend.load(Arc::new(model)).expect("the body is stable"),
        initial: Arc::new(state),
        controls: Arc::new(controls),
        frames,
        objective: Objective { groups: vec!["chamfer".into()], terms: Arc::new(terms) },
        world: Arc::default(),
        motion: Arc::default(),
    };
    let batch = [instance];
    let (cancel, request) = (CancelToken::default(), GradientRequest::default());
    let forward = best_of(7, || {
        let loss = backend.losses(&batch, &cancel).expect("valid");
        assert!(loss[0].diverged.is_none(), "the body diverged");
    });
    let gradient = best_of(3, || {
        backend.gradients(&batch, &request, &cancel).expect("valid");
    });
    let us = |s: f64| s * 1e6 / substeps as f64;
    Cost { elements, forward_us: us(forward), gradient_us: us(gradient) }
}
