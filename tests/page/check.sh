#!/usr/bin/env bash
# Makes pages as README and guide do and looks at them in browsers: tests/page/check.sh brief|all OUT PROGRAM PYTHON
#
# brief: the studies of README and guide for few points; the page of a map in full, those of a path and a placement in brief, in Chromium. all: the
# pages of every kind, of comparisons, of identifications and plans, and of a machine of each kind, in Chromium and Firefox. PYTHON has
# what requirements.txt names.
set -euo pipefail
which=$1 out=$2 program=$3 python=$4
cd "$(dirname "$0")/../.."
kinetostat() {
    "$program" "$@"
}
check() {
    "$python" tests/page/check_pages.py "$@"
}
kinetostat run studies/01_workspace_map --grid 5 --out "$out/map"
test -s "$out/map/map.csv"
kinetostat run studies/02_groove_50mm --points 73 --out "$out/groove"
kinetostat compensate studies/02_groove_50mm/groove.nc --machine orthoglide \
    --process studies/02_groove_50mm/process_program.toml --out "$out/groove.nc"
test -s "$out/groove.nc"
# Exactly placed: of few places more can be cut.
cp -r studies/03_placement_circle "$out/exactly_placed"
printf '[placement.allowance]\nposition_mm = 0.0\nangle_deg = 0.0\n' >> "$out/exactly_placed/study.toml"
kinetostat run "$out/exactly_placed" --grid 3 --out "$out/circle"
if [ "$which" = brief ]; then
    check "$out/map/report.html" &
    failed=0
    check --brief "$out/groove/report.html" "$out/circle/report.html" || failed=1
    wait $! || failed=1
    exit "$failed"
fi
kinetostat run studies/04_placement_pocket --grid 3 --out "$out/pocket"
kinetostat run studies/06_paper --points 37 --out "$out/paper"
kinetostat run studies/05_superposition --grid 3 --out "$out/superposition"
kinetostat run studies/01_workspace_map --grid 3 --out "$out/map_of_27"
kinetostat report "$out/map" "$out/map_of_27" --out "$out/comparison.html"
kinetostat run studies/02_groove_50mm --points 37 --out "$out/groove_of_37" --no-figures
kinetostat compare "$out/groove" "$out/groove_of_37" --tolerance 0.1 --out "$out/paths.html"
kinetostat compare "$out/circle" "$out/pocket" --out "$out/places.html"
# The part that a program leaves of its stock.
kinetostat compensate tests/page/stock/pocket.nc --machine orthoglide --process tests/page/stock/pocket.toml --out "$out/part.nc"
check "$out"/{map,groove,circle,pocket,superposition,paper}/report.html "$out"/{comparison,paths,places}.html "$out/part.nc.html"
# Of what is measured, and what to measure next.
kinetostat new identification "$out/mine"
kinetostat identify "$out/mine" --out "$out/found"
kinetostat new measurements "$out/next"
kinetostat design-measurements "$out/next" --out "$out/plan"
check --brief "$out"/{found,plan}/report.html
# A page for each built-in machine; those of one machine of each kind are looked at.
"$python" tests/page/catalogue.py "$out/catalogue" "$program"
check --brief "$out"/catalogue/{delta_3puu,fanuc_r2000ic,hexapod,rotary_delta}/report.html
node tests/page/firefox.mjs "$out"/{map,groove,circle,pocket,superposition,paper,found,plan}/report.html \
    "$out"/{comparison,paths,places}.html "$out"/catalogue/{delta_3puu,fanuc_r2000ic,hexapod,rotary_delta}/report.html
