//! Walks through parameter space on the device: parameters, coordinates, moments and gradients stay there;
//! a few numbers per instance and step come back.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Params, Timing};
use bendtwin_engine::{
    Backend, Error, Loaded, Model,
    backend::{GradientRequest, Instance},
    optimizer::{
        Adam, Decay, EPSILON, GradientNorm, GradientSample, Optimizer, OptimizerInit,
        Parameterization, Position, Scale,
    },
};

use crate::{
    device::{
        args::{Pointer, SquareLengthsArgs, StepAdamArgs, WeighGradientsArgs},
        kernels,
        memory::Buffer,
        queue::Queue,
        specialization::THREADS,
    },
    plan::resident::{LAWS, Resident, flatten, resident, unflatten},
    run::{backend::CudaBackend, backward::Gradients},
};

/// Blocks that add up a gradient's length.
const LENGTH_BLOCKS: u32 = 64;
/// Marks a coordinate that is a logarithm; see `kernels/descent.cu`.
const LOGARITHM: u32 = 1 << 31;

/// Walks on one device.
pub(crate) struct DeviceDescent {
    backend: CudaBackend,
    decay: Decay,
    walks: Vec<Walk>,
}

struct Walk {
    /// Owned by the walk alone. Its element parameters are those that it was loaded with; the
    /// current ones are on the device, and the laws here as well.
    model: Arc<Model>,
    resident: Arc<Resident>,
    /// A model of its own at the current point, if somebody has asked for it.
    shown: Option<Loaded>,
    parameterization: Parameterization,
    indices: Buffer<u32>,
    rates: Buffer<f64>,
    bounds: Buffer<[f64; 2]>,
    start: Buffer<f64>,
    theta: Buffer<f64>,
    first: Buffer<f64>,
    second: Buffer<f64>,
    steps: u64,
    /// Gradients that wait for a step: whose, and where among them.
    waiting: Vec<(Arc<Gradients>, Pointer<f32>)>,
}

impl DeviceDescent {
    pub(crate) fn new(
        backend: CudaBackend,
        starts: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Self, Error> {
        let begin = |start: OptimizerInit| {
            start.check()?;
            Walk::new(&backend.queue, start)
        };
        let walks = starts.into_iter().map(begin).collect::<Result<_, Error>>()?;
        Ok(Self { backend, decay, walks })
    }

    fn walk(&mut self, walk: usize) -> Result<(&Arc<Queue>, &mut Walk), Error> {
        let count = self.walks.len();
        let found = self.walks.get_mut(walk).ok_or_else(|| unknown(walk, count))?;
        Ok((&self.backend.queue, found))
    }

    /// Measures probes and leaves their gradients waiting.
    fn measure_chunk(
        &mut self,
        probes: &[GradientSample],
        instances: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let (measured, gradients) = self.backend.measure(instances, request, cancel)?;
        let gradients = Arc::new(gradients);
        let losses = measured.losses()?;
        let mut slopes = Vec::with_capacity(probes.len());
        for (i, (probe, loss)) in probes.iter().zip(losses).enumerate() {
            let ended = loss.diverged.is_none();
            let final_state = match request.final_state && ended {
                true => Some(measured.state(i, instances[i].frames)?),
                false => None,
            };
            let walk = &mut self.walks[probe.run];
            let own =
                if ended { gradients.params.at(gradients.starts[i]) } else { Pointer::default() };
            walk.waiting.push((gradients.clone(), own));
            slopes.push(GradientNorm { loss, norm: 0.0, final_state });
        }
        for (w, walk) in self.walks.iter().enumerate() {
            let own: Vec<usize> = (0..probes.len()).filter(|&i| probes[i].run == w).collect();
            let newest = &walk.waiting[walk.waiting.len() - own.len()..];
            let lengths = walk.lengths(&self.backend.queue, newest)?;
            for (i, length) in own.into_iter().zip(lengths) {
                slopes[i].norm = length;
            }
        }
        Ok(slopes)
    }
}

fn unknown(walk: usize, count: usize) -> Error {
    Error::InvalidInput(format!("walk {walk} does not exist: there are {count}"))
}

impl Optimizer for DeviceDescent {
    fn loaded(&mut self, walk: usize) -> Result<Loaded, Error> {
        let backend = self.backend.clone();
        let (queue, walk) = self.walk(walk)?;
        if let Some(shown) = &walk.shown {
            return Ok(shown.clone());
        }
        let params = walk.params(queue)?;
        let shown = backend.with_params(&walk.own(), params)?;
        Ok(walk.shown.insert(shown).clone())
    }

    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let here = |probe: &GradientSample| {
            let walk = self.walks.get(probe.run);
            let walk = walk.ok_or_else(|| unknown(probe.run, self.walks.len()))?;
            Ok(Instance { model: walk.own(), ..probe.instance.clone() })
        };
        let instances = batch.iter().map(here).collect::<Result<Vec<_>, Error>>()?;
        let request = GradientRequest { controls: false, initial: false, ..*request };
        let before: Vec<usize> = self.walks.iter().map(|w| w.waiting.len()).collect();
        let mut slopes = Vec::with_capacity(batch.len());
        let mut outcome = self.backend.check(&instances);
        for chunk in self.backend.gradient_chunks(&instances) {
            if outcome.is_err() {
                break;
            }
            let (probes, instances) = (&batch[chunk.clone()], &instances[chunk]);
            outcome = self
                .measure_chunk(probes, instances, &request, cancel)
                .map(|more| slopes.extend(more));
        }
        if outcome.is_err() {
            for (walk, &before) in self.walks.iter_mut().zip(&before) {
                walk.waiting.truncate(before);
            }
            // Nothing of what failed may go on behind our back.
            let _ = self.backend.queue.synchronize();
        }
        outcome.map(|()| slopes)
    }

