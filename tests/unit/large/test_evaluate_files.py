"""`evaluate_files`: the figures of the whole clouds, whatever the tiles."""

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError, PointsLeftOut

QUICK = ["plane_error", "mean_distance", "hausdorff", "normal_deviation"]


@pytest.mark.parametrize("n_tiles", [1, 6, 25])
def test_figures_are_those_in_memory(sheet, files, tmp_path, n_tiles):
    rng = np.random.default_rng(1)
    reduced = sheet[np.sort(rng.choice(len(sheet), 400, replace=False))]
    reduced = np.append(reduced, sheet.mean(axis=0, keepdims=True) + 3, axis=0)  # and one off the surface
    np.save(tmp_path / "thin.npy", reduced)
    known = lpcompare.evaluate(sheet, reduced, metrics=QUICK)
    found = lpcompare.evaluate_files(files[".npy"], tmp_path / "thin.npy", n_tiles=n_tiles)
    assert set(found) == set(known) - {"mean_distance_backward_pct"}
    for name, value in found.items():
        assert value == pytest.approx(known[name], rel=1e-9), name
    assert list(tmp_path.iterdir()) == [tmp_path / "thin.npy"]


@pytest.mark.parametrize("ending", [".xyz", ".csv", ".obj", ".ply", ".npz"])
def test_what_cannot_be_read_in_parts_is_read_whole(sheet, tmp_path, ending):
    """The PLY is a text file."""
    names = [str(tmp_path / f"{name}{ending}") for name in ("whole", "thin")]
    for name, points in zip(names, (sheet, sheet[::9]), strict=True):
        lpcompare.write(name, lpcompare.PointCloud(points))
        if ending == ".ply":
            lines = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
            head = "".join(f"property double {axis}\n" for axis in "xyz")
            text = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n{head}end_header\n{lines}"
            (tmp_path / name).write_text(text)
    known = lpcompare.evaluate(lpcompare.read(names[0]), lpcompare.read(names[1]), metrics=QUICK[:1])
    found = lpcompare.evaluate_files(*names)
    assert found["plane_error"] == pytest.approx(known["plane_error"], rel=1e-9)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_file_that_is_no_cloud_is_refused(sheet, tmp_path):
    np.save(tmp_path / "whole.npy", sheet)
    (tmp_path / "thin.xyz").write_text("no numbers at all\n")
    with pytest.raises(InputError, match=r"thin\.xyz"):
        lpcompare.evaluate_files(tmp_path / "whole.npy", tmp_path / "thin.xyz")
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("n_kept", [1, 2, 5])
def test_a_few_points_are_enough(sheet, files, tmp_path, n_kept):
    np.save(tmp_path / "thin.npy", sheet[:: len(sheet) // n_kept][:n_kept])
    known = lpcompare.evaluate(sheet, np.load(tmp_path / "thin.npy"), metrics=QUICK[:1])
    found = lpcompare.evaluate_files(files[".npy"], tmp_path / "thin.npy", n_tiles=4)
    assert found["plane_error_pct"] == pytest.approx(known["plane_error_pct"], rel=1e-9)


def test_a_cloud_without_extent_has_no_diagonal(tmp_path):
    np.save(tmp_path / "one.npy", np.ones((20, 3)))
    with pytest.raises(InputError, match="no extent"):
        lpcompare.evaluate_files(tmp_path / "one.npy", tmp_path / "one.npy")


@pytest.mark.parametrize("holes", [("original",), ("reduced",), ("original", "reduced")])
def test_points_left_out_are_said_as_in_memory(tmp_path, holes):
    clouds = {"original": np.random.default_rng(0).random((90, 3))}
    clouds["reduced"] = clouds["original"][::5].copy()
    clean = lpcompare.evaluate(*clouds.values())["plane_error_pct"]
    for name in holes:
        clouds[name] = np.append(clouds[name], [[0, np.nan, 0], [0, 0, np.inf]], axis=0)
    for name, points in clouds.items():
        np.save(tmp_path / f"{name}.npy", points)
    calls = (
        lambda: lpcompare.evaluate(*clouds.values()),
        lambda: lpcompare.evaluate_files(tmp_path / "original.npy", tmp_path / "reduced.npy", n_tiles=3),
    )
    said = []
    for call in calls:
        with pytest.warns(PointsLeftOut) as warned:
            assert call()["plane_error_pct"] == pytest.approx(clean)
        said.append([str(w.message) for w in warned])
    sizes = {"original": 92, "reduced": 20}
    named = {"original": "The original", "reduced": "The reduced cloud"}
    wanted = [
        f"{named[n]}: 2 of {sizes[n]} points have no finite coordinates and are left out." for n in holes
    ]
    assert said == [wanted, wanted]


@pytest.mark.parametrize(
    ("value", "says"), [(np.nan, "no point"), (1e200, "overflow"), (1e-200, "underflow")]
)
def test_coordinates_that_cannot_be_measured_are_refused(tmp_path, value, says):
    original, reduced = np.full((50, 3), value), np.random.default_rng(0).random((5, 3))
    original[:, 0] *= np.arange(50)
    np.save(tmp_path / "original.npy", original)
    np.save(tmp_path / "reduced.npy", reduced)
    with pytest.raises(InputError, match=says):
        lpcompare.evaluate_files(tmp_path / "original.npy", tmp_path / "reduced.npy")
