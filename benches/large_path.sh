#!/usr/bin/env bash
# Time and memory of a long path: benches/large_path.sh [points, default 400000]
#
# Study 02 with two methods instead of all, the table as CSV, with figures and page. 400 000 points: 0.5 GB of table. Prints
# memory as GNU time sees it (Debian: package time).
set -euo pipefail
cd "$(dirname "$0")/.."
points=${1:-400000}
cargo build --release --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp -r studies/02_groove_50mm "$folder/large_path"
sed -i '/^\[path\]$/a methods = ["none", "direct"]' "$folder/large_path/study.toml"
/usr/bin/time -f 'clock %e s, processor %U s + %S s, largest memory %M kB' \
    target/release/kinetostat run "$folder/large_path" --points "$points" --out "$folder/results"
ls -l "$folder/results/points.csv" "$folder/results/report.html"
