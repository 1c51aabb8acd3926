"""A MeshSet with a layer that has everything a vertex can carry."""

import numpy as np
import pytest

N = 3000


@pytest.fixture(scope="session")
def pymeshlab():
    return pytest.importorskip("pymeshlab")


@pytest.fixture
def installed(pymeshlab):
    """lpcompare.meshlab, installed for one test."""
    import lpcompare.meshlab

    lpcompare.meshlab.install()
    yield lpcompare.meshlab
    lpcompare.meshlab.uninstall()


@pytest.fixture
def arrays():
    rng = np.random.default_rng(8)
    points = rng.normal(size=(N, 3))
    points *= np.array([3.0, 2.0, 1.0]) / np.linalg.norm(points, axis=1, keepdims=True)
    return {
        "vertex_matrix": points,
        "v_normals_matrix": rng.normal(size=(N, 3)),
        "v_color_matrix": rng.uniform(size=(N, 4)),
        "v_scalar_array": rng.normal(size=N),
        "v_tex_coords_matrix": rng.uniform(size=(N, 2)),
    }


@pytest.fixture
def layers(pymeshlab, installed, arrays):
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(**arrays), "scan")
    rng = np.random.default_rng(9)
    layers.current_mesh().add_vertex_custom_scalar_attribute(rng.normal(size=N), "weight")
    layers.current_mesh().add_vertex_custom_point_attribute(rng.normal(size=(N, 3)), "flow")
    return layers


def state(mesh):
    """Everything of a layer that can be read."""
    return {
        "points": mesh.vertex_matrix(),
        "normals": mesh.vertex_normal_matrix(),
        "colors": mesh.vertex_color_matrix(),
        "quality": mesh.vertex_scalar_array(),
        "texture": mesh.vertex_tex_coord_matrix(),
        "weight": mesh.vertex_custom_scalar_attribute_array("weight"),
        "flow": mesh.vertex_custom_point_attribute_matrix("flow"),
        "matrix": mesh.transform_matrix(),
        "selection": mesh.vertex_selection_array(),
    }


@pytest.fixture(name="state")
def state_fixture():
    return state
