# SPDX-License-Identifier: BSD-3-Clause
"""Whether a library shows the functions of its header and no other symbol, and needs no library but those of C.

    symbols_test.py LIBRARY HEADER VERSION
"""

import re
import subprocess
import sys

library, header, version = sys.argv[1:]
text = open(header, encoding="utf-8").read()
declared = set(re.findall(r"SI_API [^;(]*?(si_\w+)\(", text))


def dump(option):
    return subprocess.run(["objdump", option, library], check=True, capture_output=True, text=True).stdout


symbols = [line.split() for line in dump("-T").splitlines() if " .text" in line or " .data" in line or " .bss" in line]
shown = {symbol[-1] for symbol in symbols}
needed = set(re.findall(r"NEEDED\s+(\S+)", dump("-p")))
known = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
major, minor, patch = map(int, version.split("."))
number = int(re.search(r"SI_VERSION (\d+)", text).group(1))
errors = [
    *(f"{symbol} is shown, but not in the header" for symbol in sorted(shown - declared)),
    *(f"{symbol} is in the header, but not shown" for symbol in sorted(declared - shown)),
    *(f"{name} is needed" for name in sorted(needed - known)),
    *([f"SI_VERSION is {number}, and not that of {version}"] if number != 10000 * major + 100 * minor + patch else []),
]
sys.exit("\n".join(errors) if errors or not declared else 0)
