"""The committed reproduction: its text is what its tables say, to the letter."""

import csv
from pathlib import Path

import pytest
from reports.paper.experiments import EXPERIMENTS
from reports.paper.page import pictures, read_made, render

FOLDER = Path(__file__).resolve().parents[2] / "reports" / "paper"


def tables():
    found = {}
    for experiment in EXPERIMENTS:
        with (FOLDER / f"{experiment.name}.csv").open(newline="", encoding="utf-8") as file:
            found[experiment.name] = list(csv.DictReader(file))
    return found


def test_the_text_agrees_with_the_numbers():
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == render(tables(), read_made(FOLDER))


def test_every_picture_is_there():
    models = {row["model"] for row in tables()["seconds"]}
    assert all((FOLDER / file).stat().st_size > 1000 for model in models for file, _ in pictures(model))


def test_every_case_of_every_experiment_was_measured():
    measured = tables()
    models = tuple(dict.fromkeys(row["model"] for row in measured["seconds"]))
    for experiment in EXPERIMENTS:
        assert len(measured[experiment.name]) == len(list(experiment.cases(models)))


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.csv")), ids=lambda p: p.name)
def test_no_table_names_a_folder_of_a_machine(path):
    assert "/" not in path.read_text(encoding="utf-8")
