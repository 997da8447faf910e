"""Rows that a channel lacks: empty cells, spikes, lost packets, a clock that counts from elsewhere."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.missing import spikes
from tests.rig.soft.commands import stairs
from tests.rig.soft.named import arm_b


@pytest.fixture
def spoiled(folder, tmp_path):
    """The campaign with each of its recordings changed."""

    def make(change):
        for path in folder.iterdir():
            table = change(pd.read_csv(path)) if path.suffix == ".csv" else None
            if table is None:
                (tmp_path / path.name).write_bytes(path.read_bytes())
            else:
                table.to_csv(tmp_path / path.name, index=False)
        return load_campaign(tmp_path)

    return make


def said(campaign, habit):
    return [r for r in corrected(campaign)[1] if r.habit == habit]


@pytest.mark.parametrize("start", [1.764e9, -3.6e4])
def test_a_clock_that_counts_from_elsewhere_starts_at_zero(spoiled, folder, start):
    campaign = spoiled(lambda t: t.assign(time_s=t.time_s + start))
    for r, plain in zip(campaign.fit, load_campaign(folder).fit, strict=True):
        np.testing.assert_allclose(r.time, plain.time, atol=1e-6)
    (remark,) = said(campaign, "clock")
    assert str(remark).startswith(f"The clock starts at {start:.10g} s (4 recordings)")


@pytest.mark.slow
def test_a_recording_that_was_cut_keeps_its_time(spoiled):
    campaign = spoiled(lambda t: t.iloc[len(t) // 5 :])
    assert all(r.time[0] > 10.0 for r in campaign.fit)
    assert not said(campaign, "clock")


def test_of_channels_that_were_merged_only_filled_cells_count(spoiled, folder):
    def merged(table):
        table.loc[table.index % 4 != 0, "pressure_kPa"] = np.nan
        table.loc[table.index % 50 == 7, "angle_deg"] = np.nan
        return table

    campaign = spoiled(merged)
    for r, plain in zip(campaign.fit, load_campaign(folder).fit, strict=True):
        assert r.held("pressure_kPa")
        assert not r.held("angle_deg")
        there = r.fresh("pressure_kPa")
        assert there.mean() == pytest.approx(0.25, abs=0.01)
        np.testing.assert_array_equal(r.pressure[there], plain.pressure[there])
        lines = np.interp(r.time, r.time[there], plain.pressure[there])
        np.testing.assert_allclose(r.pressure, lines)
    (remark,) = said(campaign, "empty")
    cells = sum(int((~v).sum()) for r in (*campaign.fit, *campaign.validate) for v in r.renewed.values())
    assert remark.value == cells > 1000


@pytest.mark.parametrize("column", ["time_s", "command_V"])
def test_what_was_commanded_and_when_may_not_be_missing(spoiled, column):
    def lacking(table):
        table.loc[77, column] = np.nan
        return table

    with pytest.raises(InputError, match=rf"row 79, column '{column}': the cell is empty"):
        spoiled(lacking)


def test_a_channel_that_is_nearly_empty_is_refused(spoiled):
    def empty(table):
        table.loc[table.index > 10, "angle_deg"] = np.nan
        return table

    with pytest.raises(InputError, match="column 'angle_deg': the cell is empty"):
        spoiled(empty)


def test_lost_packets_are_bridged_and_long_gaps_refused(spoiled, folder):
    campaign = spoiled(lambda t: t.drop(index=[*range(200, 215), *range(900, 905)]))
    plain = load_campaign(folder)
    assert all(len(r.time) == len(p.time) - 20 for r, p in zip(campaign.fit, plain.fit, strict=True))
    (remark,) = said(campaign, "gaps")
    assert remark.value == 8
    with pytest.raises(InputError, match="split the recording there"):
        spoiled(lambda t: t.drop(index=range(200, 230)))


@pytest.mark.slow
def test_spikes_are_left_out_wherever_they_stand(spoiled, folder):
    rows = {0: -40.0, 100: 50.0, 101: 49.0, 640: -30.0, 1500: 20.0}

    def bad(table):
        for row, height in (rows | {len(table) - 1: 30.0}).items():
            table.loc[row, "angle_deg"] += height
        return table

    campaign, plain = spoiled(bad), load_campaign(folder)
    (remark,) = said(campaign, "spikes")
    assert remark.value == 4 * 6
    mended = corrected(campaign)[0]
    for r, p in zip(mended.fit, corrected(plain)[0].fit, strict=True):
        assert np.flatnonzero(~r.fresh("angle_deg")).tolist() == [*rows, len(r.time) - 1]
        there = r.fresh("angle_deg")
        assert np.max(np.abs(r.angle[there] - p.angle[there])) < 0.2


def test_what_moves_fast_is_no_spike():
    time = np.arange(4000) * 0.01
    rng = np.random.default_rng(3)
    noise = 0.1 * rng.standard_normal(4000)
    jumps = np.repeat(rng.random(400) < 0.05, 10) * 20.0  # slips to and fro
    for series in (
        noise, jumps + noise, 10.0 * np.sign(np.sin(2.0 * np.pi * 12.0 * time)), np.round(noise, 1),
        10.0 * np.sin(2.0 * np.pi * 20.0 * time), np.zeros(4000), np.where(time > 20.0, 30.0, 0.0) + noise,
    ):  # fmt: skip
        assert not spikes(series).any()


def test_the_resolution_of_a_sensor_is_that_of_its_own_rows(tmp_path):
    """Straight lines between its values make steps that the sensor does not have."""
    from plants.measured.guess.rig import guessed_rig

    rig = arm_b()
    rig = replace(rig, commands=rig.commands | {"check": lambda: stairs([0, 8, 4, 9, 0], 5.0)})
    rig.write(tmp_path, ("stairs",), ("check",))
    table = pd.read_csv(tmp_path / "stairs.csv")
    table.loc[table.index % 3 == 1, "angle_deg"] = np.nan
    table.to_csv(tmp_path / "stairs.csv", index=False)
    campaign = load_campaign(tmp_path)
    assert isinstance(campaign.fit[0], Recording)
    assert guessed_rig(campaign).uncertainty.resolution == pytest.approx(0.05)
