"""Options are checked when they are made."""

import dataclasses
import inspect

import numpy as np
import pytest

from izo_ref import Options
from izo_ref.base import errors


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("selection", "some"),
        ("method", "newtonish"),
        ("preset", "cloth"),
        ("line_search", "guess"),
        ("multiplier_update", "sometimes"),
        ("penalty", "growing"),
        ("precision", "float16"),
        ("max_steps", -1),
        ("max_iterations", -1),
        ("relinearize", None),
        ("gap_tolerance", float("nan")),
        ("violation_tolerance", "1e-9"),
        ("max_steps", True),
        ("relinearize", 1.5),
        ("max_iterations", float("inf")),
    ],
)
def test_unknown_values_are_refused_and_named(name, value):
    with pytest.raises(errors.OptionError, match=name):
        Options(**{name: value})


def test_numbers_of_numpy_are_numbers():
    options = Options(relinearize=np.int64(2), max_steps=1e3, gap_tolerance=np.float32(0.5))
    assert (options.relinearize, options.max_steps, options.gap_tolerance) == (2, 1000, 0.5)
    assert type(options.relinearize) is int
    assert type(options.max_steps) is int


def test_options_are_frozen_and_keyword_only():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Options().selection = "all"
    with pytest.raises(TypeError):
        Options("all")


def test_every_option_is_explained():
    text = inspect.getdoc(Options)  # Python 3.13 alone removes the indentation from __doc__
    for field in dataclasses.fields(Options):
        assert f"\n    {field.name}: " in text


def test_options_that_contradict_each_other_are_refused():
    with pytest.raises(errors.OptionError, match="preset: 'icloth' is the method 'chebyshev'"):
        Options(preset="icloth", method="cg")
    with pytest.raises(errors.OptionError, match="precision: the method 'auto'"):
        Options(precision="float32")
    Options(preset="icloth", method="chebyshev")
    Options(preset="arcsim", precision="float32")
