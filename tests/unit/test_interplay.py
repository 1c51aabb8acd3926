"""Objects of other libraries go into `simplify` and come back, with what they say of each point."""

import subprocess
import sys

import numpy as np
import pytest

import lpcompare

POINTS = np.random.default_rng(0).normal(size=(300, 3))
MARKS = np.arange(300.0)


def of_tensor_open3d():
    o3d = pytest.importorskip("open3d", reason="open3d is not installed")
    cloud = o3d.t.geometry.PointCloud(POINTS)
    cloud.point.mark = o3d.core.Tensor(MARKS[:, None])
    return cloud, lambda c: (c.point.positions.numpy(), c.point.mark.numpy().ravel())


def of_open3d():
    o3d = pytest.importorskip("open3d", reason="open3d is not installed")
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    cloud.colors = o3d.utility.Vector3dVector(np.repeat(MARKS[:, None] / 300, 3, axis=1))
    return cloud, lambda c: (np.asarray(c.points), np.asarray(c.colors)[:, 0] * 300)


def of_pyvista():
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    cloud = pyvista.PolyData(POINTS)
    cloud.point_data["mark"] = MARKS
    return cloud, lambda c: (np.asarray(c.points), np.asarray(c.point_data["mark"]))


def of_trimesh():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    colors = np.column_stack([MARKS // 256, MARKS % 256, MARKS * 0, MARKS * 0 + 255]).astype(np.uint8)
    cloud = trimesh.PointCloud(POINTS, colors=colors)
    return cloud, lambda c: (np.asarray(c.vertices), c.colors[:, 0] * 256.0 + c.colors[:, 1])


def of_pymeshlab():
    pymeshlab = pytest.importorskip("pymeshlab")
    cloud = pymeshlab.Mesh(vertex_matrix=POINTS, v_scalar_array=MARKS)
    return cloud, lambda c: (c.vertex_matrix(), c.vertex_scalar_array())


KINDS = [of_tensor_open3d, of_open3d, of_pyvista, of_trimesh, of_pymeshlab]


@pytest.mark.parametrize("kind", KINDS)
def test_a_subset_comes_back_with_its_attributes(kind):
    cloud, look = kind()
    result = lpcompare.simplify(cloud, target_count=30, method="farthest_point")
    back = result.as_given()
    assert type(back) is type(cloud)
    points, marks = look(back)
    assert np.array_equal(points, POINTS[result.indices])
    assert np.allclose(marks, MARKS[result.indices])


@pytest.mark.parametrize("kind", KINDS)
def test_new_points_come_back_in_the_same_class(kind):
    cloud, _ = kind()
    result = lpcompare.simplify(cloud, target_count=30, method="voxel_centroid")
    back = result.as_given()
    assert type(back) is type(cloud)
    again = lpcompare.simplify(back, target_count=len(result), method="random_sample")
    assert np.allclose(again.points, result.points, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_object_can_be_measured(kind):
    cloud, _ = kind()
    result = lpcompare.simplify(cloud, target_count=30, method="farthest_point")
    wanted = lpcompare.evaluate(POINTS, result, metrics=["plane_error"])
    assert lpcompare.evaluate(cloud, result.as_given(), metrics=["plane_error"]) == pytest.approx(wanted)


def test_lists_can_be_measured():
    points = POINTS.tolist()
    assert lpcompare.evaluate(points, points[::10], metrics=["hausdorff"])["hausdorff_pct"] > 0


def test_an_object_can_be_a_model_of_a_run():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    run = lpcompare.run([trimesh.PointCloud(POINTS)], ["random_sample"], reductions=[0.9])
    assert run.frame[["model", "n_output", "status"]].values.tolist() == [["cloud", 30, "ok"]]


def test_triangles_of_a_mesh_are_used():
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    result = lpcompare.simplify(pyvista.Sphere(), target_count=100, method="quadric_decimation")
    assert len(result) == 100


def test_points_that_were_left_out_do_not_come_back():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    points = POINTS.copy()
    points[3, 0] = np.nan
    cloud = trimesh.PointCloud(points)
    result = lpcompare.simplify(cloud, target_count=299, method="random_sample", drop_invalid=True)
    assert np.isfinite(np.asarray(result.as_given().vertices)).all()


def test_arrays_and_clouds_come_back_as_they_came():
    cloud = lpcompare.PointCloud(POINTS, attributes={"mark": MARKS})
    result = lpcompare.simplify(cloud, target_count=30, method="farthest_point")
    assert np.array_equal(result.as_given().attributes["mark"], MARKS[result.indices])
    result = lpcompare.simplify(POINTS, target_count=30, method="farthest_point")
    assert np.array_equal(result.as_given(), result.points)


def test_no_library_is_imported_for_an_array():
    code = "import sys, numpy as np, lpcompare\nlpcompare.simplify(np.eye(3), target_count=2, method='random_sample')\n"
    code += "print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"open3d", "pyvista", "trimesh", "pymeshlab", "pandas"} & set(done.stdout.split())
