"""Under a word the state is multiplied by the word's radius in each pass, from the direction that grows
most."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.certificates.sampled.growth import growth_of, played
from design.robustness.certificates.sampled.sampled_loop import vertices
from design.robustness.certificates.sampled.words import Word
from design.robustness.loop_model import LoopModel
from plants import Wrist

MODEL = LoopModel.of(Wrist.flexion(), PI(6.0, 20.0))
NAMES = ("transit at the slow rate", "line1 and line2 at the fast rate")


def test_states_are_those_of_a_loop_over_the_samples():
    a, b = np.array([[0.0, 1.0], [-1.0, 0.5]]), np.array([[2.0, 0.0], [1.0, 1.0]])
    x = np.array([1.0, -2.0])
    np.testing.assert_array_equal(played(x, [(a, 2), (b, 1)]), [x, a @ x, a @ a @ x, b @ a @ a @ x])
    np.testing.assert_array_equal(played(np.eye(2), [(b, 3)])[-1], np.linalg.matrix_power(b, 3))


@pytest.mark.parametrize("passes", [3, 8])
def test_each_pass_multiplies_by_the_radius_and_letters_alone_by_their_own(passes):
    counts = (45, 120)
    first, second = (
        np.linalg.matrix_power(vertices(MODEL)[n], k) for n, k in zip(NAMES, counts, strict=True)
    )
    values, vectors = np.linalg.eig(second @ first)
    largest = values[np.argmax(np.abs(values))]
    assert largest.imag == 0.0  # so that a pass only changes the size of the direction that grows most
    radius = float(np.abs(largest))
    dwells = (counts[0] * MODEL.dt, counts[1] * MODEL.dt)
    found = growth_of(MODEL, Word((0, 1), dwells, radius, NAMES), passes)
    whole = sum(counts)
    assert len(found.time) == len(found.word) == passes * whole + 1
    np.testing.assert_allclose(np.diff(found.time), MODEL.dt)
    np.testing.assert_allclose(found.ends, np.arange(1, passes) * whole * MODEL.dt)
    assert found.word[: whole + 1].max() == pytest.approx(1.0)  # the first pass is the unit
    sizes = [found.word[k * whole : (k + 1) * whole + 1].max() for k in range(passes)]
    np.testing.assert_allclose(sizes, radius ** np.arange(passes), rtol=1e-6)
    assert list(found.alone) == list(NAMES)
    start = np.real(vectors[:, np.argmax(np.abs(values))])
    unit = np.abs(played(start, [(vertices(MODEL)[n], k) for n, k in zip(NAMES, counts, strict=True)])).max(
        axis=0
    )
    for name, sizes in found.alone.items():
        for k in (0, whole, passes * whole):
            state = np.linalg.matrix_power(vertices(MODEL)[name], k) @ start
            assert sizes[k] == pytest.approx(np.abs(state / unit).max(), rel=1e-6)
        assert len(sizes) == len(found.time)
