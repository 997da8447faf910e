"""What an import decides: which channel is what, where a log is cut, what is held out, what it refuses."""

import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.formats.channel import LoggedChannel
from plants.measured.formats.units import factor
from plants.measured.importing.importing import import_logs, write_campaign
from plants.measured.importing.roles import roles
from plants.toml import parse_toml

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"
STEPS, SINE, TASK = (load_recording(EXAMPLE / f"{n}.csv") for n in ("steps", "sine", "task"))


def csv(path: Path, columns: dict[str, np.ndarray]) -> Path:
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def imported(files, out, **options):
    made = import_logs(files, options.pop("given", {}), **options)
    write_campaign(made, "flexion", out)
    return made, tomllib.loads((out / "campaign.toml").read_text())


@pytest.mark.slow
def test_channels_without_names_and_units_are_told_by_what_leads(tmp_path):
    log = csv(
        tmp_path / "log.csv",
        {"time": STEPS.time, "ai2": STEPS.angle, "ai0": STEPS.command, "ai1": STEPS.pressure},
    )
    found = import_logs([log], {}).roles
    assert (found["command"].channel, found["angle"].channel) == ("ai0", "ai2")
    assert "leads the angle" in found["command"].why
    in_order = csv(
        tmp_path / "order.csv",
        {"time": STEPS.time, "ch1": STEPS.command, "ch2": STEPS.pressure, "ch3": STEPS.angle},
    )
    found = import_logs([in_order], {}).roles
    assert {r: f.channel for r, f in found.items()} == {"command": "ch1", "pressure": "ch2", "angle": "ch3"}
    assert "leads the angle" in found["pressure"].why


def test_what_names_say_against_the_data_is_told(tmp_path):
    exchanged = csv(
        tmp_path / "log.csv",
        {"time": STEPS.time, "u": STEPS.pressure, "p": STEPS.command, "theta": STEPS.angle},
    )
    found = import_logs([exchanged], {}).roles
    assert "follows the pressure" in found["command"].why
    assert '--map "command=u [mV]"' in found["command"].why  # far more than any command in V
    usual = {"time": STEPS.time, "u": STEPS.command, "p": STEPS.pressure, "theta": STEPS.angle}
    why = import_logs([csv(tmp_path / "usual.csv", usual)], {}).roles["command"].why
    assert "exchanged" not in why
    assert "mV" not in why


@pytest.mark.slow
def test_logs_with_a_renamed_column_in_another_unit_or_without_a_pressure_come_together(tmp_path):
    whole = {"time": STEPS.time, "u": STEPS.command, "p [kPa]": STEPS.pressure, "theta [deg]": STEPS.angle}
    renamed = {
        "time": SINE.time, "u": SINE.command, "p [kPa]": SINE.pressure, "pot [rad]": np.radians(SINE.angle)
    }  # fmt: skip
    bare = {"time": TASK.time, "u": TASK.command, "theta [deg]": TASK.angle}
    files = [csv(tmp_path / f"{n}.csv", t) for n, t in (("a", whole), ("b", renamed), ("c", bare))]
    made, _ = imported(files, tmp_path / "out")
    assert any("pot is taken for theta" in note for log in made.logs for note in log.notes)
    campaign = load_campaign(tmp_path / "out")
    logged = {r.name: r for r in (*campaign.fit, *campaign.validate)}
    assert logged["b.csv"].angle == pytest.approx(SINE.angle, abs=1e-6)
    assert logged["c.csv"].pressure is None
    assert logged["c.csv"].angle == pytest.approx(TASK.angle)


def test_a_log_in_which_the_angle_cannot_be_told_is_refused(tmp_path):
    whole = csv(
        tmp_path / "a.csv",
        {"time": STEPS.time, "u": STEPS.command, "p": STEPS.pressure, "theta": STEPS.angle},
    )
    without = csv(tmp_path / "b.csv", {"time": SINE.time, "u": SINE.command, "p": SINE.pressure})
    with pytest.raises(InputError, match=r"has no channel 'theta', which .*a\.csv has, and none that can"):
        import_logs([whole, without], {})


def test_a_file_of_the_angle_alone_is_to_be_put_beside_its_command(tmp_path):
    """It cannot be imported apart: nothing in it is a command."""
    pressure = csv(tmp_path / "press.csv", {"time": STEPS.time, "u": STEPS.command, "p": STEPS.pressure})
    camera = csv(tmp_path / "cam.csv", {"frame_time_s": STEPS.time, "angle_deg": STEPS.angle})
    with pytest.raises(
        InputError, match=r"cam\.csv: has no channel .* side by side into one file"
    ) as refused:
        import_logs([pressure, camera], {})
    assert "apart" not in str(refused.value)
    whole = {"time": STEPS.time, "u": STEPS.command, "p": STEPS.pressure, "theta": STEPS.angle}
    regulator = {"time": SINE.time, "u": SINE.command, "p": SINE.pressure}
    files = [csv(tmp_path / "a.csv", whole), csv(tmp_path / "b.csv", regulator)]
    with pytest.raises(InputError, match="import it apart"):
        import_logs(files, {})


