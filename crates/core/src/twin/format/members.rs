//! Members in the twin file: those of one stand after those of the one before, as `members.springs.count` and
//! `members.triplets.count` divide them; what is one number for each is in the metadata.

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::{FormatError, Raw, Tensors, Twin, raw};
use crate::{Contact, Environment, Params, settings::MOST_MEMBERS, twin::Member};

/// Numbers of a member.
#[derive(Serialize, Deserialize)]
pub(super) struct Numbers {
    drag: f32,
    contact: Contact,
    environment: Environment,
    substeps: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    loss: Option<f64>,
}

impl Numbers {
    pub(super) fn of(member: &Member) -> Self {
        let Params { drag, contact, .. } = member.params;
        let Member { environment, substeps, loss, .. } = *member;
        Self { drag, contact, environment, substeps, loss }
    }
}

/// Tensors of all members.
pub(super) fn tensors(members: &[Member]) -> [(&'static str, Raw<'static>); 13] {
    let counts = |of: fn(&Member) -> usize| {
        let counts: Vec<u32> = members.iter().map(|m| of(m) as u32).collect();
        raw(Dtype::U32, &[members.len()], &counts)
    };
    let numbers = |of: fn(&Params) -> &[f32]| {
        let all: Vec<f32> = members.iter().flat_map(|m| of(&m.params)).copied().collect();
        raw(Dtype::F32, &[all.len()], &all)
    };
    let springs: Vec<[u32; 2]> = members.iter().flat_map(|m| &m.springs).copied().collect();
    let triplets: Vec<[u32; 3]> = members.iter().flat_map(|m| &m.triplets).copied().collect();
    [
        ("members.springs.count", counts(|m| m.springs.len())),
        ("members.springs.ends", raw(Dtype::U32, &[springs.len(), 2], &springs)),
        ("members.springs.rest_length", numbers(|p| &p.rest_lengths_m)),
        ("members.springs.stiffness", numbers(|p| &p.spring_stiffness)),
        ("members.springs.dashpot", numbers(|p| &p.spring_dashpot)),
        ("members.triplets.count", counts(|m| m.triplets.len())),
        ("members.triplets.ends", raw(Dtype::U32, &[triplets.len(), 3], &triplets)),
        ("members.triplets.rest_angle", numbers(|p| &p.rest_angles_rad)),
        ("members.triplets.bend_stiffness", numbers(|p| &p.bend_stiffness)),
        ("members.triplets.bend_damping", numbers(|p| &p.bend_damping)),
        ("members.rods.twist_stiffness", numbers(|p| &p.twist_stiffness)),
        ("members.rods.twist_damping", numbers(|p| &p.twist_damping)),
        ("members.rods.rest_twist", numbers(|p| &p.rest_twists_rad)),
    ]
}

impl Tensors<'_> {
    /// Members of a twin with this many rods.
    pub(super) fn members(&self, of: &[Numbers], rods: usize) -> Result<Vec<Member>, FormatError> {
        let fail = |m: String| Err(FormatError::Inconsistent(m));
        if !(1..=MOST_MEMBERS).contains(&of.len()) {
            let count = of.len();
            return fail(format!(
                "{count} members (1 to {MOST_MEMBERS} are possible in a file of this version)"
            ));
        }
        let springs: Vec<u32> = self.read("members.springs.count", Dtype::U32, None)?;
        let triplets: Vec<u32> = self.read("members.triplets.count", Dtype::U32, None)?;
        if springs.len() != of.len() || triplets.len() != of.len() {
            return fail(
                "members.springs.count and members.triplets.count need one number for each member"
                    .into(),
            );
        }
        let rods = vec![rods as u32; of.len()];
        let ends = self.read_parts("members.springs.ends", Some(2), &springs)?;
        let corners = self.read_parts("members.triplets.ends", Some(3), &triplets)?;
        let numbers = |name, counts: &[u32]| self.read_parts::<f32>(name, None, counts);
        let mut lengths = numbers("members.springs.rest_length", &springs)?.into_iter();
        let mut stiffness = numbers("members.springs.stiffness", &springs)?.into_iter();
        let mut dashpots = numbers("members.springs.dashpot", &springs)?.into_iter();
        let mut angles = numbers("members.triplets.rest_angle", &triplets)?.into_iter();
        let mut bending = numbers("members.triplets.bend_stiffness", &triplets)?.into_iter();
        let mut bend_damping = numbers("members.triplets.bend_damping", &triplets)?.into_iter();
        let mut twisting = numbers("members.rods.twist_stiffness", &rods)?.into_iter();
        let mut twist_damping = numbers("members.rods.twist_damping", &rods)?.into_iter();
        let mut twists = numbers("members.rods.rest_twist", &rods)?.into_iter();
        let parts = of.iter().zip(ends).zip(corners);
        let members = parts.map(|((numbers, springs), triplets)| Member {
            springs,
            triplets,
            params: Params {
                rest_lengths_m: lengths.next().unwrap_or_default(),
                spring_stiffness: stiffness.next().unwrap_or_default(),
                spring_dashpot: dashpots.next().unwrap_or_default(),
                rest_angles_rad: angles.next().unwrap_or_default(),
                bend_stiffness: bending.next().unwrap_or_default(),
                bend_damping: bend_damping.next().unwrap_or_default(),
                twist_stiffness: twisting.next().unwrap_or_default(),
                twist_damping: twist_damping.next().unwrap_or_default(),
                rest_twists_rad: twists.next().unwrap_or_default(),
                drag: numbers.drag,
                contact: numbers.contact,
            },
            environment: numbers.environment,
            substeps: numbers.substeps,
            loss: numbers.loss,
        });
        Ok(members.collect())
    }

    /// A tensor split into parts of the given numbers of rows.
    fn read_parts<T: ElementType>(
        &self,
        name: &'static str,
        width: Option<usize>,
        counts: &[u32],
    ) -> Result<Vec<Vec<T>>, FormatError> {
        let all: Vec<T> = self.read(name, T::DTYPE, width)?;
        let total: u64 = counts.iter().copied().map(u64::from).sum();
        if total != all.len() as u64 {
            let fault = format!("has {} rows, the members have {total}", all.len());
            return Err(FormatError::Tensor { name, fault });
        }
        let mut rest = all.into_iter();
        Ok(counts.iter().map(|count| rest.by_ref().take(*count as usize).collect()).collect())
    }
}

/// Rows of tensors of members.
trait ElementType: bytemuck::AnyBitPattern {
    /// Type of their numbers.
    const DTYPE: Dtype;
}

impl ElementType for f32 {
    const DTYPE: Dtype = Dtype::F32;
}

impl<const N: usize> ElementType for [u32; N] {
    const DTYPE: Dtype = Dtype::U32;
}

impl Twin {
    /// Checks that every member can be simulated as the twin can.
    pub(super) fn check_members(&self) -> Result<(), FormatError> {
        if self.members.len() > MOST_MEMBERS {
            let count = self.members.len();
            let why = format!("{count} members, at most {MOST_MEMBERS} are possible");
            return Err(FormatError::Inconsistent(why));
        }
        self.members.iter().enumerate().try_for_each(|(index, member)| {
            member.twin(self).check().map_err(|fault| {
                FormatError::Inconsistent(format!("member {}: {fault}", index + 1))
            })
        })
    }
}
