"""The last row of the price list: what a proof of the recommended gains costs, if there is one."""

import json
from typing import Any

import pytest

from design.alternatives.designs import excess_of
from design.studies.shown.prices import in_its_cases, proved_row
from plants.files import json_text

ROWS: list[dict[str, Any]] = [
    {"guarantee": guarantee, "controller": controller, "gains": {"Kp": kp}, "feasible": True,
     "worst_iae_deg_s": 9.0, "worst_settling_s": 3.0, "worst_overshoot_percent": 4.0, "ratio_to_bound": 1.4,
     "own_worst_iae_deg_s": 9.5}
    for guarantee, controller, kp in (
        ("nominal", "PI", 4.0), ("worst case found", "PI", 3.0), ("worst case found", "robust LQI", 1.0))
]  # fmt: skip


def test_proved_gains_cost_what_they_do_under_the_whole_requirement() -> None:
    assert proved_row(ROWS, "PI", {"status": "proved"}) == {**ROWS[1], "guarantee": "proved"}


def test_without_a_proof_the_row_is_there_and_empty() -> None:
    row = proved_row(ROWS, "PI", {"status": "open"})
    assert (row.pop("guarantee"), row.pop("controller"), row.pop("feasible")) == ("proved", "PI", False)
    assert set(row) == set(ROWS[1]) - {"guarantee", "controller", "feasible"}
    assert all(v is None for v in row.values())
    assert ROWS[1]["gains"] == {"Kp": 3.0}  # what it is taken from stays


@pytest.mark.parametrize(("excess", "held"), [(-0.1, True), (0.2, False), (float("inf"), False)])
def test_a_design_read_from_its_file_holds_its_cases_as_before(excess: float, held: bool) -> None:
    """A file has null for the excess of an unstable loop, which is infinite."""
    record = {"holds": False, "worst_excess": excess}
    read = json.loads(json_text(record))
    assert excess_of(read) == excess
    assert in_its_cases(read) is held is in_its_cases(record)
    assert in_its_cases({**read, "holds": True})
