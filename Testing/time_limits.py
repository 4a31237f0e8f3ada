# SPDX-License-Identifier: BSD-3-Clause
"""How long tests wait: longer where a machine is slow or busy. As a program, prints the pace for CMake."""
import math
import time

# Of the loop below, where the limits were chosen, beside another program.
REFERENCE_SECONDS = 0.2


def measure_pace():
    """How many times longer work takes than where the limits were chosen: a whole number."""
    begin = time.perf_counter()
    total = 0
    for number in range(1_500_000):
        total += number * number
    return max(1, math.ceil((time.perf_counter() - begin) / REFERENCE_SECONDS))


# For a program that a test starts. Beyond it, the program hangs.
WAIT_SECONDS = 600 * measure_pace()

if __name__ == "__main__":
    print(measure_pace())
