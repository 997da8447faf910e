"""From a law to machine code: the only room that knows CasADi and numba.

`pytrees` are states and coefficients as flat lists; `graphs` calls a step function once with CasADi
symbols; `emitter` writes the graph down as a program, of which `arithmetic` makes machine code;
`templates` lays that into a loop over lanes, `inlining` into loops that others write; `cache` keeps the
machine code on disk; `batches` runs many rollouts side by side.
"""
