//! Pictures of the states of a session.

use std::time::Duration;

use bendtwin_core::{Appearance, Splats};
use bendtwin_engine::{backend, model};
use bendtwin_proto::v1::{
    self, ConvexMesh, PictureCamera, Prop, RenderSessionRequest, RenderedSession, prop::Shape,
    render_session_request::Look,
};
use bendtwin_splat::{Cpu, OpenRasteriser, Rasteriser};

use super::*;
use crate::{
    pictures::{Painter, Pictures},
    request::initial::Start,
    session::{Session, Setup, session_states},
};

const WIDTH: usize = 64;
const HEIGHT: usize = 48;
const FOCAL: f32 = 60.0;

/// A camera 1 m in front of the chain, in the direction of y; the world's z is up in its pictures.
fn camera() -> PictureCamera {
    // Turned by a quarter about x: the camera's z is y, its y is -z.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    PictureCamera {
        width: WIDTH as u32,
        height: HEIGHT as u32,
        intrinsics: Some(Tensor::pack(&[4], &[FOCAL, FOCAL, 31.5, 23.5])),
        pose: Some(Tensor::pack(&[7], &[0.0, -1.0, 0.35, -half, 0.0, 0.0, half])),
        background: Some(Tensor::pack(&[3], &[10_u8, 20, 30])),
        ..PictureCamera::default()
    }
}

fn request() -> RenderSessionRequest {
    RenderSessionRequest {
        cameras: vec![camera()],
        depths: true,
        labels: true,
        ..RenderSessionRequest::default()
    }
}

/// A session of a twin whose slots are moved along x [m].
fn session(warm: &Warm, fidelity: v1::Fidelity, moved: &[f32]) -> Session {
    let graph = &warm.twin.graph;
    let at = |dx: &f32| {
        let place = |p: &[f32; 3]| [p[0] + dx, p[1], p[2]];
        let positions: Vec<_> = graph.rest_positions.iter().map(place).collect();
        let velocities = vec![[0.0; 3]; positions.len()];
        let state = model::State { positions, velocities, ..model::State::default() };
        Start::new(Arc::new(state), Arc::new(graph.control_rest.clone()))
    };
    let setup = Setup {
        twin: warm.id,
        owner: String::new(),
        capture: String::new(),
        fidelity,
        world: None,
        grasps: Vec::new(),
        idle: Duration::from_secs(60),
    };
    Session::new(setup, moved.iter().map(at).collect(), None)
}

struct Studio {
    warm: Arc<Warm>,
    session: Session,
}

impl Studio {
    fn new(twin: Twin, moved: &[f32]) -> Self {
        let warm = Bench::of(twin, bendtwin_engine::cpu_with_threads(1)).warm;
        let session = session(&warm, v1::Fidelity::Exact, moved);
        Self { session, warm }
    }

    fn asked(&self, request: RenderSessionRequest) -> Result<Pictures, Error> {
        let slots = self.session.distinct(&request.slots, 0..self.session.slots())?;
        bendtwin_contract::picture::check_pictures(
            &request,
            slots.len() as u64,
            &Limits::default(),
        )?;
        Pictures::new(&self.session, &self.warm, slots, request, &CancelToken::default())
    }

    fn taken(&self, request: RenderSessionRequest, painter: &Painter) -> RenderedSession {
        let pictures = self.asked(request).unwrap();
        let drawn = pictures.draw(0..pictures.len(), painter, &CancelToken::default()).unwrap();
        pictures.reply(drawn)
    }
}

fn labels(reply: &RenderedSession) -> Vec<u8> {
    reply.cameras[0].labels.as_ref().unwrap().data.to_vec()
}

fn depths(reply: &RenderedSession) -> Vec<f32> {
    reply.cameras[0].depths.as_ref().unwrap().unpack("depths").unwrap().1
}

fn colors(reply: &RenderedSession) -> Vec<u8> {
    reply.cameras[0].colors.as_ref().unwrap().data.to_vec()
}

/// Mean column of a label in a picture [px].
fn column(labels: &[u8], label: u8) -> f32 {
    let at = (0..labels.len()).filter(|i| labels[*i] == label);
    let columns: Vec<f32> = at.map(|i| (i % WIDTH) as f32).collect();
    assert!(columns.len() > 10, "{} pixels of {label}", columns.len());
    columns.iter().sum::<f32>() / columns.len() as f32
}

