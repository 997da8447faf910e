"""The plant as C and as functional mock-up units, for simulators that do not run Python."""
