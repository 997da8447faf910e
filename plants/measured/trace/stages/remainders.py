"""What a model leaves of its channel, with all that it may depend on."""

from plants.measured.fitting.stage import begun
from plants.measured.residual.series.remainder import Remainder, variables
from plants.measured.trace.stages.model import Model


def remainders(model: Model) -> list[Remainder]:
    """What a model leaves of its channel in each recording, measured minus simulated."""
    stage, found = model.stage, []
    simulated = model.residual * stage.noise + stage.target
    whole = model.wrist
    for i, (playback, a, b) in enumerate(
        zip(stage.playbacks, stage.edges[:-1], stage.edges[1:], strict=True)
    ):
        if stage.name == "regulator":
            pressure, angle = simulated[a:b], None
        elif stage.drives is not None:
            pressure, angle = stage.drives[i][playback.rows], simulated[a:b]
        else:
            begin = None if stage.begins is None else stage.begins[i]
            pressure, angle = playback.play(whole, begun(whole, begin))
        found.append(
            Remainder(
                playback.recording.name, "regulator" if stage.name == "regulator" else "wrist",
                playback.recording.time, stage.target[a:b] - simulated[a:b], stage.noise,
                variables(playback.recording, pressure, angle),
            )
        )  # fmt: skip
    return found
