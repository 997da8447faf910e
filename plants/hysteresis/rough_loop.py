"""What is known roughly of a loop: what a law guesses its parameters from."""

from dataclasses import dataclass, replace

from plants.hysteresis.output_curve import OutputCurve


@dataclass(frozen=True)
class RoughCurve:
    """From a sum of plays to the angle: slope in the middle; of the sum times this slope [deg], the centre
    and the curve about it; angle: at the centre [deg]."""

    slope: float
    centre: float
    about: OutputCurve
    angle: float

    @property
    def zero(self) -> float:
        """The sum of plays, times the slope, at which the angle is 0 [deg]."""
        return self.centre + float(self.about.inverse(-self.angle))

    def through(self, total: float) -> "RoughCurve":
        """Shifted so that the angle is 0 at a sum of plays, times the slope [deg]."""
        return replace(self, angle=-float(self.about.value(total - self.centre)))


@dataclass(frozen=True)
class RoughLoop:
    """A sum of plays of the pressure P.

    inner, weights: of the pressure itself, which is the slope just after a reversal, and of the plays
    [deg/kPa]; reach: largest threshold [kPa], the others being equally spaced; rest: pressure at which the
    wrist rests [kPa]; low, high: least and largest pressure [kPa].  curve: what the sum is seen as, straight
    where there is none.
    """

    inner: float
    weights: tuple[float, ...]
    reach: float
    rest: float
    low: float
    high: float
    curve: RoughCurve | None = None

    @classmethod
    def of_equal_plays(
        cls, outer: float, inner: float, gap: float, rest: float, low: float, high: float, plays: int = 4
    ) -> "RoughLoop":
        """With slopes of the outer branches and after a reversal [deg/kPa] and half a width [kPa].

        >>> loop = RoughLoop.of_equal_plays(0.36, 0.08, 20.0, 100.0, 0.0, 200.0)
        >>> round(loop.outer, 6), round(loop.gap, 6)
        (0.36, 20.0)
        """
        weights = ((outer - inner) / plays,) * plays
        return cls(inner, weights, 2.0 * gap * plays / (plays + 1.0), rest, low, high)

    @property
    def outer(self) -> float:
        """Slope of the outer branches [deg/kPa]."""
        return self.inner + sum(self.weights)

    @property
    def width(self) -> float:
        """Half the width of the loop [deg]."""
        n = len(self.weights)
        return sum(w * self.reach * (i + 1) / n for i, w in enumerate(self.weights))

    @property
    def gap(self) -> float:
        """Half the width of the loop [kPa]."""
        return self.width / max(self.outer - self.inner, 1e-9)

    def straight(self, least: float) -> RoughCurve:
        """A curve without a bend, its pieces equally long within the pressures, at least so long [deg]."""
        middle, span = 0.5 * (self.low + self.high), self.outer * (self.high - self.low) / 6.0
        about = OutputCurve(max(span, least))
        return RoughCurve(1.0, self.outer * middle, about, self.outer * (middle - self.rest))

    def at_rest(self, rest: float) -> "RoughLoop":
        """The same loop, whose angle is 0 at a pressure that is known [kPa]."""
        curve = self.curve and self.curve.through(self.curve.slope * self.outer * rest)
        return replace(self, rest=rest, curve=curve)
