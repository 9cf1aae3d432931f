#!/usr/bin/env python3
"""Checks the pages of slipmap in a browser: on a phone, on a screen and on paper.

    scripts/checks/pages.py PAGE.html [--most-pages N] [--pictures FOLDER]

Debian's chromium shows the page at 420 and at 1200 pixels and prints it to A4. It fails if anything but tables and listings
is wider than the window, if the page asks for anything from elsewhere, if a printed page holds columns of single letters (words
that were broken to fit), or if there are more pages than N. FOLDER receives what was seen. Exit code 0 if all holds.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

WIDTHS = (420, 1200)


def chromium(folder, *arguments):
    command = [
        "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
        f"--user-data-dir={folder}/profile", *arguments,
    ]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=120).stdout


def overflow(folder, page, width):
    """By how many pixels the page is wider than a window of this width."""
    # Headless windows are at least 500 pixels wide, so the page is measured in a frame of the width instead.
    text = page.read_text()
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    inner = Path(folder) / "inner.html"
    inner.write_text(text.replace("</body>", "<script>parent.postMessage(document.documentElement.scrollWidth, '*')</script></body>"))
    outer = Path(folder) / "outer.html"
    outer.write_text(
        "<!DOCTYPE html><body><p id=width></p><script>addEventListener('message', e => "
        "document.getElementById('width').textContent = e.data)</script>"
        f"<iframe src=inner.html style='width:{width}px;height:900px;border:0'></iframe></body>"
    )
    dom = chromium(folder, "--virtual-time-budget=5000", "--window-size=1400,1000", "--dump-dom", f"file://{outer}")
    found = re.search(r'id="width">(\d+)<', dom)
    if not found:
        sys.exit("FAILED: the browser did not tell the width of the page")
    return int(found.group(1)) - width


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("--most-pages", type=int, default=10)
    parser.add_argument("--pictures", type=Path)
    arguments = parser.parse_args()
    page = arguments.page.resolve()
    failures = []
    if re.search(r'(?:src|href)\s*=(?!"#)|url\((?!#)|@import|<script', page.read_text()):
        failures.append("the page asks for things from elsewhere")
    with tempfile.TemporaryDirectory() as folder:
        for width in WIDTHS:
            beyond = overflow(folder, page, width)
            print(f"at {width} px: {max(beyond, 0)} px wider than the window")
            if beyond > 0:
                failures.append(f"at {width} px the page is {beyond} px too wide")
        pdf = Path(folder) / "page.pdf"
        chromium(folder, "--no-pdf-header-footer", f"--print-to-pdf={pdf}", f"file://{page}")
        pages = subprocess.run(["pdftotext", "-layout", pdf, "-"], check=True, capture_output=True, text=True).stdout
        pages = pages.split("\f")[:-1]
        print(f"on paper: {len(pages)} pages")
        if len(pages) > arguments.most_pages:
            failures.append(f"it prints to {len(pages)} pages, not to {arguments.most_pages} at most")
        for number, text in enumerate(pages, 1):
            lines = [line.split() for line in text.splitlines() if line.strip()]
            # A broken word appears as many lines of one letter each, one below the other.
            letters = run = 0
            for words in lines:
                run = run + 1 if len(words) == 1 and len(words[0]) == 1 and words[0].isalpha() else 0
                letters = max(letters, run)
            if letters > 4:
                failures.append(f"page {number} of the print has {letters} lines of one letter")
        if arguments.pictures:
            arguments.pictures.mkdir(parents=True, exist_ok=True)
            (arguments.pictures / "print.pdf").write_bytes(pdf.read_bytes())
            for width in WIDTHS:
                shot = arguments.pictures / f"page-{width}.png"
                chromium(folder, f"--window-size={width},1600", f"--screenshot={shot}", f"file://{page}")
    for failure in failures:
        print(f"FAILED: {failure}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
