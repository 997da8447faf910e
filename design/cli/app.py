"""The commands of ``wrist``, put together."""

from pathlib import Path
from typing import Annotated

import typer

from design.cli.commands import compare, design, export, robust, show, simulate, tune
from design.cli.commands.logs import check, fit, importing, plan, trace
from design.cli.completion import files
from design.cli.strict import PlainGroup, StrictCommand

MODULES = (show, simulate, importing, fit, trace, plan, tune, robust, design, check, compare, export)


def _say_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"wrist {version('wrist-workbench')}")
        raise typer.Exit


app = typer.Typer(
    name="wrist",
    cls=PlainGroup,
    help="Design a PI controller for a pneumatic wrist with hysteresis, and assess its robustness.",
    epilog="Exit codes: 0 done, 1 the answer is no, 2 bad input, 70 a bug of this program, 130 stopped.",
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


@app.callback()
def _common(
    verbose: Annotated[
        bool, typer.Option("--verbose", help="Show the traceback of an error; before or after a command.")
    ] = False,
    version: Annotated[
        bool,
        typer.Option("--version", help="Show the version and stop.", callback=_say_version, is_eager=True),
    ] = False,
    plugin: Annotated[
        list[Path] | None,
        typer.Option(
            help="Python file that registers your own effects, controllers or hysteresis laws; before the "
            "command, once for each file.",
            envvar="WRIST_PLUGIN",
            autocompletion=files,
        ),
    ] = None,
) -> None:
    """Options that stand before any command."""
    if plugin:
        from design.cli.plugins import load_plugins

        load_plugins(plugin)
    from plants.rig import built_in_rig
    from reports.shared.units import show

    show(built_in_rig())


for module in MODULES:
    following = getattr(module, "NEXT", "")
    epilog = module.EXAMPLE + (f"\n\nNext: {following}" if following else "")
    app.command(name=module.NAME, help=module.HELP, epilog=epilog, cls=StrictCommand)(module.command)
