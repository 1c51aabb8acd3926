"""The error tree: each is also a builtin, and an unknown name is helped along."""

import pytest

from lpcompare import errors


@pytest.mark.parametrize(
    ("error", "builtin"),
    [
        (errors.InputError, ValueError),
        (errors.NotApplicable, ValueError),
        (errors.Unavailable, ImportError),
        (errors.SolverError, RuntimeError),
        (errors.ModelDataError, OSError),
    ],
)
def test_each_error_is_ours_and_a_builtin(error, builtin):
    with pytest.raises(builtin):
        raise error("why")
    assert issubclass(error, errors.LpcompareError)


def test_unknown_name_offers_the_nearest_and_lists_the_known():
    error = errors.UnknownName("model", "buny", ["torus", "bunny"])
    assert isinstance(error, LookupError)
    assert str(error) == "Unknown model 'buny'. Did you mean 'bunny'? Known: bunny, torus."
