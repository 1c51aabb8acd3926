"""Dask: the same bytes without it, with one worker and with two, and when a worker is killed."""

import os
import signal
import tempfile

import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.large.cluster import local_client, remote_client

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings(
    "ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)

OPTIONS = {"target_count": 300, "n_tiles": 3, "method": "lp_uniform", "n_clusters": 3, "n_rounds": 2}


@pytest.fixture(scope="module")
def alone(files, tmp_path_factory):
    """What this process makes without Dask."""
    path = tmp_path_factory.mktemp("alone") / "thin.npy"
    lpcompare.simplify_files(files[".npy"], path, **OPTIONS)
    return path.read_bytes()


def test_neither_workers_nor_their_deaths_change_a_byte_or_leave_one(files, tmp_path, alone, monkeypatch):
    done = []
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))

    def kill(stage, n_done, _):
        """End one worker in the middle of a stage."""
        if stage == "swaps" and not done:
            done.append(next(iter(client.run(os.getpid).values())))
            os.kill(done[0], signal.SIGKILL)

    with local_client(2) as client:
        lpcompare.simplify_files(files[".npy"], tmp_path / "two.npy", client=client, **OPTIONS)
        lpcompare.simplify_files(
            files[".npy"], tmp_path / "killed.npy", client=client, callback=kill, **OPTIONS
        )
        client.cluster.scale(1)
        lpcompare.simplify_files(files[".npy"], tmp_path / "one.npy", client=client, **OPTIONS)
    assert done
    for name in ("two", "killed", "one"):
        assert (tmp_path / f"{name}.npy").read_bytes() == alone
    assert not list((tmp_path / "temporary").iterdir())


def test_a_scheduler_that_does_not_answer_is_said():
    with (
        pytest.raises(InputError, match=r"tcp://127.0.0.1:9 does not answer"),
        remote_client("tcp://127.0.0.1:9", timeout="1s"),
    ):
        pass
