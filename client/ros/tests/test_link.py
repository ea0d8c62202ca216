"""What the node does when server, twin, session or rights are missing."""

from __future__ import annotations

import socket

import numpy as np
import pytest
from server import needs_server

from bendtwin import BendTwinError, Category
from bendtwin_ros.link import Link, Trouble, Unavailable, trouble_of
from bendtwin_ros.logic import TwinNode
from bendtwin_ros.messages.own import PlanGoal, RegisterRequest
from bendtwin_ros.status import Status
from made_ros import Cable, cable_file, cloud_at


class Clock:
    """Seconds that pass when a test says so."""

    now = 0.0

    def __call__(self):
        return self.now


def failing(category, reason="SOMETHING"):
    def call():
        raise BendTwinError(category, reason, "it failed")

    return call


@pytest.fixture
def link():
    from made_ros import settings

    link = Link(settings(twin="rope"), Status(), Clock())
    link.clock = link._clock
    return link


@pytest.mark.parametrize(
    ("category", "reason", "trouble"),
    [
        (Category.UNAVAILABLE, "NO_WORKER", Trouble.TRANSIENT),
        (Category.DEADLINE_EXCEEDED, "DEADLINE_EXCEEDED", Trouble.TRANSIENT),
        (Category.ABORTED, "SESSION_LOST", Trouble.SESSION),
        (Category.NOT_FOUND, "TWIN_NOT_FOUND", Trouble.PERSON),
        (Category.UNAUTHENTICATED, "KEY_EXPIRED", Trouble.PERSON),
        (Category.PERMISSION_DENIED, "SCOPE_MISSING", Trouble.PERSON),
        (Category.FAILED_PRECONDITION, "OBSERVATION_NOT_EXPLAINED", Trouble.REQUEST),
    ],
)
def test_an_error_means_to_wait_to_reopen_or_to_call_somebody(category, reason, trouble):
    assert trouble_of(BendTwinError(category, reason, "")) is trouble


def test_pauses_grow_until_a_call_succeeds(link):
    pauses = []
    for _ in range(8):
        with pytest.raises(Unavailable, match="it failed"):
            link.run(failing(Category.UNAVAILABLE))
        began = link.clock.now
        while True:
            link.clock.now += 0.05
            try:
                assert link.run(lambda: "reply") == "reply"
            except Unavailable:
                continue
            break
        pauses.append(link.clock.now - began)
        # The next failure counts as one in a row.
        link._pause_s = 0.25 * 2 ** len(pauses)
    assert pauses == sorted(pauses)
    assert pauses[0] == pytest.approx(0.25, abs=0.06)
    assert pauses[-1] == pytest.approx(10.0, rel=5.0)
    assert link._status.down == ""


def test_a_refused_request_is_no_outage(link):
    with pytest.raises(BendTwinError):
        link.run(failing(Category.INVALID_ARGUMENT))
    assert link.run(lambda: 1) == 1
    assert not link._status.counts


def test_what_only_a_person_can_change_is_an_error_in_diagnostics(link):
    with pytest.raises(Unavailable):
        link.run(failing(Category.UNAUTHENTICATED, "KEY_EXPIRED"))
    assert link._status.needs_person
    link.clock.now += 10.0
    with pytest.raises(Unavailable):
        link.run(lambda: 1)
    link.clock.now += 10.0
    assert link.run(lambda: 1) == 1
    assert not link._status.needs_person


@pytest.fixture
def cable(server):
    return Cable(server.cable)


def node_of(cable, address, clock=None, **given):
    settings = cable.settings(address, **given)
    return TwinNode(settings, cable.frames(), lambda *_: None, clock or Clock())


def arrive(node, cable, motion, number):
    skins, _, stamps = motion
    node.on_cloud(cloud_at(skins[number], stamps[number]), stamps[number])


@needs_server
def test_a_lost_session_is_opened_again_where_it_was(server, cable):
    motion = cable.motion(8)
    node = node_of(cable, server.address)
    for number in range(4):
        arrive(node, cable, motion, number)
    node._link.session()[0].close()
    arrive(node, cable, motion, 4)
    assert node.status.counts["call failed: SESSION_LOST"] == 1
    for number in range(5, 9):
        arrive(node, cable, motion, number)
    assert node.status.counts["session opened again"] == 1
    away = np.linalg.norm(node.estimate.state.positions - motion[1][-1], axis=1)
    assert away.mean() < 0.01
    assert node.status.down == ""
    node.close()


