"""Parameters of effects that the recordings say nothing about."""

from plants.measured.trace.search.choose import Candidate


def at_neutral(now: Candidate) -> Candidate:
    """The candidate with each parameter of an effect that the recordings do not determine at the value that
    it has where the effect vanishes, or at a typical one, and not where a trial happened to leave it.

    A campaign in which the pressure never falls says nothing of the speed of exhausting, and a free run of
    another recording would meet whatever was tried.  Not determined: the sum of squares rises by less than
    what chance makes of it, that of one row.
    """
    found = now.model
    allowed = now.model.chi2 * (1.0 + 1.0 / now.model.residual.size)
    for form in now.model.forms:
        absent = form()
        for name in form.kinds():
            moved = found.with_values({f"{form.NAME}.{name}": float(getattr(absent, name))})
            if moved.chi2 < allowed:
                found = moved
    return Candidate(found) if found is not now.model else now
