"""Controllers as values: settings, a pure law compiled with the plant; `controller.py` says what one is."""
