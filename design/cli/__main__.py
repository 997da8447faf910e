"""``python -m design.cli`` is ``wrist``."""

from design.cli import main

if __name__ == "__main__":
    main()
