"""What a trace says of a rig does not hang on how its log was written."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign

pytestmark = pytest.mark.suite
EXAMPLE = Path("plants/measured/examples/deviation")


def counting_from_1970(table):
    return table.assign(time_s=table.time_s + 1.764e9)


def with_spikes(table):
    rng = np.random.default_rng(len(table))
    for channel, height in (("angle_deg", 20.0), ("pressure_kPa", -80.0)):
        table.loc[rng.choice(len(table), 6, replace=False), channel] += height
    return table


def merged_from_two_rates(table):
    table.loc[table.index % 5 != 0, "angle_deg"] = np.nan
    table.loc[table.index % 4 != 0, "pressure_kPa"] = np.nan
    return table


def with_lost_packets(table):
    return table.drop(index=[*range(700, 712), *range(1500, 1520)])


@pytest.mark.parametrize(
    ("change", "habit"),
    [
        (counting_from_1970, "clock"), (with_spikes, "spikes"), (merged_from_two_rates, "empty"),
        (with_lost_packets, "gaps"),
    ],
)  # fmt: skip
def test_the_same_is_named_and_as_much_is_left(tmp_path, change, habit):
    for path in EXAMPLE.iterdir():
        if path.suffix == ".csv":
            change(pd.read_csv(path)).to_csv(tmp_path / path.name, index=False)
        else:
            (tmp_path / path.name).write_bytes(path.read_bytes())
    trace = trace_campaign(load_campaign(tmp_path))
    assert {r.habit for r in trace.instrument} == {habit}
    assert [e.name for e in trace.effects] == ["periodic-disturbance"]
    assert trace.verdict == "explained"
    assert trace.after["angle_deg"] < 1.2 * trace.noise["angle_deg"]
