"""The command ``wrist``: one module a command, options that they share in `design.cli.common`.

Exit codes: 0 done; 1 the answer is no (a requirement cannot be met); 2 bad input, in one line; 70 a bug of
this program; 130 stopped with Ctrl-C.

Little is imported before `main` runs, so that Ctrl-C during a start is told like any other.
"""


def main(arguments: list[str] | None = None) -> None:
    """Run the command and leave with its exit code; errors in one line on stderr.

    arguments: those of the process where None, which then also hears Ctrl-C whatever it is doing.
    """
    import os

    # Before NumPy is loaded: on matrices as small as these BLAS's threads wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    code = 130
    try:
        from design.cli.errors import answered
        from design.cli.terminal.stopping import hear_stop
        from design.cli.terminal.streams import outliving

        stop = hear_stop() if arguments is None else None
        with outliving() as lost:
            code = answered(arguments, stop)
            if lost() and code == 0:
                code = 2
    except KeyboardInterrupt:  # before anybody listened
        import sys

        print("wrist: stopped", file=sys.stderr)
    raise SystemExit(code)
