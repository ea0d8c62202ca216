//! Optimizer runs on the device: parameters, coordinates, moments and gradients stay there; a few
//! numbers per instance and step are copied back.

use std::sync::Arc;

use bendtwin_core::{CancelToken, Params, Timing};
use bendtwin_engine::{
    Backend, Error, Loaded, Model,
    backend::{GradientRequest, Instance},
    optimizer::{
        Adam, Decay, EPSILON, GradientNorm, GradientSample, Optimizer, OptimizerInit,
        Parameterization, Position, SLOPE, Scale,
    },
};

use crate::{
    device::{
        args::{MeanSquaresArgs, Pointer, SquareLengthsArgs, StepAdamArgs, WeighGradientsArgs},
        kernels,
        memory::Buffer,
        queue::Queue,
        specialization::THREADS,
    },
    plan::resident::{LAWS, Resident, flatten, resident, unflatten},
    run::{backend::CudaBackend, backward::Gradients},
};

/// Blocks that sum a gradient's norm.
const NORM_BLOCKS: u32 = 64;
/// Marks a coordinate that is a logarithm; see `kernels/optimizer.cu`.
const LOGARITHM: u32 = 1 << 31;

/// Optimizer runs on one device.
pub(crate) struct DeviceOptimizer {
    backend: CudaBackend,
    decay: Decay,
    runs: Vec<DeviceRun>,
}

struct DeviceRun {
    /// Owned by the run alone. Its element parameters are those that it was loaded with; the
    /// current ones are on the device; the current laws are also here.
    model: Arc<Model>,
    resident: Arc<Resident>,
    /// Separate model at the current point, made when first needed.
    current: Option<Loaded>,
    parameterization: Parameterization,
    indices: Buffer<u32>,
    /// Kind of each coordinate, and the first coordinate of each kind with their number at the end.
    kinds: Buffer<u32>,
    starts: Buffer<u32>,
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

impl DeviceOptimizer {
    pub(crate) fn new(
        backend: CudaBackend,
        inits: Vec<OptimizerInit>,
        decay: Decay,
    ) -> Result<Self, Error> {
        let begin = |init: OptimizerInit| {
            init.check()?;
            DeviceRun::new(&backend.queue, init)
        };
        let runs = inits.into_iter().map(begin).collect::<Result<_, Error>>()?;
        Ok(Self { backend, decay, runs })
    }

    fn run(&mut self, run: usize) -> Result<(&Arc<Queue>, &mut DeviceRun), Error> {
        let count = self.runs.len();
        let found = self.runs.get_mut(run).ok_or_else(|| unknown(run, count))?;
        Ok((&self.backend.queue, found))
    }

    /// Measures samples and leaves their gradients waiting.
    fn measure_chunk(
        &mut self,
        samples: &[GradientSample],
        instances: &[Instance],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let (simulated, gradients) = self.backend.measure(instances, request, cancel)?;
        let gradients = Arc::new(gradients);
        let losses = simulated.losses()?;
        let mut norms = Vec::with_capacity(samples.len());
        let final_states = simulated.final_states(request.final_state)?;
        let results = samples.iter().zip(losses).zip(final_states);
        for (i, ((sample, loss), final_state)) in results.enumerate() {
            let ended = loss.diverged.is_none();
            let run = &mut self.runs[sample.run];
            let own =
                if ended { gradients.params.at(gradients.starts[i]) } else { Pointer::default() };
            run.waiting.push((gradients.clone(), own));
            norms.push(GradientNorm { loss, norm: 0.0, final_state });
        }
        for (w, run) in self.runs.iter().enumerate() {
            let own: Vec<usize> = (0..samples.len()).filter(|&i| samples[i].run == w).collect();
            let newest = &run.waiting[run.waiting.len() - own.len()..];
            let own_norms = run.norms(&self.backend.queue, newest)?;
            for (i, norm) in own.into_iter().zip(own_norms) {
                norms[i].norm = norm;
            }
        }
        Ok(norms)
    }
}

fn unknown(run: usize, count: usize) -> Error {
    Error::InvalidInput(format!("run {run} does not exist: there are {count}"))
}

impl Optimizer for DeviceOptimizer {
    fn loaded(&mut self, run: usize) -> Result<Loaded, Error> {
        let backend = self.backend.clone();
        let (queue, run) = self.run(run)?;
        if let Some(current) = &run.current {
            return Ok(current.clone());
        }
        let params = run.params(queue)?;
        let current = backend.with_params(&run.own(), params)?;
        Ok(run.current.insert(current).clone())
    }

