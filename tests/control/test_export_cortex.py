"""What docs/targets.md says of a Cortex-M4F is counted, and rightly for code of known size."""

import shutil

import numpy as np
import pytest

from design.export.cortex import emulator, toolchain
from design.export.cortex.__main__ import CLOCK_MHZ, HEAD, HEADING, row
from design.export.cortex.emulator import SHIFT, counted
from design.export.cortex.stack import deepest
from design.export.cortex.toolchain import COMPILER, CORE, FLAGS, missing, objects, said, sizes
from design.export.formats.folder import around
from design.export.table import EXEMPLARY, exemplary, written
from design.export.vectors import vector
from plants import InputError
from tests.control.c_target import WRIST
from tests.control.test_export_table import PAGE, table

needs_arm = pytest.mark.skipif(missing() is not None, reason=str(missing()))

KNOWN = """
#include "flexion_pi.h"
int flexion_pi_init(flexion_pi_state *s, float pressure, float angle)
{{
    (void)s; (void)pressure; (void)angle;
    return 0;
}}
int flexion_pi_step(flexion_pi_state *s, const flexion_pi_measured *m, float *out)
{{
    volatile char deep[{bytes}];
    (void)s; (void)m;
    deep[0] = 1;
    __asm volatile(".rept {nops}\\n nop\\n .endr");
    *out = 0;
    return deep[0] - 1;
}}
"""


@pytest.fixture(scope="module")
def pi():
    part = exemplary("pi", WRIST).at("single")
    return part, vector(part, WRIST, 60)


@pytest.fixture
def known(pi, tmp_path):
    """Counts, sizes and stack by the graph of a step with so many nops and so many bytes on the stack."""
    written(around(*pi), tmp_path)

    def ran(nops, size):
        (tmp_path / "known.c").write_text(KNOWN.format(nops=nops, bytes=size))
        words = [*FLAGS, "-fcallgraph-info=su", "-c", "known.c", "-o", "known.o"]
        said([COMPILER, *words], tmp_path)
        depth = deepest([(tmp_path / "known.ci").read_text()], "flexion_pi_step")[0]
        return (
            counted(*pi, ["known.o"], tmp_path),
            sizes("flexion_pi", "float", ["known.o"], tmp_path),
            depth,
        )

    return ran


@needs_arm
def test_what_is_counted_is_what_was_put_in(known):
    few, (small, ram), shallow = known(500, 64)
    many, (large, same), deep = known(1500, 1088)
    assert many.most - few.most == pytest.approx(1000, abs=1)
    assert 500 < few.mean <= few.most < 530  # the call, the frame, what is stored
    assert few.per_tick == pytest.approx(1e9 / 25e6 / 2**SHIFT, rel=1e-3)
    assert large - small == pytest.approx(2000, abs=8)  # a nop is two bytes
    assert ram == same
    assert deep - shallow == many.stack - few.stack == 1024
    assert 1088 <= deep <= many.stack < 1088 + 64


@needs_arm
def test_a_controller_answers_there_as_in_Python_within_its_budget(pi):
    cells = dict(zip(HEAD, row("pi", *pi), strict=True))
    assert 0.0 < float(cells["off from Python"].removesuffix(" V")) < 1e-5
    assert 100 < float(cells["instructions, most"]) < 2.0 * CLOCK_MHZ
    assert int(cells["stack, graph [B]"]) <= int(cells["stack, seen [B]"])


