#!/usr/bin/env python3
"""Lines of Rust by room: code, comments, tests (modules under cfg(test), and all of the folder tests); blank lines apart.

    scripts/lines.py [FOLDER]     default: this clone
"""

import subprocess
import sys
from collections import Counter
from pathlib import Path

root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[1])
rooms = Counter()
listed = subprocess.run(["git", "ls-files", "*.rs"], cwd=root, capture_output=True, text=True, check=True)
for name in listed.stdout.split():
    parts = Path(name).parts
    room = parts[1] if parts[0] == "crates" else parts[0]
    is_test = room == "tests" or parts[-1] == "tests.rs" or "tests" in parts[2:]
    for line in (root / name).read_text(encoding="utf-8").splitlines():
        line = line.strip()
        # The house writes tests at the end of a file.
        is_test = is_test or line == "mod tests {"
        if line:
            rooms[room, "tests" if is_test else "comments" if line.startswith("//") else "code"] += 1
kinds = ("code", "comments", "tests")
print(f"{'room':10}", *(f"{kind:>9}" for kind in kinds))
for room in sorted({room for room, _ in rooms}):
    print(f"{room:10}", *(f"{rooms[room, kind]:9}" for kind in kinds))
print(f"{'all':10}", *(f"{sum(n for (_, of), n in rooms.items() if of == kind):9}" for kind in kinds))
