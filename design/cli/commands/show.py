"""``wrist show``: the parameters and where they come from."""

from design.cli.common import (
    Axis,
    AxisOption,
    JsonOption,
    PlantOption,
    following,
    parameter_set,
    write_json,
)
from design.cli.places import check_places
from design.cli.terminal.screen import console

NAME, HELP = "show", "Show the parameters of a wrist and where each comes from; assumed ones are marked."
EXAMPLE = "Example: wrist show --axis deviation"
NEXT = "wrist simulate, wrist tune"


def command(axis: AxisOption = Axis.flexion, plant: PlantOption = None, json: JsonOption = None) -> None:
    from rich.padding import Padding
    from rich.text import Text

    from plants.parameters.quantities import Assumed

    check_places({"--json": json})
    chosen = parameter_set(axis, plant)
    out = console(json)
    out.print(Text(chosen.title, style="bold"))
    width = max(14, *(len(n) for n in chosen.parameters))
    forms = {e.NAME: e for e in chosen.effects}
    for name, p in chosen.parameters.items():
        form = forms.pop(name.partition(".")[0], None)  # the heading stands before its first parameter
        if form is not None:
            out.print(Text.assemble((f"{form.NAME}: {form.FORM}", "bold cyan"), f" ({form.STAGE})"))
        meaning = chosen.kinds[name].meaning
        assumed = isinstance(p.provenance, Assumed)
        head = Text.assemble(
            ("? " if assumed else "  ", "bold yellow"),
            (f"{name:<{width}}", "bold"),
            f"{p.value:>9.5g} {p.unit:<8}",
            (f" within {p.low:g} to {p.high:g}", "dim"),
        )
        out.print(head)
        out.print(Padding(Text(f"{meaning}; {p.provenance}", style="dim"), (0, 0, 0, 4), expand=False))
    if chosen.assumed:
        out.print(Text(f"? assumed, not stated and not fitted: {', '.join(chosen.assumed)}", style="yellow"))
    following(out, "wrist", "tune", *(("--plant", plant) if plant else ("--axis", chosen.axis)))
    write_json(json, chosen.record)