def test_names_of_other_languages_and_of_textbooks_are_known(tmp_path):
    log = csv(
        tmp_path / "log.csv",
        {
            "Zeit": STEPS.time, "w": np.round(STEPS.angle, 0), "Stellgroesse": STEPS.command,
            "Druck": STEPS.pressure, "Winkel": STEPS.angle,
        },
    )  # fmt: skip
    found = import_logs([log], {}).roles
    assert {r: f.channel for r, f in found.items()} == {
        "reference": "w", "command": "Stellgroesse", "pressure": "Druck", "angle": "Winkel",
    }  # fmt: skip


def test_of_two_angles_the_reference_is_that_which_leads_and_has_no_noise():
    channels = [LoggedChannel(n, u, TASK.time, v) for n, u, v in (
        ("a", "deg", TASK.angle), ("b", "deg", TASK.reference), ("c", "V", TASK.command))]  # fmt: skip
    found = roles(channels, {})
    assert (found["angle"].channel, found["reference"].channel, found["command"].channel) == ("a", "b", "c")


def test_a_map_is_obeyed_with_its_unit_and_a_wrong_one_refused(tmp_path):
    log = csv(
        tmp_path / "log.csv",
        {"time": STEPS.time, "angle": STEPS.angle, "u": STEPS.command, "x": STEPS.pressure * 10},
    )
    _, told = imported([log], tmp_path / "c", given={"pressure": ("x", "mbar")})
    assert told["columns"]["pressure_kPa"] == {"name": "x", "scale": 0.1}
    for given, said in (
        ({"pressure": ("y", "")}, "no such channel"),
        ({"pressure": ("x", "mm")}, "none of pressure"),
    ):
        with pytest.raises(InputError, match=said):
            import_logs([log], given)


@pytest.mark.parametrize(
    ("unit", "role", "expected"),
    [("psi", "pressure", 6.894757293168), ("mbar", "pressure", 0.1), ("MPa", "pressure", 1000.0),
     ("rad", "angle", 180.0 / np.pi), ("mV", "command", 1e-3), ("us", "time", 1e-6)],
)  # fmt: skip
def test_units_are_those_of_the_international_system(unit, role, expected):
    assert factor(unit, role, "log") == pytest.approx(expected, rel=1e-11)


def test_a_log_is_cut_where_the_command_comes_home_and_at_gaps_and_not_within_a_staircase(tmp_path):
    stairs = load_recording(EXAMPLE / "staircase.csv")
    assert len(import_logs([EXAMPLE / "staircase.csv"], {}).runs) == 1
    still = np.full(800, stairs.command[0])
    command = np.concatenate([stairs.command, still, stairs.command])
    angle = np.concatenate([stairs.angle, np.full(800, stairs.angle[-1]), stairs.angle])
    time = 0.01 * np.arange(len(command))
    time[-2000:] += 5.0  # the logger stood still
    made = import_logs([csv(tmp_path / "log.csv", {"time": time, "u": command, "angle": angle})], {})
    ends = [r.ends for r in made.runs]
    assert ends[0] == "the command rests where it began"
    assert "was not logged for 5.01 s" in ends[1]
    assert [len(r.time) > 1000 for r in made.runs] == [True] * 3


def test_a_rest_amid_the_range_cuts_only_the_log_that_is_alone(tmp_path):
    """What a rig with friction remembers there is not what it began with."""
    time = 0.01 * np.arange(6000)
    swing = np.sin(0.4 * np.pi * time)
    rests = np.where((time > 27.5) & (time < 32.5), 0.0, swing)
    logs = [
        csv(tmp_path / f"{n}.csv", {"time_s": time, "u_V": u, "angle_deg": 4.0 * u})
        for n, u in (("first", rests), ("second", swing))
    ]
    assert len(import_logs(logs[:1], {}).runs) == 2
    assert len(import_logs(logs, {}).runs) == 2


def test_a_camera_that_skips_frames_is_one_run_whose_rate_is_told(tmp_path):
    rng, time = np.random.default_rng(4), 0.01 * np.arange(6000)
    at = np.rint(np.arange(1790) * 100.0 / 30.0).astype(int)  # rows on which frames fall, 3 or 4 apart
    frames = np.isin(np.arange(6000), np.delete(at, [400, 700, 701, 1200]))
    command = np.repeat(rng.uniform(0.0, 4.0, 60), 100)
    angle = np.where(frames, np.round(10.0 * np.sin(time / 3.0), 2), np.nan)
    file = tmp_path / "random_val.csv"
    lines = [
        f"{t:.2f},{u:.4f},{'' if np.isnan(a) else a}" for t, u, a in zip(time, command, angle, strict=True)
    ]
    file.write_text("time_s,command_V,angle_deg\n" + "\n".join(lines) + "\n")
    made = import_logs([file], {})
    assert [len(r.time) for r in made.runs] == [frames.sum()]
    assert made.excitation[0].word == "random steps"
    assert round(made.logs[0].channels[1].rate, 2) == 30.0


