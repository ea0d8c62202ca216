"""PhysTwin's results are imported as twins whose rollouts are those of PhysTwin's model, which is
written here a second time from its description, in its own axes (z down) and in double precision.

The results are written without torch, in the form that crates/capture/testdata/phystwin has from
torch itself."""

import io
import json
import pickle
import sys
import types
import zipfile
from contextlib import contextmanager

import numpy as np
import pytest
from numpy_twin import norm
from server import needs_server, run, running

from bendtwin import Client, Returns

FRAMES = 30
#: Largest distance of a node from PhysTwin's model after any of the frames, metres.
TOLERANCE_M = 2e-4
DT_S, SUBSTEPS = 5e-5, 667
GRAVITY = np.array([0, 0, 9.8])
#: To the twin's axes and back.
TURN = np.array([1, -1, -1])

PARAMS = {
    "global_spring_Y": np.float32(2500),
    "object_radius": np.float32(0.022),
    "object_max_neighbours": 12,
    "controller_radius": np.float32(0.03),
    "controller_max_neighbours": 6,
    "collide_elas": np.float32(0.4),
    "collide_fric": np.float64(0.5),
    "collide_object_elas": 0.7,
    "collide_object_fric": np.float32(0.3),
    "collision_dist": np.float32(0.03),
    "drag_damping": np.float32(4.75),
    "dashpot_damping": np.float32(60.5),
}

pytestmark = needs_server


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with running(tmp_path_factory.mktemp("bendtwin")) as address, Client(address) as client:
        yield client


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A case where PhysTwin has it: a blob above the ground that a hand drags along and down."""
    folder = tmp_path_factory.mktemp("phystwin") / "data/different_types/blob"
    folder.mkdir(parents=True)
    random = np.random.default_rng(5)
    observed, surface, inside = (random.uniform(-0.03, 0.03, (n, 3)) for n in (24, 12, 9))
    above = np.array([0.1, 0.2, -0.06])
    t = np.linspace(0, 1, FRAMES + 1)[:, None, None]
    held = np.array([[0.0, 0.0, -0.035], [0.01, 0.01, -0.035]]) + above
    data = {
        "object_points": np.tile(observed + above, (FRAMES + 1, 1, 1)),
        "object_colors": np.zeros((FRAMES + 1, 24, 3)),
        "object_visibilities": np.ones((FRAMES + 1, 24), bool),
        "object_motions_valid": np.ones((FRAMES, 24), bool),
        "controller_points": held + t * np.array([0.15, 0, 0]) + np.sin(6 * t) * [0, 0.02, 0.02],
        "surface_points": surface + above,
        "interior_points": inside + above,
    }
    (folder / "final_data.pkl").write_bytes(pickle.dumps(data))
    (folder / "metadata.json").write_text(json.dumps({"fps": 30}))
    (folder / "split.json").write_text(json.dumps({"train": [0, 20], "test": [20, FRAMES + 1]}))
    return folder


class Reference:
    """PhysTwin's model of a case."""

    def __init__(self, case, drag, dashpot, stiffness=None, elas=0.4, fric=0.5):
        data = pickle.loads((case / "final_data.pkl").read_bytes())
        parts = data["object_points"][0], data["surface_points"], data["interior_points"]
        self.x = np.concatenate(parts).astype("f4").astype(float)
        self.controls = data["controller_points"].astype("f4").astype(float)
        self.springs = []
        self.drag, self.dashpot, self.elas, self.fric = drag, dashpot, elas, fric
        self.join(self.x, range(len(self.x)), 0.022, 12)
        self.object_springs = len(self.springs)
        for c, point in enumerate(self.controls[0]):
            near = self.nearest(self.x, point, 0.03, 6)
            self.springs += [(len(self.x) + c, j) for j in near]
        i, j = np.array(self.springs).T
        everything = np.concatenate([self.x, self.controls[0]])
        self.rest = norm(everything[i] - everything[j])
        self.stiffness = np.full(len(i), 2500.0) if stiffness is None else stiffness

    @staticmethod
    def nearest(points, at, radius, most):
        square = np.sum((points - at) ** 2, axis=1)
        order = np.argsort(square, kind="stable")[:most]
        return [j for j in order if square[j] < float(np.float32(radius)) ** 2]

    def join(self, points, indices, radius, most):
        joined = set()
        for i in indices:
            for j in self.nearest(points, points[i], radius, most)[1:]:
                if norm(points[i] - points[j]) > 1e-4 and frozenset((i, j)) not in joined:
                    joined.add(frozenset((i, j)))
                    self.springs.append((i, j))

    def roll_out(self):
        x, v, n = self.x.copy(), np.zeros_like(self.x), len(self.x)
        i, j = np.array(self.springs).T
        frames = []
        for start, end in zip(self.controls[:-1], self.controls[1:], strict=True):
            for step in range(SUBSTEPS):
                held = start + (end - start) * (step + 1) / SUBSTEPS
                places = np.concatenate([x, held])
                # Control points count as standing still.
                speeds = np.concatenate([v, np.zeros_like(held)])
                d = places[j] - places[i]
                length = norm(d)
                d /= length[:, None]
                pull = self.stiffness * (length / self.rest - 1)
                pull = pull + self.dashpot * np.sum((speeds[j] - speeds[i]) * d, axis=1)
                force = np.zeros_like(places)
                np.add.at(force, i, pull[:, None] * d)
                np.add.at(force, j, -pull[:, None] * d)
                v = (v + (force[:n] + GRAVITY) * DT_S) * np.exp(-DT_S * self.drag)
                x, v = self.above_ground(x, v)
            frames.append(x)
        return np.array(frames)

    def above_ground(self, x, v):
        down = v[:, 2]
        hits = (x[:, 2] + DT_S * down > 0) & (down > 1e-4)
        along = v * [1, 1, 0]
        speed = np.maximum(norm(along), 1e-6)
        share = np.maximum(0, 1 - self.fric * (1 + self.elas) * np.abs(down) / speed)
        bounced = share[:, None] * along + np.outer(-self.elas * down, [0, 0, 1])
        after = np.where(hits[:, None], bounced, v)
        until = np.where(hits, -x[:, 2] / np.where(hits, down, 1), 0)[:, None]
        return x + until * v + (DT_S - until) * after, after


