#!/usr/bin/env bash
# Builds the wheel, installs it into a clean environment and runs its tests, notebooks, examples and type checks: python/check.sh [OUT]
#
# PROFILE says how packaging/make.py builds the wheel: dev (if nothing is said) is the quickest; release is the one for others, whose source
# distribution must also build alone. KINETOSTAT names the program that studies are held against; without, they are not. OUT is the
# folder of the wheel.
set -euo pipefail
if [ -n "${KINETOSTAT:-}" ]; then
    KINETOSTAT=$(realpath "$KINETOSTAT")
    export KINETOSTAT
fi
cd "$(dirname "$0")"
profile=${PROFILE:-dev}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
wheels=${1:-$folder/wheels}
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --requirement tests/requirements.txt
export PATH="$folder/venv/bin:$PATH"
wheel=$(python ../packaging/make.py wheel --profile "$profile" --out "$wheels")
if [ "$profile" = release ]; then
    maturin sdist --out "$folder/source" 2> "$folder/said" || { cat "$folder/said"; exit 1; }
    mkdir "$folder/unpacked"
    tar -xf "$folder"/source/kinetostat-*.tar.gz -C "$folder/unpacked"
    cargo check --quiet --locked --manifest-path "$folder"/unpacked/kinetostat-*/python/Cargo.toml --target-dir "$folder/checked"
fi
pip install --quiet --no-index "$wheel"
cargo fmt --check
ruff format --quiet --check .
ruff check --quiet .
# Nothing of this folder is on the way to the package that was installed.
cp -r tests notebooks examples pyproject.toml "$folder"
export REPOSITORY="$PWD/.."
cd "$folder"
pytest --quiet tests
for example in examples/*.py; do
    python "$example" > "$folder/said"
    test -s "$folder/said"
done
mypy --strict -p kinetostat
mypy --strict examples
stubtest kinetostat._kinetostat
pyright --pythonpath "$folder/venv/bin/python" examples