    fn step(&mut self, walk: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let decay = self.decay;
        let (queue, walk) = self.walk(walk)?;
        if weights.len() != walk.waiting.len() {
            let (n, waiting) = (weights.len(), walk.waiting.len());
            return Err(Error::InvalidInput(format!("{n} weights for {waiting} gradients")));
        }
        walk.step(queue, weights, rate, decay)
    }

    fn discard(&mut self, walk: usize) -> Result<(), Error> {
        self.walk(walk)?.1.waiting.clear();
        Ok(())
    }

    fn position(&self, walk: usize) -> Result<Position, Error> {
        let found = self.walks.get(walk).ok_or_else(|| unknown(walk, self.walks.len()))?;
        Ok(Position {
            theta: found.theta.read()?,
            adam: Adam {
                steps: found.steps,
                first: found.first.read()?,
                second: found.second.read()?,
            },
        })
    }

    fn move_to(&mut self, walk: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let backend = self.backend.clone();
        let (queue, walk) = self.walk(walk)?;
        walk.parameterization.check_position(position)?;
        let params = walk.parameterization.params(&position.theta);
        let model = Model { params, timing, ..Model::clone(&walk.model) };
        let loaded = backend.load(Arc::new(model))?;
        let start = OptimizerInit {
            loaded,
            parameterization: walk.parameterization.clone(),
            position: position.clone(),
        };
        *walk = Walk::new(queue, start)?;
        Ok(())
    }
}

impl Walk {
    fn new(queue: &Queue, start: OptimizerInit) -> Result<Self, Error> {
        let OptimizerInit { loaded, parameterization, position } = start;
        let before = resident(&loaded)?;
        let params = parameterization.params(&position.theta);
        let own = Resident::new(&before.device, &before.graph, &params)?.varying();
        let stream = &queue.stream;
        let rates: Vec<f64> = parameterization.rates().collect();
        let model = Model { params, ..Model::clone(loaded.model()) };
        Ok(Self {
            indices: Buffer::of(stream, &indices(&parameterization, &model))?,
            rates: Buffer::of(stream, &rates)?,
            bounds: Buffer::of(stream, parameterization.bounds())?,
            start: Buffer::of(stream, &parameterization.start())?,
            theta: Buffer::of(stream, &position.theta)?,
            first: Buffer::of(stream, &position.adam.first)?,
            second: Buffer::of(stream, &position.adam.second)?,
            steps: position.adam.steps,
            model: Arc::new(model),
            resident: Arc::new(own),
            shown: None,
            parameterization,
            waiting: Vec::new(),
        })
    }

    /// The model at the current point, to be simulated at once.
    fn own(&self) -> Loaded {
        Loaded::new(self.model.clone(), self.resident.clone())
    }

    /// The current parameters.
    fn params(&self, queue: &Queue) -> Result<Params, Error> {
        Ok(unflatten(&self.model.params, &queue.fetch(&self.resident.params)?))
    }

    /// Euclidean lengths of some gradients.
    fn lengths(
        &self,
        queue: &Queue,
        gradients: &[(Arc<Gradients>, Pointer<f32>)],
    ) -> Result<Vec<f64>, Error> {
        if gradients.is_empty() {
            return Ok(Vec::new());
        }
        let ended: Vec<Pointer<f32>> =
            gradients.iter().map(|g| g.1).filter(|g| !g.is_null()).collect();
        let addresses = Buffer::of(&queue.stream, &ended)?;
        let sums: Buffer<f64> = Buffer::empty(&queue.stream, ended.len() * LENGTH_BLOCKS as usize)?;
        let args = SquareLengthsArgs {
            out: sums.address(),
            gradients: addresses.address(),
            params: self.resident.params.address(),
            indices: self.indices.address(),
            count: self.indices.len() as u32,
            unused: 0,
        };
        let launch = queue.grid(LENGTH_BLOCKS, ended.len() as u32, 1);
        // SAFETY: the gradients are of this walk's parameters, which the indices count.
        unsafe { kernels::square_lengths(&launch, &args)? };
        let sums = sums.read()?;
        let mut squares = sums.chunks(LENGTH_BLOCKS as usize).map(|s| s.iter().sum::<f64>());
        let length = |g: &(Arc<Gradients>, Pointer<f32>)| match g.1.is_null() {
            true => 0.0,
            false => squares.next().unwrap_or(0.0).sqrt(),
        };
        let lengths = gradients.iter().map(length);
        Ok(lengths.map(|l| if l.is_nan() { f64::INFINITY } else { l }).collect())
    }

