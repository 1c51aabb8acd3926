"""Filter scripts that mix MeshLab's filters with ours: recorded, saved, replayed."""

import numpy as np
import pytest

NAME = "generate_simplified_point_cloud_linear_programming"


def mixed_session(layers):
    layers.apply_coord_laplacian_smoothing(stepsmoothnum=1)
    layers.compute_absolute_curvature_per_vertex(neighbornum=15)
    getattr(layers, NAME)(samplenum=2000, clusternum=4, randomseed=4, formulation="As printed")
    layers.compute_selection_by_condition_per_vertex(condselect="x > 0")
    layers.generate_simplified_point_cloud_uniform_linear_programming(targetperc=0.5, selected=True)


@pytest.fixture
def fresh(pymeshlab):
    def make():
        from lpcompare.models import load_model

        cloud = load_model("torus")
        layers = pymeshlab.MeshSet()
        layers.add_mesh(pymeshlab.Mesh(cloud.points, cloud.faces), "torus")
        return layers

    return make


def test_a_recorded_script_replays_to_the_same_layers(fresh, installed, tmp_path):
    first, second = fresh(), fresh()
    mixed_session(first)
    installed.save_filter_script(first, tmp_path / "mixed.mlx")
    text = (tmp_path / "mixed.mlx").read_text()
    assert text.count("<filter ") == 5, "our own steps inside MeshLab are not part of the script"
    assert text.index("Laplacian") < text.index("curvature") < text.index(NAME) < text.index("Conditional")
    installed.apply_filter_script(second, tmp_path / "mixed.mlx")
    assert [m.label() for m in second] == [m.label() for m in first]
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one.vertex_matrix(), other.vertex_matrix())
    installed.save_filter_script(second, tmp_path / "again.mlx")
    assert (tmp_path / "again.mlx").read_text() == text


def test_a_script_of_meshlab_alone_is_read_by_meshlab(fresh, installed, tmp_path):
    layers = fresh()
    layers.apply_coord_laplacian_smoothing(stepsmoothnum=1)
    installed.save_filter_script(layers, tmp_path / "theirs.mlx")
    other = fresh()
    other.load_filter_script(str(tmp_path / "theirs.mlx"))
    other.apply_filter_script()
    assert np.array_equal(other.current_mesh().vertex_matrix(), layers.current_mesh().vertex_matrix())


def test_a_script_may_be_written_by_hand(fresh, installed, tmp_path):
    path = tmp_path / "hand.mlx"
    path.write_text(
        f'<!DOCTYPE FilterScript><FilterScript><filter name="{NAME}">'
        '<Param name="targetperc" value="0.5"/><Param name="clusternum" value="2"/></filter></FilterScript>'
    )
    layers = fresh()
    installed.apply_filter_script(layers, path)
    assert layers.current_mesh().vertex_number() == 6000


def test_what_was_cleared_is_not_written(fresh, installed, tmp_path):
    layers = fresh()
    layers.apply_coord_laplacian_smoothing(stepsmoothnum=1)
    getattr(layers, NAME)(samplenum=2000, clusternum=4)
    layers.clear_filter_script()
    installed.save_filter_script(layers, tmp_path / "a.mlx")
    assert "<filter " not in (tmp_path / "a.mlx").read_text()
    getattr(layers, NAME)(samplenum=2000, clusternum=4)
    installed.clear_filter_script(layers)
    installed.save_filter_script(layers, tmp_path / "a.mlx")
    assert "<filter " not in (tmp_path / "a.mlx").read_text()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (None, "No such file"),
        ("", "not XML"),
        ("<Other/>", "<Other>"),
        (
            f'<FilterScript><filter name="{NAME}"><Param name="nosuch" value="1"/></filter></FilterScript>',
            "nosuch",
        ),
        (
            f'<FilterScript><filter name="{NAME}"><Param name="samplenum" value="x"/></filter>'
            "</FilterScript>",
            "an int",
        ),
        ('<FilterScript><filter name="Nosuch"/></FilterScript>', "Nosuch"),
    ],
)
def test_scripts_that_cannot_be_applied(content, reason, fresh, installed, pymeshlab, tmp_path):
    path = tmp_path / "bad.mlx"
    if content is not None:
        path.write_text(content)
    layers = fresh()
    with pytest.raises(pymeshlab.PyMeshLabException, match=reason):
        installed.apply_filter_script(layers, path)
    assert layers.mesh_number() == 1
