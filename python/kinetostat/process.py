"""Processes: where the workpiece stands, the cutting force, errors of the machine's chains, limits."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, TypeAlias

from . import _kinetostat
from .machine import Machine

Tables: TypeAlias = Mapping[str, Any]


class Process:
    """A process on a machine, as process files say it (docs/process_file.md)."""

    __slots__ = ("_process", "machine")

    def __init__(self, machine: Machine, what: str | PathLike[str] | Tables) -> None:
        """The process file `what`, or its tables as a dictionary: ``{"force": {"path_frame": {"radial_force_N": 215.0,
        ...}}}``.

        Files that tables name are sought where Python runs. Raises :class:`Error` with file, key, value and what was
        expected.
        """
        if isinstance(what, Mapping):
            toml = _kinetostat.as_toml(json.dumps({"schema": 1, **what}))
            self._process = _kinetostat.Process.from_toml(toml, "process", ".", machine._machine)
        else:
            self._process = _kinetostat.Process.from_file(fspath(what), machine._machine)
        self.machine = machine

    @property
    def facts(self) -> dict[str, str]:
        """What it says, in words."""
        return dict(self._process.facts())

    @property
    def assumed(self) -> dict[str, str]:
        """What was assumed where it does not say, in words."""
        return dict(self._process.assumed())

    def __repr__(self) -> str:
        return f"Process on {self.machine.name}: " + "; ".join(f"{what}: {words}" for what, words in self.facts.items())
