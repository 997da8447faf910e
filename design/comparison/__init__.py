"""Controllers compared on the standard tasks, with bounds, execution times and the break-even map."""
