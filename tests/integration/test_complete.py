"""What the Tab key offers, asked of the scripts that the shells load; fish and zsh where they are installed."""

import os
import shlex
import subprocess
import sys
from shutil import which

import pytest

from lpcompare import cli
from lpcompare.benchmark.study import preset_names
from lpcompare.models import model_names
from lpcompare.registry import METHODS, METRICS

BASH = """
eval "$(_LPCOMPARE_COMPLETE=source_bash lpcompare)"
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_lpcompare_completion lpcompare
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """An environment with the word lpcompare on the search path, and a folder with one scan."""
    folder = tmp_path_factory.mktemp("shell")
    script = folder / "lpcompare"
    script.write_text(f'#!/bin/sh\nexec {sys.executable} -P -m lpcompare.cli "$@"\n')
    script.chmod(0o755)
    (folder / "scan.laz").touch()
    return {"cwd": folder, "env": os.environ | {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}}


def answer(environment, *words, **variables):
    environment = environment | {"env": environment["env"] | variables}
    done = subprocess.run(words, **environment, capture_output=True, text=True, timeout=60, check=True)
    assert not done.stderr
    return done.stdout


@pytest.fixture
def tab(monkeypatch, capsys):
    """What the command tells bash for the last of some words."""

    def offers(*words):
        monkeypatch.setenv("_LPCOMPARE_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", "\n".join(["lpcompare", *(shlex.quote(word) for word in words)]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        with pytest.raises(SystemExit):
            cli.main()
        return capsys.readouterr().out.split()

    return offers


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("r",), ["report", "run"]),
        (("run", "--m"), ["--model", "--method", "--metric", "--memory-limit"]),
        (("run", "--method", ""), ["all", *METHODS]),
        (("run", "--model", ""), list(model_names())),
        (("run", "--metric", ""), ["all", *(m for m in METRICS if m not in METRICS.quick)]),
        (("run", "--study", ""), list(preset_names())),
        (("run", "--protocol", "e"), ["equal-count"]),
        (("run", "--set", "lp_den"), ["lp_density."]),
        (("run", "--set", "voxel_nearest.c"), ["voxel_nearest.cell_size="]),
        (("simplify", "--method", "poisson_disk", "--set", "r"), ["radius="]),
        (("simplify", "--statistic", ""), ["mean", "p95", "max"]),
        (("report", "--reference", "poi"), ["poisson_disk"]),
        (("view", "bun"), ["bunny"]),
        (("list", "m"), ["methods", "models", "metrics", *METHODS, *model_names(), *METRICS]),
        (("simplify", "sc"), []),
    ],
    ids=lambda words: " ".join(words[:3]),
)
def test_names_are_offered(tab, words, expected):
    assert tab(*words) == [name for name in expected if name.startswith(words[-1])]


def test_bash_offers_what_it_is_told(environment):
    words = ("bash", "--norc", "-c", BASH, "-", "lpcompare", "view", "bun")
    assert answer(environment, *words).split() == ["bunny"]


@pytest.mark.skipif(not which("fish"), reason="fish is not installed")
def test_fish_offers_names_with_summaries_and_else_files(environment):
    script = "_LPCOMPARE_COMPLETE=source_fish lpcompare | source; complete -C 'lpcompare {}'"

    def offers(words):
        return answer(environment, "fish", "--no-config", "-c", script.format(words)).splitlines()

    found = dict(line.split("\t") for line in offers("run --method lp_"))
    assert list(found) == [name for name in METHODS if name.startswith("lp_")]
    assert found["lp_placed"].startswith(METHODS.summary("lp_placed")[:40])
    assert offers("simplify sc") == ["scan.laz"]


@pytest.mark.parametrize(("words", "said"), [("list bunn", '"bunny"'), ("simplify sc", "_files")])
def test_zsh_is_told_names_and_else_files(environment, words, said):
    told = answer(
        environment,
        "lpcompare",
        _LPCOMPARE_COMPLETE="complete_zsh",
        _TYPER_COMPLETE_ARGS=f"lpcompare {words}",
    )
    assert said in told
    if which("zsh"):
        answer(environment, "zsh", "-f", "-n", "-c", told)
