#!/usr/bin/env bash
# Time and memory of a large workspace map: benches/large_map.sh [points along each axis, default 100]
#
# Study 01 with 4 tool angles instead of 36, the table as CSV. 216 are ten million points: 11 GB of table, 5 GB of state
# while it runs. Prints memory as GNU time sees it (Debian: package time).
set -euo pipefail
cd "$(dirname "$0")/.."
grid=${1:-100}
cargo build --release --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/large_map"
sed 's/^phi_step_deg = 10.0$/phi_step_deg = 90.0/' studies/01_workspace_map/study.toml > "$folder/large_map/study.toml"
/usr/bin/time -f 'clock %e s, processor %U s + %S s, largest memory %M kB' \
    target/release/kinetostat run "$folder/large_map" --grid "$grid" --out "$folder/results"
ls -l "$folder/results/map.csv"
