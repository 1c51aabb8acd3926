"""Dask: the same bytes without it, with one worker and with two, and when workers are killed."""

import os
import signal
import threading
import time

import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.large.cluster import local_client, remote_client

pytest.importorskip("distributed")

OPTIONS = {"target_count": 600, "n_tiles": 6, "method": "lp_uniform", "n_clusters": 4}


@pytest.fixture(scope="module")
def alone(files, tmp_path_factory):
    """What this process makes without Dask."""
    path = tmp_path_factory.mktemp("alone") / "thin.npy"
    lpcompare.simplify_files(files[".npy"], path, **OPTIONS)
    return path.read_bytes()


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_workers_change_no_byte(files, tmp_path, alone):
    with local_client(1) as client:
        lpcompare.simplify_files(files[".npy"], tmp_path / "one.npy", client=client, **OPTIONS)
    lpcompare.simplify_files(files[".npy"], tmp_path / "two.npy", workers=2, **OPTIONS)
    assert (tmp_path / "one.npy").read_bytes() == alone
    assert (tmp_path / "two.npy").read_bytes() == alone


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_workers_that_are_killed_change_no_byte(files, tmp_path, alone):
    with local_client(2) as client:
        killed, over = [], threading.Event()

        def kill():
            while len(killed) < 3 and not over.wait(0.5):
                workers = [w["id"] for w in client.scheduler_info()["workers"].values()]
                pids = [pid for pid in client.run(os.getpid).values() if pid not in killed] if workers else []
                if pids:
                    os.kill(pids[0], signal.SIGKILL)
                    killed.append(pids[0])
                    time.sleep(1)

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            lpcompare.simplify_files(files[".npy"], tmp_path / "thin.npy", client=client, **OPTIONS)
        finally:
            over.set()
            killer.join()
    assert killed
    assert (tmp_path / "thin.npy").read_bytes() == alone


def test_a_scheduler_that_does_not_answer_is_said():
    with pytest.raises(InputError, match=r"tcp://127.0.0.1:9 does not answer"), remote_client("tcp://127.0.0.1:9"):
        pass


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_error_of_a_worker_is_the_sentence_of_the_error(files, tmp_path):
    with local_client(1) as client, pytest.raises(InputError, match="1 to the 6000|from 1 to 6000"):
        lpcompare.simplify_files(files[".npy"], tmp_path / "thin.npy", client=client, **OPTIONS | {"target_count": 7000})
