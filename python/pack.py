"""Packs a wheel anew, as small as its format allows, with the licences of what it is made of."""

from __future__ import annotations

import base64
import hashlib
import zipfile
from pathlib import Path

from zopfli import ZipFile


def record(name: str, content: bytes) -> str:
    """The line of a wheel's RECORD for a file."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
    return f"{name},sha256={digest},{len(content)}\n"


def pack(wheel: Path, licences: dict[str, bytes]) -> None:
    """In place; `licences` by the names of their files."""
    packed = wheel.with_suffix(".partial")
    with zipfile.ZipFile(wheel) as old, ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
        entries = old.infolist()
        # The record comes last, as whoever unpacks a wheel expects.
        [last] = [entry for entry in entries if entry.filename.endswith(".dist-info/RECORD")]
        text = old.read(last).decode()
        for entry in entries:
            if entry is not last:
                new.writestr(entry, old.read(entry))
        for name, content in sorted(licences.items()):
            entry = zipfile.ZipInfo(last.filename.replace("RECORD", f"licenses/{name}"), last.date_time)
            entry.external_attr, entry.compress_type = last.external_attr, zipfile.ZIP_DEFLATED
            new.writestr(entry, content)
            text += record(entry.filename, content)
        new.writestr(last, text)
    packed.replace(wheel)
