"""Contact of the object with the links of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bendtwin.robots.transforms import Array
from bendtwin.simulation.rollout import RolloutResult


@dataclass(frozen=True)
class Contact:
    """Forces of a link on the object; R returned instances, F frames."""

    #: Mean force over each frame [R, F, 3], newtons; per unit mass without a `mass_kg`.
    forces: Array
    #: The largest of them [R], and the frame in which it acts, 1-based [R]; 0 without contact.
    largest: Array
    frame: npt.NDArray[np.int64]


def contacts_of(
    result: RolloutResult, links_of_colliders: Mapping[int, tuple[str, ...]]
) -> dict[str, Contact]:
    """The contact of each link, of which colliders are numbered in the world of a rollout.

    Raises:
        ValueError: If the rollout returned no forces, or had another world.
    """
    if result.forces is None:
        raise ValueError("ask for forces: Returns(forces=True)")
    colliders = np.asarray(result.forces.colliders, np.float64)
    if links_of_colliders and max(links_of_colliders) >= colliders.shape[2]:
        raise ValueError(
            f"the rollout had {colliders.shape[2]} colliders: give it the world of the workcell"
        )
    contacts = {}
    for link in dict.fromkeys(name for names in links_of_colliders.values() for name in names):
        numbers = [i for i, names in links_of_colliders.items() if link in names]
        forces = colliders[:, :, numbers, :3].sum(axis=2)
        sizes = np.linalg.norm(forces, axis=-1)
        largest = sizes.max(axis=1, initial=0.0)
        frame = np.where(largest > 0.0, sizes.argmax(axis=1) + 1, 0)
        contacts[link] = Contact(forces, largest, frame)
    return contacts
