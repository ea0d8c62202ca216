//! `f32` on AVX2 with fused multiply-add: a block is one register, records are read and written
//! as whole vectors and turned in registers.

use std::{
    arch::x86_64::{__m128, __m256},
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

use pulp::{cast, x86::V3};

use super::{Machine, Pack, Pack3};
use crate::cpu::arithmetic::{
    lanes::{Index, LANES, Lane, Node},
    real::Quad,
};

/// Proof that the processor has these instructions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(V3);

/// A number per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8(__m256, V3);

/// A truth value per lane: all bits set or clear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask(__m256, V3);

/// Comparisons that are false for NaN, as `_mm256_cmp_ps` calls them.
const GREATER: i32 = 30;
const GREATER_OR_EQUAL: i32 = 29;

impl Avx2 {
    #[inline(always)]
    pub(crate) fn new(v3: V3) -> Self {
        Self(v3)
    }

    /// Two quads in one register.
    #[inline(always)]
    fn pair(self, low: &Quad<f32>, high: &Quad<f32>) -> __m256 {
        let avx = self.0.avx;
        let low = avx._mm256_castps128_ps256(cast(*low));
        avx._mm256_insertf128_ps::<1>(low, cast(*high))
    }

    /// x | v.
    #[inline(always)]
    fn node(self, nodes: &[Node<f32>], index: u32) -> __m256 {
        let node = &nodes[index as usize];
        self.pair(&node.x, &node.v)
    }

    #[inline(always)]
    fn packs(self, [x, y, z]: [__m256; 3]) -> Pack3<F32x8> {
        [F32x8(x, self.0), F32x8(y, self.0), F32x8(z, self.0)]
    }

    /// x, y and z of four quads in each half.
    #[inline(always)]
    fn columns(self, rows: [__m256; 4]) -> [__m256; 3] {
        let avx = self.0.avx;
        let xy_low = avx._mm256_unpacklo_ps(rows[0], rows[1]);
        let xy_high = avx._mm256_unpacklo_ps(rows[2], rows[3]);
        let z_low = avx._mm256_unpackhi_ps(rows[0], rows[1]);
        let z_high = avx._mm256_unpackhi_ps(rows[2], rows[3]);
        [
            avx._mm256_shuffle_ps::<0x44>(xy_low, xy_high),
            avx._mm256_shuffle_ps::<0xee>(xy_low, xy_high),
            avx._mm256_shuffle_ps::<0x44>(z_low, z_high),
        ]
    }

    #[inline(always)]
    fn add(self, quad: &mut Quad<f32>, by: __m128) {
        *quad = cast(self.0.sse._mm_add_ps(cast(*quad), by));
    }

    #[inline(always)]
    fn add_node(self, node: &mut Node<f32>, by: __m256) {
        let avx = self.0.avx;
        let sum = avx._mm256_add_ps(self.pair(&node.x, &node.v), by);
        node.x = cast(avx._mm256_castps256_ps128(sum));
        node.v = cast(avx._mm256_extractf128_ps::<1>(sum));
    }

    /// Quads (x, y, z, 0) of lanes l and l + 4, l = 0..4.
    #[inline(always)]
    fn rows(self, [x, y, z]: Pack3<F32x8>) -> [__m256; 4] {
        let avx = self.0.avx;
        let zero = avx._mm256_setzero_ps();
        let xy_low = avx._mm256_unpacklo_ps(x.0, y.0);
        let xy_high = avx._mm256_unpackhi_ps(x.0, y.0);
        let z_low = avx._mm256_unpacklo_ps(z.0, zero);
        let z_high = avx._mm256_unpackhi_ps(z.0, zero);
        [
            avx._mm256_shuffle_ps::<0x44>(xy_low, z_low),
            avx._mm256_shuffle_ps::<0xee>(xy_low, z_low),
            avx._mm256_shuffle_ps::<0x44>(xy_high, z_high),
            avx._mm256_shuffle_ps::<0xee>(xy_high, z_high),
        ]
    }
}

macro_rules! operators {
    ($($name:ident $method:ident $intrinsic:ident $of:ident),*) => {$(
        impl $name for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.1.avx.$intrinsic(self.0, other.0), self.1)
            }
        }
    )*};
}

operators!(
    Add add _mm256_add_ps F32x8,
    Sub sub _mm256_sub_ps F32x8,
    Mul mul _mm256_mul_ps F32x8,
    Div div _mm256_div_ps F32x8,
    BitAnd bitand _mm256_and_ps Mask,
    BitOr bitor _mm256_or_ps Mask
);

impl Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let avx = self.1.avx;
        Self(avx._mm256_xor_ps(self.0, avx._mm256_set1_ps(-0.0)), self.1)
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let all: __m256 = cast([u32::MAX; LANES]);
        Self(self.1.avx._mm256_xor_ps(self.0, all), self.1)
    }
}

