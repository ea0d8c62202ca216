"""Resumable uploads against the real `bendtwin`, named by BENDTWIN_BIN: ours and tuspy's."""

import asyncio
import hashlib
import os
import random
import subprocess
import time
import urllib.request
import zipfile

import pytest
import requests
from tusclient.client import TusClient
from tusclient.exceptions import TusCommunicationError, TusUploadFailed

from bendtwin import BendTwinError, Category, Client, aio
from bendtwin.captures import uploads

BINARY = os.environ.get("BENDTWIN_BIN")
START_S = 60
TUS = {"Tus-Resumable": "1.0.0"}

pytestmark = pytest.mark.skipif(not BINARY, reason="BENDTWIN_BIN names no binary")


class Server:
    """A server without workers that can be killed and started again at the same address."""

    def __init__(self, folder):
        self.folder, self.port, self.process = folder, 0, None
        self.start()

    def start(self):
        port_file = self.folder / "port"
        port_file.unlink(missing_ok=True)
        command = [BINARY, "server", "--listen", f"127.0.0.1:{self.port}", "--workers", "0"]
        # tuspy and plain requests show none.
        command += ["--client-token", "none"]
        command += ["--port-file", port_file, "--data-dir", self.folder / "data"]
        with (self.folder / "log").open("a") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log)
        deadline = time.monotonic() + START_S
        while not port_file.exists() or not port_file.read_text().strip():
            assert self.process.poll() is None, (self.folder / "log").read_text()
            assert time.monotonic() < deadline, "the server does not start"
            time.sleep(0.02)
        self.port = int(port_file.read_text())

    def kill(self):
        self.process.kill()
        self.process.wait()

    @property
    def address(self):
        return f"127.0.0.1:{self.port}"

    @property
    def uploads(self):
        return f"http://{self.address}/v1/uploads"

    def content(self, capture):
        url = f"http://{self.address}/v1/{capture}/content"
        with urllib.request.urlopen(url) as response:
            return response.read()


@pytest.fixture
def server(tmp_path):
    server = Server(tmp_path)
    yield server
    server.kill()


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "rope.zip"
    path.write_bytes(random.Random(7).randbytes(3_000_000))
    return path


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(uploads, "PART_BYTES", 1_000_000)


def capture_of(url):
    return requests.head(url, headers=TUS).headers["Bendtwin-Capture"]


def test_the_official_client_uploads_with_checksums_and_resumes(server, archive):
    client = TusClient(server.uploads)
    metadata = {"filename": "rope.zip", "display_name": "a röpe", "mine": "7"}
    first = client.uploader(
        str(archive), chunk_size=700_000, metadata=metadata, upload_checksum=True
    )
    first.upload(stop_at=1_400_000)
    url = first.url
    assert first.offset == 1_400_000

    # Both sides forget everything but the URL.
    server.kill()
    server.start()
    second = client.uploader(str(archive), url=url, chunk_size=700_000, upload_checksum=True)
    assert second.offset == 1_400_000
    second.upload()
    assert server.content(capture_of(url)) == archive.read_bytes()
    with Client(server.address) as ours:
        assert [c.display_name for c in ours.captures()] == ["a röpe"]
    said = requests.head(url, headers=TUS).headers
    assert said["Upload-Offset"] == said["Upload-Length"] == "3000000"
    assert "mine" in said["Upload-Metadata"]


def test_the_official_client_survives_a_kill_in_the_middle(server, archive):
    client = TusClient(server.uploads)
    uploader = client.uploader(str(archive), chunk_size=500_000, retries=20, retry_delay=0.1)
    uploader.upload_chunk()
    server.kill()
    server.start()
    uploader.upload()
    assert server.content(capture_of(uploader.url)) == archive.read_bytes()


def test_the_official_client_hears_of_wrong_checksums_and_of_termination(server, archive):
    client = TusClient(server.uploads)
    uploader = client.uploader(str(archive), chunk_size=100_000, upload_checksum=True)
    wrong = ("sha1", lambda chunk: hashlib.sha1(chunk + b"damaged"))
    uploader._BaseUploader__checksum_algorithm = wrong[1]
    with pytest.raises(TusUploadFailed) as refused:
        uploader.upload_chunk()
    assert refused.value.status_code == 460
    assert uploader.get_offset() == 0
    uploader._BaseUploader__checksum_algorithm = hashlib.sha1
    uploader.upload_chunk()
    assert uploader.get_offset() == 100_000
    # tuspy has no call for it.
    assert requests.delete(uploader.url, headers=TUS).status_code == 204
    with pytest.raises(TusUploadFailed) as gone:
        uploader.upload_chunk()
    assert gone.value.status_code == 410
    with pytest.raises(TusCommunicationError):
        uploader.get_offset()


def test_a_push_goes_on_over_kills_of_the_server(server, archive, small_parts):
    seen = []

    def progress(there, of):
        seen.append(there)
        if there == 1_000_000 and seen.count(there) == 1:
            server.kill()
            server.start()

    with Client(server.address) as client:
        capture = client.push_capture(archive, on_progress=progress)
        assert capture.size_bytes == 3_000_000
        assert capture.display_name == "rope"
        assert server.content(capture.name) == archive.read_bytes()
        assert seen[-1] == 3_000_000
        assert seen == sorted(seen), "what was acknowledged stayed"
        # It is there: nothing is sent.
        seen.clear()
        assert client.push_capture(archive, on_progress=progress) == capture
        assert seen == [3_000_000]
        # The default name is no other fact than the same one stated.
        seen.clear()
        assert client.push_capture(archive, display_name="rope", on_progress=progress) == capture
        assert seen == [3_000_000]


