"""What an effect may ask of a log: where to be tried, and what of it the commands made by themselves."""

from typing import Any, Protocol

from plants.rig import Rig


class TrialHints(Protocol):
    """What a log, and what a model without the effect leaves of it, tell of where to try an effect.

    channel: ``pressure_kPa`` or ``angle_deg``; noise: its floor, in its unit.
    """

    @property
    def channel(self) -> str:
        """``pressure_kPa`` or ``angle_deg``."""
        ...

    @property
    def rig(self) -> Rig:
        """The rig whose log it is."""
        ...

    @property
    def noise(self) -> float:
        """Floor of the noise, in the channel's unit."""
        ...

    def quantiles(self, *shares: float) -> Any:
        """Quantiles of the channel as it was measured, in its unit."""
        ...

    def spectral_lines(self) -> list[tuple[float, float, float]]:
        """Frequencies [Hz] that the residual has most of, with sine and cosine part over the noise."""
        ...

    def steps(self) -> list[tuple[float, float]]:
        """Moments [s] at which a shift explains most of the residual, with its sign."""
        ...


class ExcitationHints(Protocol):
    """What was asked of a rig in the recordings at hand; `plants.measured.trace.ranking.excitation`.

    ramp: whether each command is one ramp; minor_loops: whether it turns round inside its range too;
    begins: time [s] up to which recordings only begin; longest: of the recordings [s].
    """

    @property
    def ramp(self) -> bool:
        """Whether each command is one ramp."""
        ...

    @property
    def minor_loops(self) -> bool:
        """Whether the command turns round inside its range too."""
        ...

    @property
    def begins(self) -> float:
        """Time [s] up to which the recordings only begin."""
        ...

    @property
    def longest(self) -> float:
        """Length of the longest recording [s]."""
        ...

    def pressed_beyond(self, angle: float, way: float) -> float:
        """By how much the drive goes on, as a share of its range, after the joint has come to an angle [deg]
        (way: 1 from below, -1 from above)."""
        ...

    def harmonic(self, frequency: float) -> int | None:
        """Which multiple of the single sine that was asked a frequency [Hz] is; None for none."""
        ...
