"""How often true answers lie within the 95 % intervals that are stated for measured friction.

    scripts/study measured [CASES=300] [PAGES=20] [FIRST=0] [WHAT]

Synthetic measurements of five laws, as `crates/config/src/measured/coverage.rs` has them, with fixed seeds: the critical dampings of CASES
fits and as many tables, and of fits and curves of as many records over time, a second each, and the critical belt speeds
and kicks of PAGES, which take several seconds each; or only of WHAT: fits, tables, fits of records, records.
"""

import os
import subprocess
import sys

given = sys.argv[1:]
cases, pages, first, what = given + ["300", "20", "0", ""][len(given) :]
command = "cargo test --release --locked -p slipmap-config --lib measured::coverage::coverage -- --ignored --nocapture"
numbers = {"SLIPMAP_CASES": cases, "SLIPMAP_PAGES": pages, "SLIPMAP_FIRST": first, "SLIPMAP_WHAT": what}
sys.exit(subprocess.run(command.split(), env={**os.environ, **numbers}).returncode)
