"""The grids: numpy counts what MeshLab's filter returns."""

import numpy as np
import pytest

from lpcompare.geometry.scale import about_center
from lpcompare_baselines._cells import cell_means, grid_cells, meshlab_cells, n_occupied
from lpcompare_baselines._meshlab import mesh_set, ml


@pytest.fixture(scope="module")
def cloud():
    points = np.random.default_rng(1).normal(size=(3000, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) * [1, 2, 0.5]


@pytest.mark.parametrize("size", np.random.default_rng(2).uniform(0.02, 1.5, 25))
def test_numpy_counts_the_cells_that_meshlab_fills(cloud, size):
    meshes = mesh_set(cloud)
    meshes.meshing_decimation_clustering(threshold=ml.PureValue(size))
    assert n_occupied(meshlab_cells(about_center(cloud), size)) == meshes.current_mesh().vertex_number()


def test_grid_cells_by_hand():
    points = np.array([[0, 0, 0], [0.9, 0, 0], [1.1, 0, 0], [0, 2.5, 0], [0.2, 2.9, 0.1]])
    cells = grid_cells(points, 1.0)
    assert n_occupied(cells) == 3
    assert cells[0] == cells[1] != cells[2]
    assert cells[3] == cells[4]
    means, group = cell_means(points, cells)
    assert np.allclose(means[group[0]], [0.45, 0, 0])
    assert np.allclose(means[group[4]], [0.1, 2.7, 0.05])


def test_a_size_far_below_the_spacing_neither_overflows_nor_merges(cloud):
    far = cloud + np.array([5e5, 4e6, 100.0])
    assert n_occupied(grid_cells(far, 1e-300)) == len(cloud)


def test_one_point_is_one_cell():
    assert n_occupied(grid_cells(np.ones((1, 3)), 0.5)) == 1
    assert n_occupied(meshlab_cells(np.zeros((1, 3)), 0.5)) == 1
