"""How options are grouped in ``--help``: what to design for, which limits, how hard to search, what to write.

A name belongs to one group in every command; an option that is not listed stays with typer's own group.
"""

from typing import Any

PLANT, REQUIREMENT, LIMITS, SEARCH, OUTPUT = (
    "Plant and data", "What to design for", "Limits", "Search effort", "Output",
)  # fmt: skip
OPTIONS = {
    PLANT: ("axis", "plant", "design", "motion", "example", "volts", "recording", "scenario", "figure",
            "start", "step", "duration", "gains", "robust_gains", "map_", "sample_time"),
    REQUIREMENT: ("cost", "two_dof", "nominal", "plain", "no_dead_time", "no_load", "no_noise", "no_box",
                  "no_remainder", "dead_time", "load", "noise", "quantum", "box", "corners"),
    LIMITS: ("overshoot", "ms", "delay_margin", "variation", "steady_error", "rate_limit"),
    SEARCH: ("points", "starts", "rounds", "samples", "tried", "mpc", "no_alternatives", "mpc_plants",
             "budget", "seed", "jobs", "scheduler", "retune", "learn"),
    OUTPUT: ("target", "precision", "hand_over", "json", "out", "save", "worst", "verbose", "version",
             "plugin"),
}  # fmt: skip
"""Names of options by the group in which ``--help`` shows them, in its order."""

_PANEL = {name: panel for panel, names in OPTIONS.items() for name in names}
_PLACE = {name: place for place, name in enumerate(_PANEL)}


def grouped(parameters: list[Any]) -> list[Any]:
    """Parameters of a command with their groups, those of a group together; a switch shows no type."""
    for p in parameters:
        if getattr(p, "is_flag", False):
            p.metavar = ""
        if p.param_type_name == "option" and p.rich_help_panel is None:
            p.rich_help_panel = _PANEL.get(p.name)
    return sorted(parameters, key=lambda p: _PLACE.get(p.name, -1 if p.param_type_name == "argument" else 99))
