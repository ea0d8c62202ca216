//! Models that the instances of a batch run on: the twin's, or variants with other parameters and
//! in other surroundings. Factors apply on top of a rest shape that corrections have changed.
//!
//! A mass factor m divides what exerts forces (stiffness, damping, drag, holds) by m, which changes
//! every motion as a mass of m does; a force that the engine reports, at unit node mass, is then m
//! times as large.
//!
//! A variant that is too stiff for the twin's substeps gets more, by the stability estimate that fits use:
//! those that it needs itself, independent of its batch, so that an instance moves in the same
//! bits alone and beside others.

use std::{collections::HashMap, sync::Arc};

use bendtwin_contract::rollout::{MOST_SUBSTEPS, finer_substeps};
use bendtwin_core::{CancelToken, Params};
use bendtwin_engine::{
    Backend, Loaded, Model, Objective, Term, World, backend, enough_substeps,
    objective::WeightedTerm,
};
use bendtwin_proto::v1::{Tensor, Vary};

use crate::{error::Error, twin::rest_shape::RestShape, world::Surroundings};

/// Largest Coulomb friction.
const MOST_FRICTION: f32 = 2.0;

/// Factors of the twin's own parameters, and what takes their place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factors {
    pub(crate) stiffness: f32,
    pub(crate) damping: f32,
    pub(crate) bending: f32,
    pub(crate) friction: f32,
    pub(crate) mass: f32,
    pub(crate) ground_restitution: Option<f32>,
    pub(crate) object_restitution: Option<f32>,
}

/// A model and what surrounds it.
#[derive(Clone)]
pub(crate) struct Variant {
    pub(crate) loaded: Loaded,
    pub(crate) world: Arc<World>,
    /// Mass factor.
    pub(crate) mass: f32,
}

/// Inputs from which variants are made.
pub(crate) struct Base<'a> {
    /// The twin.
    pub(crate) loaded: &'a Loaded,
    /// The twin and its members, if the members of the ensemble are to be simulated on these.
    pub(crate) fits: &'a [Loaded],
    /// Rest shapes that are not the twin's: one for all actions, or one for each; empty: none.
    pub(crate) rests: &'a [Option<Arc<RestShape>>],
    /// Members of the ensemble, 1 without one.
    pub(crate) members: usize,
}

/// The models of a batch.
pub(crate) struct Variants {
    all: Vec<Variant>,
    /// Variant of each instance; fewer ones repeat: those of the members of an ensemble, or one.
    of: Vec<u32>,
}

impl Factors {
    /// The unchanged twin.
    #[cfg(test)]
    pub(crate) const ONE: Self = Self {
        stiffness: 1.0,
        damping: 1.0,
        bending: 1.0,
        friction: 1.0,
        mass: 1.0,
        ground_restitution: None,
        object_restitution: None,
    };

    fn bits(self) -> [Option<u32>; 7] {
        let factors = [self.stiffness, self.damping, self.bending, self.friction, self.mass];
        let [a, b, c, d, e] = factors.map(|x| Some(x.to_bits()));
        let [f, g] =
            [self.ground_restitution, self.object_restitution].map(|x| x.map(f32::to_bits));
        [a, b, c, d, e, f, g]
    }

    /// Parameters of the twin with these factors.
    pub(crate) fn apply(self, params: &mut Params) {
        let scale = |values: &mut Vec<f32>, factor: f32| {
            if factor != 1.0 {
                values.iter_mut().for_each(|x| *x *= factor);
            }
        };
        let damping = self.damping / self.mass;
        scale(&mut params.spring_stiffness, self.stiffness / self.mass);
        scale(&mut params.spring_dashpot, damping);
        for values in [&mut params.bend_stiffness, &mut params.twist_stiffness] {
            scale(values, self.bending / self.mass);
        }
        for values in [&mut params.bend_damping, &mut params.twist_damping] {
            scale(values, damping);
        }
        params.drag *= damping;
        let contact = &mut params.contact;
        contact.ground_friction = self.friction_of(contact.ground_friction);
        contact.object_friction = self.friction_of(contact.object_friction);
        contact.ground_restitution = self.ground_restitution.unwrap_or(contact.ground_restitution);
        contact.object_restitution = self.object_restitution.unwrap_or(contact.object_restitution);
    }

