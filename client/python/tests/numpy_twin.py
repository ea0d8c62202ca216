"""A twin file read, written and simulated with numpy alone, as docs/formats/twin.md says: what
another program would write from that page. Double precision throughout."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

TYPES = {"F32": "<f4", "U32": "<u4", "U8": "|u1"}
NONE = 0xFFFFFFFF


@dataclass(frozen=True)
class TwinFile:
    about: dict
    tensors: dict

    @classmethod
    def decode(cls, content):
        length = int.from_bytes(content[:8], "little")
        header = json.loads(content[8 : 8 + length])
        about = json.loads(header.pop("__metadata__")["bendtwin.twin"])
        tensors = {}
        for name, entry in header.items():
            start, end = (8 + length + offset for offset in entry["data_offsets"])
            array = np.frombuffer(content[start:end], TYPES[entry["dtype"]])
            tensors[name] = array.reshape(entry["shape"])
        return cls(about, tensors)

    def encode(self):
        names = {numpy: name for name, numpy in TYPES.items()}
        header = {"__metadata__": {"bendtwin.twin": json.dumps(self.about)}}
        data = b""
        for name, array in self.tensors.items():
            offsets = [len(data), len(data) + array.nbytes]
            dtype = names[array.dtype.str]
            header[name] = {"dtype": dtype, "shape": array.shape, "data_offsets": offsets}
            data += array.tobytes()
        text = json.dumps(header).encode()
        text += b" " * (-len(text) % 8)
        return len(text).to_bytes(8, "little") + text + data

    def without(self, **contact):
        """The same with other contact parameters."""
        return replace(self, about=self.about | {"contact": self.about["contact"] | contact})

    def __getitem__(self, name):
        array = self.tensors[name]
        return array.astype(np.float64 if array.dtype.kind == "f" else np.int64)


def dot(a, b):
    return np.einsum("...i,...i->...", a, b)


def norm(a):
    return np.sqrt(dot(a, a))


def impact(start, v, n, restitution, friction):
    """Change of a relative velocity by an impact, `start` being that at the substep's start."""
    v_n = dot(v, n)[:, None]
    v_t = v - v_n * n
    speed = norm(v_t)[:, None]
    impulse = restitution * np.clip(-dot(start, n)[:, None], 0, -v_n) - v_n
    brake = np.minimum(1, friction * impulse / np.maximum(speed, 1e-300))
    return impulse * n - brake * v_t


