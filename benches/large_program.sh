#!/usr/bin/env bash
# Time and memory of a long program: benches/large_program.sh [lines, default 1000000] [method, default direct]
#
# `compensate` of a finishing pass of short G1 lines on the Orthoglide, with the process of study 02: read, compensated, written,
# read back, simulated as written, table and page made. Prints points per second and core, and memory as GNU time sees it
# (Debian: package time).
set -euo pipefail
cd "$(dirname "$0")/.."
lines=${1:-1000000}
method=${2:-direct}
cargo build --release --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# There and back over 50 mm × 50 mm, on a surface of waves that is 2 mm deep.
awk -v lines="$lines" 'BEGIN {
    print "G21 G90 G17"; print "G0 X-25 Y-25 Z5"; print "G1 Z-1 F600"
    across = int(sqrt(lines)); step = 50 / across
    for (k = 0; k < lines; k++) {
        row = int(k / across); i = k % across; if (row % 2) i = across - 1 - i
        x = -25 + step * i; y = -25 + step * row
        printf "G1 X%.3f Y%.3f Z%.3f\n", x, y, -1 + sin(x / 4) * cos(y / 5)
    }
    print "G0 Z5"; print "M30"
}' > "$folder/program.nc"
ls -l "$folder/program.nc"
/usr/bin/time -f '%e %U %S %M' -o "$folder/time" "${CARGO_TARGET_DIR:-target}/release/kinetostat" compensate "$folder/program.nc" \
    --machine orthoglide --process studies/02_groove_50mm/process_program.toml --method "$method" --out "$folder/out.nc"
ls -l "$folder"
awk -v lines="$lines" '{
    printf "clock %s s, processor %s s + %s s, largest memory %.0f MB\n", $1, $2, $3, $4 / 1024
    printf "%.0f points per second of processor time\n", lines / ($2 + $3)
}' "$folder/time"
