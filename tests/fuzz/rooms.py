"""What is tried: campaigns, plants, gains, scenarios, options, names and caches, a function each."""

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from hypothesis import strategies as st

from tests.fuzz import lines, texts
from tests.fuzz.sandbox import Outcome, Sandbox
from tests.fuzz.texts import Spoiled

ROOT = Path(__file__).parents[2]
FLEXION = ROOT / "plants/parameters/flexion.toml"
CAMPAIGN = ROOT / "plants/measured/examples/flexion"


class Room(NamedTuple):
    """Strategy of what is tried, how it is tried, and the share of all tries."""

    given: st.SearchStrategy[Any]
    attempt: Callable[[Sandbox, Any], Outcome]
    share: float


@cache
def revised() -> str:
    """A set with a rig of its own, effects and fitted parameters, as TOML."""
    from dataclasses import replace

    from plants.effects import Creep
    from plants.parameters.files import built_in, dump

    rig = replace(built_in("flexion").rig, name="mine")
    found = built_in("flexion").revised(
        [Creep], {"creep.gain": 0.1, "creep.time_constant": 4.0, "Tw": 0.15}, {"Tw": 0.01}, "d"
    )
    with tempfile.TemporaryDirectory() as folder:
        dump(replace(found, rig=rig), Path(folder) / "x.toml")
        return (Path(folder) / "x.toml").read_text(encoding="utf-8")


@cache
def scenario() -> str:
    """A scenario file of a short run."""
    import tomlkit

    text = tomlkit.parse(texts.shown(FLEXION))
    text["scenario"] = {
        "start": "virgin", "angle": 0.0, "references": [5.0, 1.0], "holds": [0.2, 0.2], "dead_time": 0.01,
        "load": 0.5, "plant": "nominal", "violated": [],
    }  # fmt: skip
    text["controller"] = {"Kp": 2.0, "Ki": 6.0, "gain": 49.4, "rest_pressure": 100.0, "low": 0.0, "high": 4.0}
    from design.evaluation.metrics import UNITS

    text["metrics"] = dict.fromkeys(UNITS, 1.0)
    return tomlkit.dumps(text)


GAINS = """# gains
[gains.Kp]
value = 2.3
unit = "kPa/deg"
[gains.Ki]
value = 6.4
unit = "kPa/(deg s)"
"""


def plant(box: Sandbox, given: Spoiled) -> Outcome:
    (box.given / "plant.toml").write_bytes(given.text)
    line = ["show", "--plant", "in/plant.toml", "--json", "out/x.json"]
    outcome = box.wrist(line, given.must_refuse)
    if outcome.code or outcome.faults:
        return outcome
    more = ["simulate", "--plant", "in/plant.toml", "--duration", "0.05", "--json", "out/y.json"]
    return box.wrist(more)


def gains(box: Sandbox, given: Spoiled) -> Outcome:
    (box.given / "gains.toml").write_bytes(given.text)
    return box.wrist(["simulate", "--gains", "in/gains.toml", "--duration", "0.05"], given.must_refuse)


def replayed(box: Sandbox, given: Spoiled) -> Outcome:
    (box.given / "s.toml").write_bytes(given.text)
    return box.wrist(["simulate", "--scenario", "in/s.toml", "--json", "out/s.json"], given.must_refuse)


def declaration(box: Sandbox, given: Spoiled) -> Outcome:
    """A campaign whose campaign.toml is spoiled."""
    from plants.measured.campaigns.campaign import load_campaign

    for path in CAMPAIGN.glob("*.csv"):
        (box.given / path.name).write_bytes(path.read_bytes())
    (box.given / "campaign.toml").write_bytes(given.text)
    return box.call(lambda: load_campaign(box.given), given.must_refuse)


def recording(box: Sandbox, given: Spoiled) -> Outcome:
    (box.given / "r.csv").write_bytes(given.text)
    line = ["simulate", "--recording", "in/r.csv", "--json", "out/r.json"]
    return box.wrist(line, given.must_refuse)


def options(box: Sandbox, given: lines.Line) -> Outcome:
    return box.wrist(list(given.words), given.must_refuse)


def names(box: Sandbox, given: tuple[str, str]) -> Outcome:
    """A motion and a title of any name, drawn."""
    import tomlkit

    text = tomlkit.parse(texts.shown(FLEXION))
    text["axis"], text["title"] = given
    (box.given / "n.toml").write_text(tomlkit.dumps(text), encoding="utf-8", errors="replace")
    return box.wrist(["simulate", "--plant", "in/n.toml", "--duration", "0.05", "--out", "out/pictures"])


def damaged(box: Sandbox, given: Callable[[bytes], bytes]) -> Outcome:
    """A kernel of the cache, spoiled."""
    from plants.kernel import cache as kernels
    from plants.kernel.templates import module

    source = module("fuzz", "def run(x):\n    return 2.0 * x + 1.0\n")
    folder = box.out
    with mock.patch.object(kernels, "cache_folder", return_value=folder):
        kernels.load(source)(1.0)
        (entry,) = folder.glob("*.kernel")
        entry.write_bytes(given(entry.read_bytes()))

        def again() -> None:
            if kernels.load(source)(3.0) != 7.0:
                raise ArithmeticError("the kernel computes something else")

        return box.call(again)


@st.composite
def damage(draw: st.DrawFn) -> Callable[[bytes], bytes]:
    kind, seed = draw(st.sampled_from(["flip", "cut", "bytes"])), draw(st.floats(0.0, 1.0))
    junk = draw(st.binary(max_size=40))

    def spoil(content: bytes) -> bytes:
        at = int(seed * (len(content) - 1))
        if kind == "flip":
            return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]
        return content[:at] if kind == "cut" else content[:at] + junk + content[at:]

    return spoil


def rooms() -> dict[str, Room]:
    """All that is tried, by name."""
    campaign = texts.shown(CAMPAIGN / "campaign.toml")
    steps = "\n".join(texts.shown(CAMPAIGN / "steps.csv").splitlines()[:600])
    name = st.one_of(st.sampled_from(texts.NAMES), st.text(min_size=1, max_size=40))
    return {
        "plants": Room(texts.toml(texts.shown(FLEXION)), plant, 0.16),
        "plants with a rig and effects": Room(texts.toml(revised()), plant, 0.16),
        "gains": Room(texts.toml(GAINS), gains, 0.12),
        "scenarios": Room(texts.toml(scenario()), replayed, 0.12),
        "campaigns": Room(texts.toml(campaign), declaration, 0.10),
        "recordings": Room(texts.table(steps), recording, 0.10),
        "options that cannot be meant": Room(lines.not_meant(), options, 0.10),
        "options of any kind": Room(lines.quick(), options, 0.08),
        "names": Room(st.tuples(name, name), names, 0.02),
        "caches": Room(damage(), damaged, 0.04),
    }
