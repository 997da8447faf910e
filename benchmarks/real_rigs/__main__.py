"""``python -m benchmarks.real_rigs``: traces of other people's rigs, whatever comes of them.

Reads the folder that WRIST_DATA names, makes campaigns of it in ``build/real``
(`benchmarks.real_rigs.data` says how), and writes figures and numbers, never the data,
to ``reports/examples/real``, and the table of all rigs into the guide.  With
words it does only those rigs in whose names one of them is, as in
``python -m benchmarks.real_rigs seal damper``, and keeps the others' numbers.
Exit codes: 0 done, or WRIST_DATA is unset; 1 a campaign could not be traced,
which the numbers then say.
"""

import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.real_rigs import friction
from benchmarks.real_rigs.data import rigs
from benchmarks.real_rigs.figures import draw_rig
from benchmarks.real_rigs.outcome import line, others, outcome, record, shortened
from benchmarks.real_rigs.table import ABOUT, KEPT, kept_table
from plants.files import json_text, write_atomically
from reports.shared.figures.style import save

GUIDE = Path(__file__).parents[2] / "docs" / "how-trace-decides.md"
TABLE = re.compile(r"^\| rig \|.*\n(\|.*\n)*", re.MULTILINE)
"""The table of all rigs, which stands in the guide."""

INTERVAL = "95 %, bootstrap over blocks of 2 s, or over recordings where these are shorter"


def main(names: Sequence[str] = ()) -> int:
    """Trace all rigs and find the friction of all tasks, one after the other; or only those in whose names
    one of `names` is, and keep what there is of the others."""
    folder = os.environ.get("WRIST_DATA")
    if not folder:
        print("WRIST_DATA is not set: no measured data at hand, nothing done")
        return 0
    data, stopped = Path(folder), False

    def asked(name: str) -> bool:
        return not names or any(n in name for n in names)

    for rig in filter(lambda r: asked(r.name), rigs(data)):
        found = outcome(rig, data)
        said = record(found, data) | {"others": others(found)}
        stopped = stopped or found.stopped is not None
        if found.fit is not None:
            save(draw_rig(found.rig, found.fit, found.trace), KEPT / f"{rig.name}.png", dpi=150)
        print(line(said), flush=True)
        _keep("real-rigs.json", "campaigns", "campaign", said, [r.name for r in rigs(data)])
    for task in filter(lambda t: asked(t.name), friction.tasks(data)):
        law = friction.record(task)
        print(f"{task.name}: {law['errors']['ours']}", flush=True)
        _keep("friction.json", "tasks", "task", law, [t.name for t in friction.tasks(data)])
    text = GUIDE.read_text(encoding="utf-8")
    write_atomically(GUIDE, TABLE.sub(lambda _: kept_table(), text))
    return int(stopped)


def _keep(name: str, key: str, by: str, said: Mapping[str, Any], order: Sequence[str]) -> None:
    """Put a record among those that a file keeps under `key`, in the place of the one of its name."""
    place = KEPT / name
    old = json.loads(place.read_text(encoding="utf-8"))[key] if place.is_file() else []
    records = {r[by]: r for r in old} | {said[by]: shortened(said)}
    content = {"what": ABOUT[name], "interval": INTERVAL, key: [records[n] for n in order if n in records]}
    write_atomically(place, json_text(content))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