/// The chain with Gaussians at its nodes.
fn with_gaussians() -> Twin {
    let mut twin = twin();
    let count = twin.graph.node_count();
    let splats = Splats {
        carriers: Skin::at_nodes(&(0..count as u32).collect::<Vec<_>>()),
        scales_m: vec![[0.03; 3]; count],
        rotations: vec![[0.0, 0.0, 0.0, 1.0]; count],
        opacities: vec![0.95; count],
        colors: vec![[0.9, 0.3, 0.1]; count],
    };
    twin.appearance = Some(Appearance { skin_colors: Vec::new(), splats: Some(splats) });
    twin.check().unwrap();
    twin
}

#[test]
fn a_cable_is_seen_where_the_states_of_its_slots_are() {
    let studio = Studio::new(twin(), &[0.0, 0.2, -0.1]);
    let reply = studio.taken(request(), &Painter::new(2, None));
    assert_eq!(reply.slots, [0, 1, 2]);
    let (labels, depths) = (labels(&reply), depths(&reply));
    let states = session_states(&studio.session, &studio.warm, &[0, 1, 2]);
    let (_, positions) = states.states.unwrap().positions.unwrap().unpack_points("p").unwrap();
    let size = WIDTH * HEIGHT;
    for (slot, positions) in positions.chunks(studio.warm.twin.graph.node_count()).enumerate() {
        let own = &labels[slot * size..(slot + 1) * size];
        let expected = 31.5 + FOCAL * positions[0][0];
        assert!((column(own, 1) - expected).abs() < 0.6, "{} {expected}", column(own, 1));
        let seen = depths[slot * size..(slot + 1) * size].iter().filter(|d| **d > 0.0);
        assert!(seen.copied().all(|d| (d - 1.0).abs() < 0.03));
    }
    // A planner's twin leaves the states those of the twin.
    let planner = session(&studio.warm, v1::Fidelity::Planner, &[0.0, 0.2, -0.1]);
    let planner = Studio { session: planner, warm: Arc::clone(&studio.warm) };
    assert_eq!(planner.taken(request(), &Painter::new(1, None)), reply);
}

#[test]
fn slots_differ_by_camera_prop_light_and_background() {
    let studio = Studio::new(twin(), &[0.0, 0.0]);
    let (low, high) = (vec![-0.05; 3], vec![0.05; 3]);
    let pose = |x: f32| [x, 0.0, 0.35, 0.0, 0.0, 0.0, 1.0];
    let cuboid = Prop {
        shape: Some(Shape::Cuboid(v1::Cuboid { low, high })),
        pose: Some(Tensor::pack(&[2, 7], &[pose(0.2), pose(-0.2)].concat())),
        color: Some(Tensor::pack(&[2, 3], &[200_u8, 0, 0, 0, 0, 200])),
    };
    let light = v1::Light {
        ambient: Some(Tensor::pack(&[1], &[1.0_f32])),
        brightness: Some(Tensor::pack(&[2], &[1.0_f32, 0.0])),
        direction: None,
    };
    let mut asked = RenderSessionRequest { props: vec![cuboid], light: Some(light), ..request() };
    let images = [7_u8, 99].map(|grey| vec![grey; 3 * WIDTH * HEIGHT]).concat();
    asked.cameras[0].background = Some(Tensor::pack(&[2, HEIGHT, WIDTH, 3], &images));
    let reply = studio.taken(asked, &Painter::new(2, None));
    let (labels, colors) = (labels(&reply), colors(&reply));
    let size = WIDTH * HEIGHT;
    let columns = [column(&labels[..size], 2), column(&labels[size..], 2)];
    assert!((columns[0] - 31.5 - 12.0).abs() < 1.0 && (columns[1] - 31.5 + 12.0).abs() < 1.0);
    let at = |slot: usize, x: usize, y: usize| {
        let i = 3 * (slot * size + y * WIDTH + x);
        [colors[i], colors[i + 1], colors[i + 2]]
    };
    assert_eq!([at(0, 1, 1), at(1, 1, 1)], [[7; 3], [99; 3]]);
    assert_eq!(at(0, 43, 23), [200, 0, 0]);
    assert_eq!(at(1, 20, 23), [0; 3], "there is no light");
}

