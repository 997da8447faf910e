"""Campaigns of recordings, as a user of the workbench would have measured them on a rig."""

import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from tests.rig import signals
from tests.rig.core import Controller
from tests.rig.effects import VOCABULARY, draw_hidden
from tests.rig.parameters import draw
from tests.rig.rig import Bench, Noise, Rig, Run, draw_noise

RECORDINGS = ("staircase", "steps", "small", "sine", "task")
VALIDATE = ("sine", "task")  # never used to fit
TICKS_PER_ROW = 10
TASK_CONTROLLER = Controller(Kp=1.2, Ki=2.2)
QUICK = Controller(Kp=4.28, Ki=10.4)


def make_rig(
    axis: str,
    effects: Sequence[str],
    seed: int,
    variants: dict[str, int] | None = None,
    noise: Noise | None = None,
    scale: float = 1.0,
    correlation_s: float = 0.0,
) -> Rig:
    """A rig of the motion `axis` with the named effects, all drawn from the seed.

    variants: form numbers by name, drawn where not given; scale multiplies the strength of the effects;
    correlation_s [s] colours the noise.
    """
    # A stream for each thing drawn: the declared wrist does not depend on which effects it hides.
    declared = draw(axis, np.random.default_rng([seed, 0]))
    hidden = draw_hidden(list(effects), variants or {}, np.random.default_rng([seed, 1]), declared, scale)
    loud = noise or draw_noise(np.random.default_rng([seed, 2]), correlation_s)
    return Rig(axis, tuple(effects), loud, seed, declared, hidden)


def make_campaign(
    folder: Path | str,
    axis: str,
    effects: Sequence[str] = (),
    seed: int = 0,
    variants: dict[str, int] | None = None,
    noise: Noise | None = None,
    recordings: Sequence[str] = RECORDINGS,
    scale: float = 1.0,
    short: bool = False,
    correlation_s: float = 0.0,
    with_other: bool | None = None,
) -> Rig:
    """Write a campaign of such a rig to `folder`; the rig, which knows the truth, is returned.

    short: 66 s in all instead of 364 s, too short for a load step; with_other: whether other_pressure_kPa is
    logged, by default where it acts and on every third other rig.
    """
    rig = make_rig(axis, effects, seed, variants, noise, scale, correlation_s)
    record(rig, folder, recordings, short, with_other)
    return rig


def record(
    rig: Bench,
    folder: Path | str,
    recordings: Sequence[str] = RECORDINGS,
    short: bool = False,
    with_other: bool | None = None,
) -> None:
    """Run the rig through the recordings and write them as a campaign."""
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    logged = with_other if with_other is not None else "cross-coupling" in rig.effects or rig.seed % 3 == 0
    for name in recordings:
        table = logged_table(rig, name, run_of(rig, name, short), logged)
        table.to_csv(target / f"{name}.csv", index=False, lineterminator="\n")
    write_description(target, rig.axis, recordings)


def set_points(rig: Bench, salt: int, digits: int) -> tuple[signals.Signal, signals.Signal]:
    """Moments [s], to so many digits, at which a set-point changes every 1 to 4 s, and the set-point [deg] of
    each ms of a minute."""
    rng = np.random.default_rng([rig.seed, salt])
    edges = np.round(np.cumsum(rng.uniform(1.0, 4.0, 60)), digits)
    levels = np.append(0.0, rng.uniform(-14.0, 14.0, 60))
    return edges, levels[np.searchsorted(edges, np.arange(60_001) * 0.001 + 1e-6)]


def record_closed(
    rig: Bench, folder: Path, digits: int, with_other: bool = False, controller: Controller = QUICK
) -> Path:
    """A campaign of three minutes under a PI that sees the noise, to random set-points; digits: of the
    moments [s] at which these change: with 2 they are rows of the log, with 3 they lie between rows."""
    names = ("one", "two", "three")
    for salt, name in enumerate(names, start=11):
        run = rig.follow(set_points(rig, salt, digits)[1], controller, salt)
        logged_table(rig, "task", run, with_other).to_csv(folder / f"{name}.csv", index=False)
    write_description(folder, rig.axis, names, ("three",))
    return folder


def write_description(
    folder: Path, axis: str, recordings: Sequence[str], held_out: Sequence[str] = VALIDATE
) -> None:
    """campaign.toml of such recordings."""
    fit = ", ".join(f'"{name}.csv"' for name in recordings if name not in held_out)
    validate = ", ".join(f'"{name}.csv"' for name in recordings if name in held_out)
    text = f'axis = "{axis}"\nsample_time_s = 0.01\nfit = [{fit}]\nvalidate = [{validate}]\n'
    (folder / "campaign.toml").write_text(text)


def salt_of(recording: str) -> int:
    """Number by which the random streams of a recording differ from the others'."""
    return zlib.crc32(recording.encode())


def run_of(rig: Bench, recording: str, short: bool = False) -> Run:
    """The rig's run of one recording, at 1 kHz."""
    salt = salt_of(recording)
    if recording == "task":
        return rig.follow(signals.task_reference(short), TASK_CONTROLLER, salt, noisy=False)
    asked = signals.OPEN_LOOP[recording](np.random.default_rng([rig.seed, salt, 100]), short)
    return rig.play(np.repeat(signals.command_of(asked), TICKS_PER_ROW), salt)


def logged_table(rig: Bench, recording: str, run: Run, with_other: bool) -> pd.DataFrame:
    """What the logger keeps of a run: every tenth tick, rounded, with the noise of the pressure sensors."""
    rows = Run(*(column[::TICKS_PER_ROW] for column in run))
    rng = np.random.default_rng([rig.seed, salt_of(recording), 101])
    count, loud = len(rows.time), rig.noise.pressure_kPa
    shake = signals.noise(loud, count, rig.noise.correlation_s, signals.ROW, rng)
    other = rows.other_pressure + rng.normal(0.0, loud, count)
    columns = {
        "time_s": [f"{t:.4f}" for t in rows.time],
        "command_V": [f"{v:.4f}" for v in rows.command],
        "pressure_kPa": [f"{v:.4f}" for v in rows.pressure + shake],
        "angle_deg": [f"{round(v * 100) / 100 + 0.0:.4f}" for v in rows.measured],  # 0.01 deg per bit
    }
    if recording == "task":
        columns["reference_deg"] = [f"{v:.4f}" for v in rows.reference]
    if with_other:
        columns["other_pressure_kPa"] = [f"{v:.4f}" for v in other]
    return pd.DataFrame(columns)


def answer(rig: Bench) -> dict[str, object]:
    """Entry of an answers.json."""
    return {
        "axis": rig.axis,
        "angle_noise_deg": rig.noise.angle_deg,
        "pressure_noise_kPa": rig.noise.pressure_kPa,
        "effects": [name for name in rig.effects if name in VOCABULARY],
        "open": [name for name in rig.effects if name not in VOCABULARY],
    }


def drop(folder: Path, columns: Iterable[str]) -> None:
    """Take columns out of all logs of a campaign, as if they had not been logged."""
    for log in folder.glob("*.csv"):
        pd.read_csv(log).drop(columns=list(columns)).to_csv(log, index=False)