def test_channels_of_several_rates_meet_on_the_samples_of_the_angle(tmp_path):
    import h5py

    fast = np.arange(30_000) / 1000.0
    held, dither = np.repeat(STEPS.command[:3000], 10), np.tile([0.1, -0.1], 15_000)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name, time, values, unit in (
            ("command", fast, held + dither, "V"),
            ("angle", STEPS.time[:3000], STEPS.angle[:3000], "deg"),
        ):
            group = file.create_group(name)
            group["time"], group[name] = time, values
            group[name].attrs["unit"] = unit
    made, told = imported([tmp_path / "log.h5"], tmp_path / "c")
    assert told["sample_time_s"] == 0.01
    np.testing.assert_array_equal(made.runs[0].values["angle"], STEPS.angle[:3000])
    # A row holds what the command was on the average until the next, as the pressure follows it.
    np.testing.assert_allclose(made.runs[0].values["command"][:-1], STEPS.command[:2999], atol=1e-9)


@pytest.mark.slow
def test_one_sine_is_not_fitted_on_and_held_out_too(tmp_path):
    def run(name, values):
        return csv(
            tmp_path / f"{name}.csv", {"time": t, "u": values, "angle": 10.0 * values, "p": 50.0 * values}
        )

    t = np.arange(6000) / 100
    sines = [run(f"sine{i}", 2.0 + 1.2 * np.sin(0.6 * t + i)) for i in range(3)]
    wide = run("stairs", 2.0 + 2.0 * np.round(np.sin(0.11 * t), 1))
    _, told = imported([*sines, wide], tmp_path / "c")
    sides = [{name.startswith("sine") for name in told[key]} for key in ("fit", "validate")]
    assert sides in ([{False}, {True}], [{True}, {False}])
    _, alone = imported(sines, tmp_path / "d")
    assert "all runs ask the same" in (tmp_path / "d/campaign.toml").read_text()
    assert alone["validate"] == ["sine2.csv"]


HOSTILE = [
    'x; system("ls")',
    "../../evil",
    "<script>",
    r"$\alpha$",
    "a\nb = 1\n[rig]",
    "\x1b[31mred",
    'q"uo,te;',
]


@pytest.mark.parametrize("name", HOSTILE)
def test_names_of_channels_and_files_do_nothing_but_name(tmp_path, name):
    rows = {"time": STEPS.time, "u": STEPS.command, name: STEPS.angle, "p [kPa]": STEPS.pressure}
    pd.DataFrame(rows).to_parquet(tmp_path / "log.parquet")
    seen = {c.name for c in import_logs([tmp_path / "log.parquet"], {"angle": ("u", "")}).logs[0].channels}
    (channel,) = seen - {"u", "p"}
    out = tmp_path / "campaign"
    _, told = imported([tmp_path / "log.parquet"], out, given={"angle": (channel, "deg")})
    text = (out / "campaign.toml").read_bytes()
    assert set(parse_toml(text, out, "correct it")) == {"axis", "start", "sample_time_s", "fit", "columns"}
    assert all(c >= 32 or c == 10 for c in text)
    found = load_recording(out / told["fit"][0], told["columns"])
    np.testing.assert_allclose(found.angle, STEPS.angle)
    assert {p.name for p in tmp_path.iterdir()} == {"log.parquet", "campaign"}


@pytest.mark.parametrize("content", [b"", b"\x00" * 400, b"a;b\n1;2\n", b"time,angle\n" + b"1,2\n" * 50])
@pytest.mark.parametrize(
    "suffix", [".csv", ".h5", ".tdms", ".mf4", ".mcap", ".bag", ".parquet", ".mat", ".xyz"]
)
@pytest.mark.filterwarnings("default")
def test_what_is_no_log_is_refused_in_one_line(tmp_path, content, suffix):
    path = tmp_path / f"log{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError) as refused:
        import_logs([path], {})
    assert "\n" not in str(refused.value)


def test_a_folder_with_something_in_it_is_kept(tmp_path):
    made = import_logs([EXAMPLE / "steps.csv"], {})
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty"):
        write_campaign(made, "flexion", tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.slow
def test_the_examples_come_back_as_they_are(tmp_path):
    made, told = imported(sorted(EXAMPLE.glob("*.csv")), tmp_path / "c")
    campaign = load_campaign(tmp_path / "c")
    assert (
        len(campaign.fit) + len(campaign.validate)
        == len(told["fit"]) + len(told["validate"])
        == len(made.runs)
    )
    for r in (*campaign.fit, *campaign.validate):
        np.testing.assert_array_equal(r.command, load_recording(EXAMPLE / r.name).command[: len(r.command)])
