"""A folder that holds logs and no campaign.toml is answered with a draft that loads."""

import tomllib

import numpy as np
import pandas as pd
import pytest

from design.cli.errors import answered
from plants.errors import InputError
from plants.measured.campaign import load_campaign


@pytest.fixture
def logs(tmp_path):
    """Two logs with names of a recorder's own."""
    t = np.arange(300) * 0.02
    for name, phase in (("run1.csv", 0.0), ("run2.csv", 1.0)):
        command, bend = 1000 + 500 * np.sin(t + phase), 30 * np.cos(t)
        frame = {"Timestamp": t, "DAC": command, "P_bar": np.sin(t), "bend": bend}
        pd.DataFrame(frame).to_csv(tmp_path / name, index=False)
    return tmp_path


def test_the_draft_loads_as_it_is(logs):
    with pytest.raises(InputError, match=r"holds no campaign\.toml; correct the draft") as refused:
        load_campaign(logs)
    draft = tomllib.loads(refused.value.draft)
    assert draft["columns"] == {
        "time_s": "Timestamp", "command_V": "DAC", "pressure_kPa": "P_bar", "angle_deg": "bend"
    }  # fmt: skip
    assert draft["sample_time_s"] == pytest.approx(0.02)
    assert (draft["fit"], draft["validate"]) == (["run1.csv"], ["run2.csv"])
    (logs / "campaign.toml").write_text(refused.value.draft)
    campaign = load_campaign(logs)
    assert campaign.fit[0].command.max() == pytest.approx(1500.0, abs=1.0)


def test_the_command_says_it_in_a_line_and_prints_the_draft(logs, capsys):
    assert answered(["fit", str(logs)]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert tomllib.loads(said.out)["start"] == "unknown"


def test_a_folder_without_logs_has_no_draft(tmp_path, capsys):
    assert answered(["fit", str(tmp_path)]) == 2
    assert capsys.readouterr().out == ""
