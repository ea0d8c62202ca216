//! The rope, the bars, the toy and the ring: shape, material, grasp and motion.

use std::f32::consts::TAU;

use bendtwin_core::Point;

use super::{
    MakeOptions, Scene, Substance,
    body::Body,
    hand::Hand,
    pose::{Pose, norm, segment_distance, smoothstep, sub},
    simulate::Material,
};

/// A body, a hand and what the hand does.
pub(super) struct Setup {
    pub(super) name: String,
    pub(super) body: Body,
    /// Zero on the body's surface, negative inside.
    pub(super) distance: fn(Point) -> f32,
    pub(super) material: Material,
    pub(super) hand: Hand,
    /// Another hand that holds the body and moves as the first does.
    pub(super) second: Option<Hand>,
    /// The hand's pose at a time [s].
    pub(super) motion: fn(f32) -> Pose,
    pub(super) frames: usize,
    /// Tracked, completed, interior and true points; control points.
    pub(super) observed: usize,
    pub(super) completed: usize,
    pub(super) interior: usize,
    pub(super) truth: usize,
    pub(super) controls: usize,
}

impl Setup {
    /// A second hand at the far side of the body.
    pub(super) fn other_hand(&self, scene: Scene) -> Hand {
        let [x, y, z] = self.hand.grasp;
        let length = self.body.positions.iter().map(|p| p[0]).fold(f32::MIN, f32::max);
        let (grasp, forearm) = match scene {
            Scene::Toy => ([-0.05, 0.0, 0.055], [-0.7, 0.0, 1.0]),
            _ => ([length - x, y, z], [1.0, 0.0, 0.5]),
        };
        Hand { grasp, forearm, size: self.hand.size }
    }
}

/// Parts of a scene; `None` if no camera sees it.
pub(super) fn setup(scene: Scene, options: &MakeOptions) -> Option<Setup> {
    let mut setup = match scene {
        Scene::Rope => rope(options),
        Scene::Bar => bar::<25>(options, scene.name()),
        Scene::ThickBar => bar::<50>(options, scene.name()),
        Scene::Toy => toy(options),
        Scene::Ring => ring(options),
        Scene::Cable => return None,
    };
    turn_into(&mut setup.material, options.material);
    if options.material != Substance::Foam {
        setup.name = format!("{}_{}", setup.name, options.material.name());
    }
    Some(setup)
}

/// Makes foam another material: by the speed of sound, by the damping of its springs at equal
/// stiffness, by drag, and by how it meets the ground.
fn turn_into(material: &mut Material, substance: Substance) {
    let [sound, damping, drag, restitution, friction] = match substance {
        Substance::Foam => return,
        Substance::Plush => [0.7, 3.0, 1.5, 0.0, 0.6],
        Substance::Rubber => [1.6, 0.5, 0.5, 0.4, 0.9],
        Substance::Cord => [1.3, 2.0, 0.8, 0.05, 0.35],
    };
    material.stiffness.iter_mut().for_each(|k| *k *= sound * sound);
    material.dashpot.iter_mut().for_each(|c| *c *= sound * damping);
    material.drag *= drag;
    (material.ground_restitution, material.ground_friction) = (restitution, friction);
}

/// Speed of sound that gives a lattice of this spacing its stiffness, unevenly
/// over the body as real foam is, and light internal damping.
fn foam(body: &Body, sound_m_s: f32, drag: f32) -> Material {
    let l = body.spacing_m;
    // Axes and face diagonals of equal spring constant K: Young's modulus is about 2.5 K l² per
    // unit mass.
    let constant = sound_m_s * sound_m_s / (2.5 * l * l);
    let mut material =
        Material { drag, ground_restitution: 0.1, ground_friction: 0.5, ..Material::default() };
    for &[a, b] in &body.springs {
        let (p, q) = (body.positions[a as usize], body.positions[b as usize]);
        let unevenness =
            1.0 + 0.15 * (31.0 * (p[0] + q[0])).sin() * (17.0 * (p[1] - q[2]) + 1.0).cos();
        material.stiffness.push(constant * norm(sub(p, q)) * unevenness);
        // A small part of critical damping of one spring.
        material.dashpot.push(0.02 * constant.sqrt());
    }
    material
}

