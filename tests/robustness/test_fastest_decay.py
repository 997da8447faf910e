"""The largest decay of a search is found by bisection, and only what was confirmed of it is handed back."""

from types import SimpleNamespace

import numpy as np
import pytest

from design.robustness.certificates.memory.ladder import TRIED, fastest

SLOWEST = 0.8


class Search:
    """Finds functions up to one decay [1/s], and confirms them up to another."""

    def __init__(self, found, confirmed):
        self.found, self.confirmed, self.asked = found, confirmed, []

    def __call__(self, decay, sure):
        self.asked.append((decay, sure))
        there = decay <= (self.confirmed if sure else self.found)
        return SimpleNamespace(form=SimpleNamespace(decay=decay) if there else None)


@pytest.mark.parametrize("share", np.linspace(0.002, 0.999, 23))
@pytest.mark.parametrize("halvings", [0, 1, 3, 5])
def test_what_the_solver_finds_and_the_check_confirms_is_found_to_the_last_halving(share, halvings):
    search = Search(share * SLOWEST, share * SLOWEST)
    found = fastest(search, SLOWEST, halvings).form.decay
    first = max(t for t in TRIED if t <= share) * SLOWEST
    assert found <= share * SLOWEST < found + (SLOWEST - first) / 2**halvings + 1e-12
    assert (found, True) in search.asked


@pytest.mark.parametrize("trusted", [0.98, 0.8, 0.55, 0.3])
def test_of_what_the_check_does_not_confirm_a_smaller_share_is_tried(trusted):
    """The shares are those beyond the first decay, which was confirmed."""
    first = TRIED[0] * SLOWEST
    search = Search(SLOWEST, first + trusted * (SLOWEST - first))
    found = fastest(search, SLOWEST, 12).form.decay
    assert found <= search.confirmed
    assert (found - first) / (SLOWEST - first) >= (0.5 * trusted if trusted > 0.5 else 0.0)
    looked = [d for d, sure in search.asked if sure]
    assert len(set(looked)) == len(looked)  # nothing is confirmed twice


def test_a_search_that_finds_nothing_tries_ever_smaller_decays():
    search = Search(0.0, 0.0)
    assert fastest(search, SLOWEST).form is None
    asked = [d for d, _ in search.asked]
    assert asked == sorted(asked, reverse=True)
    assert all(0.0 < d < SLOWEST for d in asked)