class Simulator:
    def __init__(self, file):
        self.file, self.about = file, file.about
        self.rest = file["nodes.rest_position"]
        self.mass = file["nodes.mass"]
        self.n = len(self.rest)
        pins = file["pins.ends"]
        self.pinned, self.pinned_to = pins[:, 0], pins[:, 1]
        self.offsets = file["pins.offset"]
        self.inverse_mass = 1 / self.mass
        self.inverse_mass[self.pinned] = 0
        timing = self.about["timing"]
        self.fps, self.substeps = timing["fps"], timing["substeps"]
        self.dt = 1 / (self.fps * self.substeps)
        self.decay = np.exp(-self.about["drag"] * self.dt)
        self.gravity = np.array(self.about["environment"]["gravity"])
        self.may_touch = self.pairs_that_may_touch()
        lengths = file["rods.lengths"] if "rods.lengths" in file.tensors else []
        ends = np.cumsum(lengths)[:-1].astype(int)
        self.rods = np.split(file["rods.nodes"], ends) if len(lengths) else []

    def roll_out(self, controls, x=None, v=None):
        """Positions at frames' ends [F, N, 3] for controls [F + 1, C, 3]."""
        x = (self.rest if x is None else x).copy()
        v = np.zeros_like(x) if v is None else v.copy()
        self.twists = np.zeros(len(self.rods))
        frames = []
        for start, end in pairwise(controls):
            x, v = self.frame(x, v, np.asarray(start, float), np.asarray(end, float))
            frames.append(x)
        return np.array(frames)

    def frame(self, x, v, start, end):
        w = (end - start) * self.fps
        if self.about["control_velocity"] == "ignored":
            w = np.zeros_like(w)
        x[self.pinned] = start[self.pinned_to] + self.offsets
        v[self.pinned] = w[self.pinned_to]
        pairs = self.candidates(x, v)
        self.clearance = self.clearances(x)
        for s in range(1, self.substeps + 1):
            c = (1 - s / self.substeps) * start + s / self.substeps * end
            force = self.forces(np.concatenate([x, c]), np.concatenate([v, w]))
            begin = v
            v = (v + (force / self.mass[:, None] + self.gravity) * self.dt) * self.decay
            v[self.pinned] = w[self.pinned_to]
            v = self.collide(pairs, x, begin, v)
            x, v = self.travel(x, begin, v)
            x[self.pinned] = c[self.pinned_to] + self.offsets
            v[self.pinned] = w[self.pinned_to]
        return x, v

    def clearances(self, x):
        """Distances from the ground at which nodes touch it."""
        clearance, ground = np.zeros(self.n), self.about["environment"]["ground"]
        if ground is None or not self.about["contact"].get("skin"):
            return clearance
        counts, weight = self.file["skin.weight_count"], self.file["skin.weight"]
        point = np.repeat(np.arange(len(counts)), counts)
        largest = np.zeros(len(counts))
        np.maximum.at(largest, point, weight)
        bears = (weight > 0) & (weight >= 0.25 * largest[point])
        node, point = self.file["skin.weight_node"][bears], point[bears]
        nearer = (x[node] - skin(self.file, x[None])[0, point]) @ np.array(ground["normal"])
        np.maximum.at(clearance, node, nearer)
        return clearance

    def forces(self, x, v):
        force = np.zeros_like(x)
        self.add_springs(force, x, v)
        self.add_triplets(force, x, v)
        for r, rod in enumerate(self.rods):
            self.add_rod(force, x, v, r, rod)
        return force[: self.n]

    def add_springs(self, force, x, v):
        i, j = self.file["springs.ends"].T
        r = x[j] - x[i]
        length = norm(r)
        rest = self.file["springs.rest_length"]
        d = r / np.maximum(length, 1e-12)[:, None]
        elastic = self.file["springs.stiffness"] * (length / np.maximum(rest, 1e-300) - 1)
        elastic[rest == 0] = 0
        damping = self.file["springs.dashpot"] * dot(v[j] - v[i], d)
        f = np.where(length > 1e-12, elastic + damping, 0)[:, None] * d
        np.add.at(force, i, f)
        np.add.at(force, j, -f)

    def add_triplets(self, force, x, v):
        i, j, k = self.file["triplets.ends"].T
        if not len(i):
            return
        bend0 = np.pi - self.file["triplets.rest_angle"]
        bend0[np.abs(bend0) < 1e-6] = 0
        u, w = x[i] - x[j], x[k] - x[j]
        n = np.cross(u, w)
        sine, cosine = norm(n), dot(u, w)
        arms = norm(u) * norm(w)
        has_arms = (norm(u) > 1e-6) & (norm(w) > 1e-6)
        regular = has_arms & (sine >= 1e-4 * arms)
        straight = has_arms & ~regular & (bend0 == 0) & (cosine < 0)
        bend = np.arctan2(sine, -cosine)
        rounded = np.sqrt(bend**2 + (bend0 / 2) ** 2)
        q, q0 = -rounded, -np.sqrt(bend0**2 + (bend0 / 2) ** 2)
        share = np.where(regular, bend / np.where(regular, rounded, 1), 1)
        by_sine = share / np.where(regular, sine, np.where(straight, cosine, 1))
        g_i = np.cross(u, n) / np.maximum(dot(u, u), 1e-300)[:, None] * by_sine[:, None]
        g_k = np.cross(n, w) / np.maximum(dot(w, w), 1e-300)[:, None] * by_sine[:, None]
        rate = dot(g_i, v[i] - v[j]) + dot(g_k, v[k] - v[j])
        moment = self.file["triplets.bend_stiffness"] * np.where(regular, q - q0, 1)
        moment = moment + np.where(regular, self.file["triplets.bend_damping"] * rate, 0)
        moment = -np.where(regular | straight, moment, 0)[:, None]
        np.add.at(force, i, moment * g_i)
        np.add.at(force, k, moment * g_k)
        np.add.at(force, j, -moment * (g_i + g_k))

    def add_rod(self, force, x, v, r, rod):
        gradient = np.zeros_like(force)
        has_arm = rod[-1] not in self.pinned
        for at in range(1, len(rod) - 1):
            before, j, after = rod[at - 1 : at + 2]
            e, g = x[j] - x[before], x[after] - x[j]
            n, (e1, g1) = np.cross(e, g), (norm(e), norm(g))
            if min(e1, g1) <= 1e-6:
                continue
            if has_arm and at == len(rod) - 2:
                if n @ n <= 0.01 * (e1 * g1) ** 2:
                    continue
                a, c = -(e @ g) * n / (e1 * (n @ n)), -e1 * n / (n @ n)
            else:
                fold = e1 * g1 + e @ g
                if fold <= 0.01 * e1 * g1:
                    continue
                a, c = n / fold / e1, -n / fold / g1
            gradient[before] += a
            gradient[j] -= a + c
            gradient[after] += c
        rate = np.sum(gradient * v)
        self.twists[r] += rate * self.dt
        torque = self.file["rods.twist_stiffness"][r] * (
            self.twists[r] - self.file["rods.rest_twist"][r]
        )
        force -= (torque + self.file["rods.twist_damping"][r] * rate) * gradient

    def pairs_that_may_touch(self):
        a, b = np.triu_indices(self.n, 1)
        contact, ids = self.about["contact"], self.file["nodes.object_id"]
        springs = np.sort(self.file["springs.ends"], axis=1)
        joined = np.isin(a * self.n + b, (springs @ [self.n, 1])[springs[:, 1] < self.n])
        other = ids[a] != ids[b]
        may = (other & contact["between_objects"]) | (~other & contact["within_object"] & ~joined)
        return np.stack([a[may], b[may]])

    def candidates(self, x, v):
        near = self.about["contact"]["collision_distance_m"]
        reach = np.clip(2 * norm(v).max() / self.fps, near, 4 * near)
        a, b = self.may_touch
        # No test here has a node with more than 512 of them.
        return self.may_touch[:, norm(x[b] - x[a]) <= near + reach]

    def collide(self, pairs, x, start, v):
        contact = self.about["contact"]
        limit = contact["collision_distance_m"]
        a, b = pairs
        inverse = self.inverse_mass[a] + self.inverse_mass[b]
        length = norm(x[b] - x[a])
        near = (length < limit) & (length > 1e-12) & (inverse > 0)
        a, b, inverse, length = a[near], b[near], inverse[near], length[near]
        n = (x[b] - x[a]) / length[:, None]
        change = v[b] - v[a]
        hits = dot(change, n) < 0
        law = contact["object_restitution"], contact["object_friction"]
        by_impact = impact(start[b] - start[a], change, n, *law)
        total_change = np.where(hits[:, None], by_impact, 0)
        leaves = dot(change + total_change, n)
        apart = norm(self.rest[b] - self.rest[a]) >= limit
        lack = np.where(apart, np.minimum(limit - length, 0.005) / 0.01 - leaves, 0)
        pushes = lack > 0
        total_change += np.where(pushes, lack, 0)[:, None] * n
        touch = hits | pushes
        a, b = a[touch], b[touch]
        impulse = total_change[touch] / inverse[touch][:, None]
        total, count = np.zeros_like(v), np.zeros(self.n)
        np.add.at(total, a, impulse)
        np.add.at(total, b, -impulse)
        np.add.at(count, np.concatenate([a, b]), 1)
        return v - (self.inverse_mass / np.maximum(count, 1))[:, None] * total

    def travel(self, x, start, v):
        ground, contact = self.about["environment"]["ground"], self.about["contact"]
        after = x + self.dt * v
        if ground is None:
            return after, v
        n = np.array(ground["normal"])
        offset = ground["offset_m"] + self.clearance
        hits = (after @ n - offset < 1e-6) & (v @ n < 0)
        x, old, v = x[hits], v[hits], v.copy()
        law = contact["ground_restitution"], contact["ground_friction"]
        v[hits] = old + impact(start[hits], old, np.broadcast_to(n, old.shape), *law)
        height = x @ n - offset[hits]
        tau = np.where(height > 1e-6, np.minimum(height / np.abs(old @ n), self.dt), 0)[:, None]
        after[hits] = x + tau * old + (self.dt - tau) * v[hits]
        return after, v


def skin(file, x):
    """Positions of the skin [F, M, 3] for nodes at x [F, N, 3]."""
    counts = file["skin.weight_count"]
    point = np.repeat(np.arange(len(counts)), counts)
    places = np.zeros((len(x), len(counts), 3))
    weighted = x[:, file["skin.weight_node"]] * file["skin.weight"][:, None]
    np.add.at(places, (slice(None), point), weighted)
    framed = file["skin.frame"][:, 0] != NONE
    places[:, ~framed] += file["skin.offset"][~framed]
    a, b, c = (x[:, nodes] for nodes in file["skin.frame"][framed].T)
    e1, e3 = b - a, np.cross(b - a, c - a)
    e1, e3 = e1 / norm(e1)[..., None], e3 / norm(e3)[..., None]
    axes = np.stack([e1, np.cross(e3, e1), e3], axis=-2)
    places[:, framed] += np.einsum("mo,fmoi->fmi", file["skin.offset"][framed], axes)
    return places