def agree(client, path, reference):
    twin = client.import_twin(path)
    controls = (reference.controls * TURN).astype("f4")
    returns = {"returns": Returns(every_frames=1)}
    ours = twin.rollout(trajectories=controls[None], **returns).positions[0] * TURN
    theirs = reference.roll_out()
    difference = norm(ours - theirs).max()
    print(f"{1e3 * difference:.4f} mm, {1e3 * norm(theirs[-1] - theirs[0]).max():.0f} mm of travel")
    assert theirs[:, :, 2].max() > -0.001
    return difference


def test_what_the_search_found_moves_as_in_phystwin(client, case, tmp_path):
    (case / "optimal_params.pkl").write_bytes(pickle.dumps(PARAMS))
    out = tmp_path / "search.safetensors"
    done = run("twin", "import", "--phystwin", case, "--search-only", "--out", out)
    assert done.returncode == 0, done.stderr
    reference = Reference(case, drag=4.75, dashpot=60.5)
    assert json.loads(done.stdout)["springs"] == len(reference.springs)
    assert agree(client, out, reference) < TOLERANCE_M


@pytest.mark.parametrize("protocol", [2, 4])
def test_what_training_found_moves_as_in_phystwin(client, case, tmp_path, protocol):
    root = case.parents[2]
    search = root / "experiments_optimization" / case.name / "optimal_params.pkl"
    train = root / "experiments" / case.name / "train" / "best_40.pth"
    for path in (search, train):
        path.parent.mkdir(parents=True, exist_ok=True)
    search.write_bytes(pickle.dumps(PARAMS, protocol=protocol))
    (case / "optimal_params.pkl").unlink(missing_ok=True)
    count = len(Reference(case, 0, 0).springs)
    random = np.random.default_rng(1)
    stiffness = random.uniform(800, 4000, count).astype("f4")
    contact = [np.array([x], "f4") for x in (0.25, 0.75, 0.5, 0.5)]
    keys = ["collide_elas", "collide_fric", "collide_object_elas", "collide_object_fric"]
    objects = Reference(case, 0, 0).object_springs
    content = {"epoch": 40, "num_object_springs": objects, "spring_Y": stiffness}
    content |= dict(zip(keys, contact, strict=True))
    content["optimizer_state_dict"] = {"state": {0: {"step": np.array([9], "f4")}}, "lr": 0.001}
    train.write_bytes(archive(content))
    out = tmp_path / "train.safetensors"
    done = run("twin", "import", "--phystwin", case, "--out", out)
    assert done.returncode == 0, done.stderr
    # Its training cuts drag and dashpots of the search to integers.
    reference = Reference(case, 4, 60, stiffness.astype(float), elas=0.25, fric=0.75)
    assert agree(client, out, reference) < TOLERANCE_M


