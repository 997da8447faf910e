"""Running ``wrist`` as its users do, in this process."""

import json
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from design.cli import main


class Outcome(NamedTuple):
    """What a command left: exit code, stdout, stderr."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def wrist(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """``wrist(*arguments)`` and its outcome."""

    def run(*arguments: object) -> Outcome:
        code = 0
        try:
            main([str(a) for a in arguments])
        except SystemExit as stop:
            code = int(stop.code or 0)
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return run