    fn step(
        &mut self,
        queue: &Queue,
        weights: &[f64],
        rate: f64,
        decay: Decay,
    ) -> Result<(), Error> {
        let stream = &queue.stream;
        let count = self.indices.len() as u32;
        let pairs = self.waiting.iter().zip(weights).filter(|(g, _)| !g.1.is_null());
        let (addresses, used): (Vec<Pointer<f32>>, Vec<f64>) =
            pairs.map(|(g, w)| (g.1, *w)).unzip();
        let (on_device, used_on_device) =
            (Buffer::of(stream, &addresses)?, Buffer::of(stream, &used)?);
        let sums: Buffer<f64> = Buffer::empty(stream, self.indices.len())?;
        let finite = Buffer::of(stream, &[1_u32])?;
        let args = WeighGradientsArgs {
            sums: sums.address(),
            finite: finite.address(),
            gradients: on_device.address(),
            weights: used_on_device.address(),
            params: self.resident.params.address(),
            indices: self.indices.address(),
            gradient_count: addresses.len() as u32,
            count,
        };
        let launch = queue.grid(count.div_ceil(THREADS), 1, 1);
        // SAFETY: as in `lengths`; the sums have a place for every coordinate.
        unsafe { kernels::weigh_gradients(&launch, &args)? };
        if !rate.is_finite() || finite.read()?.first() != Some(&1) {
            return Err(Error::InvalidInput("rate and weighted gradient must be finite".into()));
        }
        self.steps += 1;
        let [unbias_first, unbias_second] = Adam::unbias(self.steps, decay);
        let graph = &self.model.graph;
        let (e, t) = (graph.springs.len() as u32, graph.triplets.len() as u32);
        let args = StepAdamArgs {
            theta: self.theta.address(),
            first: self.first.address(),
            second: self.second.address(),
            sums: sums.address(),
            rates: self.rates.address(),
            bounds: self.bounds.address(),
            start: self.start.address(),
            params: self.resident.params.address(),
            indices: self.indices.address(),
            back: (decay.prior * rate).clamp(0.0, 1.0),
            rate,
            beta1: decay.beta1,
            beta2: decay.beta2,
            unbias1: unbias_first,
            unbias2: unbias_second,
            epsilon: EPSILON,
            count,
            angles: 3 * e + 2 * t,
            angles_end: 3 * e + 3 * t,
            unused: 0,
        };
        // SAFETY: all arrays have a value for every coordinate, and indices are those of parameters.
        unsafe { kernels::step_adam(&launch, &args)? };
        self.resident.repack()?;
        self.read_laws()?;
        self.waiting.clear();
        self.shown = None;
        Ok(())
    }

    /// Drag, restitutions and frictions are the host's business: the arguments of instances carry them.
    fn read_laws(&mut self) -> Result<(), Error> {
        let params = &self.resident.params;
        let laws = params.read_from(params.len() - LAWS, LAWS)?;
        let own = &mut Arc::make_mut(&mut self.model).params;
        own.drag = laws[0];
        own.contact.ground_restitution = laws[1];
        own.contact.ground_friction = laws[2];
        own.contact.object_restitution = laws[3];
        own.contact.object_friction = laws[4];
        Ok(())
    }
}

/// Index of each coordinate's parameter in the kernels' order.
fn indices(parameterization: &Parameterization, model: &Model) -> Vec<u32> {
    let lengths: Vec<usize> = bendtwin_engine::optimizer::Parameter::ALL
        .iter()
        .map(|p| p.values(&model.params).len())
        .collect();
    debug_assert_eq!(lengths.iter().sum::<usize>(), flatten(&model.params).len());
    let mut indices = Vec::with_capacity(parameterization.len());
    for section in parameterization.sections() {
        let all = bendtwin_engine::optimizer::Parameter::ALL;
        let at = all.iter().position(|p| *p == section.parameter).unwrap_or(0);
        let first = lengths[..at].iter().sum::<usize>() as u32;
        let mark = if section.scale == Scale::Logarithmic { LOGARITHM } else { 0 };
        indices.extend((first..first + section.range.len() as u32).map(|i| i | mark));
    }
    indices
}
