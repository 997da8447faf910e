"""Every form of every effect, absent and present."""

from plants import Wrist
from plants.effects import CommandedOpenings, known_effects
from plants.effects.effect import Effect

WRIST = Wrist.flexion()
FORMS = [form for forms in known_effects().values() for form in forms]
IDS = [f"{f.NAME}, {f.FORM}" for f in FORMS]


def present(form: type[Effect]) -> Effect:
    """The effect at the trial values that differ most from its null; valves such that they hold any angle."""
    if form is CommandedOpenings:
        return CommandedOpenings(5.0, 3.0, 260.0, -10.0, 0.5, 0.8)
    null = list(vars(form()).values())
    trials = [form(**values) for values in form.trials()]
    return max(trials, key=lambda e: sum(a != b for a, b in zip(vars(e).values(), null, strict=True)))
