#!/usr/bin/env bash
# A new question is one folder and one line: adds the folder `reach` beside this script and its line in
# src/questions/mod.rs to a copy of the sources, shows the difference, and runs `kinetostat new reach` and the study it writes.
#
# usage: tests/question/add.sh    (CARGO_TARGET_DIR shares what is built already)
set -euo pipefail
cd "$(dirname "$0")/../.."
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
mkdir "$copy/benches"
cp -r src crates examples studies Cargo.toml Cargo.lock "$copy"
cp benches/*.rs "$copy/benches"
cp -r benches/peers "$copy/benches"
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
cp -r tests/question/reach "$copy/src/questions/reach"
sed -i 's|^        validation: Validation(validation::ValidationStudy),$|&\n        reach: Reach(reach::ReachStudy),|' "$copy/src/questions/mod.rs"
diff -r src "$copy/src" || true
changed=$(diff src/questions/mod.rs "$copy/src/questions/mod.rs" | grep -c '^[<>]' || true)
if [ "$changed" != 1 ] || [ "$(diff -rq src "$copy/src" | wc -l)" != 2 ]; then
    echo "expected one folder and one line" >&2
    exit 1
fi
cd "$copy"
# With the packages that tests are built with, and as quickly as it can be built itself.
kinetostat() {
    cargo run --quiet --all-features --config profile.dev.package.kinetostat.opt-level=0 --config profile.dev.package.kinetostat.debug=false -- "$@"
}
kinetostat new reach far
kinetostat run far
test -s results/far/ways.csv
test -s results/far/report.html