#[test]
fn gaussians_are_drawn_if_the_twin_has_them_and_refused_if_not() {
    let studio = Studio::new(with_gaussians(), &[0.0, 0.1]);
    let painter = Painter::new(2, None);
    let reply = studio.taken(request(), &painter);
    let chosen = |look: Look| RenderSessionRequest { look: look.into(), ..request() };
    assert_eq!(studio.taken(chosen(Look::Gaussians), &painter), reply);
    let surface = studio.taken(chosen(Look::Surface), &painter);
    assert!(
        column(&labels(&reply)[WIDTH * HEIGHT..], 1)
            > column(&labels(&reply)[..WIDTH * HEIGHT], 1) + 4.0
    );
    let count = |reply: &RenderedSession| labels(reply).iter().filter(|l| **l == 1).count();
    assert!(count(&reply) > count(&surface), "{} {}", count(&reply), count(&surface));

    // One rasteriser for all, as on a GPU, gives the same.
    let open: OpenRasteriser = Arc::new(|| Ok(Box::new(Cpu::default()) as Box<dyn Rasteriser>));
    assert_eq!(studio.taken(request(), &Painter::new(2, Some(open))), reply);
    let broken: OpenRasteriser = Arc::new(|| Err("no device".to_owned()));
    let pictures = studio.asked(request()).unwrap();
    let failed = pictures.draw(0..1, &Painter::new(1, Some(broken)), &CancelToken::default());
    assert!(failed.unwrap_err().to_string().contains("no device"));

    let plain = Studio::new(twin(), &[0.0]);
    let error = plain.asked(chosen(Look::Gaussians)).err().unwrap();
    assert_eq!(error.reason(), "GAUSSIANS_UNKNOWN");
    assert_eq!(error.category(), Category::FailedPrecondition);
}

#[test]
fn pictures_do_not_depend_on_threads_or_on_what_is_drawn_together() {
    for twin in [twin(), with_gaussians()] {
        let studio = Studio::new(twin, &[0.0, 0.1, 0.2, -0.1, -0.2]);
        let pictures = studio.asked(request()).unwrap();
        let all = CancelToken::default();
        let whole = pictures.draw(0..5, &Painter::new(3, None), &all).unwrap();
        let painter = Painter::new(1, None);
        let mut parts = pictures.draw(0..2, &painter, &all).unwrap();
        parts.extend(pictures.draw(2..5, &painter, &all).unwrap());
        assert!(parts == whole);
        assert_eq!(pictures.together(1), 4);
        assert!(pictures.drawing_bytes(8) >= pictures.drawing_bytes(1));
        let cancelled = CancelToken::default();
        cancelled.cancel();
        let error = pictures.draw(0..5, &painter, &cancelled).unwrap_err();
        assert!(matches!(error, Error::Engine(backend::Error::Cancelled)), "{error:?}");
    }
}

#[test]
fn twins_without_a_surface_are_balls_at_their_nodes() {
    let mut loose = twin();
    loose.graph.springs.truncate(1);
    loose.graph.triplets.clear();
    loose.params.spring_stiffness.truncate(1);
    loose.params.spring_dashpot.truncate(1);
    loose.params.rest_lengths_m.truncate(1);
    loose.params.bend_stiffness.clear();
    loose.params.bend_damping.clear();
    loose.params.rest_angles_rad.clear();
    loose.skin = Skin::of_nodes(&loose.graph);
    loose.check().unwrap();
    let studio = Studio::new(loose, &[0.0]);
    let reply = studio.taken(request(), &Painter::new(1, None));
    assert!((column(&labels(&reply), 1) - 31.5).abs() < 0.6);
}

#[test]
fn a_flat_mesh_is_refused_by_its_name() {
    let studio = Studio::new(twin(), &[0.0]);
    let points: Vec<[f32; 3]> =
        (0..4).map(|i| [i as f32 * 0.1, (i * i) as f32 * 0.1, 0.0]).collect();
    let mesh = ConvexMesh { points: Some(Tensor::pack_points(&[4], &points)) };
    let prop = Prop { shape: Some(Shape::ConvexMesh(mesh)), ..Prop::default() };
    let error =
        studio.asked(RenderSessionRequest { props: vec![prop], ..request() }).err().unwrap();
    assert_eq!(error.reason(), "INVALID_PICTURE");
    assert!(error.to_string().contains("`props[0].convex_mesh.points`"), "{error}");
}
