"""Bad campaigns are refused in one line: the file, the key, and what to do."""

from pathlib import Path

import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign

DECLARATION = 'axis = "flexion"\nsample_time_s = 0.01\nfit = ["steps.csv"]\nvalidate = ["sine.csv"]\n'


def refusal(folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_missing_folder(tmp_path: Path):
    folder = tmp_path / "none"
    assert refusal(folder) == f"{folder}: no such folder; give the folder of a campaign"


def test_a_folder_without_declaration(tmp_path: Path):
    said = refusal(tmp_path)
    assert said == f"{tmp_path}: holds no campaign.toml; write one that names axis, fit and validate"


def test_a_file_in_place_of_a_folder(campaign):
    path = campaign() / "campaign.toml"
    assert refusal(path).startswith(f"{path}: is a file; ")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('axis = "flexion"', "axis = flexion", "not valid TOML ("),
        ('axis = "flexion"', "", "axis is missing; "),
        ('axis = "flexion"', "axis = 1", "axis is missing; "),
        (
            'axis = "flexion"',
            'axis = "flexion"\nsampletime = 1',
            "unknown key 'sampletime'; known are axis, ",
        ),
        ("sample_time_s = 0.01", "", "sample_time_s is missing; "),
        ("sample_time_s = 0.01", 'sample_time_s = "0.01"', "sample_time_s '0.01' is not a positive number; "),
        ("sample_time_s = 0.01", "sample_time_s = -1", "sample_time_s -1 is not a positive number; "),
        ("sample_time_s = 0.01", "sample_time_s = nan", "sample_time_s nan is not a positive number; "),
        ("sample_time_s = 0.01", "sample_time_s = true", "sample_time_s True is not a positive number; "),
        ('fit = ["steps.csv"]', "", "fit is missing; list at least one recording: "),
        ('fit = ["steps.csv"]', "fit = []", "fit is empty; list at least one recording: "),
        ('fit = ["steps.csv"]', 'fit = "steps.csv"', "fit must be a list of file names such as "),
        (
            'fit = ["steps.csv"]\nvalidate = ["sine.csv"]',
            'fit = ["steps.csv", "sine.csv"]\nvalidate = []',
            "validate is empty; list at least one recording: the error is reported on held-out recordings",
        ),
        (
            'fit = ["steps.csv"]\nvalidate = ["sine.csv"]',
            'fit = ["steps.csv", "sine.csv"]',
            "validate is missing; list at least one recording: the error is reported",
        ),
        ('["sine.csv"]', '["./steps.csv"]', "'steps.csv' is in both fit and validate; "),
        ('["sine.csv"]', '["sine.csv", "sine.csv"]', "'sine.csv' is listed twice in validate; "),
        ('axis = "flexion"', 'axis = "flexion"\nstage = "hand"', "stage 'hand' is unknown; it is "),
        ('axis = "flexion"', 'axis = "flexion"\nstart = "warm"', "start 'warm' is unknown; it is "),
        ('["sine.csv"]', '["sine.csv"]\n[columns]\nspeed = "v"', "unknown column 'speed' in [columns]; "),
        ('["sine.csv"]', '["sine.csv"]\ncolumns = 1', "columns must be a table such as "),
    ],
)
def test_a_declaration_that_is_wrong(campaign, old, new, said):
    assert old in DECLARATION
    folder = campaign(DECLARATION.replace(old, new))
    message = refusal(folder)
    assert message.startswith(f"{folder / 'campaign.toml'}: {said}")


def test_a_recording_that_the_folder_does_not_hold(campaign):
    folder = campaign(DECLARATION.replace("sine.csv", "task.csv"))
    assert refusal(folder).startswith(f"{folder / 'task.csv'}: no such file; ")


def test_an_optional_column_that_no_recording_has_was_mistyped(campaign):
    folder = campaign(DECLARATION + '[columns]\nreference_deg = "rfe"\n')
    said = refusal(folder)
    assert said.startswith(
        f"{folder / 'steps.csv'}: no column 'rfe', to which [columns] maps reference_deg; "
    )


def test_a_bad_recording_of_a_campaign_is_named(campaign, write_csv):
    folder = campaign()
    path = write_csv("sine.csv", rows=[["0.00", "2", "0", "100"], ["0.01", "2", "?", "100"]])
    assert refusal(folder).startswith(f"{path}: row 3, column 'angle_deg': '?' is not a number; ")
