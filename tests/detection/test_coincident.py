"""Which vertices coincide at the start, in the words of the error."""

import numpy as np

from izo_ref.base.records import Pairs
from izo_ref.detection.coincident import find_coincident


def test_groups_are_named_with_those_that_part():
    places = np.array([0, 1, 0, 2, 1, 3, 0, 4, 5, 5])
    start = np.array([[place, 0.5 * place, -place] for place in places], float)
    end = start + 1.0
    end[6] += 1.0  # one of the first group goes elsewhere
    faces = np.array([[0, 1, 3], [2, 4, 3], [5, 6, 7]], np.int32)
    nodes = np.array([[0, 2, 1, 3], [6, 4, 5, 7]], np.int32)  # 8 and 9 are in no pair
    found = find_coincident(start, end, faces, Pairs(nodes, np.zeros(2, bool)))
    assert found.groups == [[0, 2, 6], [1, 4]]
    assert found.parted == [[0, 2, 6]]
    text = str(found)
    assert "5 vertices coincide exactly, in 2 groups, the first: (0, 2, 6), (1, 4)" in text
    assert "1 face" in text
    assert "The vertices of 1 group end at different places" in text


def test_nothing_coincides_and_long_groups_are_cut():
    nodes = np.array([[0, 1, 2, 3]], np.int32)
    pairs, faces = Pairs(nodes, np.zeros(1, bool)), np.array([[0, 1, 2]], np.int32)
    apart = np.arange(12.0).reshape(4, 3)
    assert str(find_coincident(apart, apart, faces, pairs)) == ""
    seven = np.zeros((7, 3))
    pairs = Pairs(np.array([[0, 1, 2, 3], [3, 4, 5, 6]], np.int32), np.zeros(2, bool))
    assert "(0, 1, 2, 3, 4, ...)" in str(find_coincident(seven, seven, faces, pairs))
    five = Pairs(np.array([[0, 1, 2, 3], [1, 2, 3, 4]], np.int32), np.zeros(2, bool))
    assert "(0, 1, 2, 3, 4)" in str(find_coincident(seven[:5], seven[:5], faces, five))