    /// A coefficient of friction with this factor.
    pub(crate) fn friction_of(self, coefficient: f32) -> f32 {
        (self.friction * coefficient).min(MOST_FRICTION)
    }

    /// True if the model may need more substeps than the twin.
    fn stiffens(self) -> bool {
        [self.stiffness, self.damping, self.bending].iter().any(|x| x / self.mass > 1.0)
    }
}

impl Variants {
    /// Loads the models that a checked request asks for, each once.
    pub(crate) fn load(
        vary: Option<Vary>,
        base: &Base<'_>,
        surroundings: &Surroundings,
        backend: &dyn Backend,
        cancel: &CancelToken,
    ) -> Result<Self, Error> {
        let around = |loaded: &Loaded| match surroundings.environment(loaded.model().environment) {
            None => Ok(loaded.clone()),
            Some(environment) => backend.with_environment(loaded, environment),
        };
        let fits = base.models().iter().map(around).collect::<Result<Vec<_>, _>>()?;
        let sets = read(vary.unwrap_or_default())?;
        let count = base.count(sets.len());
        let (mut numbers, mut finer) = (HashMap::new(), Finer::default());
        let (mut all, mut of) = (Vec::new(), Vec::with_capacity(count));
        for index in 0..count {
            if cancel.is_cancelled() {
                return Err(backend::Error::Cancelled.into());
            }
            let next = all.len() as u32;
            let (set, rest, fit) = (index % sets.len(), base.rest(index), index % fits.len());
            let factors = sets[set];
            let key = (rest.map(Arc::as_ptr), fit, factors.bits());
            let number = *numbers.entry(key).or_insert(next);
            if number == next {
                let changed = Changed { factors, set, rest: rest.map(|rest| &**rest) };
                let base = (fit, &fits[fit]);
                let loaded = changed.load(base, surroundings, &mut finer, backend)?;
                let world = Arc::new(surroundings.world(factors));
                all.push(Variant { loaded, world, mass: factors.mass });
            }
            of.push(number);
        }
        Ok(Self { all, of })
    }

    /// The variant of an instance; those of the members of an ensemble follow one another.
    pub(crate) fn of(&self, index: usize) -> &Variant {
        &self.all[self.of[index % self.of.len()] as usize]
    }

    /// Substeps per frame of the variant that takes most.
    pub(crate) fn most_substeps(&self) -> u32 {
        let substeps = |variant: &Variant| variant.loaded.model().timing.substeps;
        self.all.iter().map(substeps).max().unwrap_or_default()
    }
}

impl<'a> Base<'a> {
    /// A twin with its own rest shape, without an ensemble.
    pub(crate) fn own(loaded: &'a Loaded) -> Self {
        Self { loaded, fits: &[], rests: &[], members: 1 }
    }

    /// Models of the members of the ensemble, or one for all of them.
    fn models(&self) -> &'a [Loaded] {
        if self.fits.is_empty() { std::slice::from_ref(self.loaded) } else { self.fits }
    }

    /// Number of instances after which fits, rest shapes and `sets` sets of factors repeat.
    fn count(&self, sets: usize) -> usize {
        match (self.rests.len(), self.fits.len()) {
            (2.., _) => self.rests.len() * self.members,
            // Factors are the same for all members, or as many as these.
            (_, 1..) => self.members,
            _ => sets,
        }
    }

    /// The rest shape of an instance, if it is not the twin's.
    fn rest(&self, index: usize) -> Option<&'a Arc<RestShape>> {
        let action = if self.rests.len() > 1 { index / self.members } else { 0 };
        self.rests.get(action)?.as_ref()
    }
}

impl Variant {
    /// An objective whose forces are those of this variant, from one for the unchanged twin: at
    /// unit node mass a limit is smaller by the mass, and a squared force by its square.
    pub(crate) fn objective(&self, of: &Objective) -> Objective {
        let is_force = |term: &WeightedTerm| matches!(term.term, Term::Force { .. });
        if self.mass == 1.0 || !of.terms.iter().any(is_force) {
            return of.clone();
        }
        let mut terms = Vec::clone(&of.terms);
        for term in &mut terms {
            if let Term::Force { limit, .. } = &mut term.term {
                *limit /= self.mass;
                term.weight *= self.mass * self.mass;
            }
        }
        Objective { terms: Arc::new(terms), groups: of.groups.clone() }
    }
}

