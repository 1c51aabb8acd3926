"""The filters on a MeshSet: what they add, what they keep, what they leave alone."""

import numpy as np
import pytest

import lpcompare
from lpcompare.metrics.comparison import Comparison

GENERATE = (
    "generate_simplified_point_cloud_linear_programming",
    "generate_simplified_point_cloud_uniform_linear_programming",
)
CARRIED = ("points", "normals", "colors", "quality", "texture", "weight", "flow")


@pytest.mark.parametrize("name", GENERATE)
def test_a_new_current_layer_carries_everything_bit_for_bit(name, layers, state):
    before = state(layers.mesh(0))
    found = getattr(layers, name)(samplenum=500, clusternum=2)
    rows = found["sample_indices"]
    assert found["sample_num"] == len(rows) == 500
    assert [mesh.label() for mesh in layers][1].endswith("LP simplified cloud")
    assert layers.current_mesh_id() == 1
    after = state(layers.current_mesh())
    for key in CARRIED:
        assert np.array_equal(after[key], before[key][rows]), key
    assert layers.current_mesh().face_number() == 0
    untouched = state(layers.mesh(0))
    assert all(np.array_equal(untouched[key], before[key]) for key in before)


def test_the_points_are_those_of_the_library(layers, arrays):
    found = layers.generate_simplified_point_cloud_linear_programming(
        samplenum=500, clusternum=2, randomseed=3
    )
    points = arrays["vertex_matrix"]
    same = lpcompare.simplify(points, method="lp_density", target_count=500, n_clusters=2, random_state=3)
    assert np.array_equal(found["sample_indices"], same.indices)


def test_the_matrix_of_the_layer_is_respected_and_carried(layers, pymeshlab, arrays, installed):
    matrix = np.array([[2.0, 0, 0, 5e5], [0, 0, -0.5, 4e6], [0, 1.0, 0, 7], [0, 0, 0, 1]])
    layers.set_matrix(transformmatrix=matrix, freeze=False)
    found = layers.generate_simplified_point_cloud_linear_programming(samplenum=500, clusternum=2)
    assert np.array_equal(layers.current_mesh().transform_matrix(), matrix)
    world = layers.mesh(0).transformed_vertex_matrix()
    assert np.array_equal(layers.current_mesh().transformed_vertex_matrix(), world[found["sample_indices"]])
    frozen = pymeshlab.MeshSet()
    frozen.add_mesh(pymeshlab.Mesh(world))
    again = installed.apply_filter(
        frozen, "generate_simplified_point_cloud_linear_programming", samplenum=500, clusternum=2
    )
    assert np.array_equal(again["sample_indices"], found["sample_indices"])


@pytest.mark.parametrize("name", GENERATE)
def test_selected_works_on_the_selection(name, layers):
    layers.compute_selection_by_condition_per_vertex(condselect="x > 0")
    chosen = layers.current_mesh().vertex_selection_array()
    found = getattr(layers, name)(targetperc=0.2, clusternum=2, selected=True)
    assert chosen[found["sample_indices"]].all()
    assert found["sample_num"] == int(0.2 * chosen.sum())
    assert np.array_equal(layers.mesh(0).vertex_selection_array(), chosen)


def test_plane_error_is_eq_27_in_the_world(layers, arrays):
    layers.set_matrix(transformmatrix=np.diag([10.0, 10.0, 10.0, 1.0]), freeze=False)
    rows = layers.generate_simplified_point_cloud_linear_programming(samplenum=500, clusternum=2)[
        "sample_indices"
    ]
    found = layers.get_plane_error()
    points = 10 * arrays["vertex_matrix"]
    comparison = Comparison(points, points[rows])
    assert found["mean"] == pytest.approx(comparison.plane_errors(8).mean())
    assert found["mean_percent"] == pytest.approx(100 * found["mean"] / found["diag_mesh_0"])
    assert found == layers.get_plane_error(sampledmesh=0, targetmesh=1, neighbornum=8)
    assert layers.get_plane_error(neighbornum=12)["mean"] != found["mean"]


def test_plane_error_per_vertex_fills_the_original_and_keeps_the_current_layer(layers):
    layers.generate_simplified_point_cloud_linear_programming(samplenum=500, clusternum=2)
    for _ in range(2):
        found = layers.compute_scalar_by_plane_error_per_vertex(measuremesh=0, refmesh=1)
    quality = layers.mesh(0).vertex_scalar_array()
    assert layers.current_mesh_id() == 1
    assert quality.mean() == pytest.approx(found["mean"])
    assert np.array_equal(quality, layers.mesh(0).vertex_custom_scalar_attribute_array("plane_error"))


def test_curvature_and_clusters_are_those_of_the_library(layers, arrays):
    from lpcompare import LPSimplifier

    fitted = LPSimplifier(target_count=2999, n_clusters=6, random_state=1).fit(arrays["vertex_matrix"])
    layers.compute_absolute_curvature_per_vertex()
    assert np.array_equal(layers.current_mesh().vertex_scalar_array(), fitted.curvature_.absolute)
    found = layers.compute_expectation_maximization_clusters_per_vertex(clusternum=6, randomseed=1)
    assert np.array_equal(layers.current_mesh().vertex_scalar_array(), fitted.labels_)
    assert found["cluster_sizes"].tolist() == np.bincount(fitted.labels_).tolist()


def test_values_outside_the_selection_stay(layers, arrays):
    layers.compute_selection_by_condition_per_vertex(condselect="x > 0")
    chosen = layers.current_mesh().vertex_selection_array()
    layers.compute_absolute_curvature_per_vertex(selected=True)
    quality = layers.current_mesh().vertex_scalar_array()
    assert np.array_equal(quality[~chosen], arrays["v_scalar_array"][~chosen])
    assert (quality[chosen] > 0).all()


def test_attributes_of_meshlabs_own_filter_are_carried(layers):
    layers.compute_new_custom_scalar_attribute_per_vertex(name="height", expr="z*2")
    rows = layers.generate_simplified_point_cloud_linear_programming(samplenum=500, clusternum=2)[
        "sample_indices"
    ]
    kept = layers.current_mesh().vertex_custom_scalar_attribute_array("height")
    assert np.array_equal(kept, layers.mesh(0).vertex_custom_scalar_attribute_array("height")[rows])
    # the layer is sound: MeshLab's expression filters crash on one whose attributes came too early
    layers.compute_scalar_by_function_per_vertex(q="height + weight")


def test_a_cloud_of_one_vertex_and_of_duplicates(pymeshlab, installed):
    for points in (np.zeros((1, 3)), np.ones((40, 3))):
        layers = pymeshlab.MeshSet()
        layers.add_mesh(pymeshlab.Mesh(points))
        assert layers.generate_simplified_point_cloud_linear_programming(samplenum=1)["sample_num"] == 1


def test_the_error_may_choose_the_count_as_a_percentage_or_a_length(layers, pymeshlab):
    name = "generate_simplified_point_cloud_uniform_linear_programming"
    found = getattr(layers, name)(maxerror=pymeshlab.PercentageValue(0.5), clusternum=2)
    error = layers.get_plane_error()
    assert error["mean_percent"] <= 0.5
    length = pymeshlab.PureValue(0.005 * error["diag_mesh_0"])
    layers.set_current_mesh(0)
    again = getattr(layers, name)(maxerror=length, clusternum=2)
    assert abs(again["sample_num"] - found["sample_num"]) <= 0.02 * found["sample_num"]
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"must be a pymeshlab\.PercentageValue object"):
        getattr(layers, name)(maxerror=0.5)
