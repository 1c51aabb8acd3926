"""Names, signatures, help, errors and binding are those that a user of pymeshlab expects."""

import inspect
import threading

import numpy as np
import pytest

NAME = "generate_simplified_point_cloud_linear_programming"
VERBS = ("generate_", "compute_", "get_")


def test_methods_have_real_signatures_and_help(pymeshlab, installed, capsys):
    for name in installed.filter_list():
        method = getattr(pymeshlab.MeshSet, name)
        parameters = list(inspect.signature(method).parameters.values())[1:]
        assert name.startswith(VERBS)
        assert method.__name__ == name
        assert all(p.kind is p.KEYWORD_ONLY and p.name.isalpha() and p.name.islower() for p in parameters)
        assert all(p.name in method.__doc__ for p in parameters)
    help(getattr(pymeshlab.MeshSet, NAME))
    text = capsys.readouterr().out
    assert f"{NAME}(self, *, samplenum: int = 1000" in text
    assert "boolean linear programming" in text


def test_parameter_lists_look_like_pymeshlabs(pymeshlab, installed, capfd):
    installed.print_filter_parameter_list(NAME)
    ours = capfd.readouterr().out.splitlines()
    assert ours[0] == f"{NAME} filter - list of parameter names:"
    assert "\tsamplenum : int = 1000" in ours
    assert "\tselected : bool = False" in ours


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"nosuch": 1}, f"Parameter nosuch not found for filter {NAME}. Please check the documentation."),
        ({"samplenum": 3.5}, "Parameter samplenum: must be an int"),
        ({"samplenum": "3"}, "Parameter samplenum: must be an int"),
        ({"samplenum": True}, "Parameter samplenum: must be an int"),
        ({"samplenum": 0}, "Parameter samplenum: must be from 1 up"),
        ({"samplenum": 3001}, f"Failed to apply filter: {NAME}\nDetails: "),
        ({"targetperc": 1.5}, "Parameter targetperc: must be from 0 to 1"),
        ({"targetperc": float("nan")}, "Parameter targetperc: must be a finite float"),
        ({"selected": 1}, "Parameter selected: must be a bool"),
        ({"selected": True}, "No vertices of mesh 'scan' are selected"),
    ],
)
def test_wrong_parameters_are_pymeshlabs_exceptions(parameters, reason, layers, pymeshlab):
    with pytest.raises(pymeshlab.PyMeshLabException) as caught:
        getattr(layers, NAME)(**parameters)
    assert reason in str(caught.value)
    assert layers.mesh_number() == 1


@pytest.mark.parametrize("value", ["As prnted", 2])
def test_wrong_choices_are_pymeshlabs_enum_exceptions(value, layers, pymeshlab):
    with pytest.raises(pymeshlab.InvalidEnumException, match="Enum"):
        getattr(layers, NAME)(formulation=value)


def test_choices_may_be_numbers_and_numpy_integers_are_integers(layers):
    first = getattr(layers, NAME)(samplenum=np.int64(500), clusternum=2, formulation=1)
    layers.set_current_mesh(0)
    second = getattr(layers, NAME)(samplenum=500, clusternum=2, formulation="As printed")
    assert np.array_equal(first["sample_indices"], second["sample_indices"])
    assert [mesh.label() for mesh in layers][2] == "LP simplified cloud(1)"


def test_a_set_without_meshes(pymeshlab, installed):
    for name in installed.filter_list():
        with pytest.raises(pymeshlab.PyMeshLabException, match="requires at least one mesh loaded"):
            getattr(pymeshlab.MeshSet(), name)()


def test_an_empty_layer_and_nan(pymeshlab, installed, tmp_path):
    header = "ply\nformat ascii 1.0\nelement vertex 0\n"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    (tmp_path / "empty.ply").write_text(f"{header}{axes}end_header\n")
    layers = pymeshlab.MeshSet()
    layers.load_new_mesh(str(tmp_path / "empty.ply"))
    spoilt = np.random.default_rng(0).normal(size=(50, 3))
    spoilt[7, 2] = np.nan
    damaged = pymeshlab.MeshSet()
    damaged.add_mesh(pymeshlab.Mesh(spoilt), "damaged")
    for name in installed.filter_list():
        with pytest.raises(pymeshlab.PyMeshLabException, match="has no vertices"):
            getattr(layers, name)()
        with pytest.raises(pymeshlab.PyMeshLabException, match="1 of 50 vertices of mesh 'damaged' have NaN"):
            getattr(damaged, name)()


def test_an_unknown_layer(layers, pymeshlab):
    with pytest.raises(pymeshlab.PyMeshLabException, match="id of a mesh in the MeshSet \\(0\\)"):
        layers.get_plane_error(targetmesh=5)


def test_uninstall_restores_everything(pymeshlab):
    import lpcompare.meshlab

    before = dict(vars(pymeshlab.MeshSet)), dict(vars(pymeshlab.Mesh))
    lpcompare.meshlab.install()
    lpcompare.meshlab.install()
    assert hasattr(pymeshlab.MeshSet, NAME)
    lpcompare.meshlab.uninstall()
    lpcompare.meshlab.uninstall()
    assert (dict(vars(pymeshlab.MeshSet)), dict(vars(pymeshlab.Mesh))) == before
    lpcompare.meshlab.install()
    assert hasattr(pymeshlab.MeshSet, NAME)
    lpcompare.meshlab.uninstall()


def test_sets_that_existed_before_are_served_too(pymeshlab):
    import lpcompare.meshlab

    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(np.random.default_rng(0).normal(size=(400, 3))))
    with pytest.raises(AttributeError):
        getattr(layers, NAME)
    lpcompare.meshlab.install()
    assert getattr(layers, NAME)(samplenum=100, clusternum=1)["sample_num"] == 100
    lpcompare.meshlab.uninstall()


def test_the_function_form_needs_no_binding_and_knows_meshlabs_filters(pymeshlab):
    import lpcompare.meshlab

    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(np.random.default_rng(0).normal(size=(400, 3))))
    assert lpcompare.meshlab.apply_filter(layers, NAME, samplenum=100, clusternum=1)["sample_num"] == 100
    lpcompare.meshlab.apply_filter(layers, "generate_copy_of_current_mesh")
    assert layers.mesh_number() == 3
    with pytest.raises(pymeshlab.PyMeshLabException, match="Filter does not exist"):
        lpcompare.meshlab.apply_filter(layers, "nosuch")


def test_threads_with_a_set_each(pymeshlab, installed):
    points = np.random.default_rng(0).normal(size=(400, 3))
    found = {}

    def work(number):
        layers = pymeshlab.MeshSet()
        layers.add_mesh(pymeshlab.Mesh(points))
        installed.install()
        found[number] = getattr(layers, NAME)(samplenum=100, clusternum=1)["sample_indices"]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert all(np.array_equal(found[0], rows) for rows in found.values())
