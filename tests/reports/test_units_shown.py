"""Figures and words are in the units of the rig that is shown; the axis of its angle says what is zero."""

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from plants.rig import Zero, built_in_rig
from reports.shared.units import ANGLE, in_units, relabel, show


@pytest.fixture(autouse=True)
def built_in_again():
    yield
    show(built_in_rig())


def labelled() -> list[str]:
    figure = Figure()
    axes = figure.subplots()
    axes.set(xlabel="Pressure [kPa]", ylabel=ANGLE, title="Angle [deg] of a step of 15 deg")
    relabel(figure)
    return [axes.get_xlabel(), axes.get_ylabel(), axes.get_title()]


def test_the_built_in_rig_is_shown_as_it_is_written():
    show(built_in_rig())
    assert labelled() == ["Pressure [kPa]", "Angle [deg]", "Angle [deg] of a step of 15 deg"]


def test_an_angle_that_is_counted_from_elsewhere_says_so_on_its_axis_alone():
    show(replace(built_in_rig(), zero=Zero(3.0, 26.04)))
    assert labelled() == ["Pressure [kPa]", "Angle from 26.04 [deg]", "Angle [deg] of a step of 15 deg"]


def test_it_does_so_in_the_units_of_the_rig():
    rig = built_in_rig()
    show(replace(rig, zero=Zero(0.0, -7.5), units=replace(rig.units, angle="mm", pressure="bar")))
    assert labelled() == ["Pressure [bar]", "Angle from -7.5 [mm]", "Angle [mm] of a step of 15 mm"]
    assert in_units("12 kPa and 3 degrees") == "12 bar and 3 mm"
