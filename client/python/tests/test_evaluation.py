"""Evaluations of twins."""

from bendtwin import calls
from bendtwin.v1 import evaluation_pb2


def test_a_twin_is_scored_on_a_capture() -> None:
    call = calls.evaluate_twin("twins/t", "captures/c")
    assert (call.request.twin, call.request.capture) == ("twins/t", "captures/c")
    reply = evaluation_pb2.Evaluation(quality_json='{"scores": [], "recordings": [{"name": "a"}]}')
    assert call.read(reply) == {"scores": [], "recordings": [{"name": "a"}]}
