"""The command ``wrist``: one module a command, common options in `design.cli.common`.

Exit codes: 0 done; 1 the answer is no (a requirement cannot be met); 2 bad input.
"""

import sys
import warnings
from typing import Annotated, Any

import typer

from design.cli import compare, export, fit, robust, show, simulate, trace, tune


def _say_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"wrist {version('wrist-workbench')}")
        raise typer.Exit


app = typer.Typer(
    name="wrist",
    help="Design a PI controller for a pneumatic wrist with hysteresis, and say how far it can be trusted.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


@app.callback()
def _common(
    verbose: Annotated[bool, typer.Option("--verbose", help="Show the traceback of an error.")] = False,
    version: Annotated[
        bool,
        typer.Option("--version", help="Show the version and stop.", callback=_say_version, is_eager=True),
    ] = False,
) -> None:
    """Options that stand before or after any command."""


for module in (show, simulate, fit, trace, tune, robust, compare, export):
    app.command(name=module.NAME, help=module.HELP, epilog=module.EXAMPLE)(module.command)


def main(arguments: list[str] | None = None) -> None:
    """Run the command; errors in one line on stderr, the traceback with ``--verbose``."""
    arguments = sys.argv[1:] if arguments is None else arguments
    verbose = "--verbose" in arguments
    arguments = [a for a in arguments if a != "--verbose"]
    warnings.showwarning = _say_warning
    try:
        app(args=arguments, prog_name="wrist")
    except KeyboardInterrupt:
        print("wrist: stopped", file=sys.stderr)
        raise SystemExit(130) from None
    except Exception as error:
        from plants.errors import InputError

        if verbose or not isinstance(error, InputError):
            raise
        print(f"wrist: {error}", file=sys.stderr)
        raise SystemExit(2) from None


def _say_warning(message: Any, category: Any, *_: Any, **__: Any) -> None:
    if category.__name__ == "InputWarning":
        print(f"wrist: warning: {message}", file=sys.stderr)
