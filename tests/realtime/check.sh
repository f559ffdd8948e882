#!/usr/bin/env bash
# Builds what export-realtime writes and holds it against the program: tests/realtime/check.sh [COUNT [ROUNDS]]
#
# The Orthoglide is exported, with errors of its chains; the static library is built by cargo and linked by C without warnings; its answers are
# those of the program to 1e-6 mm; nothing in it panics; COUNT (100000) random states are timed, the shortest of ROUNDS (3)
# calls each. Where valgrind is there, calls are counted in instructions: least and most differ by less than 0.5 %.
# KINETOSTAT names the program, target/release/kinetostat if nothing does, which is built then.
set -euo pipefail
cd "$(dirname "$0")/../.."
count=${1:-100000}
rounds=${2:-3}
program=${KINETOSTAT:-}
if [ -z "$program" ]; then
    cargo build --release --quiet
    program=target/release/kinetostat
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/errors.toml" <<'PROCESS'
schema = 1

[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0

[[chain_error]]
chain = "y"
turn_about_drive_axis_deg = -1.0

[[chain_error]]
chain = "z"
turn_about_drive_axis_deg = 1.0
PROCESS
"$program" export-realtime --machine orthoglide --process "$folder/errors.toml" --out "$folder/made"
cd "$folder/made"
RUSTFLAGS="-D warnings" cargo build --release --quiet --target-dir target
library=target/release/libkinetostat_correction.a
symbols=$(nm "$library" 2> /dev/null)
for name in correct where nominal; do
    grep -q " T kinetostat_$name\$" <<< "$symbols"
done
if grep -i panic <<< "$symbols"; then
    echo "the library has a panic path" >&2
    exit 1
fi
for example in main time; do
    cc -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -Iinclude "example/$example.c" "$library" -lm -o "$example"
done
./main | tail -n 1
./time "$count" "$rounds"
if command -v valgrind > /dev/null; then
    for name in kinetostat_correct kinetostat_where; do
        valgrind --quiet --tool=callgrind --toggle-collect="$name" --dump-after="$name" --callgrind-out-file="$name.calls" ./time 50
        # The last file is what follows the last call.
        grep -h '^totals: ' "$name".calls.* | sort -k 2 -n | awk -v name="$name" '
            $2 > 1000 { if (!least) least = $2; most = $2; calls++ }
            END {
                printf "%s: %d to %d instructions in %d calls\n", name, least, most, calls
                exit !(calls >= 50 && most <= 1.005 * least)
            }'
    done
fi
