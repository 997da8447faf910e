"""The last row of the price list: what a proof of the recommended gains costs, if there is one."""

from typing import Any

from design.studies.shown.prices import proved_row

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
