#!/usr/bin/env python3
"""Changes study files of version 2 to version 3, comments and layout kept: packaging/convert.py STUDY.toml...

A file that is no study of version 2 (machine and process files, which are read as before, studies of another version) is named and left as
it is. With --columns, names of columns, statuses and keys in tables and JSON files of results are changed instead, as CHANGELOG.md lists
them: packaging/convert.py --columns results/mine/*.csv results/mine/*.json
"""

import argparse
import os
import re
import sys
import tempfile
from pathlib import Path

# What studies of version 2 call otherwise: tables, keys, and values in quotes.
TABLES = {"held": "locked", "turn_map": "redundancy_map"}
KEYS = {"turn_step_deg": "gamma_step_deg", "departure": "superposition_error"}
VALUES = {"error_left": "residual_error", "departure": "superposition_error"}
# What results call otherwise, as parts of names.
COLUMNS = [
    (r"\brho_held_", "rho_locked_"),
    (r"departures_fitted", "superposition_errors_fitted"),
    (r"departure", "superposition_error"),
    (r"error_left", "residual_error"),
    (r"leftover_rotation", "residual_rotation"),
    (r"\bgiven_up\b", "pruned"),
    (r"\bno_band\b", "no_continuous_path"),
    (r"\bsnapped\b", "snap_through"),
    (r"\b(best_|worst_|constant_)?turn_deg\b", r"\1gamma_deg"),
    (r"\bturn_(min|max)_deg\b", r"gamma_\1_deg"),
    (r"\bturn_(\w+)_deg\b", r"gamma_\1_deg"),
    (r"\bturns_possible\b", "gammas_possible"),
]


def study(text):
    """The text of version 3; None where it is no study of version 2."""
    if not re.search(r"(?m)^\s*schema\s*=\s*2\b", text) or not re.search(r"(?m)^\s*question\s*=", text):
        return None
    lines = []
    for line in text.splitlines(keepends=True):
        code, mark, comment = line.partition("#")
        code = re.sub(r"^(\s*schema\s*=\s*)2\b", r"\g<1>3", code)
        code = re.sub(r"^(\s*\[+\s*)(\w+)", lambda m: m[1] + TABLES.get(m[2], m[2]), code)
        code = re.sub(r"([\w]+)(?=\s*=)", lambda m: KEYS.get(m[1], m[1]), code)
        code = re.sub(r"^(\s*)(\w+)(?=\.\w+\s*=)", lambda m: m[1] + TABLES.get(m[2], m[2]), code)
        code = re.sub(r'(["\'])(\w+)\1', lambda m: m[1] + VALUES.get(m[2], m[2]) + m[1], code)
        lines.append(code + mark + comment)
    return "".join(lines)


def columns(text):
    """The text with the names of this version."""
    for old, new in COLUMNS:
        text = re.sub(old, new, text)
    return text


def put(path, text):
    """Writes the file whole or not at all."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8", newline="") as new:
        new.write(text)
    os.chmod(new.name, path.stat().st_mode)
    os.replace(new.name, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", type=Path)
    parser.add_argument("--columns", action="store_true", help="files of results instead of studies")
    options = parser.parse_args()
    failed = 0
    for path in options.files:
        try:
            old = path.read_bytes().decode()
            new = columns(old) if options.columns else study(old)
            if new is None:
                print(f"{path}: no study of version 2, left as it is")
            elif new == old:
                print(f"{path}: nothing to change")
            else:
                put(path, new)
                print(f"{path}: changed")
        except (OSError, UnicodeDecodeError) as fault:
            print(f"error: {path}: {fault}", file=sys.stderr)
            failed = 2
    return failed


if __name__ == "__main__":
    sys.exit(main())
