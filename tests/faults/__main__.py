"""`python3 -m tests.faults [--table] [--only FAULT]`: plays the matrix; exit status 1 where a cell is wrong."""
from __future__ import annotations

import argparse
import sys
import time

from .faults import FAULTS
from .matrix import play_matrix, table


def main() -> int:
    parser = argparse.ArgumentParser(prog="python3 -m tests.faults", description=__doc__)
    parser.add_argument("--table", action="store_true", help="print the matrix")
    parser.add_argument("--only", metavar="FAULT", choices=FAULTS, help=f"one of {', '.join(FAULTS)}")
    options = parser.parse_args()
    start = time.monotonic()
    outcomes = play_matrix([options.only] if options.only else list(FAULTS), all_again=True)
    wrong = [o for o in outcomes.values() if o.wrong]
    if options.table:
        print(table(outcomes))
    for outcome in wrong:
        print(f"\n{outcome.cell}: {'; '.join(outcome.wrong)}")
    skipped = sum(bool(o.skipped) for o in outcomes.values())
    reruns = sum(o.rerun for o in outcomes.values())
    print(f"\n{len(outcomes)} cells, {len(wrong)} wrong, {skipped} skipped, {reruns} run again in the same folder, "
          f"{time.monotonic() - start:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