    fn measure(
        &mut self,
        batch: &[GradientSample],
        request: &GradientRequest,
        cancel: &CancelToken,
    ) -> Result<Vec<GradientNorm>, Error> {
        let here = |sample: &GradientSample| {
            let run = self.runs.get(sample.run);
            let run = run.ok_or_else(|| unknown(sample.run, self.runs.len()))?;
            Ok(Instance { model: run.own(), ..sample.instance.clone() })
        };
        let instances = batch.iter().map(here).collect::<Result<Vec<_>, Error>>()?;
        let request = GradientRequest {
            cut_every: request.cut_every,
            final_state: request.final_state,
            ..GradientRequest::PARAMS
        };
        let before: Vec<usize> = self.runs.iter().map(|w| w.waiting.len()).collect();
        let mut norms = Vec::with_capacity(batch.len());
        let mut outcome = self.backend.check(&instances);
        for chunk in self.backend.gradient_chunks(&instances) {
            if outcome.is_err() {
                break;
            }
            let (samples, instances) = (&batch[chunk.clone()], &instances[chunk]);
            outcome = self
                .measure_chunk(samples, instances, &request, cancel)
                .map(|more| norms.extend(more));
        }
        if outcome.is_err() {
            for (run, &before) in self.runs.iter_mut().zip(&before) {
                run.waiting.truncate(before);
            }
            // Failed work must not continue unseen.
            let _ = self.backend.queue.synchronize();
        }
        outcome.map(|()| norms)
    }

    fn step(&mut self, run: usize, weights: &[f64], rate: f64) -> Result<(), Error> {
        let decay = self.decay;
        let (queue, run) = self.run(run)?;
        if weights.len() != run.waiting.len() {
            let (n, waiting) = (weights.len(), run.waiting.len());
            return Err(Error::InvalidInput(format!("{n} weights for {waiting} gradients")));
        }
        run.step(queue, weights, rate, decay)
    }

    fn discard(&mut self, run: usize) -> Result<(), Error> {
        self.run(run)?.1.waiting.clear();
        Ok(())
    }

    fn position(&self, run: usize) -> Result<Position, Error> {
        let found = self.runs.get(run).ok_or_else(|| unknown(run, self.runs.len()))?;
        Ok(Position {
            theta: found.theta.read()?,
            adam: Adam {
                steps: found.steps,
                first: found.first.read()?,
                second: found.second.read()?,
            },
        })
    }

    fn move_to(&mut self, run: usize, position: &Position, timing: Timing) -> Result<(), Error> {
        let backend = self.backend.clone();
        let (queue, run) = self.run(run)?;
        run.parameterization.check_position(position)?;
        let params = run.parameterization.params(&position.theta);
        let model = Model { params, timing, ..Model::clone(&run.model) };
        let loaded = backend.load(Arc::new(model))?;
        let init = OptimizerInit {
            loaded,
            parameterization: run.parameterization.clone(),
            position: position.clone(),
        };
        *run = DeviceRun::new(queue, init)?;
        Ok(())
    }
}

impl DeviceRun {
    fn new(queue: &Queue, init: OptimizerInit) -> Result<Self, Error> {
        let OptimizerInit { loaded, parameterization, position } = init;
        let before = resident(&loaded)?;
        let params = parameterization.params(&position.theta);
        let own = before.with_params(&params)?.varying();
        let stream = &queue.stream;
        let rates: Vec<f64> = parameterization.rates().collect();
        let model = Model { params, ..Model::clone(loaded.model()) };
        let ranges = parameterization.kinds();
        let kinds: Vec<u32> =
            (0..).zip(&ranges).flat_map(|(k, r)| std::iter::repeat_n(k, r.len())).collect();
        let ends = ranges.iter().map(|r| r.end as u32);
        let starts: Vec<u32> = std::iter::once(0).chain(ends).collect();
        Ok(Self {
            indices: Buffer::of(stream, &indices(&parameterization, &model))?,
            kinds: Buffer::of(stream, &kinds)?,
            starts: Buffer::of(stream, &starts)?,
            rates: Buffer::of(stream, &rates)?,
            bounds: Buffer::of(stream, parameterization.bounds())?,
            start: Buffer::of(stream, &parameterization.start())?,
            theta: Buffer::of(stream, &position.theta)?,
            first: Buffer::of(stream, &position.adam.first)?,
            second: Buffer::of(stream, &position.adam.second)?,
            steps: position.adam.steps,
            model: Arc::new(model),
            resident: Arc::new(own),
            current: None,
            parameterization,
            waiting: Vec::new(),
        })
    }

