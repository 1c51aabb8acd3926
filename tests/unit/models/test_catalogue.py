"""Models by name: the embedded one, generated ones, downloads from a server on 127.0.0.1."""

import gc
import hashlib
import re
import threading
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from lpcompare.errors import InputError, ModelDataError, UnknownName
from lpcompare.models import load_model, model_names, model_summary
from lpcompare.models.catalogue import catalogue, points_of

DOWNLOADED = sorted(name for name, model in catalogue().items() if model.url and model.sha256)


class Server(SimpleHTTPRequestHandler):
    """Whole files of a folder; /short/ ends after half of the promised bytes, /wrong/ changes one."""

    def log_message(self, *_):
        pass

    def do_GET(self):
        kind, _, name = self.path.lstrip("/").partition("/")
        if not kind:
            return self.send_error(404)
        path = self.directory / name
        if not path.is_file():
            return self.send_error(404)
        content = path.read_bytes()
        self.send_response(200)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        body = {"short": content[: len(content) // 2], "wrong": b"#" + content[1:]}.get(kind, content)
        self.wfile.write(body)
        self.close_connection = True
        return None


@pytest.fixture
def serve():
    """Serve a folder; returns the address."""
    servers = []

    def start(folder):
        handler = type("Handler", (Server,), {})
        server = ThreadingHTTPServer(("127.0.0.1", 0), partial(handler, directory=folder))
        handler.__init__ = lambda self, *a, directory, **k: (
            setattr(self, "directory", directory),
            super(SimpleHTTPRequestHandler, self).__init__(*a),
        )[-1]
        threading.Thread(target=server.serve_forever, daemon=True).start()
        servers.append(server)
        return f"http://127.0.0.1:{server.server_port}"

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


@pytest.fixture
def small(tmp_path):
    """A catalogue entry of a file of three points, and its folder."""
    folder = tmp_path / "upstream"
    folder.mkdir()
    content = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + b"# filler\n" * 5000
    (folder / "small.obj").write_bytes(content)
    blob = hashlib.sha1(f"blob {len(content)}\0".encode() + content).hexdigest()
    model = replace(catalogue()["fandisk"], sha256=hashlib.sha256(content).hexdigest(), points=3)
    return folder, model, replace(model, sha256="", git_blob=blob)


def at(model, address, kind, name="small.obj"):
    return replace(model, url=f"{address}/{kind}/{name}")


def test_every_entry_says_where_it_comes_from_and_how_it_is_checked():
    for name, model in catalogue().items():
        assert sum(map(bool, (model.embedded, model.url, model.made_by))) == 1, name
        assert bool(model.made_by) != bool(model.sha256 or model.git_blob), name
        assert model.title, name
        assert model.licence, name
        assert model.cite, name
        assert re.fullmatch(r"[^\n]+\.", model_summary(name))


@pytest.mark.parametrize("name", [n for n, m in catalogue().items() if not m.url])
def test_models_that_need_no_network_have_the_points_they_promise(name, monkeypatch):
    monkeypatch.setattr("socket.socket.connect", lambda *_: pytest.fail("went to the network"))
    first, second = load_model(name), load_model(name)
    assert len(first) == catalogue()[name].points
    assert first.name == name
    assert np.array_equal(first.points, second.points)
    assert first.points.dtype == np.float64
    assert first.faces is not None
    assert first.faces.max() < len(first)


@pytest.mark.shared
@pytest.mark.parametrize("name", DOWNLOADED)
def test_downloaded_models_match_checksum_and_count_and_then_come_from_the_cache(
    name, shared_models, serve, tmp_path
):
    model = catalogue()[name]
    address = serve(shared_models / "upstream")
    here = at(model, address, "whole", model.url.rpartition("/")[2])
    cloud = points_of(name, here, tmp_path)
    assert len(cloud) == model.points
    gone = replace(here, url=here.url.replace(address, "http://127.0.0.1:9"))
    assert np.array_equal(points_of(name, gone, tmp_path).points, cloud.points)


@pytest.mark.shared
def test_folder_of_the_environment_stands_in_for_the_network(shared_models, monkeypatch):
    monkeypatch.setenv("LPCOMPARE_MODELS", str(shared_models / "upstream"))
    bunny = load_model("stanford-bunny")
    assert bunny.faces is not None
    assert len(bunny) - len(np.unique(bunny.faces)) == 1113, "points without a face are kept"


def test_git_blob_id_is_a_checksum_too(small, serve, tmp_path):
    folder, _, by_blob = small
    assert len(points_of("small", at(by_blob, serve(folder), "whole"), tmp_path / "cache")) == 3


# pooch leaves an interrupted response to the garbage collector, which warns of its socket
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("kind", ["short", "wrong", "absent"])
@pytest.mark.parametrize("checksum", ["sha256", "git_blob"])
def test_a_bad_download_is_one_sentence_and_leaves_nothing(kind, checksum, small, serve, tmp_path):
    folder, by_hash, by_blob = small
    model = at(by_hash if checksum == "sha256" else by_blob, serve(folder), kind)
    if kind == "absent":
        model = replace(model, url=model.url.replace("small", "nosuch"))
    with pytest.raises(ModelDataError, match=r"127\.0\.0\.1") as caught:
        points_of("small", model, tmp_path / "cache")
    assert "\n" not in str(caught.value)
    assert list((tmp_path / "cache").iterdir()) == []
    del caught
    gc.collect()


def test_no_network_is_one_sentence(small, tmp_path):
    with pytest.raises(ModelDataError, match="check the network, or set LPCOMPARE_MODELS"):
        points_of("small", at(small[1], "http://127.0.0.1:9", "whole"), tmp_path / "cache")
    assert list((tmp_path / "cache").iterdir()) == []


def test_a_spoilt_cache_is_fetched_again(small, serve, tmp_path):
    folder, model, _ = small
    (tmp_path / "small.obj").write_bytes(b"v 9 9 9\n")
    assert len(points_of("small", at(model, serve(folder), "whole"), tmp_path)) == 3


def test_the_folder_of_the_environment_is_checked_too(small, tmp_path, monkeypatch):
    monkeypatch.setenv("LPCOMPARE_MODELS", str(tmp_path))
    with pytest.raises(ModelDataError, match="does not exist"):
        load_model("fandisk")
    (tmp_path / "fandisk.obj").write_bytes(b"v 0 0 0\n")
    with pytest.raises(ModelDataError, match="not the file that the catalogue describes"):
        load_model("fandisk")


def test_unknown_names_and_missing_files_are_told_apart(tmp_path):
    with pytest.raises(UnknownName, match="Did you mean 'bunny'"):
        load_model("buny")
    with pytest.raises(InputError, match="No such file"):
        load_model(str(tmp_path / "nosuch.ply"))
    assert "bunny" in model_names()
