//! Rotations as unit quaternions x, y, z, w, and the gradients of what is made of them.

/// Below this length nothing can be said about the rotation that was meant. The check of requests
/// has a larger one.
const SHORTEST: f64 = 1e-7;
/// Above this cosine the arc is so short that its chord serves.
const NEARLY_EQUAL: f64 = 1.0 - 1e-9;

/// A vector in double precision.
pub(crate) type Vector = [f64; 3];

/// A rotation; of unit length by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quaternion([f64; 4]);

impl Quaternion {
    /// No rotation.
    pub(crate) const IDENTITY: Self = Self([0.0, 0.0, 0.0, 1.0]);

    /// Normalises; none if there is no direction to normalise.
    pub(crate) fn new(xyzw: [f64; 4]) -> Option<Self> {
        let length = dot(xyzw, xyzw).sqrt();
        (length.is_finite() && length >= SHORTEST).then(|| Self(xyzw.map(|c| c / length)))
    }

    /// The quaternion of a checked request.
    pub(crate) fn of(xyzw: [f32; 4]) -> Self {
        Self::new(xyzw.map(f64::from)).unwrap_or(Self::IDENTITY)
    }

    /// The opposite rotation.
    pub(crate) fn inverse(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([-x, -y, -z, w])
    }

    /// This rotation after another.
    pub(crate) fn times(self, first: Self) -> Self {
        let ([ax, ay, az, aw], [bx, by, bz, bw]) = (self.0, first.0);
        let (a, b) = ([ax, ay, az], [bx, by, bz]);
        let c = cross(a, b);
        let [x, y, z]: Vector = std::array::from_fn(|i| aw * b[i] + bw * a[i] + c[i]);
        Self::new([x, y, z, aw * bw - dot(a, b)]).unwrap_or(Self::IDENTITY)
    }

    /// x, y, z, w.
    pub(crate) fn parts(self) -> [f64; 4] {
        self.0
    }

    /// Gradient by the quaternion, along the unit sphere, of what grows by `along · w` as the
    /// rotation is followed by a small one with the rotation vector w.
    pub(crate) fn turn_gradient(self, along: Vector) -> [f64; 4] {
        let ([x, y, z, w], g) = (self.0, along);
        let q = [x, y, z];
        let c = cross(g, q);
        let by = |i: usize| 2.0 * (w * g[i] + c[i]);
        [by(0), by(1), by(2), -2.0 * dot(g, q)]
    }

    /// v + 2 w (q x v) + 2 q x (q x v), with q the vector part.
    pub(crate) fn rotate(self, v: Vector) -> Vector {
        let [x, y, z, w] = self.0;
        let q = [x, y, z];
        let t = cross(q, v).map(|c| 2.0 * c);
        let u = cross(q, t);
        std::array::from_fn(|i| v[i] + w * t[i] + u[i])
    }

    /// Gradient of `along · rotate(v)` by the quaternion, as a function on the unit sphere: what
    /// points along the quaternion itself has no meaning.
    pub(crate) fn rotate_gradient(self, v: Vector, along: Vector) -> [f64; 4] {
        let [x, y, z, w] = self.0;
        let (q, g) = ([x, y, z], along);
        let turn = cross(v, g);
        let (qv, gq, gv) = (dot(q, v), dot(g, q), dot(g, v));
        let by = |i: usize| 2.0 * (w * turn[i] + g[i] * qv + v[i] * gq - 2.0 * q[i] * gv);
        [by(0), by(1), by(2), 2.0 * dot(q, turn)]
    }

    /// Spherical linear interpolation along the shorter arc: `self` at 0, `other` at 1.
    pub(crate) fn slerp(self, other: Self, share: f64) -> Self {
        let arc = Arc::new(self, other, share);
        let mixed = std::array::from_fn(|i| arc.a * self.0[i] + arc.b * arc.other[i]);
        Self::new(mixed).unwrap_or(self)
    }

    /// Gradients by both ends of a function of [`slerp`](Self::slerp) whose gradient there is
    /// `gradient`.
    pub(crate) fn slerp_gradient(
        self,
        other: Self,
        share: f64,
        gradient: [f64; 4],
    ) -> [[f64; 4]; 2] {
        let arc = Arc::new(self, other, share);
        let mixed: [f64; 4] = std::array::from_fn(|i| arc.a * self.0[i] + arc.b * arc.other[i]);
        let length = dot(mixed, mixed).sqrt();
        let Some(at) = Self::new(mixed) else { return [[0.0; 4]; 2] };
        let g = at.tangent(gradient).map(|c| c / length);
        // The shares depend on the angle between the ends, whose cosine is their product.
        let by_cosine = arc.a_by_cosine * dot(g, self.0) + arc.b_by_cosine * dot(g, arc.other);
        [
            std::array::from_fn(|i| arc.a * g[i] + by_cosine * arc.other[i]),
            std::array::from_fn(|i| arc.sign * (arc.b * g[i] + by_cosine * self.0[i])),
        ]
    }

    /// The part of a gradient along the unit sphere.
    pub(crate) fn tangent(self, gradient: [f64; 4]) -> [f64; 4] {
        let along = dot(self.0, gradient);
        std::array::from_fn(|i| gradient[i] - along * self.0[i])
    }
}

/// The way from one quaternion to the nearer of another's two signs.
struct Arc {
    other: [f64; 4],
    sign: f64,
    /// Shares of both ends, and their derivatives by the cosine of the angle between them.
    a: f64,
    b: f64,
    a_by_cosine: f64,
    b_by_cosine: f64,
}

impl Arc {
    fn new(from: Quaternion, to: Quaternion, share: f64) -> Self {
        // q and -q are the same rotation: go to the nearer one.
        let sign = if dot(from.0, to.0) < 0.0 { -1.0 } else { 1.0 };
        let other = to.0.map(|c| sign * c);
        let cosine = dot(from.0, other);
        let (s, r) = (share, 1.0 - share);
        if cosine > NEARLY_EQUAL {
            return Self { other, sign, a: r, b: s, a_by_cosine: 0.0, b_by_cosine: 0.0 };
        }
        let angle = cosine.acos();
        let (sine, square) = (angle.sin(), 1.0 - cosine * cosine);
        let by_cosine = |part: f64| {
            let (top, slope) = ((part * angle).sin(), part * (part * angle).cos());
            (top * cosine - slope * sine) / (square * sine)
        };
        Self {
            other,
            sign,
            a: (r * angle).sin() / sine,
            b: (s * angle).sin() / sine,
            a_by_cosine: by_cosine(r),
            b_by_cosine: by_cosine(s),
        }
    }
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests;