    /// A separate model at the current point, ready to be simulated.
    fn own(&self) -> Loaded {
        Loaded::new(self.model.clone(), self.resident.clone())
    }

    /// The current parameters.
    fn params(&self, queue: &Queue) -> Result<Params, Error> {
        Ok(unflatten(&self.model.params, &queue.fetch(&self.resident.params)?))
    }

    /// Euclidean norms of some gradients.
    fn norms(
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
        let sums: Buffer<f64> = Buffer::empty(&queue.stream, ended.len() * NORM_BLOCKS as usize)?;
        let args = SquareLengthsArgs {
            out: sums.address(),
            gradients: addresses.address(),
            params: self.resident.params.address(),
            indices: self.indices.address(),
            count: self.indices.len() as u32,
            pad: 0,
        };
        let launch = queue.grid(NORM_BLOCKS, ended.len() as u32, 1);
        // SAFETY: the gradients are of this run's parameters, which the indices count.
        unsafe { kernels::square_lengths(&launch, &args)? };
        let sums = sums.read()?;
        let mut squares = sums.chunks(NORM_BLOCKS as usize).map(|s| s.iter().sum::<f64>());
        let norm = |g: &(Arc<Gradients>, Pointer<f32>)| {
            if g.1.is_null() { 0.0 } else { squares.next().unwrap_or(0.0).sqrt() }
        };
        let norms = gradients.iter().map(norm);
        Ok(norms.map(|l| if l.is_nan() { f64::INFINITY } else { l }).collect())
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
        // SAFETY: as in `norms`; the sums have a place for every coordinate.
        unsafe { kernels::weigh_gradients(&launch, &args)? };
        if !rate.is_finite() || finite.read()?.first() != Some(&1) {
            return Err(Error::InvalidInput("rate and weighted gradient must be finite".into()));
        }
        self.steps += 1;
        let [unbias_first, unbias_second] = Adam::unbias(self.steps, decay);
        let args = MeanSquaresArgs {
            second: self.second.address(),
            sums: sums.address(),
            starts: self.starts.address(),
            beta2: decay.beta2,
        };
        let of_kinds = queue.grid(self.second.len() as u32, 1, 1);
        // SAFETY: the second moments have a place for every kind, whose coordinates the sums have.
        unsafe { kernels::mean_squares(&of_kinds, &args)? };
        let graph = &self.model.graph;
        let (e, t) = (graph.springs.len() as u32, graph.triplets.len() as u32);
        let args = StepAdamArgs {
            theta: self.theta.address(),
            first: self.first.address(),
            second: self.second.address(),
            sums: sums.address(),
            kinds: self.kinds.address(),
            rates: self.rates.address(),
            bounds: self.bounds.address(),
            start: self.start.address(),
            params: self.resident.params.address(),
            indices: self.indices.address(),
            back: (decay.prior * rate).clamp(0.0, 1.0),
            rate,
            beta1: decay.beta1,
            unbias1: unbias_first,
            unbias2: unbias_second,
            slope: SLOPE,
            epsilon: EPSILON,
            count,
            angles: 3 * e + 2 * t,
            angles_end: 3 * e + 3 * t,
            pad: 0,
        };
        // SAFETY: all arrays have a value for every coordinate, and indices are those of
        // parameters.
        unsafe { kernels::step_adam(&launch, &args)? };
        self.resident.repack()?;
        self.read_laws()?;
        self.waiting.clear();
        self.current = None;
        Ok(())
    }

    /// Reads drag, restitutions and frictions back to the host: the arguments of instances carry
    /// them.
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