@needs_server
def test_after_an_advance_with_an_unknown_effect_the_twin_is_where_it_was_last_seen(server, cable):
    clock, motion = Clock(), cable.motion(8)
    node = node_of(cable, server.address, clock)
    for number in range(4):
        arrive(node, cable, motion, number)
    node._tracker._timeout_s = 1e-6
    arrive(node, cable, motion, 4)
    assert node.status.counts["call failed: DEADLINE_EXCEEDED"] == 1
    node._tracker._timeout_s = 5.0
    arrive(node, cable, motion, 5)
    assert node.status.counts["server not available"] == 2
    clock.now += 1.0
    for number in range(6, 9):
        arrive(node, cable, motion, number)
    assert node.status.counts["session opened again"] == 1
    assert node.estimate.at_ns == motion[2][-1]
    away = np.linalg.norm(node.estimate.state.positions - motion[1][-1], axis=1)
    assert away.mean() < 0.01
    node.close()


@needs_server
def test_a_deleted_twin_is_told_and_followed_again_once_it_is_back(server, cable, tmp_path):
    (tmp_path / "other.twin").write_bytes(cable_file().encode())
    twin = server.client.import_twin(tmp_path / "other.twin")
    clock, motion = Clock(), cable.motion(4)
    node = node_of(cable, server.address, clock, twin=twin.name)
    arrive(node, cable, motion, 0)
    assert node.estimate is not None
    server.client.delete_twin(twin.name)
    node.close()
    node = node_of(cable, server.address, clock, twin=twin.name)
    arrive(node, cable, motion, 1)
    assert node.status.needs_person
    assert "twin" in node.status.down
    assert node.register(RegisterRequest(), 0).success is False
    server.client.restore_twin(twin.name)
    clock.now += 20.0
    arrive(node, cable, motion, 2)
    assert node.status.down == ""
    assert node.status.follows
    node.close()


@needs_server
def test_a_twin_is_found_by_its_display_name(server, cable):
    server.client.update_twin(cable.twin.name, display_name="my cable")
    node = node_of(cable, server.address, twin="my cable")
    arrive(node, cable, cable.motion(1), 0)
    assert node.status.follows
    node.close()
    node = node_of(cable, server.address, twin="no such cable")
    arrive(node, cable, cable.motion(1), 0)
    assert "name one twin" in node.status.down
    node.close()


@needs_server
def test_a_wrong_token_and_a_missing_file_of_it_are_told(server, cable, tmp_path):
    (tmp_path / "token").write_text("wrong")
    (tmp_path / "token").chmod(0o600)
    for file in ("token", "missing"):
        node = node_of(cable, server.address, server__token_file=str(tmp_path / file))
        arrive(node, cable, cable.motion(1), 0)
        assert node.status.needs_person, file
        assert node.status.down
        node.close()


def test_a_server_that_does_not_answer_is_waited_for_with_a_deadline(monkeypatch):
    from made_ros import settings

    monkeypatch.setattr("bendtwin_ros.link._CALL_S", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        link = Link(settings(twin="twins/x", server__address=address), Status(), Clock())
        with pytest.raises(Unavailable):
            link.twin()
    assert link._status.counts["call failed: DEADLINE_EXCEEDED"] == 1
    assert not link._status.needs_person
    link.close()


@needs_server
def test_without_a_server_clouds_are_dropped_until_it_is_there(cable, server):
    clock, motion = Clock(), cable.motion(3)
    # A port that nothing listens on.
    node = node_of(cable, "127.0.0.1:9", clock)
    arrive(node, cable, motion, 0)
    arrive(node, cable, motion, 1)
    assert node.status.counts["server not available"] == 2
    assert not node.status.needs_person
    result = node.plan(PlanGoal(), lambda: False, lambda _: None)
    assert result.reason == "NOT_READY"
    assert not node.reset().success or node.estimate is None
    node.close()
