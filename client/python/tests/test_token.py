import pytest
from fake import FIT, serve

from bendtwin import Client
from bendtwin.connection.token import find_token


@pytest.fixture
def tokens(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.delenv("BENDTWIN_TOKEN", raising=False)
    monkeypatch.delenv("BENDTWIN_TOKEN_FILE", raising=False)
    folder = tmp_path / "bendtwin" / "tokens"
    folder.mkdir(parents=True)
    return folder


def test_the_token_of_a_server_on_this_machine_is_found_by_its_port(tokens):
    (tokens / "7070").write_text("secret\n")
    for target in ("127.0.0.1:7070", "localhost:7070", "LOCALHOST:7070", "[::1]:7070"):
        assert find_token(target) == "secret", target
    for target in ("127.0.0.1:7071", "10.0.0.1:7070", "twin.example:7070", "7070", ":x", ""):
        assert find_token(target) is None, target


def test_the_environment_wins(tokens, monkeypatch):
    (tokens / "7070").write_text("secret\n")
    monkeypatch.setenv("BENDTWIN_TOKEN", "given")
    assert find_token("127.0.0.1:7070") == "given"
    assert find_token("twin.example:7070") == "given"


def test_a_sign_in_is_found_by_scheme_host_and_port(tokens):
    (tokens / "7070").write_text("secret\n")
    folder = tokens.parent / "sign-ins"
    folder.mkdir()
    for name in ("https_twin.example_443", "http_127.0.0.1_7070", "http___1_7070"):
        (folder / name).write_text(f"of {name}\n")
        (folder / name).chmod(0o600)
    assert find_token("Twin.Example:443", True) == "of https_twin.example_443"
    assert find_token("twin.example:443", False) is None
    assert find_token("twin.example:8443", True) is None
    assert find_token("127.0.0.1:7070") == "of http_127.0.0.1_7070"
    assert find_token("[::1]:7070") == "of http___1_7070"
    assert find_token("localhost:7070") == "secret"
    (folder / "http_127.0.0.1_7070").chmod(0o644)
    with pytest.raises(PermissionError, match="chmod 600"):
        find_token("127.0.0.1:7070")


def test_every_kind_of_call_shows_the_token(fake, tokens, tmp_path):
    server, address = serve(fake)
    (tokens / address.rpartition(":")[2]).write_text("secret\n")
    archive = tmp_path / "rope.zip"
    archive.write_bytes(b"content")
    with Client(address) as client:
        client.upload_capture(archive)
        client.get_fit(FIT)
        client.wait(FIT, timeout_s=30)
    with Client(address, token="other") as client:
        next(client.captures())
    server.stop(None)
    methods = {method for method, _ in fake.shown}
    assert {"CreateCapture", "GetFit", "WatchFit", "ListCaptures"} <= methods
    for method, shown in fake.shown:
        assert shown == ("Bearer other" if method == "ListCaptures" else "Bearer secret"), method


def test_without_a_token_none_is_sent(fake, tokens):
    server, address = serve(fake)
    with Client(address) as client:
        client.get_fit(FIT)
    server.stop(None)
    assert [shown for _, shown in fake.shown] == [None]


def test_a_file_has_the_key_unless_others_can_read_it(fake, tokens, tmp_path, monkeypatch):
    key = tmp_path / "robot.key"
    key.write_text("bt_1_2\n")
    key.chmod(0o600)
    server, address = serve(fake)
    with Client(address, token_file=key) as client:
        client.get_fit(FIT)
    monkeypatch.setenv("BENDTWIN_TOKEN_FILE", str(key))
    with Client(address) as client:
        client.get_fit(FIT)
    server.stop(None)
    assert [shown for _, shown in fake.shown] == ["Bearer bt_1_2"] * 2
    for mode in (0o644, 0o640, 0o604):
        key.chmod(mode)
        with pytest.raises(PermissionError, match="chmod 600") as refused:
            Client(address, token_file=key)
        assert "bt_1_2" not in str(refused.value)
    empty = tmp_path / "empty"
    empty.touch(0o600)
    with pytest.raises(ValueError, match="no token or key"):
        Client(address, token_file=empty)
