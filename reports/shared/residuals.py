"""Residuals of a traced plant in a log: rows of a table, and the figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from design.studies.check.residual import ChannelResidual
from plants.measured.campaigns.recording import Recording
from reports.shared.figures.style import BLACK, GREY, ORANGE, new_figure, seen, styled
from reports.shared.tables import Cell, Column, number, row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMOOTHED = 0.5
"""Time [s] over which a residual is averaged where it is drawn."""

COLUMNS = (Column("Channel", number=False), Column("Residual now"), Column("Before"), Column("Limit"))
"""Columns of the rows of `channel_rows`."""

CAPTION = (
    "Measured minus simulated, open-loop simulation of the traced plant with the logged command, averaged "
    "over half a second. Dotted: limit of the RMS, both signs."
)


def channel_rows(channels: Sequence[ChannelResidual]) -> tuple[tuple[Cell, ...], ...]:
    """Rms of the residual of each channel, in this log and in the campaign of the trace, and its limit."""
    return tuple(
        row(
            c.channel.replace("_", " [") + "]", Cell(number(c.rms), broken=c.new), number(c.before),
            number(c.allowed),
        )
        for c in channels
    )  # fmt: skip


def draw_residuals(log: Recording, channels: Sequence[ChannelResidual]) -> "Figure":
    """Residual of the plant in each channel of a log, and its bound."""
    from scipy.ndimage import uniform_filter1d

    rows = max(1, round(SMOOTHED / float(np.median(np.diff(log.time)))))
    with styled():
        figure, axes = new_figure(len(channels), 1, 1.9 * len(channels), sharex=True)
        few = seen(len(log.time))
        for at, c in zip(axes, channels, strict=True):
            name, unit = c.channel.split("_")
            smooth = uniform_filter1d(c.left, rows, mode="nearest")
            at.plot(log.time[few], smooth[few], color=ORANGE if c.new else BLACK)
            for side in (-c.allowed, c.allowed):
                at.axhline(side, color=GREY, lw=0.8, ls=":")
            at.set(ylabel=f"{name} [{unit}]", xlim=(log.time[0], log.time[-1]))
        axes[-1].set_xlabel("Time [s]")
    return figure
