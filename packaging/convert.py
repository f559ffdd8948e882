#!/usr/bin/env python3
"""Gives study files (of version 2 or 3) and process files the keys of now, comments and layout kept: packaging/convert.py FILE.toml...

A folder stands for the study.toml in it. A file that has no old key is named and left as it is; one that is neither a study nor a process file,
or whose change cannot be proved right, is refused. With --columns, columns and statuses in CSV tables of results are renamed instead, as
CHANGELOG.md lists them: packaging/convert.py --columns results/mine/*.csv
"""

import argparse
import os
import re
import sys
import tempfile
import tomllib
from pathlib import Path

# What studies of version 2 call otherwise: tables, keys, and what may be named as a quantity or a metric.
TABLES = {"held": "locked", "turn_map": "redundancy_map"}
QUANTITIES = {"error_left": "residual_error", "departure": "superposition_error"}
# What results call otherwise, as parts of names.
COLUMNS = [
    (r"\brho_held_", "rho_carrier_"),
    (r"departures_fitted", "superposition_errors_fitted"),
    (r"departure", "superposition_error"),
    (r"error_left", "residual_error"),
    (r"leftover_rotation", "residual_rotation"),
    (r"\b(best_|worst_|constant_)?turn_deg\b", r"\1gamma_deg"),
    (r"\bturn_(\w+)_deg\b", r"gamma_\1_deg"),
    (r"\bturns_possible\b", "gammas_possible"),
]
STATUSES = {"given_up": "pruned", "no_band": "no_continuous_path", "snapped": "snap_through"}


class Refused(Exception):
    """Why a file is left as it is, in words for who gave it."""


def renamed_process(tables):
    """The tables of a process with the names of now."""
    old = next((key for key in ("tool_turn", "redundancy") if key in tables), None)
    if old is None:
        return tables
    own = {"gamma" if key == "redundancy" else key: value for key, value in tables[old].items()}
    return {"redundancy" if key == old else key: own if key == old else value for key, value in tables.items()}


def renamed(tree):
    """The file of now that a parsed process file, or a parsed study of version 2 or 3, is."""
    if "question" not in tree:
        return renamed_process(tree)
    if isinstance(tree.get("process"), dict):
        tree = {**tree, "process": renamed_process(tree["process"])}
    if tree["schema"] == 3:
        return tree
    new = {TABLES.get(key, key): value for key, value in tree.items()}
    new["schema"] = 3
    if (own := new.get("redundancy_map")) is not None and "turn_step_deg" in own:
        new["redundancy_map"] = {"gamma_step_deg" if key == "turn_step_deg" else key: value for key, value in own.items()}
    if (own := new.get("validation")) is not None and "quoted" in own:
        quoted = [{**one, "quantity": QUANTITIES.get(one.get("quantity"), one.get("quantity"))} for one in own["quoted"]]
        new["validation"] = {**own, "quoted": quoted}
    if (own := new.get("placement", {}).get("objective")) is not None:
        own = dict(own)
        if "weights" in own:
            own["weights"] = {QUANTITIES.get(key, key): value for key, value in own["weights"].items()}
        if "pareto" in own:
            own["pareto"] = [QUANTITIES.get(one, one) for one in own["pareto"]]
        new["placement"] = {**new["placement"], "objective": own}
    return new


def line_of_version_3(line):
    """A line of a study of version 2 with the names of version 3."""
    line = re.sub(r'^(\s*"?schema"?\s*=\s*)2(?=\s|#|$)', r"\g<1>3", line)
    line = re.sub(r"^(\s*\[+\s*)(held|turn_map)\b", lambda m: m[1] + TABLES[m[2]], line)
    line = re.sub(r"^(\s*)(held|turn_map)(?=\s*[.=])", lambda m: m[1] + TABLES[m[2]], line)
    if re.match(r"\s*(\w+\.)*(quantity|pareto)\s*=", line):
        line = re.sub(r"([\"'])(error_left|departure)\1", lambda m: m[1] + QUANTITIES[m[2]] + m[1], line)
    if not re.match(r"\s*(question|machine|branch|process|name)\s*=", line):
        line = re.sub(r"^(\s*|.*[{,.]\s*)turn_step_deg(?=\s*=)", r"\1gamma_step_deg", line)
        line = re.sub(r"(?<![\w\"'])departure(?=\s*=\s*[-+.\d])", QUANTITIES["departure"], line)
    return line


def renamed_file(text):
    """The text with the keys of now, which is read as the file that it was."""
    text = text.removeprefix("\ufeff")
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise Refused(f"is not TOML: {fault}") from fault
    version = tree.get("schema")
    if version not in ((2, 3) if "question" in tree else (1,)):
        raise Refused(f"is neither a study of version 2 or 3 nor a process file of version 1 (it has version {version})")
    lines = []
    header = ""
    for line in text.splitlines(keepends=True):
        if found := re.match(r"\s*\[+\s*([\w.]+)", line):
            header = found[1]
        line = re.sub(r"^(\s*\[\s*(?:process\.)?)tool_turn\b", r"\1redundancy", line)
        line = re.sub(r"^(\s*(?:process\.)?)tool_turn(?=\s*[.=])", r"\1redundancy", line)
        if header in ("tool_turn", "process.tool_turn", "redundancy", "process.redundancy"):
            line = re.sub(r"^(\s*)redundancy(?=\s*=)", r"\1gamma", line)
        line = re.sub(r"^(\s*(?:process\.)?redundancy\s*(?:\.|=\s*\{\s*))redundancy(?=\s*=)", r"\1gamma", line)
        lines.append(line_of_version_3(line) if version == 2 else line)
    new = "".join(lines)
    try:
        is_right = tomllib.loads(new) == renamed(tree)
    except (tomllib.TOMLDecodeError, AttributeError, TypeError, ValueError):
        is_right = False
    if not is_right:
        raise Refused("is written in a way that is not changed without a doubt: change it by hand, as CHANGELOG.md lists")
    return new


def columns(text):
    """The CSV table with the names of this version: its header, and the statuses in its cells."""
    header, end, rows = text.partition("\n")
    for old, new in COLUMNS:
        header = re.sub(old, new, header)
    cell = "|".join(STATUSES)
    return header + end + re.sub(rf"(?m)(?<=,)({cell})(?=,|\r?$)", lambda m: STATUSES[m[1]], rows)


def put(path, text):
    """Writes the file whole or not at all."""
    if not os.access(path, os.W_OK):
        raise Refused("may not be written")
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8", newline="") as new:
        new.write(text)
    try:
        os.chmod(new.name, path.stat().st_mode)
        os.replace(new.name, path)
    except OSError:
        os.unlink(new.name)
        raise


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", type=Path)
    parser.add_argument("--columns", action="store_true", help="CSV tables of results instead of studies and processes")
    options = parser.parse_args()
    code = 0
    for path in options.files:
        try:
            file = (path / "study.toml" if path.is_dir() and not options.columns else path).resolve()
            old = file.read_bytes().decode()
            new = columns(old) if options.columns else renamed_file(old)
            if new == old:
                print(f"{path}: nothing to change")
            else:
                put(file, new)
                print(f"{path}: changed")
        except Refused as fault:
            print(f"{path}: {fault}; left as it is")
            code = max(code, 1)
        except (OSError, RuntimeError, UnicodeDecodeError) as fault:
            print(f"error: {path}: {fault}", file=sys.stderr)
            code = 2
    return code


if __name__ == "__main__":
    sys.exit(main())