def test_results_of_other_springs_are_refused(case, tmp_path):
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(PARAMS))
    one = np.array([0.5], "f4")
    keys = ["collide_elas", "collide_fric", "collide_object_elas", "collide_object_fric"]
    content = {"spring_Y": np.ones(7, "f4"), **dict.fromkeys(keys, one)}
    (tmp_path / "a.pth").write_bytes(archive(content))
    files = ("--params", tmp_path / "a.pkl", "--checkpoint", tmp_path / "a.pth")
    done = run("twin", "import", "--phystwin", case, *files, "--out", tmp_path / "a.twin")
    assert json.loads(done.stderr)["error"]["reason"] == "IMPORT_OTHER_SPRINGS"
    # A pickle that would run a command when Python loads it.
    (tmp_path / "a.pkl").write_bytes(b"cos\nsystem\n(S'touch run'\ntR.")
    done = run("twin", "import", "--phystwin", case, *files, "--out", tmp_path / "a.twin")
    assert done.returncode != 0
    assert not (tmp_path / "a.twin").exists()


def archive(content):
    """The file that torch.save writes of numbers, dictionaries and tensors (arrays here)."""
    storages = []

    class Storage:
        def __init__(self, array):
            self.array = array

    class Tensors(pickle.Pickler):
        def persistent_id(self, value):
            if not isinstance(value, Storage):
                return None
            storages.append(value.array)
            kind = sys.modules["torch"].FloatStorage
            return "storage", kind, str(len(storages) - 1), "cuda:0", value.array.size

        def reducer_override(self, value):
            if not isinstance(value, np.ndarray):
                return NotImplemented
            rebuild = sys.modules["torch._utils"]._rebuild_tensor_v2
            hooks = __import__("collections").OrderedDict()
            stride = tuple(s // value.itemsize for s in value.strides)
            return rebuild, (Storage(value), 0, value.shape, stride, False, hooks)

    with names_of_torch():
        program = io.BytesIO()
        Tensors(program, protocol=2).dump(content)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as zipped:
        zipped.writestr("best/data.pkl", program.getvalue())
        zipped.writestr("best/byteorder", "little")
        for key, array in enumerate(storages):
            zipped.writestr(f"best/data/{key}", array.tobytes())
        zipped.writestr("best/version", "3\n")
    return out.getvalue()


@contextmanager
def names_of_torch():
    """Stand-ins for the names in a pickle of tensors: torch itself is not needed for them."""
    modules = {name: types.ModuleType(name) for name in ("torch", "torch._utils")}

    def define(module, name):
        value = type(name, (), {"__module__": module})
        value.__qualname__ = name
        setattr(modules[module], name, value)

    define("torch", "FloatStorage")
    define("torch._utils", "_rebuild_tensor_v2")
    with pytest.MonkeyPatch.context() as patch:
        for name, module in modules.items():
            patch.setitem(sys.modules, name, module)
        yield
