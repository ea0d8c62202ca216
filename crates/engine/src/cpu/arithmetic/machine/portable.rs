//! Any scalar on any processor: loops over lanes that the compiler vectorises.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::{Machine, Pack, Pack3};
use crate::cpu::arithmetic::{
    lanes::{Index, LANES, Lane, Node},
    real::{Quad, Real},
};

/// No instructions in particular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

/// A number per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes<T>(Lane<T>);

/// A truth value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask([bool; LANES]);

impl<T: Real> Lanes<T> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        Self(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(&T, &T) -> bool) -> Mask {
        Mask(std::array::from_fn(|l| f(&self.0[l], &other.0[l])))
    }
}

macro_rules! operators {
    ($($name:ident $method:ident $operator:tt),*) => {$(
        impl<T: Real> $name for Lanes<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }
    )*};
}

operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<T: Real> Neg for Lanes<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl BitAnd for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] & other.0[l]))
    }
}

impl BitOr for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|l| self.0[l] | other.0[l]))
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|a| !a))
    }
}

impl<T: Real> Pack for Lanes<T> {
    type Mask = Mask;

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        c - self * b
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(T::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(T::abs))
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        self.zip(other, T::at_least)
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        self.zip(other, T::at_most)
    }
    #[inline(always)]
    fn above(self, other: Self) -> Mask {
        self.compare(other, T::gt)
    }
    #[inline(always)]
    fn not_below(self, other: Self) -> Mask {
        self.compare(other, T::ge)
    }
    #[inline(always)]
    fn or(self, condition: Mask, other: Self) -> Self {
        let choose = |l: usize| if condition.0[l] { self.0[l] } else { other.0[l] };
        Self(std::array::from_fn(choose))
    }
    #[inline(always)]
    fn only_if(self, condition: Mask) -> Self {
        self.or(condition, Self([T::ZERO; LANES]))
    }
}

impl<T: Real> Machine<T> for Portable {
    type Pack = Lanes<T>;

    #[inline(always)]
    fn splat(self, x: T) -> Lanes<T> {
        Lanes([x; LANES])
    }
    #[inline(always)]
    fn load(self, from: &Lane<T>) -> Lanes<T> {
        Lanes(*from)
    }
    #[inline(always)]
    fn store(self, pack: Lanes<T>) -> Lane<T> {
        pack.0
    }
    #[inline(always)]
    fn any(self, condition: Mask) -> bool {
        condition.0.into_iter().fold(false, |any, c| any | c)
    }
    #[inline(always)]
    fn gather(self, nodes: &[Node<T>], index: &Index) -> (Pack3<Lanes<T>>, Pack3<Lanes<T>>) {
        let nodes = index.map(|i| &nodes[i as usize]);
        (columns(nodes.map(|n| &n.x)), columns(nodes.map(|n| &n.v)))
    }
    #[inline(always)]
    fn gather_quads(self, quads: &[Quad<T>], index: &Index) -> Pack3<Lanes<T>> {
        columns(index.map(|i| &quads[i as usize]))
    }
    #[inline(always)]
    fn scatter_add(self, quads: &mut [Quad<T>], index: &Index, by: Pack3<Lanes<T>>) {
        for (l, &i) in index.iter().enumerate() {
            add_lane(&mut quads[i as usize], by, l);
        }
    }
    #[inline(always)]
    fn scatter_add_nodes(
        self,
        nodes: &mut [Node<T>],
        index: &Index,
        x: Pack3<Lanes<T>>,
        v: Pack3<Lanes<T>>,
    ) {
        for (l, &i) in index.iter().enumerate() {
            let node = &mut nodes[i as usize];
            add_lane(&mut node.x, x, l);
            add_lane(&mut node.v, v, l);
        }
    }
}

#[inline(always)]
fn columns<T: Real>(quads: [&Quad<T>; LANES]) -> Pack3<Lanes<T>> {
    [0, 1, 2].map(|c| Lanes(quads.map(|q| q[c])))
}

#[inline(always)]
fn add_lane<T: Real>(quad: &mut Quad<T>, by: Pack3<Lanes<T>>, l: usize) {
    for c in 0..3 {
        quad[c] += by[c].0[l];
    }
}
