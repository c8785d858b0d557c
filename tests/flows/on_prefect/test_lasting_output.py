"""A run that writes to a reader which is gone goes on."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.real_time
WRITES = """
import logging, os, sys
from rich.console import Console
from flows.signals import resilient_output
console = Console(stderr=True)
with resilient_output():
    print("before", file=sys.stderr, flush=True)
    sys.stdin.readline()
    for number in range(3):
        console.print("by rich, which would end the process")
        print("plainly", file=sys.stderr, flush=True)
        os.write(1, b"by the system")
console.print("and after it")
print("went on", file=open(sys.argv[1], "w"))
"""


def test_what_is_written_after_the_reader_died_ends_nothing(tmp_path) -> None:
    out = tmp_path / "end"
    process = subprocess.Popen(
        [sys.executable, "-c", WRITES, str(out)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin
    assert process.stdout
    assert process.stderr
    assert process.stderr.readline() == b"before\n"
    process.stdout.close()
    process.stderr.close()
    process.stdin.write(b"\n")
    process.stdin.close()
    assert process.wait(60) == 0
    assert out.read_text() == "went on\n"


def test_a_reader_that_lives_gets_every_line_and_a_child_that_lives_on_keeps_nobody_waiting() -> (
    None
):
    code = (
        "import os, subprocess, sys\nfrom flows.signals import resilient_output\n"
        "with resilient_output():\n"
        "    for number in range(2000): os.write(1, b'%d\\n' % number)\n"
        "    child = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=subprocess.PIPE)\n"
        "os.write(1, b'after\\n')\n"
        "child.stdin.write(b'\\n'); child.stdin.close(); child.wait()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=True, timeout=120
    )
    assert done.stdout.split() == [*(b"%d" % number for number in range(2000)), b"after"]
