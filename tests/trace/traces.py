"""Campaigns of the independent rig, traced: shared by the tests of this folder."""

import json
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

from plants.kernel.batches import default_jobs
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.result import Trace
from plants.measured.trace.trace import trace_campaign
from plants.parameters.files import built_in

OUTSIDE, NOTHING, KNOWN = "unexplained", "nothing-missing", "explained"


@dataclass(frozen=True)
class Judged:
    """A trace beside what the rig really has."""

    key: str
    axis: str
    truth: dict
    trace: Trace

    @property
    def effects(self) -> list[str]:
        return sorted(e.name for e in self.trace.effects)

    @property
    def wanted(self) -> str:
        if self.truth["open"]:
            return OUTSIDE
        return KNOWN if self.truth["effects"] else NOTHING

    @property
    def right(self) -> bool:
        """The verdict, and where the vocabulary has the effects, exactly those."""
        named = self.wanted == OUTSIDE or self.effects == sorted(self.truth["effects"])
        return named and self.trace.verdict == self.wanted

    @property
    def ratio(self) -> float:
        """Error of the angle after over the noise floor, on held-out recordings."""
        return self.trace.after["angle_deg"] / self.trace.noise["angle_deg"]

    def __str__(self) -> str:
        said = f"{self.trace.verdict} {self.effects}"
        return f"{self.key} {self.axis} {self.truth['effects'] or self.truth['open'] or 'nothing'}: {said}"


def trace_folder(folder: Path) -> Trace:
    """The trace of a campaign's folder, from the built-in parameters of its axis."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        campaign = load_campaign(folder)
        return trace_campaign(campaign, built_in(campaign.axis))


def trace_without_models(folder: Path) -> Trace:
    """The trace of a campaign's folder without the models of its search, which take 100 MB a campaign."""
    return replace(trace_folder(folder), stages=())


def judge_suite(root: Path, every: int = 1) -> list[Judged]:
    """The campaigns of a suite, or one of every so many, traced side by side and held against its answers."""
    answers = json.loads((root / "answers.json").read_text())
    answers = {key: answers[key] for key in list(answers)[::every]}
    folders = [root / key for key in answers]
    with ProcessPoolExecutor(default_jobs(), get_context("spawn")) as pool:
        traces = list(pool.map(trace_without_models, folders))
    return [Judged(k, a["axis"], a, t) for (k, a), t in zip(answers.items(), traces, strict=True)]
