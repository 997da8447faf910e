"""The committed examples are those of the commands that are said to make them, and a number that differs
from them is found."""

import html
import json
import re
import shutil
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from reports import regenerate
from reports.regenerate import ALL, TOLERANCES, differences, flat

EXAMPLES = Path(__file__).parents[2] / "reports" / "examples"
RECORD = {
    "standings": [
        {"motion": "flexion", "controller": "tuned", "Ms": 1.98, "worst_settling_s": 1.676},
        {"motion": "flexion", "controller": "linear MPC", "Ms": None, "worst_settling_s": 0.39},
    ],
    "verdicts": ["flexion: settles in 1.68 s."],
    "ledger": {"flexion": {"tuned": {"total_s": {"median": 1e-5}}}},
    "made": {"commit": "one"},
}


def changed(path: str, value):
    """The record with one value changed."""
    record = json.loads(json.dumps(RECORD))
    *way, last = path.split("/")
    at = record
    for step in way:
        at = at[int(step) if step.isdigit() else step]
    at[int(last) if last.isdigit() else last] = value
    return record


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("standings/0/Ms", 1.98 * 1.02),
        ("standings/0/worst_settling_s", 1.72),
        ("standings/0/Ms", None),
        ("standings/1/Ms", 1.0),
        ("verdicts/0", "flexion: does not settle in 1.68 s."),
        ("standings", RECORD["standings"][1:]),
        ("standings/0/more", 1.0),
    ],
)
def test_what_differs_is_found(path, value):
    assert len(differences(RECORD, changed(path, value))) >= 1


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("standings/0/Ms", 1.98 * 1.001),
        ("standings/0/worst_settling_s", 1.682),
        ("verdicts/0", "flexion: settles in 1.70 s."),
        ("made/commit", "two"),
        ("ledger/flexion/tuned/total_s/median", 1.0),
    ],
)
def test_what_may_differ_does_not_count(path, value):
    assert differences(RECORD, changed(path, value)) == []


def test_what_the_quick_command_leaves_out_may_lack_and_nothing_else():
    less = changed("standings", RECORD["standings"][:1])
    assert differences(RECORD, less, ("standings.*MPC*",)) == []
    assert differences(RECORD, less)
    assert differences(RECORD, changed("standings", RECORD["standings"][1:]), ("standings.*MPC*",))


def test_every_tolerance_is_said_why_and_meets_a_number_of_some_example():
    paths = {p for e in ALL.values() for p in flat(json.loads((EXAMPLES / e.record).read_text()))}
    for t in TOLERANCES:
        assert t.why
        assert t.pattern.startswith("ledger") or any(fnmatchcase(p, t.pattern) for p in paths), t.pattern


@pytest.mark.parametrize("name", list(ALL))
def test_the_committed_page_was_made_by_its_command_and_its_files_are_there(name):
    example = ALL[name]
    page = html.unescape((EXAMPLES / example.page).read_text(encoding="utf-8"))
    (command,) = re.findall(r"<dt>Command</dt><dd><code>(.*?)</code>", page)
    assert command.startswith(" ".join(("wrist", *example.command)) + " --out build/")
    for kept in (example.record, *example.files.values()):
        assert (EXAMPLES / kept).stat().st_size > 100, kept
    assert not re.search(r"/(?:root|home|tmp|work)/", page)


def test_the_readme_of_the_examples_says_the_commands():
    said = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for name, example in ALL.items():
        assert f"`wrist {' '.join(example.command)} --out build/examples/{name}`" in said
        assert f"({example.page})" in said


def test_commands_come_after_what_they_read_and_find_it_there(tmp_path, monkeypatch):
    """Robustness is shown of the gains that the design has just found, not of those of the time before."""
    kept = {f"reports/examples/{n}": name for name, e in ALL.items() for n in e.files.values()}
    read = [(name, word) for name, e in ALL.items() for word in e.command if word in kept]
    assert {(name, kept[word]) for name, word in read} == {("robust", "design")}
    assert f"{regenerate.BUILT}/design" in ALL["comparison"].command
    assert list(ALL).index("design") < min(list(ALL).index(n) for n in ("comparison", "robust"))
    for name in ALL["design"].files:
        (tmp_path / name).write_text(f"new {name}")
    committed = tmp_path / "reports/examples"
    committed.mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    regenerate.hand_on(ALL["design"], tmp_path)
    assert sorted(p.name for p in committed.iterdir()) == sorted(Path(word).name for _, word in read)
    assert (committed / "gains-flexion.toml").read_text() == "new gains-flexion.toml"


def test_what_is_made_already_is_compared_as_it_lies(tmp_path, monkeypatch, capsys):
    (tmp_path / "trace").mkdir()
    example, place = ALL["trace"], tmp_path / "trace"
    monkeypatch.setattr(regenerate, "BUILT", tmp_path)
    monkeypatch.setattr(regenerate, "make", lambda *_, **__: pytest.fail("it was made again"))
    for name in (example.page, example.record):
        shutil.copy(EXAMPLES / name, place)
    assert regenerate.main(["--check", "--made", "trace"]) == 0
    record = json.loads((place / example.record).read_text(encoding="utf-8"))
    (place / example.record).write_text(json.dumps({**record, "verdict": "nothing-missing"}))
    assert regenerate.main(["--check", "--made", "trace"]) == 1
    assert "trace: 1 differences" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        regenerate.main(["--made", "trace"])


def test_the_committed_comparison_has_fewer_words_than_it_may():
    """Text and tables with all folds open; letters within figures and numbers of their axes apart."""
    page = (EXAMPLES / "comparison.html").read_text(encoding="utf-8")
    text = re.sub(r"<(svg|script|style|template)\b.*?</\1>|<[^>]+>", " ", page, flags=re.DOTALL)
    assert len(text.split()) < 6000