def test_a_push_resumes_whatever_the_order_of_its_facts(server, archive, small_parts):
    seen = []

    def end_early(there, of):
        if there >= 2_000_000:
            raise KeyboardInterrupt

    with Client(server.address) as client:
        with pytest.raises(KeyboardInterrupt):
            client.push_capture(
                archive, recorded_by="Ada", display_name="toy", on_progress=end_early
            )
        capture = client.push_capture(
            archive,
            display_name="toy",
            recorded_by="Ada",
            on_progress=lambda there, of: seen.append(there),
        )
    assert seen[0] == 2_000_000
    assert capture.display_name == "toy"


def test_the_client_of_asyncio_pushes_while_other_tasks_run(server, tmp_path):
    folder = tmp_path / "rope"
    folder.mkdir()
    (folder / "depth.npy").write_bytes(random.Random(1).randbytes(300_000))
    seen = []

    async def main():
        async with aio.Client(server.address) as client:
            loop = asyncio.get_running_loop()
            # Were the loop blocked, what is asked of it from the thread of the push had no answer.
            answer = asyncio.run_coroutine_threadsafe

            def progress(there, of):
                seen.append((there, answer(asyncio.sleep(0, "free"), loop).result(START_S)))

            pushed = await client.push_capture(folder, on_progress=progress)
            uploaded = await client.upload_capture(folder, request_id="other")
            return pushed, uploaded

    pushed, uploaded = asyncio.run(main())
    assert pushed.display_name == uploaded.display_name == "rope"
    assert seen[-1] == (pushed.size_bytes, "free")
    assert pushed.digest == uploaded.digest


def test_a_push_goes_on_where_its_process_ended(server, tmp_path, small_parts):
    folder = tmp_path / "rope"
    (folder / "color").mkdir(parents=True)
    (folder / "color" / "0.png").write_bytes(random.Random(1).randbytes(2_500_000))
    (folder / "depth.npy").write_bytes(b"depth" * 1000)
    (folder / ".hidden").write_text("x")
    (folder / "link").symlink_to(folder / "depth.npy")
    seen = []

    def end_early(there, of):
        if there >= 2_000_000:
            raise KeyboardInterrupt

    with Client(server.address) as client:
        with pytest.raises(KeyboardInterrupt):
            client.push_capture(folder, on_progress=end_early)
        capture = client.push_capture(folder, on_progress=lambda there, of: seen.append(there))
    assert seen[0] == 2_000_000
    assert capture.display_name == "rope"
    path = tmp_path / "got.zip"
    path.write_bytes(server.content(capture.name))
    with zipfile.ZipFile(path) as got:
        assert got.namelist() == ["color/0.png", "depth.npy"]
        stored, deflated = (entry.compress_type for entry in got.infolist())
    assert (stored, deflated) == (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def test_what_a_push_cannot_mend_is_an_error(server, archive, tmp_path):
    with Client(server.address) as client:
        client.push_capture(archive, request_id="key")
        archive.write_bytes(b"another content")
        with pytest.raises(BendTwinError) as refused:
            client.push_capture(archive, request_id="key")
    assert refused.value.category is Category.ALREADY_EXISTS
    assert refused.value.reason == "REQUEST_ID_TAKEN"
    nobody = uploads.Sender("127.0.0.1:1", archive, {"display_name": "rope"}, patience_s=0.1)
    with pytest.raises(BendTwinError) as unreachable:
        nobody.send()
    assert unreachable.value.category is Category.UNAVAILABLE


def test_files_are_added_later_and_survive_the_death_of_the_server(server, archive, tmp_path):
    mask = tmp_path / "case" / "mask" / "0" / "object"
    mask.mkdir(parents=True)
    (mask / "0.png").write_bytes(b"png")
    with Client(server.address) as client:
        capture = client.push_capture(archive).name
        with pytest.raises(BendTwinError, match="under way") as early:
            client.add_masks(capture, tmp_path / "case")
        assert early.value.reason == "INGEST_UNDER_WAY"
        client.cancel_ingest(capture)
        client.add_masks(capture, tmp_path / "case")
        with pytest.raises(BendTwinError, match="capture calibrate"):
            client.add_calibration(capture, b"cam0: {}")
        client.add_calibration(
            capture, {"format": "bendtwin-calibration", "version": 1, "cameras": []}
        )
    server.kill()
    server.start()
    with Client(server.address) as client:
        assert [s.kind for s in client.capture(capture).supplements] == ["masks", "calibration"]
        client.download_supplement(capture, "masks", tmp_path / "masks.zip")
        with zipfile.ZipFile(tmp_path / "masks.zip") as packed:
            assert packed.namelist() == ["mask/0/object/0.png"]
        client.delete_supplement(capture, "masks")
        assert [s.kind for s in client.capture(capture).supplements] == ["calibration"]
        with pytest.raises(BendTwinError) as missing:
            client.download_masks(capture, tmp_path / "none.zip")
        assert missing.value.reason == "CAPTURE_HAS_NO_MASKS"
