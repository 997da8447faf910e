"""The tuner as a widget of Jupyter: sliders in, pictures out, and a button that keeps the gains."""

from dataclasses import asdict, fields, replace
from pathlib import Path
from threading import RLock
from time import perf_counter
from typing import Any, Literal

import anywidget
import numpy as np
import traitlets

from design.synthesis.designed_plant import in_loop
from design.synthesis.requirements import Limits
from design.synthesis.tuning import Region
from design.tuner import gains_file, record
from design.tuner.case import TunedPlant, case
from design.tuner.picture import Picture, picture
from design.tuner.regions import Regions, first, sharper
from design.tuner.setting import Setting, initial, plant, region_of, sliders
from plants.errors import InputError
from plants.parameters.files import built_in, load
from plants.parameters.quantities import ParameterSet
from plants.wrist import Wrist

HERE = Path(__file__).parent
SLIDERS = tuple(f.name for f in fields(Setting))

IN_TIME = 0.045
"""Seconds from a drag of the plant within which the map may begin with another few points: what is left of
a tenth of a second is for a machine that is busy with other things.  Its first level comes in time on one
that is not; else the map follows as soon as the drag pauses."""

PIECE = 40
"""Points by which the map is sharpened at a time, so that a drag that begins meanwhile waits for no more."""


