"""What parameter sets say of the data that they were fitted to."""

import re
from collections.abc import Mapping

from plants.parameters.quantities import Fitted, ParameterSet

SYNTHETIC = "The example campaigns are synthetic: they come from a simulator, not from a rig."


def data_of(sets: Mapping[str, ParameterSet]) -> dict[str, str]:
    """SHA-256, as far as it is noted, of the campaigns that parameters were fitted to, by name.

    >>> from plants.parameters.files import built_in
    >>> plant = built_in("flexion")
    >>> data_of({"flexion": plant.fitted({"a1": 0.36}, {"a1": 0.001}, "bench (sha256 0123456789ab)")})
    {'bench': '0123456789ab'}
    """
    fits = [p.provenance for s in sets.values() for p in s.parameters.values()]
    noted = (re.fullmatch(r"(.+) \(sha256 (\w+)\)", f.data) for f in fits if isinstance(f, Fitted))
    return {m[1]: m[2] for m in noted if m}


def remark_on(data: Mapping[str, str]) -> str:
    """That data is synthetic, where campaigns that ship with the project are among it; else nothing.

    >>> remark_on({"flexion": "0123456789ab"})
    ''
    """
    from plants.measured.campaign import load_campaign, shipped

    for folder in shipped():
        noted = data.get(folder.name)
        if noted and load_campaign(folder).checksum.startswith(noted):
            return SYNTHETIC
    return ""