impl Pack for F32x8 {
    type Mask = Mask;

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.1.fma._mm256_fmadd_ps(self.0, b.0, c.0), self.1)
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(self.1.fma._mm256_fnmadd_ps(self.0, b.0, c.0), self.1)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.1.avx._mm256_sqrt_ps(self.0), self.1)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let avx = self.1.avx;
        Self(avx._mm256_andnot_ps(avx._mm256_set1_ps(-0.0), self.0), self.1)
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        Self(self.1.avx._mm256_max_ps(self.0, other.0), self.1)
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        Self(self.1.avx._mm256_min_ps(self.0, other.0), self.1)
    }
    #[inline(always)]
    fn above(self, other: Self) -> Mask {
        Mask(self.1.avx._mm256_cmp_ps::<GREATER>(self.0, other.0), self.1)
    }
    #[inline(always)]
    fn not_below(self, other: Self) -> Mask {
        Mask(self.1.avx._mm256_cmp_ps::<GREATER_OR_EQUAL>(self.0, other.0), self.1)
    }
    #[inline(always)]
    fn or(self, condition: Mask, other: Self) -> Self {
        Self(self.1.avx._mm256_blendv_ps(other.0, self.0, condition.0), self.1)
    }
    #[inline(always)]
    fn only_if(self, condition: Mask) -> Self {
        Self(self.1.avx._mm256_and_ps(self.0, condition.0), self.1)
    }
}

impl Machine<f32> for Avx2 {
    type Pack = F32x8;

    #[inline(always)]
    fn splat(self, x: f32) -> F32x8 {
        F32x8(self.0.avx._mm256_set1_ps(x), self.0)
    }
    #[inline(always)]
    fn load(self, from: &Lane<f32>) -> F32x8 {
        F32x8(cast(*from), self.0)
    }
    #[inline(always)]
    fn store(self, pack: F32x8) -> Lane<f32> {
        cast(pack.0)
    }
    #[inline(always)]
    fn any(self, condition: Mask) -> bool {
        self.0.avx._mm256_movemask_ps(condition.0) != 0
    }
    #[inline(always)]
    fn gather(self, nodes: &[Node<f32>], index: &Index) -> (Pack3<F32x8>, Pack3<F32x8>) {
        let avx = self.0.avx;
        // Lane by lane x | v, so that both are transposed together.
        let low = self.columns([
            self.node(nodes, index[0]),
            self.node(nodes, index[1]),
            self.node(nodes, index[2]),
            self.node(nodes, index[3]),
        ]);
        let high = self.columns([
            self.node(nodes, index[4]),
            self.node(nodes, index[5]),
            self.node(nodes, index[6]),
            self.node(nodes, index[7]),
        ]);
        let x = [
            avx._mm256_permute2f128_ps::<0x20>(low[0], high[0]),
            avx._mm256_permute2f128_ps::<0x20>(low[1], high[1]),
            avx._mm256_permute2f128_ps::<0x20>(low[2], high[2]),
        ];
        let v = [
            avx._mm256_permute2f128_ps::<0x31>(low[0], high[0]),
            avx._mm256_permute2f128_ps::<0x31>(low[1], high[1]),
            avx._mm256_permute2f128_ps::<0x31>(low[2], high[2]),
        ];
        (self.packs(x), self.packs(v))
    }
    #[inline(always)]
    fn gather_quads(self, quads: &[Quad<f32>], index: &Index) -> Pack3<F32x8> {
        self.packs(self.columns([
            self.pair(&quads[index[0] as usize], &quads[index[4] as usize]),
            self.pair(&quads[index[1] as usize], &quads[index[5] as usize]),
            self.pair(&quads[index[2] as usize], &quads[index[6] as usize]),
            self.pair(&quads[index[3] as usize], &quads[index[7] as usize]),
        ]))
    }
    #[inline(always)]
    fn scatter_add(self, quads: &mut [Quad<f32>], index: &Index, by: Pack3<F32x8>) {
        let avx = self.0.avx;
        let rows = self.rows(by);
        for l in 0..4 {
            self.add(&mut quads[index[l] as usize], avx._mm256_castps256_ps128(rows[l]));
        }
        for l in 0..4 {
            let row = avx._mm256_extractf128_ps::<1>(rows[l]);
            self.add(&mut quads[index[l + 4] as usize], row);
        }
    }
    #[inline(always)]
    fn scatter_add_nodes(
        self,
        nodes: &mut [Node<f32>],
        index: &Index,
        x: Pack3<F32x8>,
        v: Pack3<F32x8>,
    ) {
        let avx = self.0.avx;
        let (x, v) = (self.rows(x), self.rows(v));
        for l in 0..4 {
            let row = avx._mm256_permute2f128_ps::<0x20>(x[l], v[l]);
            self.add_node(&mut nodes[index[l] as usize], row);
        }
        for l in 0..4 {
            let row = avx._mm256_permute2f128_ps::<0x31>(x[l], v[l]);
            self.add_node(&mut nodes[index[l + 4] as usize], row);
        }
    }
}
