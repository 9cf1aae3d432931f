"""What studies and evidence share: what a command costs, what a map holds, tables that are printed as they are written."""

import csv
import os
import subprocess
import sys
import time
from typing import NamedTuple

import h5py

# n^4 columns of n cells at one epsilon, but for `a` nodes of alpha.
FIVE_AXES = """
title = "n^5 cells at one epsilon"
[grid]
epsilon = 0.05
alpha = {{ from = 0.0, to = 1.0, points = {a} }}
beta = {{ from = 0.0, to = 0.5, points = {n} }}
gamma = {{ from = 0.0, to = 4.0, points = {n} }}
V = {{ from = 0.2, to = 1.5, points = {n} }}
c = {{ from = 0.0, to = 1.0, points = {n} }}
[output]
path = "map.h5"
fields = ["verdict"]
"""


class Ran(NamedTuple):
    """A command that has ended: its exit code, what it printed, and what it cost."""

    code: int
    said: str
    wall: float
    """seconds"""
    processor: float
    """seconds of all its threads"""
    memory: int
    """bytes at the most"""


def ended(command, folder=None, messages=subprocess.STDOUT, before=None):
    """Runs a command to its end; `messages` is where its standard error goes, `before` is called in the new process."""
    start = time.perf_counter()
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=messages, preexec_fn=before)
    said = process.stdout.read().decode(errors="replace")
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    return Ran(process.returncode, said, wall, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024)


def done(command, folder=None, messages=subprocess.STDOUT):
    """Runs a command that must not fail."""
    ran = ended(command, folder, messages)
    if ran.code:
        sys.exit(f"{ran.said}\n{command}: exit code {ran.code}")
    return ran


def fingerprints(path):
    """The fingerprint of every variable of a map."""
    with h5py.File(path) as file:
        return {name: bytes(data.attrs["sha256"]) for name, data in file.items() if isinstance(data, h5py.Dataset)}


def table(path, columns):
    """Begins a CSV file; returns the function that adds a row to it, and prints the row."""
    file = open(path, "w", newline="")
    targets = [(target, csv.writer(target, lineterminator="\n")) for target in (file, sys.stdout)]

    def add(row):
        for target, writer in targets:
            writer.writerow(row)
            target.flush()

    add(columns)
    return add