class Tuner(anywidget.AnyWidget):
    """Sliders for gains and plant beside the resulting loop; shown as the last value of a cell.

    wrist: a wrist, a parameter set, ``flexion``, ``deviation`` or the path of a parameter set (TOML), with
    its effects if it has some.  limits: those that turn red when broken, the rig's where not given.
    region: the gains that the sliders and the map reach, scaled to the rig where not given.  Gains and plant
    are traits, in the units of `design.tuner.setting.Setting`, so that they can be read and set from Python:

    >>> tuner = Tuner("deviation")
    >>> tuner.shown.broken
    []
    >>> tuner.Kp, tuner.Ki = 12.0, 60.0
    >>> "Ms" in tuner.shown.broken
    True

    Raises ValueError for limits that are no limits and gains outside the region, InputError for a parameter
    set that cannot be read.
    """

    # One module: what a widget brings along cannot import a file beside it.
    _esm = "\n".join((HERE / name).read_text(encoding="utf-8") for name in ("drawing.js", "tuner.js"))
    _css = HERE / "tuner.css"

    Kp = traitlets.Float().tag(sync=True)
    Ki = traitlets.Float().tag(sync=True)
    width = traitlets.Float().tag(sync=True)
    lines = traitlets.Float().tag(sync=True)
    transit = traitlets.Float().tag(sync=True)
    dead_time = traitlets.Float().tag(sync=True)

    about = traitlets.Dict().tag(sync=True)
    picture = traitlets.Dict().tag(sync=True)
    regions = traitlets.Dict().tag(sync=True)
    kept = traitlets.Dict().tag(sync=True)
    asked = traitlets.Int(0).tag(sync=True)
    """Number of what the browser asked for last; it asks for no more before it is answered."""
    answered = traitlets.Int(0).tag(sync=True)
    sharpen = traitlets.Int(0).tag(sync=True)
    """Raised by the browser while nobody drags, for the next points of the map."""

    def __init__(
        self,
        wrist: Wrist | ParameterSet | str | Path = "flexion",
        limits: Limits | None = None,
        region: Region | None = None,
        jobs: int | None = None,
    ) -> None:
        super().__init__()
        self.title, self.wrist, self.option = _named(wrist)
        rig = self.wrist.rig
        self.limits, self.region, self.jobs = limits or Limits.of(rig), region or region_of(rig), jobs
        self.files: set[Path] = set()
        self._alone = RLock()  # Jupyter answers the browser beside a cell that runs
        self._case: TunedPlant | None = None
        self._regions: Regions | None = None
        self._shown: Picture | None = None
        start = initial(self.wrist)
        self.sliders = sliders(self.region, rig, start.dead_time)
        self.about = record.about(self.title, self.sliders, start.dead_time, self.limits, self.region, rig)
        reach = {n: getattr(self.region, n) for n in GAINS}
        inside = {n: min(max(getattr(start, n), low), high) for n, (low, high) in reach.items()}
        with self.hold_trait_notifications():
            for name, value in asdict(replace(start, **inside)).items():
                setattr(self, name, value)
        self.on_msg(self._told)

    @property
    def setting(self) -> Setting:
        """Where the sliders stand."""
        return Setting(**{name: getattr(self, name) for name in SLIDERS})

    @property
    def shown(self) -> Picture:
        """The picture of the setting."""
        assert self._shown is not None
        return self._shown

    @traitlets.validate(*SLIDERS)
    def _within(self, proposal: Any) -> float:
        slider = next(s for s in self.sliders if s.name == proposal["trait"].name)
        value = float(proposal["value"])
        if not slider.low <= value <= slider.high:
            raise traitlets.TraitError(
                f"{slider.name}: {value:g} is outside {slider.low:g} to {slider.high:g}"
            )
        return value

    @traitlets.observe(*SLIDERS, "asked")
    def _moved(self, _change: Any) -> None:
        with self._alone:
            self._show()

    def _show(self) -> None:
        """Show the setting; of several sliders that moved at once, the first to be told of does it all."""
        setting = self.setting
        if self._shown is not None and setting == self._shown.setting:
            self.answered = self.asked
            return
        another = self._shown is None or setting.of_plant != self._shown.setting.of_plant
        begin = perf_counter()
        if another:
            self._case = case(self.wrist, setting, self.limits, self.jobs)
        assert self._case is not None
        early = self._shown is None
        self._shown = picture(self._case, setting)
        if another:
            coarse, left = self._case.coarse, np.inf if early else begin + IN_TIME - perf_counter()
            self._regions = None if coarse is None else first(coarse, self.region, left)
        with self.hold_sync():
            self.picture = record.picture_record(self._shown, self.limits, plant(self.wrist, setting))
            if another:
                self.regions = self._outlined()
            self.answered = self.asked

    def _outlined(self) -> dict[str, Any]:
        """The map for the browser; that of the plant before, said to be behind, where there was no time."""
        if self._regions is None or self._regions.level:
            return record.regions_record(self._regions)
        return {**self.regions, "complete": False, "behind": True}

    @traitlets.observe("sharpen")
    def _sharper(self, _change: Any) -> None:
        """Some points more of the map; it is drawn anew when a level is complete."""
        with self._alone:
            before = self._regions
            if before is None or self._case is None or self._case.coarse is None:
                return
            self._regions = sharper(self._case.coarse, before, PIECE)
            if self._regions.level > before.level:
                self.regions = record.regions_record(self._regions)

    def keep(self, name: str | Path = "gains.toml") -> Path:
        """Write the gains as TOML, which ``wrist simulate --gains FILE`` and others take; returns where.

        Raises InputError for a file of that name that this tuner did not write, and for a place that
        cannot be written to.
        """
        tuned_on = {
            "plant": self.title,
            "limits_broken": self.shown.broken,
            **{n: v for n, v in asdict(self.setting).items() if n not in GAINS},
        }
        gains: dict[str, float] = {n: getattr(self, n) for n in GAINS}
        path = gains_file.write(name, gains, tuned_on, self.files, self.wrist.rig)
        self.files.add(path)
        return path

    def _told(self, _widget: Any, content: dict[str, Any], _buffers: Any) -> None:
        """A message of the browser: ``{"keep": name}``."""
        if "keep" not in content:
            return
        try:
            path = self.keep(str(content["keep"]))
        except InputError as error:
            self.kept = {"done": False, "words": str(error)}
            return
        command = f"wrist robust {self.option}--gains {path.name}"
        self.kept = {"done": True, "words": f"Written: {path}", "command": command}


GAINS: tuple[Literal["Kp", "Ki"], ...] = ("Kp", "Ki")


def _named(given: Wrist | ParameterSet | str | Path) -> tuple[str, Wrist, str]:
    """What a plant is called, the wrist, and the option with which the command gets it, a space after it."""
    if isinstance(given, Wrist):
        for axis in ("flexion", "deviation"):
            if given == Wrist.of(built_in(axis)):
                return axis, given, f"--axis {axis} "
        return "your wrist", given, ""
    if isinstance(given, ParameterSet):
        return given.axis, Wrist.of(in_loop(given)), ""
    if given in ("flexion", "deviation"):
        return str(given), Wrist.of(built_in(str(given))), f"--axis {given} "
    chosen = in_loop(load(given))
    return chosen.axis, Wrist.of(chosen), f"--plant {given} "