/// The differences of a variant from the twin.
struct Changed<'a> {
    factors: Factors,
    /// Number of the set of factors.
    set: usize,
    rest: Option<&'a RestShape>,
}

/// Models with more substeps than the fits have, by fit and substeps, from which variants are made.
#[derive(Default)]
struct Finer(HashMap<(usize, u32), Loaded>);

impl Finer {
    fn load(
        &mut self,
        (fit, base): (usize, &Loaded),
        substeps: u32,
        backend: &dyn Backend,
    ) -> Result<Loaded, Error> {
        if let Some(loaded) = self.0.get(&(fit, substeps)) {
            return Ok(loaded.clone());
        }
        let mut model = Model::clone(base.model());
        model.timing.substeps = substeps;
        let loaded = backend.load(Arc::new(model))?;
        self.0.insert((fit, substeps), loaded.clone());
        Ok(loaded)
    }
}

impl Changed<'_> {
    /// The model of this variant, of a fit with this number.
    fn load(
        &self,
        (fit, base): (usize, &Loaded),
        surroundings: &Surroundings,
        finer: &mut Finer,
        backend: &dyn Backend,
    ) -> Result<Loaded, Error> {
        let model = base.model();
        let mut params = model.params.clone();
        if let Some(rest) = self.rest {
            rest.put_into(&mut params);
        }
        surroundings.touch(&mut params.contact);
        self.factors.apply(&mut params);
        if params == model.params {
            return Ok(base.clone());
        }
        if self.factors.stiffens() {
            let own = model.timing.substeps;
            let stiffer = Model { params: params.clone(), ..Model::clone(model) };
            if let Err(needs) = enough_substeps(&stiffer, own) {
                let substeps = finer_substeps(own, needs.needed.into());
                if substeps < needs.needed {
                    return Err(self.too_stiff(needs.needed));
                }
                let finer = finer.load((fit, base), substeps, backend)?;
                return Ok(backend.with_params(&finer, params)?);
            }
        }
        Ok(backend.with_params(base, params)?)
    }

    fn too_stiff(&self, needed: u32) -> Error {
        let set = self.set;
        let fault = format!(
            "needs {needed} substeps a frame for {set}, and a frame has at most {MOST_SUBSTEPS}: use smaller factors of stiffness, bending and damping, or a larger one of the mass"
        );
        Error::field("vary", fault)
    }
}

/// Factors by instance or member; one set if none are given.
fn read(vary: Vary) -> Result<Vec<Factors>, Error> {
    let unpack = |tensor: Option<Tensor>, field| match tensor.filter(|t| !t.is_absent()) {
        None => Ok(Vec::new()),
        Some(tensor) => tensor.unpack::<f32>(field).map(|(_, values)| values),
    };
    let stiffness = unpack(vary.stiffness, "vary.stiffness")?;
    let damping = unpack(vary.damping, "vary.damping")?;
    let bending = unpack(vary.bending, "vary.bending")?;
    let friction = unpack(vary.friction, "vary.friction")?;
    let mass = unpack(vary.mass, "vary.mass")?;
    let ground_restitution = unpack(vary.ground_restitution, "vary.ground_restitution")?;
    let object_restitution = unpack(vary.object_restitution, "vary.object_restitution")?;
    let arrays = [
        &stiffness,
        &damping,
        &bending,
        &friction,
        &mass,
        &ground_restitution,
        &object_restitution,
    ];
    let count = arrays.iter().map(|values| values.len()).max().unwrap_or(0).max(1);
    let at = |values: &[f32], i: usize| values.get(i).copied().unwrap_or(1.0);
    let factors = |i| Factors {
        stiffness: at(&stiffness, i),
        damping: at(&damping, i),
        bending: at(&bending, i),
        friction: at(&friction, i),
        mass: at(&mass, i),
        ground_restitution: ground_restitution.get(i).copied(),
        object_restitution: object_restitution.get(i).copied(),
    };
    Ok((0..count).map(factors).collect())
}

#[cfg(test)]
mod tests;
