"""`wrist trace OLD NEW`: a rig that did not change says so, and what changed is named with its size.

The rigs are the tests' own, in campaigns of 66 s; the later one has other commands and other noise.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

import plants.measured.trace.trace as tracing
from design.studies.check.campaigns import campaign_change
from plants.measured.campaigns.campaign import load_campaign, shipped
from plants.measured.trace.change.two_steps import sensitivity
from plants.measured.trace.declared import driven
from plants.measured.trace.search.candidate import Candidate
from reports.shared.html import Made
from reports.trace.change.page import draw_differences, write_change
from reports.trace.change.words import summary, title
from tests.change.pairs import SIZES, worn, write
from tests.reports.html_page import Page, summary_of
from tests.reports.legible import faults
from tests.rig.campaign import make_rig
from tests.rig.effects import Hidden
from tests.trace.traces import trace_folder


class Pairs:
    """A rig, its traced campaign, and later ones of the rig worn in some way."""

    def __init__(self, root, effects, variants):
        self.root, self.rig = root, make_rig("flexion", effects, 3, variants)
        self.folder = write(self.rig, root / "old", short=True)
        self.old = trace_folder(self.folder)

    def later(self, name, rig):
        return write(rig, self.root / name, later=True, short=True)

    def change(self, name, rig):
        return campaign_change(self.old, load_campaign(self.later(name, rig)))


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A rig as declared."""
    return Pairs(tmp_path_factory.mktemp("plain"), [], {})


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """A rig with a dead time."""
    return Pairs(tmp_path_factory.mktemp("late"), ["dead-time"], {"dead-time": 1})


@pytest.mark.suite
def test_a_rig_that_did_not_change_says_so(wrist, plain, late, monkeypatch):
    found = late.change("same", late.rig)
    assert (found.verdict, found.kept, found.came, found.went) == ("unchanged", ("dead-time",), (), ())
    softer = replace(found.parameters[0], name="a1", old=0.4, new=0.36, low=-0.05, high=-0.03, rise=9.0)
    hidden = replace(found, parameters=(softer, *found.parameters[1:]))
    assert title(hidden).startswith("No change beyond the residual between")
    assert title(hidden).endswith("yet parameters differ: a1 −10 %")
    assert "Trace" in summary(hidden)[-1]
    assert "lie within" in summary(replace(found, parameters=()))[1]
    unexplained = replace(found, old=replace(found.old, verdict="unexplained"), parameters=())
    assert title(unexplained).startswith("No change is seen between")
    assert re.search(r"hides changes of less than [\d.]+ deg and [\d.]+ kPa$", title(unexplained))
    monkeypatch.setattr(tracing, "trace_campaign", lambda *given: plain.old)
    same = plain.later("same", plain.rig)
    outcome = wrist("trace", plain.folder, same, "--json", "-")
    assert outcome.code == 0, outcome.err
    assert outcome.json["verdict"] == "unchanged"
    assert outcome.json["words"].startswith("Nothing changed")
    assert set(outcome.json) == {
        "axis", "old", "new", "verdict", "words", "confidence", "parameters", "undetermined", "effects",
        "unexplained", "recordings", "instrument",
    }  # fmt: skip


@pytest.mark.suite
def test_a_slope_that_softens_is_told_with_its_size(plain, tmp_path):
    found = plain.change("slope", worn(plain.rig, "slope"))
    told = {p.name: p for p in found.parameters if p.differs}
    assert set(told) == {"a1", "a2", "s"}
    assert (found.came, found.went, found.unexplained) == ((), (), ())
    for name, p in told.items():
        assert p.difference == pytest.approx(-SIZES["slope"] * getattr(plain.rig.declared, name), rel=0.02)
    page = write_change(tmp_path, found, Made.now(command="wrist trace old new", seed=0, sets={})).read_text()
    assert "a1 −12 %" in Page(page).text
    assert len(summary_of(page)) == 3
    assert faults(draw_differences(found)) == []
    for name in ("change.json", "differences.png", "residual.png"):
        assert (tmp_path / name).stat().st_size > 500


@pytest.mark.suite
def test_a_leak_that_opens_comes(plain):
    found = plain.change("leak", worn(plain.rig, "leak"))
    (came,) = found.came
    assert came.name == "leak"
    assert came.parameters["rate"][0] == pytest.approx(SIZES["leak"], rel=0.1)
    assert not any(p.differs for p in found.parameters)
    assert found.unexplained == ()


@pytest.mark.suite
def test_a_tube_that_was_long_is_told_longer_and_one_that_is_gone_goes(late):
    longer = late.change("longer", worn(late.rig, "tube", 0.03))
    (p,) = [p for p in longer.parameters if p.differs]
    assert p.name == "dead-time.delay"
    assert p.difference == pytest.approx(0.03, rel=0.02)
    assert p.low < 0.03 < p.high
    gone = late.change("gone", replace(late.rig, hidden=Hidden()))
    assert gone.went == ("dead-time",)
    assert not any(p.differs for p in gone.parameters)


@pytest.mark.suite
def test_what_a_wrong_regulator_does_to_the_wrist_is_foreseen(plain):
    """The linear prediction of what standard errors pass on, against a fit under another pressure."""
    regulator, wrist = (s.model for s in plain.old.stages)
    by = 2e-4 * regulator.values["gain"]
    other = regulator.with_values({"gain": regulator.values["gain"] + by})
    moved = driven(wrist.with_values({"gain": other.values["gain"]}), Candidate(other)).fitted()
    foreseen = by * sensitivity(wrist, regulator)[:, regulator.names.index("gain")]
    slopes = [wrist.names.index(n) for n in ("a1", "a2")]
    assert np.allclose((moved.vector - wrist.fitted().vector)[slopes], foreseen[slopes], rtol=0.2)


@pytest.mark.slow
def test_what_cannot_be_compared_is_told_in_a_line(wrist, tmp_path):
    old, other = shipped()[::-1]
    cases = {
        "give two campaigns of one motion": (old, other),
        "give a later campaign": (old, old),
        "--save: is of one campaign": (old, other, "--save", tmp_path / "revised.toml"),
        "--retune: is of one campaign": (old, other, "--retune"),
    }
    for words, arguments in cases.items():
        outcome = wrist("trace", *arguments)
        assert outcome.code == 2
        assert outcome.err.count("\n") == 1
        assert words in outcome.err
