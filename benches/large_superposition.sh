#!/usr/bin/env bash
# Time and memory of a large superposition map: benches/large_superposition.sh [points along each axis, default 40]
#
# Study 05 with 4 tool angles instead of 36 and loads of up to twice that of the study, the table as CSV. Prints memory as
# GNU time sees it (Debian: package time).
set -euo pipefail
cd "$(dirname "$0")/.."
grid=${1:-40}
cargo build --release --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/large_superposition"
sed 's/^phi_step_deg = 10.0$/phi_step_deg = 90.0/; s/^largest_factor = 16.0$/largest_factor = 2.0/' \
    studies/05_superposition/study.toml > "$folder/large_superposition/study.toml"
/usr/bin/time -f 'clock %e s, processor %U s + %S s, largest memory %M kB' \
    target/release/kinetostat run "$folder/large_superposition" --grid "$grid" --out "$folder/results"
ls -l "$folder/results/map.csv" "$folder/results/report.html"
