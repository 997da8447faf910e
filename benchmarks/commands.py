"""What a user waits for: whole processes of the command line."""

import subprocess
import sys
from pathlib import Path
from statistics import median

from benchmarks.timing import seconds

ROOT = Path(__file__).parents[1]
REPEATS = 5
LIMIT = 600.0
"""A command that takes longer [s] has failed."""


class Failed(Exception):
    """A command did not exit with 0."""


def wrist(*arguments: str) -> None:
    """Run ``wrist`` in a process of its own.  Raises Failed, with its last line, unless it exits with 0."""
    command = [sys.executable, "-m", "design.cli", *arguments]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        raise Failed(f"took longer than {LIMIT:.0f} s") from None
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise Failed(f"exit code {done.returncode}: {said[-1] if said else 'nothing said'}")


def timed(arguments: tuple[str, ...], repeats: int) -> float:
    """Median time of a command [s], run once before to fill the caches."""
    wrist(*arguments)
    return median(seconds(lambda: wrist(*arguments)) for _ in range(repeats))


COMMANDS = {
    "cli.help_s": (("--help",), REPEATS),
    "cli.second_start_s": (("simulate", "--axis", "flexion", "--json", "-"), REPEATS),
    "tune.warm_s": (("tune", "--axis", "flexion", "--json", "-"), 1),
    "trace.warm_s": (("trace", "plants/measured/examples/deviation", "--json", "-"), 1),
}
"""Arguments and number of measurements by figure."""


def measure() -> tuple[dict[str, float | None], dict[str, str]]:
    """Figures of the commands, None for those that failed, and why by figure."""
    figures: dict[str, float | None] = {}
    why: dict[str, str] = {}
    for key, (arguments, repeats) in COMMANDS.items():
        try:
            figures[key] = timed(arguments, repeats)
        except Failed as failed:
            figures[key], why[key] = None, f"failed, {failed}"
    return figures, why
