"""The small pages of each kind, written once for all tests that look at them, and pages without pictures."""

from pathlib import Path
from typing import Any, NamedTuple

import pytest

from reports.comparison.page import write_comparison
from reports.robustness.page import write_robust
from reports.shared.html import Made
from reports.trace.page import write_trace
from tests.reports.report_samples import small_robustness, small_study, small_trace, whole_study

LONG = " a&b <c> " + "word " * 60 + "x" * 300
"""Arguments of a command that fit no line, with letters that mean something in HTML."""


class Written(NamedTuple):
    """A page, and what made it."""

    path: Path
    made: Made

    @property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")


def _data() -> dict[str, str]:
    return {f.campaign.name: f.campaign.checksum for f in small_study().fits.values()}


@pytest.fixture(scope="session")
def written_comparison(tmp_path_factory) -> Written:
    folder = tmp_path_factory.mktemp("comparison") / "new"
    plants = small_study().plants
    made = Made.now("wrist compare" + LONG, 7, plants, _data(), "The recordings are synthetic.")
    return Written(write_comparison(folder, whole_study(), made), made)


@pytest.fixture(scope="session")
def written_trace(tmp_path_factory) -> Written:
    trace = small_trace()
    c = trace.campaign
    made = Made.now("wrist trace" + LONG, 7, {c.axis: trace.revised}, {c.name: c.checksum})
    return Written(write_trace(tmp_path_factory.mktemp("trace"), trace, made), made)


@pytest.fixture(scope="session")
def written_robust(tmp_path_factory) -> Written:
    study = small_robustness()
    plants = {"flexion": study.assessment.box.plant}
    made = Made.now("wrist robust" + LONG, 7, plants, _data(), "A remark.")
    return Written(write_robust(tmp_path_factory.mktemp("robust"), study, made), made)


@pytest.fixture
def no_pictures(monkeypatch) -> None:
    """Figures are drawn and not rendered, which takes most of a page's time: for tests of its words."""

    def nothing(_figure: Any, into: Any, **_settings: Any) -> None:
        into.write('<svg width="1pt" height="1pt"></svg>')

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", nothing)
