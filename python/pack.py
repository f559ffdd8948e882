"""Packs a wheel anew, as small as its format allows: python pack.py WHEEL"""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

from zopfli import ZipFile


def main() -> None:
    wheel = Path(sys.argv[1])
    packed = wheel.with_suffix(".partial")
    with zipfile.ZipFile(wheel) as old, ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.infolist():
            new.writestr(entry, old.read(entry))
    packed.replace(wheel)


if __name__ == "__main__":
    main()
