"""What pip calls to build: maturin, whose wheels are packed anew, as small as their format allows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import maturin
from maturin import (
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

from pack import pack

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]


def build_wheel(
    wheel_directory: str, config_settings: dict[str, Any] | None = None, metadata_directory: str | None = None
) -> str:
    """The name of the wheel that is in `wheel_directory` then."""
    name: str = maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    pack(Path(wheel_directory, name), {})
    return name
