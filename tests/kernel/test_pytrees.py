"""Frozen dataclasses, NamedTuples and tuples nest as one pytree, and a kernel runs on any of them."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from plants.kernel import pytrees
from plants.kernel.batches import run_lanes


@dataclass(frozen=True)
class Spring:
    stiffness: Any
    offset: Any = 0.0

    def __post_init__(self):
        if not np.all(np.asarray(self.stiffness, float) > 0.0):
            raise ValueError("a spring pulls back")


class Mass(NamedTuple):
    speed: Any
    place: Any


@dataclass(frozen=True)
class Oscillator:
    spring: Spring
    masses: tuple[Mass, Mass]


TREE = Oscillator(Spring(1.0, 2.0), (Mass(3.0, 4.0), Mass(5.0, 6.0)))


def test_leaves_and_their_names_are_in_the_order_of_the_fields():
    assert pytrees.leaves(TREE) == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert pytrees.names(TREE) == [
        "spring.stiffness", "spring.offset",
        "masses.0.speed", "masses.0.place", "masses.1.speed", "masses.1.place",
    ]  # fmt: skip


def test_a_tree_of_its_own_leaves_is_the_tree_and_names_fit_where_checks_would_refuse_them():
    assert pytrees.like(TREE, pytrees.leaves(TREE)) == TREE
    named = pytrees.like(TREE, pytrees.names(TREE))
    assert named.spring.stiffness == "spring.stiffness"
    assert hash(named) == hash(pytrees.like(TREE, pytrees.names(TREE)))


def test_places_count_leaves():
    assert pytrees.places(TREE, Mass) == [2, 4]
    assert pytrees.places(TREE, Oscillator) == [0]
    assert pytrees.places(TREE, Spring) == [0]


def test_a_dataclass_that_may_change_is_no_pytree():
    @dataclass
    class Loose:
        x: float

    with pytest.raises(TypeError, match="Loose: a dataclass in a pytree must be frozen"):
        pytrees.leaves((Loose(1.0), 2.0))


def _swung(s: Mass, _inputs: tuple[()], c: tuple[Spring, Any]) -> Mass:
    spring, dt = c
    speed = s.speed - dt * spring.stiffness * (s.place - spring.offset)
    return Mass(speed, s.place + dt * speed)


def test_a_kernel_takes_coefficients_that_are_dataclasses():
    spring = Spring(np.array([1.0, 4.0]), 0.5)
    last, _ = run_lanes(_swung, Mass(0.0, 1.0), (spring, 0.01), 100)
    expected = Mass(np.zeros(2), np.ones(2))
    for _ in range(100):
        expected = _swung(expected, (), (spring, 0.01))
    np.testing.assert_allclose(last, expected, rtol=1e-12)
