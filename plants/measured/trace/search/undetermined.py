"""Parameters of effects, and of a law's curve, that the recordings say nothing about."""

from plants.measured.trace.search.choose import Candidate


def at_neutral(now: Candidate) -> Candidate:
    """The candidate with each parameter of an effect that the recordings do not determine at the value that
    it has where the effect vanishes, or at a typical one, and not where a trial happened to leave it; also
    those that the hysteresis law can do without.

    A campaign in which the pressure never falls says nothing of the speed of exhausting, and a free run of
    another recording would meet whatever was tried; a slope of the output curve beyond all that was recorded
    would be a branch that no loop has.  Not determined: the sum of squares rises by less than what chance
    makes of it, that of one row.
    """
    found = now.model
    allowed = now.model.chi2 * (1.0 + 1.0 / now.model.residual.size)
    neutral = {n: v for n, v in now.model.wrist.hysteresis.NEUTRAL.items() if n in now.model.names}
    for form in now.model.forms:
        absent = form()
        neutral |= {f"{form.NAME}.{n}": float(getattr(absent, n)) for n in form.kinds()}
    for name, value in neutral.items():
        moved = found.with_values({name: value})
        if moved.chi2 < allowed:
            found = moved
    return Candidate(found) if found is not now.model else now
