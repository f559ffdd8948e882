"""Tables of samples, and checks that print what they found."""

import csv


class Checks:
    """Prints a line for each figure; `end` is the exit code."""

    def __init__(self):
        self.failed = 0

    def at_most(self, what, found, most, unit="mm"):
        good = found <= most
        self.failed += not good
        print(f"  {'ok    ' if good else 'FAILED'} {what}: {found:.2e} {unit}, at most {most:g}")

    def holds(self, what, good):
        self.failed += not good
        print(f"  {'ok    ' if good else 'FAILED'} {what}")

    def end(self):
        return 1 if self.failed else 0


def read(path):
    """Rows of a table; every cell that is a number is one."""
    def number(cell):
        try:
            return float(cell)
        except ValueError:
            return {"True": 1.0, "False": 0.0}.get(cell, cell)

    with open(path, newline="") as file:
        return [{name: number(cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def three(row, name, suffixes="012"):
    return tuple(row[f"{name}_{suffix}"] for suffix in suffixes)


def place(row):
    return row["x"], row["y"], row["z"]


def distance(a, b):
    """Largest difference of a component."""
    return max(abs(p - q) for p, q in zip(a, b))


def largest_change(rows, name):
    """Largest change of a drive from row to row."""
    return max(distance(three(a, name), three(b, name)) for a, b in zip(rows, rows[1:]))
