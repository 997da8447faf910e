"""Other people's rigs: traces and friction laws beside what users would take instead."""
