"""The HTTP form of a real server: its description, and the examples of docs/formats/http-api.md."""

import json
import re
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from server import make_rope, needs_server, running

from bendtwin import Client

PAGE = Path(__file__).parents[3] / "docs" / "formats" / "http-api.md"
SETTINGS = {
    "graph": {"max_nodes": 30},
    "search": {"generations": 2, "population": 4},
    "refine": {"passes": 1},
}

pytestmark = needs_server


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """Address and folder of a server."""
    folder = tmp_path_factory.mktemp("http")
    with running(folder) as address:
        yield address, folder


def call(server, path, body=None):
    """The JSON that a server answers with."""
    address, folder = server
    token = (folder / "data" / "client-token").read_text().strip()
    headers = {"authorization": f"Bearer {token}", "content-type": "application/json"}
    request = urllib.request.Request(f"http://{address}{path}", body, headers)
    with urllib.request.urlopen(request) as reply:
        return json.load(reply)


def test_the_description_is_valid_openapi(server):
    validator = pytest.importorskip("openapi_spec_validator")
    validator.validate(call(server, "/openapi.json"))


def test_generators_of_clients_know_every_array(server):
    """openapi-python-client drops what uses an array without `items`: rollouts, plans, sessions."""

    def arrays(value):
        if isinstance(value, dict):
            if value.get("type") == "array" or "array" in (value.get("type") or []):
                yield value
            for inner in value.values():
                yield from arrays(inner)
        elif isinstance(value, list):
            for inner in value:
                yield from arrays(inner)

    document = call(server, "/openapi.json")
    found = list(arrays(document))
    assert len(found) > 50
    assert all("items" in array for array in found)


@pytest.mark.skipif(not PAGE.is_file(), reason="no docs folder beside the package")
def test_the_examples_of_the_page_are_answered_by_a_twin_whose_controls_pin_nothing(server):
    address, folder = server
    make_rope(folder / "rope.zip")
    with Client(address) as client:
        capture = client.wait_for_capture(client.upload_capture(folder / "rope.zip"))
        twin = client.twin(client.wait(client.fit(capture.name, SETTINGS), timeout_s=120).twin)
        geometry = twin.geometry()
    assert len(geometry.controls) > 1
    assert len(geometry.pins) == 0
    examples = re.findall(r"/rollouts [^']*-d '(\{.*?\})'\n```", PAGE.read_text(), re.DOTALL)
    assert len(examples) == 2
    for example in examples:
        asked = json.loads(example)
        reply = call(server, f"/v1/{twin.name}/rollouts", example.encode())
        assert len(reply["costs"]) == len(asked["poses"]["poses"])
        assert set(reply["timing"]) == {"queue_s", "compute_s"}
        assert ("forces" in reply) == asked["returns"].get("forces", False)
    opening, advance = (
        re.search(rf"/{call} [^']*-d '(\{{.*?\}})'", PAGE.read_text(), re.DOTALL)
        for call in ("v1/sessions", "advance")
    )
    asked = {**json.loads(opening[1]), "twin": twin.name}
    session = call(server, "/v1/sessions", json.dumps(asked).encode())
    assert session["frames"] == [0] * asked["slots"]
    reply = call(server, f"/v1/{session['name']}/advance", advance[1].encode())
    assert np.shape(reply["final_positions"]) == (1, len(geometry.kinds), 3)
    assert call(server, f"/v1/{session['name']}")["frames"] == [3, 0, 0, 0]
    step = re.search(r"/step [^']*-d '(\{.*?\})'", PAGE.read_text(), re.DOTALL)
    reply = call(server, f"/v1/{session['name']}/step", step[1].encode())
    assert reply["plan"]["last"]
    assert np.shape(reply["state"]["positions"]) == (len(geometry.kinds), 3)
    assert np.shape(reply["advanced"]["controls"])[1] == 4
    assert ("refused" in reply) != ("corrected" in reply)
    assert call(server, f"/v1/{session['name']}")["frames"] == [6, 0, 0, 0]
