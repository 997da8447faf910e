"""What goes wrong, said in one line with what to do, and the exit codes that scripts read."""

import re
import sys
import traceback
import warnings
from difflib import get_close_matches
from typing import Any

from design.cli.terminal.plain import plain
from design.cli.terminal.stopping import STOPPED, Stop

DONE, BAD_INPUT, BUG = 0, 2, 70


def answered(arguments: list[str] | None, stop: Stop | None = None) -> int:
    """Run the command and give its exit code, having said on stderr what went wrong.

    ``--verbose``, anywhere among the arguments, shows the traceback before the line.
    """
    given = sys.argv[1:] if arguments is None else arguments
    verbose = "--verbose" in given
    given = [a for a in given if a != "--verbose"] or ["--help"]
    try:
        from design.cli.app import app

        with warnings.catch_warnings():  # who calls this from Python keeps the warnings' own ways
            warnings.showwarning = _say_warning
            code = app(args=given, prog_name="wrist", standalone_mode=False) or DONE
    except KeyboardInterrupt:
        code = STOPPED
    except Exception as error:
        if stop is not None and stop.asked:  # Ctrl-C within an import comes out as another error
            code = STOPPED
        else:
            if verbose:
                print(plain("".join(traceback.format_exception(error))), end="", file=sys.stderr)
            line, code = told(error, given)
            print(line, file=sys.stderr)
            if draft := getattr(error, "draft", None):
                print(draft, end="")
    if code == STOPPED:
        if stop is not None:
            stop.leave()
        print("wrist: stopped", file=sys.stderr)
    return int(code)


def told(error: Exception, arguments: list[str]) -> tuple[str, int]:
    """The line that says an error, and the exit code.

    >>> told(ValueError("odd"), [])[0]
    'wrist: a bug of this program: ValueError: odd; run it again with --verbose and report what it shows'
    """
    from plants.errors import InputError

    if isinstance(error, InputError):
        said = _plain(str(error))
        return f"wrist: {said}{_meant(said)}", BAD_INPUT
    if hasattr(error, "format_message"):  # what typer, or click under it, finds wrong with the arguments
        context = getattr(error, "ctx", None)
        path = context.command_path if context is not None else _path(arguments)
        return f"{path}: {_usage(error)}; see {path} --help", BAD_INPUT
    name, said = type(error).__name__, _plain(str(error))
    line = f"wrist: a bug of this program: {name}{': ' if said else ''}{said}"
    return f"{line}; run it again with --verbose and report what it shows", BUG


def _usage(error: Any) -> str:
    """What is wrong with the arguments, without the frame and the headings of typer."""
    if getattr(error, "option_name", None) and hasattr(error, "possibilities"):
        known = [name.removeprefix("--") for name in error.possibilities or ()]
        near = [f"--{n}" for n in get_close_matches(error.option_name.removeprefix("--"), known, 1)]
        return f"no such option {error.option_name}" + _perhaps(near)
    said = _plain(error.format_message()).removesuffix(".")
    said = re.sub(r"\. Did you mean '(\w+)'.*", r" (did you mean \1?)", said)
    where = re.match(r"Invalid value for '([^']+)': ", said)
    said = said[where.end() if where else 0 :].removeprefix("Value error, ")
    return (f"{where[1]}: " if where else "") + said[:1].lower() + said[1:] + _meant(said)


def _meant(said: str) -> str:
    """The name that was meant, where a message quotes one that is unknown and lists those that are known.

    >>> _meant("unknown cost 'ia'; one of iae, itae, settling_time")
    ' (did you mean iae?)'
    >>> _meant("unknown cost 'beauty'; one of iae, itae, settling_time")
    ''
    """
    found = re.search(r"'([^']+)'(?:(?!').)*?(?:one of|known are) (.+)$", said)
    if found is None:
        return ""
    near = get_close_matches(found[1], re.findall(r"[\w.-]+", found[2]), 1)
    return _perhaps(near)


def _perhaps(near: list[str]) -> str:
    return f" (did you mean {near[0]}?)" if near else ""


def _path(arguments: list[str]) -> str:
    """``wrist`` and the command, where the error does not say in which it arose."""
    from design.cli.app import MODULES

    named = next((a for a in arguments if a in {m.NAME for m in MODULES}), None)
    return "wrist" if named is None else f"wrist {named}"


def _plain(text: str) -> str:
    """A text in one line, which the terminal shows and does not obey."""
    return plain(" ".join(text.split()))


def _say_warning(message: Any, category: Any, *_: Any, **__: Any) -> None:
    if category.__name__ == "InputWarning":
        print(f"wrist: warning: {_plain(str(message))}", file=sys.stderr)
