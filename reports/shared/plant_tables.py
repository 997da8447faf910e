"""Tables of a plant: its parameters with their evidence, the errors of its fit, what is assumed."""

from collections.abc import Mapping

from plants.measured.fitting.fit import Fit
from plants.parameters.quantities import Assumed, Fitted, Learnt, ParameterSet, Stated
from reports.shared.names import CHANNELS
from reports.shared.tables import Cell, Column, Group, Table, number, row, with_error


def parameter_table(sets: ParameterSet, before: ParameterSet | None = None) -> Table:
    """Every parameter with its evidence; with the set before the fit, where there was one."""
    rows = []
    for name, p in sets.parameters.items():
        kind, origin = sets.kinds[name], p.provenance
        value = with_error(p.value, origin.std_error) if isinstance(origin, Fitted) else number(p.value, 4)
        where = Cell(provenance(origin), marked=isinstance(origin, Assumed))
        first = [number(before.parameters[name].value, 4)] if before else []
        rows.append(row(name, *first, value, p.unit, where, kind.meaning))
    values = [Column("Before"), Column("Fitted")] if before else [Column("Value")]
    words = [Column(heading, number=False) for heading in ("Unit", "Where from", "Meaning")]
    return Table((Column("Name", number=False), *values, *words), (Group("", tuple(rows)),))


def provenance(origin: Stated | Assumed | Fitted) -> str:
    """Where a value is from, in few words; reasons of assumptions have a table of their own."""
    if isinstance(origin, Assumed):
        return "assumed"
    if isinstance(origin, Learnt):
        return "learnt"
    if isinstance(origin, Fitted):
        return "fitted" if origin.std_error is not None else "fitted, at a bound"
    return f"stated, {origin.section}"


def error_table(fit: Fit) -> Table:
    """Errors of free runs against the noise of the sensors."""
    rows = []
    for channel, (words, unit) in CHANNELS.items():
        errors = (fit.noise, fit.validate_rmse_before, fit.validate_rmse, fit.fit_rmse)
        values = [e.get(channel) for e in errors]
        if any(v is not None for v in values):
            rows.append(row(words, *(f"{number(v)} {unit}" if v is not None else "–" for v in values)))
    columns = (
        Column("Channel", number=False), Column("Noise floor"), Column("Before"), Column("Fitted"),
        Column("Fitted, on fit data"),
    )  # fmt: skip
    return Table(columns, (Group("", tuple(rows)),))


def assumption_table(sets: Mapping[str, ParameterSet]) -> Table:
    """Every assumed parameter with its reason; motions that share value and reason share a row."""
    shared: dict[tuple[str, str, str], list[str]] = {}
    for motion, s in sets.items():
        for name in s.assumed:
            p = s.parameters[name]
            assert isinstance(p.provenance, Assumed)
            shared.setdefault((name, f"{number(p.value, 4)} {p.unit}", p.provenance.why), []).append(motion)
    order = list(dict.fromkeys(n for s in sets.values() for n in s.kinds))
    keys = sorted(shared, key=lambda k: order.index(k[0]) if k[0] in order else len(order))
    rows = tuple(row(k[0], k[1], ", ".join(shared[k]), k[2]) for k in keys)
    columns = (Column("Name", number=False), Column("Value"), Column("Motion", number=False),
               Column("Reason for the value", number=False))  # fmt: skip
    return Table(columns, (Group("", rows),))