@needs_arm
def test_the_folder_says_what_it_takes_and_stays_an_export(pi, tmp_path):
    written(around(*pi), tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    text, data, bss = map(
        int, said(["make", "--no-print-directory", "size"], tmp_path).splitlines()[-1].split()[:3]
    )
    flash, _ = sizes("flexion_pi", "float", objects("flexion_pi", tmp_path), tmp_path)
    assert 500 < text < flash + 100  # its functions are not dropped where nobody calls them
    assert (data, bss) == (0, 0)  # nothing global
    said(["make", "--no-print-directory", "manifest"], tmp_path)
    assert set(before) <= {p.name for p in tmp_path.iterdir()}
    assert not (tmp_path / "size.o").exists()


@needs_arm
def test_code_that_does_not_compile_is_told_in_a_line(tmp_path):
    (tmp_path / "x.c").write_text("no C\n")
    with pytest.raises(InputError, match=rf"^{COMPILER} failed: .*error") as refused:
        objects("x", tmp_path)
    assert "\n" not in str(refused.value)


def test_the_page_has_each_controller_in_both_precisions_and_tells_the_goals_as_they_came_out():
    head, *rows = table(HEADING)
    assert head == list(HEAD)
    assert [cells[:2] for cells in rows] == [[k, p] for k in EXEMPLARY for p in ("double", "single")]
    most = {(r[0], r[1]): float(r[7].replace(",", "")) for r in rows}
    assert most["pi", "single"] < 2.0 * CLOCK_MHZ < most["pi", "double"]
    assert all(n > 1000.0 * CLOCK_MHZ for (kind, _), n in most.items() if kind.startswith("mpc"))
    assert f"| {most['pi', 'single']:,.0f} instructions: met" in PAGE
    assert f"| {most['pi', 'double']:,.0f}: short |" in PAGE
    mean = {(r[0], r[1]): r[6] for r in rows}
    for kind in ("mpc", "mpc-robust", "mpc-real-time", "mpc-real-time-robust"):
        told = f"| {kind} | {most[kind, 'single']:,.0f} | {mean[kind, 'single']} |"
        assert told in PAGE
    period = 20_000.0 * CLOCK_MHZ
    assert all((n < period) == (precision == "single") for (k, precision), n in most.items() if "mpc" in k)
    assert all(float(mean[k, "double"].replace(",", "")) > period for k, _ in most if "real-time" in k)
    for cells in rows:
        shown = float(cells[8].replace(",", ""))
        assert shown == pytest.approx(most[cells[0], cells[1]] / CLOCK_MHZ, abs=0.06)


def test_what_is_missing_is_told_in_a_line_with_what_to_install(monkeypatch):
    there = {"arm-none-eabi-gcc", "arm-none-eabi-size"}
    monkeypatch.setattr(toolchain.shutil, "which", lambda tool: tool if tool in there else None)
    monkeypatch.setattr(toolchain, "said", lambda *_: "/usr/lib/nano.specs\n")
    assert missing() == "not on this machine: qemu-system-arm; apt-get install qemu-system-arm"
    monkeypatch.setattr(toolchain, "said", lambda *_: "nano.specs\n")
    assert str(missing()).endswith("apt-get install qemu-system-arm libnewlib-arm-none-eabi")
    there.clear()
    assert "gcc-arm-none-eabi, binutils-arm-none-eabi, qemu-system-arm;" in str(missing())


NODE = 'node: {{ title: "{0}" label: "{0}\\nx.c:1:1\\n{1}" }}\n'
EDGE = 'edge: {{ sourcename: "{0}" targetname: "{1}" }}\n'


@pytest.mark.parametrize(
    ("graph", "words"),
    [
        (NODE.format("f", "8 bytes (static)") + EDGE.format("f", "f"), "f: calls itself"),
        (NODE.format("f", "8 bytes (dynamic)"), "f: a frame without a bound"),
        (NODE.format("f", "8 bytes (static)") + EDGE.format("f", "__indirect_call"), "through a pointer"),
    ],
)
def test_a_stack_without_a_bound_is_refused(graph, words):
    with pytest.raises(InputError, match=words):
        deepest([graph], "f")


KNOWN_SIZES = """
int f_init(void *s, double pressure, double angle) {{ (void)s; (void)pressure; (void)angle; return 0; }}
static volatile char kept[{bss}];
static volatile char given[{data}] = {{1}};
int f_step(void *s, const void *m, double *out)
{{
    (void)s; (void)m; (void)out;
    __asm volatile(".rept {nops}\\n nop\\n .endr");
    return kept[0] + given[0];
}}
"""
HEADER = "typedef struct { double x; } f_state;\ntypedef struct { double y; } f_measured;\n"
HEADER += "int f_init(void *s, double p, double a);\nint f_step(void *s, const void *m, double *out);\n"


@pytest.fixture
def on_this_machine(monkeypatch):
    """The compiler of this machine for the one for ARM, and an emulator that has counted already."""
    if shutil.which("gcc") is None or shutil.which("size") is None:
        pytest.skip("no gcc on this machine")
    really = toolchain.said

    def here(words, folder):
        if words[0] == toolchain.QEMU:
            return "mean 1200.4 most 1680 stack 96 worst 2e-07 tick 2.4\n"
        own = [w for w in words if w not in CORE and not w.startswith("--specs")]
        return "" if "measure.c" in own else really([own[0].removeprefix(toolchain.PREFIX), *own[1:]], folder)

    for module in (toolchain, emulator):
        monkeypatch.setattr(module, "said", here)
    return here


def test_flash_is_code_and_what_data_begin_with_and_ram_is_all_data(on_this_machine, tmp_path):
    (tmp_path / "f.h").write_text(HEADER)

    def measured(**sizes_of):
        (tmp_path / "f.c").write_text(KNOWN_SIZES.format(**{"bss": 64, "data": 64, "nops": 0, **sizes_of}))
        on_this_machine([COMPILER, *FLAGS, "-c", "f.c", "-o", "f.o"], tmp_path)
        return np.array(sizes("f", "double", ["f.o"], tmp_path))

    plain = measured()
    assert measured(nops=4096) - plain == pytest.approx([4096, 0], abs=16)  # a nop is a byte here
    assert measured(bss=64 + 4096) - plain == pytest.approx([0, 4096], abs=16)
    assert measured(data=64 + 4096) - plain == pytest.approx([4096, 4096], abs=16)


def test_a_line_of_the_table_has_what_the_tools_said(on_this_machine, pi, tmp_path):
    written(around(*pi), tmp_path)
    made = objects("flexion_pi", tmp_path)
    flash, ram = sizes("flexion_pi", pi[0].real, made, tmp_path)
    graphs = [(tmp_path / f"{name}.ci").read_text() for name in ("flexion_pi", "flexion_pi_law")]
    begun, stepped = (deepest(graphs, f"flexion_pi_{entry}")[0] for entry in ("init", "step"))
    assert begun < stepped
    cells = row("pi", *pi)
    assert cells[:6] == ["pi", "single", f"{flash:,}", f"{ram:,}", f"{stepped:,}", "96"]
    assert cells[6:] == ["1,200", "1,680", "10.0", "2e-07 V"]  # 1,680 at 168 MHz
