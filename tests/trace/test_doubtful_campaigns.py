"""Campaigns that would mislead a trace: a clear error, or a verdict that claims no more than it can."""

import shutil
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from plants.errors import InputError, InputWarning
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.trace.suspect import check
from plants.measured.trace.trace import trace_campaign
from plants.parameters.files import built_in
from tests.rig.campaign import make_campaign
from tests.rig.soft.named import climber
from tests.trace.traces import NOTHING, trace_folder


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> Path:
    """A short campaign with nothing missing, to be spoiled."""
    folder = tmp_path_factory.mktemp("plain") / "c"
    make_campaign(folder, "flexion", [], seed=51, short=True)
    return folder


@pytest.fixture
def spoiled(plain, tmp_path):
    """A copy, and a function that changes one of its recordings."""
    folder = tmp_path / "c"
    shutil.copytree(plain, folder)

    def change(name: str, how) -> Path:
        table = pd.read_csv(folder / name)
        how(table).to_csv(folder / name, index=False)
        return folder

    return change


def test_a_clipped_sensor_of_the_pressure_is_refused(spoiled):
    """The measured pressure is what drives the joint."""
    folder = spoiled("steps.csv", lambda t: t.assign(pressure_kPa=t.pressure_kPa.clip(upper=150.0)))
    with pytest.raises(
        InputError, match=r"steps.csv: column 'pressure_kPa': stays at exactly 150.*is clipped"
    ):
        trace_folder(folder)


@pytest.mark.slow
def test_a_clipped_sensor_of_the_angle_lacks_no_effect(spoiled):
    found = trace_folder(spoiled("steps.csv", lambda t: t.assign(angle_deg=t.angle_deg.clip(lower=-6.0))))
    assert [(r.habit, r.value, r.recordings) for r in found.instrument] == [("clipped", -6.0, ("steps.csv",))]
    assert (found.verdict, found.effects) == (NOTHING, ())
    assert found.after["angle_deg"] < 1.1 * found.noise["angle_deg"]


def test_a_coarse_channel_that_is_held_is_not_clipped(tmp_path):
    """Three equal renewals at the top of a sine are 120 rows."""
    rig = climber()
    logger = replace(rig.logger, pressure_step=0.5)
    replace(rig, logger=logger).write(tmp_path / "held", ("wave",), ("check",))
    campaign, remarks = corrected(load_campaign(tmp_path / "held"))
    pressure = pd.read_csv(tmp_path / "held" / "wave.csv").pressure_kPa
    assert (pressure == pressure.max()).sum() >= 80
    assert {(r.habit, r.channel, len(r.recordings)) for r in remarks} >= {("held", "pressure_kPa", 2)}
    check(campaign)


def test_a_gap_inside_a_recording_is_refused(spoiled):
    folder = spoiled("steps.csv", lambda t: t.drop(index=range(300, 360)))
    with pytest.raises(InputError, match=r"gap of .* split the recording there"):
        trace_folder(folder)


def test_the_same_rows_in_fit_and_validate_are_refused(spoiled, plain):
    folder = spoiled("sine.csv", lambda t: pd.read_csv(plain / "steps.csv"))
    with pytest.raises(InputError, match=r"holds the same rows as"):
        load_campaign(folder)


def test_a_command_that_never_moves_is_refused(spoiled):
    for name in ("staircase.csv", "steps.csv", "small.csv"):
        folder = spoiled(name, lambda t: t.assign(command_V=2.0))
    with pytest.raises(InputError, match="never moves"):
        trace_folder(folder)


def test_an_angle_that_never_moves_is_refused(spoiled):
    for name in ("staircase.csv", "steps.csv", "small.csv", "sine.csv"):
        folder = spoiled(name, lambda t: t.assign(angle_deg=3.0))
    with pytest.raises(InputError, match="angle"):
        trace_folder(folder)


def test_a_single_recording_is_split_and_said_so(spoiled):
    folder = spoiled("steps.csv", lambda t: t)
    (folder / "campaign.toml").write_text('axis = "flexion"\nsample_time_s = 0.01\nfit = ["steps.csv"]\n')
    with pytest.warns(InputWarning, match="only one recording"):
        campaign = load_campaign(folder)
    (whole,), (part,) = campaign.validate, campaign.fit
    assert part.time[-1] < whole.judged_from <= part.time[-1] + 0.011
    assert trace_campaign(campaign, built_in("flexion")).verdict == "nothing-missing"


def test_a_few_seconds_cannot_tell_slow_effects(spoiled, plain):
    for name in ("staircase.csv", "steps.csv", "small.csv"):
        folder = spoiled(name, lambda t: t.iloc[:400])
    trace = trace_folder(folder)
    assert trace.verdict != "explained"
    assert any("slow effects cannot show" in r for r in trace.remarks)
    assert trace.cannot_judge


@pytest.mark.suite
def test_two_rigs_in_one_campaign_are_not_explained_by_an_effect(tmp_path):
    for seed, name in ((52, "a"), (57, "b")):
        make_campaign(tmp_path / name, "flexion", [], seed=seed)
    shutil.copy(tmp_path / "b" / "steps.csv", tmp_path / "a" / "steps.csv")
    trace = trace_folder(tmp_path / "a")
    assert trace.verdict == "unexplained"
    assert any("two rigs" in r for r in trace.remarks)