/// Radius and length of the rope [m].
const ROPE_RADIUS_M: f32 = 0.0125;
const ROPE_LENGTH_M: f32 = 0.4;

fn rope(options: &MakeOptions) -> Setup {
    let spacing = if options.tiny { 0.0083 } else { 0.005 };
    let radius = ROPE_RADIUS_M;
    let body = Body::fill(
        [0.0, -radius, 0.0],
        [ROPE_LENGTH_M, radius, 2.0 * radius],
        spacing,
        rope_distance,
    );
    let material = foam(&body, 55.0, 1.5);
    let pick = |full, tiny| if options.tiny { tiny } else { full };
    Setup {
        name: "rope".to_owned(),
        hand: Hand {
            grasp: [0.012, 0.0, radius],
            size: [0.032, 0.022, 0.022],
            forearm: [-1.0, 0.0, 0.5],
        },
        second: None,
        body,
        distance: rope_distance,
        material,
        motion: wave,
        frames: options.frames_or(80, 24),
        observed: pick(200, 40),
        completed: pick(120, 24),
        interior: pick(60, 10),
        truth: pick(40, 10),
        controls: pick(24, 8),
    }
}

/// A cylinder that lies along x, and its flat ends.
fn rope_distance(p: Point) -> f32 {
    let around = (p[1] * p[1] + (p[2] - ROPE_RADIUS_M).powi(2)).sqrt() - ROPE_RADIUS_M;
    around.max(-p[0]).max(p[0] - ROPE_LENGTH_M)
}

/// Length and width of the bars [m].
const BAR_SIZE_M: [f32; 2] = [0.36, 0.05];

/// A bar of foam; bars of any thickness are cut from the same block.
fn bar<const THICKNESS_MM: u32>(options: &MakeOptions, name: &str) -> Setup {
    let spacing = if options.tiny { 0.01 } else { 0.006 };
    let [length, width] = BAR_SIZE_M;
    let thickness = THICKNESS_MM as f32 * 1e-3;
    let high = [length, 0.5 * width, thickness];
    let body = Body::fill([0.0, -0.5 * width, 0.0], high, spacing, bar_distance::<THICKNESS_MM>);
    let material = foam(&body, 45.0, 1.5);
    let pick = |full, tiny| if options.tiny { tiny } else { full };
    Setup {
        name: name.to_owned(),
        hand: Hand {
            grasp: [0.012, 0.0, 0.5 * thickness],
            size: [0.032, 0.036, 0.8 * thickness],
            forearm: [-1.0, 0.0, 0.5],
        },
        second: None,
        body,
        distance: bar_distance::<THICKNESS_MM>,
        material,
        motion: wave,
        frames: options.frames_or(80, 24),
        observed: pick(240, 50),
        completed: pick(150, 30),
        interior: pick(80, 10),
        truth: pick(40, 10),
        controls: pick(24, 8),
    }
}

/// A box that lies along x.
fn bar_distance<const THICKNESS_MM: u32>(p: Point) -> f32 {
    let [length, width] = BAR_SIZE_M;
    let half = [0.5 * length, 0.5 * width, 0.5e-3 * THICKNESS_MM as f32];
    let centre = [half[0], 0.0, half[2]];
    (0..3).map(|a| (p[a] - centre[a]).abs() - half[a]).fold(f32::MIN, f32::max)
}

/// Lifts, waves up and down and sideways, then shakes; continues in the frames that are held back.
fn wave(t: f32) -> Pose {
    let after = |start: f32, ramp: f32| smoothstep((t - start) / ramp);
    let swing = |start: f32, hz: f32| (TAU * hz * (t - start)).sin() * after(start, 0.4);
    let pitch = 0.4 * smoothstep(t / 1.0) + 0.22 * swing(0.8, 1.0);
    let yaw = 0.28 * swing(0.9, 0.7);
    let shift = [
        0.02 * swing(1.2, 0.9),
        0.035 * swing(1.4, 1.1),
        0.28 * smoothstep(t / 1.1) + 0.025 * swing(1.2, 1.5),
    ];
    Pose::new(yaw, pitch, shift)
}

