"""A number that is shown in several places comes from one study: every place is compared with its record.

`NUMBERS` names for each number the study that it is of, and where else it is shown.  README's tables are
compared by `test_readme`, a record with what its command gives by `python -m reports.regenerate --check`.
"""

import html
import json
import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "reports/examples"
MOTIONS = ("flexion", "deviation")
WHOLE = "worst case found"
"""Guarantees of the whole requirement, before any proof."""


def record(study: str) -> Any:
    """What a study says to machines."""
    return json.loads((EXAMPLES / f"{study}.json").read_text(encoding="utf-8"))


def page(study: str) -> str:
    """The text of a study's page, without marks."""
    text = (EXAMPLES / f"{study}.html").read_text(encoding="utf-8")
    text = re.sub(r"<(svg|script|style)\b.*?</\1>", " ", text, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", text)).split())


def text(name: str) -> str:
    """A file of words of the project."""
    return " ".join((ROOT / name).read_text(encoding="utf-8").split())


def read(where: str, pattern: str) -> list[float]:
    """The groups of a pattern in a text as numbers; the pattern has to be there."""
    found = re.search(pattern, where)
    assert found is not None, pattern
    return [float(g.replace(",", "")) for g in found.groups()]


def standing(motion: str) -> Any:
    """The row of the recommended PI in the comparison."""
    (row,) = [
        s for s in record("comparison")["standings"] if s["motion"] == motion and s["controller"] == "tuned"
    ]
    return row


def limit(study: str, motion: str, name: str) -> Any:
    """A row of the card's matrix."""
    at = record(study)
    rows = at["limits"][motion] if study == "design" else at["decisions"][motion]["limits"]
    (row,) = [r for r in rows if r["limit"] == name]
    return row


def price(motion: str, controller: str) -> list[float]:
    """Worst IAE, slowest settling and ratio to the bound of a row of the design's prices."""
    row = next(
        r for r in record("design")["prices"]
        if (r["motion"], r["controller"]) == (motion, controller) and r["guarantee"] == WHOLE
    )  # fmt: skip
    return [row["worst_iae_deg_s"], row["worst_settling_s"], row["ratio_to_bound"]]


def recommended(motion: str) -> Any:
    """What the design recommends for a motion."""
    return record("design")["recommended"][motion]


def gains(motion: str) -> list[float]:
    """Kp, Ki and the reference weight that the design recommends."""
    g = recommended(motion)["gains"]
    return [g["Kp"], g["Ki"], g["b"]]


def of_file(motion: str) -> list[float]:
    """The same from the file that other commands read."""
    found = tomllib.loads((EXAMPLES / f"gains-{motion}.toml").read_text(encoding="utf-8"))["gains"]
    return [found[n]["value"] for n in ("Kp", "Ki", "b")]


def on_card(study: str, motion: str) -> list[float]:
    """The same from the card of a page."""
    return read(page(study), rf"{motion} 2-DOF PI ([\d.]+) ([\d.]+) ([\d.]+)")


@dataclass(frozen=True)
class Number:
    """A number by its name, the study that it is of with its value there, and the places that show it."""

    name: str
    study: str
    value: Callable[[], list[float]]
    shown: tuple[tuple[str, Callable[[], list[float]]], ...]
    relative: float = 0.006


def _of(motion: str) -> tuple[Number, ...]:
    beyond, readme = "docs/beyond-a-pi.md", "README.md"
    row = rf"\| {motion} \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| proved, ([\d.]+) 1/s"
    known = (
        Number(
            f"gains, {motion}",
            "design",
            lambda: gains(motion),
            (
                ("the file of the gains", lambda: of_file(motion)),
                ("README", lambda: read(text(readme), row)[:3]),
                ("the design's page", lambda: on_card("design", motion)),
                ("the comparison's page", lambda: on_card("comparison", motion)),
                (
                    "the comparison's record",
                    lambda: [record("comparison")["tunings"][motion][n] for n in ("Kp", "Ki", "b")],
                ),
                (
                    "the comparison's table",
                    lambda: [standing(motion)[n] for n in ("Kp", "Ki")] + [gains(motion)[2]],
                ),
            ),
        ),
        Number(
            f"worst IAE and rate of the proof, {motion}",
            "design",
            lambda: [
                recommended(motion)["evidence"]["samples"]["worst_iae_deg_s"],
                recommended(motion)["evidence"]["proved"]["rate_1_s"],
            ],
            (("README", lambda: read(text(readme), row)[3:]),),
        ),
        Number(
            f"steps on the plant as fitted, {motion}",
            "design",
            lambda: [
                limit("design", motion, n)["values"]["every branch and memory"]
                for n in ("settling_time_s", "overshoot_percent", "Ms", "delay_margin_s")
            ],
            (
                (
                    "the comparison's table",
                    lambda: [
                        standing(motion)[n]
                        for n in ("worst_settling_s", "worst_overshoot_percent", "Ms", "delay_margin_s")
                    ],
                ),
            ),
            0.02,
        ),
        Number(
            f"every limit under every condition, {motion}",
            "design",
            lambda: [
                v for r in record("design")["limits"][motion] for v in r["values"].values() if v is not None
            ],
            (
                (
                    "the comparison's card",
                    lambda: [
                        v
                        for r in record("comparison")["decisions"][motion]["limits"]
                        for v in r["values"].values()
                        if v is not None
                    ],
                ),
            ),
        ),
        Number(
            f"the price of the recommended PI, {motion}",
            "design",
            lambda: price(motion, "2-DOF PI"),
            (
                (
                    "the guide beyond a PI",
                    lambda: read(
                        text(beyond),
                        rf"{motion}, recommended PI with two degrees of freedom \| ([\d.]+) deg s \| "
                        r"([\d.]+) s \| ([\d.]+)",
                    ),
                ),
            ),
        ),
    )
    return known + tuple(
        Number(
            f"the price of a {name}, {motion}",
            "design",
            lambda name=name: price(motion, name),
            (
                (
                    "the guide beyond a PI",
                    lambda name=name: read(
                        text(beyond),
                        rf"{motion}, {re.escape(name)}[^|]*\| ([\d.]+) deg s \| ([\d.]+) s \| ([\d.]+)",
                    ),
                ),
            ),
        )
        for name in ("PI + feedforward", "cascade PI", "robust LQI", "robust MPC")
    )


NUMBERS = (
    *_of("flexion"),
    *_of("deviation"),
    Number(
        "samples and search runs of both motions",
        "design",
        lambda: [
            sum(recommended(m)["evidence"][k][n] for m in MOTIONS)
            for k, n in (("samples", "total"), ("worst_case", "runs"))
        ],
        (
            (
                "README, of one motion",
                lambda: [
                    2 * v
                    for v in read(
                        text("README.md"), r"[Nn]one of ([\d,]+) samples.*none of ([\d,]+) search runs"
                    )
                ],
            ),
            (
                "the design's page",
                lambda: read(page("design"), r"in (\d+) fresh samples and in (\d+) runs of a search"),
            ),
            (
                "the comparison's page",
                lambda: read(page("comparison"), r"in (\d+) samples and (\d+) search runs"),
            ),
        ),
    ),
    Number(
        "error of the fitted model, and the noise",
        "design",
        lambda: [record("design")["trace"]["flexion"][k]["angle_deg"] for k in ("after", "noise")],
        (("README", lambda: read(text("README.md"), r"([\d.]+) deg; the sensor's noise is ([\d.]+) deg")),),
    ),
    Number(
        "RMSE after and before the trace, and the noise",
        "trace",
        lambda: [
            record("trace")[a][b]
            for a, b in (
                ("after", "angle_rmse_deg"),
                ("before", "angle_rmse_deg"),
                ("noise_floor", "angle_deg"),
            )
        ],
        (
            (
                "README",
                lambda: read(
                    text("README.md"), r"([\d.]+) deg, from ([\d.]+) deg; the noise is ([\d.]+) deg"
                ),
            ),
            (
                "the trace's page",
                lambda: [
                    read(page("trace"), r"falls from ([\d.]+) to ([\d.]+) deg, noise ([\d.]+) deg")[i]
                    for i in (1, 0, 2)
                ],
            ),
            (
                "the design's record",
                lambda: [
                    record("design")["trace"]["deviation"][k]["angle_deg"]
                    for k in ("after", "before", "noise")
                ],
            ),
        ),
    ),
    Number(
        "gains of the robustness",
        "design",
        lambda: gains("flexion"),
        (
            ("its record", lambda: [record("robust")[n] for n in ("Kp", "Ki", "b")]),
            ("its page", lambda: on_card("robust", "flexion")),
        ),
    ),
    Number(
        "Ms of the worst branch",
        "robust",
        lambda: [max(m["Ms"] for m in record("robust")["margins"])],
        (
            ("its page", lambda: read(page("robust"), r"Ms is ([\d.]+) \(limit")),
            (
                "the design's card",
                lambda: [limit("design", "flexion", "Ms")["values"]["every branch and memory"]],
            ),
        ),
    ),
    Number(
        "rate of the proof",
        "design",
        lambda: [recommended("flexion")["evidence"]["proved"]["rate_1_s"]],
        (
            ("the robust page", lambda: read(page("robust"), r"rate at least ([\d.]+) 1/s, for tasks")),
            (
                "its record",
                lambda: [
                    min(
                        c["value"]
                        for c in record("robust")["certificates"]
                        if c["statement"].startswith("steps of 15 deg")
                    )
                ],
            ),
        ),
        0.02,
    ),
)


@pytest.mark.parametrize("of", NUMBERS, ids=lambda n: n.name)
def test_a_number_is_that_of_its_study_wherever_it_is_shown(of):
    true = of.value()
    assert true
    for place, shown in of.shown:
        found = shown()
        said = f"{of.name}, of the study {of.study}, in {place}"
        assert found == pytest.approx(true, rel=of.relative, abs=0.0006), said


def test_the_plants_of_all_pages_are_those_of_the_design():
    for study in ("comparison", "robust"):
        plants = record(study)["plants"] if study == "comparison" else {"flexion": {}}
        for motion in plants:
            title = tomllib.loads((EXAMPLES / f"plant-{motion}.toml").read_text(encoding="utf-8"))["title"]
            assert title in page(study)
            assert title in page("design")
