"""What a controller makes of a measurement: implausible samples, and the memory of the plant."""