/// Radius of the ring's middle line and of its section [m].
pub(super) const RING_RADIUS_M: f32 = 0.075;
const RING_SECTION_M: f32 = 0.016;

fn ring(options: &MakeOptions) -> Setup {
    let spacing = if options.tiny { 0.0105 } else { 0.0055 };
    let (section, outer) = (RING_SECTION_M, RING_RADIUS_M + RING_SECTION_M);
    let body =
        Body::fill([0.0, -outer, 0.0], [2.0 * outer, outer, 2.0 * section], spacing, ring_distance);
    let material = foam(&body, 22.0, 1.4);
    let pick = |full, tiny| if options.tiny { tiny } else { full };
    Setup {
        name: "ring".to_owned(),
        hand: Hand {
            grasp: [section, 0.0, section],
            size: [0.026, 0.034, 0.026],
            forearm: [-1.0, 0.0, 0.5],
        },
        second: None,
        body,
        distance: ring_distance,
        material,
        motion: wave,
        frames: options.frames_or(80, 24),
        observed: pick(260, 50),
        completed: pick(160, 30),
        interior: pick(80, 10),
        truth: pick(40, 10),
        controls: pick(24, 8),
    }
}

/// A lying ring that begins at x = 0.
fn ring_distance(p: Point) -> f32 {
    let [x, y, z] = sub(p, [RING_RADIUS_M + RING_SECTION_M, 0.0, RING_SECTION_M]);
    norm([norm([x, y, 0.0]) - RING_RADIUS_M, z, 0.0]) - RING_SECTION_M
}

fn toy(options: &MakeOptions) -> Setup {
    let spacing = if options.tiny { 0.013 } else { 0.0068 };
    let body = Body::fill([-0.09, -0.11, 0.0], [0.13, 0.11, 0.1], spacing, toy_distance);
    let material = foam(&body, 12.0, 1.3);
    let pick = |full, tiny| if options.tiny { tiny } else { full };
    Setup {
        name: "toy".to_owned(),
        hand: Hand {
            grasp: [0.1, 0.0, 0.05],
            size: [0.026, 0.034, 0.034],
            forearm: [0.7, 0.0, 1.0],
        },
        second: None,
        body,
        distance: toy_distance,
        material,
        motion: shake,
        frames: options.frames_or(75, 20),
        observed: pick(300, 60),
        completed: pick(250, 40),
        interior: pick(200, 30),
        truth: pick(40, 10),
        controls: pick(28, 8),
    }
}

/// A lying toy: belly, head and four limbs.
fn toy_distance(p: Point) -> f32 {
    let belly = norm([p[0] / 1.4, p[1], p[2] - 0.042]) - 0.04;
    let head = norm(sub(p, [0.088, 0.0, 0.05])) - 0.032;
    let limbs = [[0.035, 0.095], [0.035, -0.095], [-0.05, 0.085], [-0.05, -0.085]]
        .map(|[x, y]| segment_distance(p, [0.7 * x, 0.3 * y, 0.03], [x, y, 0.018]) - 0.015);
    limbs.into_iter().fold(belly.min(head), f32::min)
}

/// Lifts by the head, sways and shakes.
fn shake(t: f32) -> Pose {
    let after = |start: f32, ramp: f32| smoothstep((t - start) / ramp);
    let swing = |start: f32, hz: f32| (TAU * hz * (t - start)).sin() * after(start, 0.3);
    let shift = [
        0.03 * swing(0.9, 1.0),
        0.045 * swing(1.0, 1.3),
        0.24 * smoothstep(t / 1.0) + 0.025 * swing(1.2, 1.8),
    ];
    Pose::new(0.25 * swing(0.9, 0.8), 0.4 * smoothstep(t / 1.0), shift)
}
