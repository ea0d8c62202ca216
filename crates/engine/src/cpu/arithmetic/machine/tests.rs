use super::*;
use crate::cpu::arithmetic::{
    lanes::LANES,
    real::{Quad, Real},
};

/// Does the same on the machine that `f32` is dispatched to and in plain loops.
struct Everything<'a> {
    nodes: &'a [Node<f32>],
    index: Index,
}

impl Work<f32> for Everything<'_> {
    type Output = (Vec<Quad<f32>>, Vec<Node<f32>>, Lane<f32>);

    #[inline(always)]
    fn run<M: Machine<f32>>(self, m: M) -> Self::Output {
        let (x, v) = m.gather(self.nodes, &self.index);
        let mut quads = vec![[1.0, 2.0, 3.0, 0.0]; self.nodes.len()];
        m.scatter_add(&mut quads, &self.index, v3::sub(x, v));
        let mut nodes = self.nodes.to_vec();
        m.scatter_add_nodes(&mut nodes, &self.index, v, x);
        let y = m.gather_quads(&quads, &self.index);
        // Exact in both, fused or not.
        let z = (-y[0]).abs().at_least(x[1]).at_most(v[2] * v[2]) + y[1].mul_add(y[2], x[0]);
        let chosen = z.or(z.above(x[2]) & !z.not_below(v[1]) | x[0].not_below(v[0]), x[2]);
        assert!(m.any(z.not_below(z)) && !m.any(z.above(z)));
        let masked = x[1].neg_mul_add(v[1], z).only_if(chosen.above(z));
        (quads, nodes, m.store(chosen + masked))
    }
}

/// Small whole numbers, so that every result is exact.
fn nodes() -> Vec<Node<f32>> {
    let number = |i: usize, c: usize| ((i * 7 + c * 5) % 13) as f32 - 6.0;
    let quad = |i: usize, c: usize| [number(i, c), number(i, c + 1), number(i, c + 2), 0.0];
    (0..12).map(|i| Node { x: quad(i, 0), v: quad(i, 3) }).collect()
}

#[test]
fn machines_agree() {
    let nodes = nodes();
    for index in [[0, 1, 2, 3, 4, 5, 6, 7], [11, 3, 3, 0, 9, 3, 11, 2], [5; LANES]] {
        let fast = f32::dispatch(Everything { nodes: &nodes, index });
        assert_eq!(fast, Everything { nodes: &nodes, index }.run(Portable));
    }
}

struct Angles([Lane<f32>; 2]);

impl Work<f32> for Angles {
    type Output = Lane<f32>;

    #[inline(always)]
    fn run<M: Machine<f32>>(self, m: M) -> Lane<f32> {
        m.store(f32::angle(m, m.load(&self.0[0]), m.load(&self.0[1])))
    }
}

#[test]
fn fast_angle_is_accurate_everywhere() {
    let at = |theta: f64, r: f64| ((r * theta.sin()).max(0.0) as f32, (r * theta.cos()) as f32);
    for i in 0..=20_000 {
        let theta = f64::from(i) / 20_000.0 * std::f64::consts::PI;
        for r in [1e-12, 1.0, 1e6] {
            let (y, x) = at(theta, r);
            let exact = f64::from(y).atan2(f64::from(x));
            let both = [[y; LANES], [x; LANES]];
            for found in [f32::dispatch(Angles(both)), Angles(both).run(Portable)] {
                assert!((f64::from(found[0]) - exact).abs() < 3e-7, "{theta}");
            }
        }
    }
    assert_eq!(f32::dispatch(Angles([[0.0; LANES]; 2])), [0.0; LANES]);
}
