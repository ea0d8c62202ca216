"""Uploads through a proxy that passes a path on as another one."""

import threading
import zipfile
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from bendtwin import BendTwinError
from bendtwin.captures import uploads
from bendtwin.captures.archive import archive_of, masks_of

CAPTURE = "captures/0190a000-0000-7000-8000-000000000001"


class Proxy(BaseHTTPRequestHandler):
    """A server that is reached below /bendtwin, and does not know it."""

    def do_POST(self):
        self.server.created += 1
        self.answer(201, {"location": "/v1/uploads/a", "upload-offset": "0"})

    def do_PATCH(self):
        self.rfile.read(int(self.headers["content-length"]))
        if self.path != "/bendtwin/v1/uploads/a" or not self.server.passes_on:
            return self.answer(404, {})
        self.answer(204, {"upload-offset": "10", "bendtwin-capture": CAPTURE})

    def answer(self, status, headers):
        self.send_response(status)
        for name, value in {"content-length": "0", **headers}.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, *_):
        pass


@pytest.fixture
def proxy():
    server = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
    server.created, server.passes_on = 0, True
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()


def send(server, tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(b"0123456789")
    url = f"http://127.0.0.1:{server.server_port}/bendtwin"
    return uploads.Sender(url, path, {}).send()


def test_an_upload_lies_below_the_address_of_the_server(proxy, tmp_path):
    assert send(proxy, tmp_path) == CAPTURE
    assert proxy.created == 1


def test_an_upload_that_is_never_found_is_not_begun_without_end(proxy, tmp_path):
    proxy.passes_on = False
    with pytest.raises(BendTwinError, match="proxy in front of it") as error:
        send(proxy, tmp_path)
    assert error.value.reason == "UPLOAD_LOST"
    assert proxy.created == uploads.MOST_GONE + 1


@pytest.mark.parametrize("location", ["", "/v1/uploads/", "/v1/uploads/a/b", "/v1/captures/a"])
def test_other_addresses_are_refused(location):
    with pytest.raises(BendTwinError):
        uploads._address("http://lab", location)


def test_links_are_left_out_and_named(tmp_path):
    folder = tmp_path / "toy"
    folder.mkdir()
    (folder / "metadata.json").write_text("{}")
    (tmp_path / "secret").write_text("x")
    (folder / "color.png").symlink_to(tmp_path / "secret")
    (tmp_path / "private").mkdir()
    (tmp_path / "private" / "key.png").write_text("x")
    (folder / "depth").symlink_to(tmp_path / "private")
    with (
        pytest.warns(UserWarning, match=r"2 links .* \(color.png\)"),
        archive_of(folder) as packed,
        zipfile.ZipFile(packed) as archive,
    ):
        assert archive.namelist() == ["metadata.json"]


def test_masks_behind_a_link_out_of_the_folder_are_refused(tmp_path):
    folder = tmp_path / "toy"
    private = tmp_path / "private"
    for made in (folder, private, folder / "made"):
        made.mkdir()
    (private / "key").write_text("secret")
    (folder / "made" / "0.png").write_text("png")
    (folder / "mask").symlink_to(private)
    with pytest.raises(ValueError, match="leads out of"), masks_of(folder):
        pass
    (folder / "mask").unlink()
    (folder / "mask").symlink_to(folder / "made")
    with masks_of(folder) as packed, zipfile.ZipFile(packed) as archive:
        assert archive.namelist() == ["mask/0.png"]
