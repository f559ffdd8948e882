#!/usr/bin/env bash
# What uncertain inputs cost: benches/uncertain_map.sh [points along each axis, default 11] [runs of which the shortest counts, default 3]
#
# Maps of an arm and of a hexapod, 36 tool angles, one thread, without figures: with exact inputs, with six uncertain stiffnesses, and with thirty
# parameters (24 errors of chains or lengths more); the force is uncertain as well. All in turns. "Computation" leaves out what a map of one point with
# exact inputs takes, which is start, tables and page.
set -euo pipefail
cd "$(dirname "$0")/.."
grid=${1:-11} runs=${2:-3}
cargo build --release --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

force='[process.force.path_frame]\nradial_force_N = 800.0\ntangential_force_N = 300.0\naxial_force_N = -200.0\n'
exact() { printf '[uncertainty]\nmachine = "exact"\n'; }
vary() { printf '[[uncertainty.parameter]]\nname = "%s"\n%s\n' "$1" "$2"; }
forces() { printf '[uncertainty.process]\nforce_relative_std = 0.15\n'; }
# The slice of pictures, which are not drawn, must be within the workspace.
declare -A slice=([kr270]=850.0 [hexapod]=800.0)
study() {
    mkdir -p "$folder/$1_$2"
    { printf 'schema = 3\nquestion = "?"\nmachine = "%s"\n' "$1"; cat; printf "$force"'[workspace_map]\nslices_z_mm = [%s]\n' "${slice[$1]}"; } > "$folder/$1_$2/study.toml"
}
six_arm() { vary 'arm.*.stiffness' 'relative_std = 0.2'; }
six_legs() { vary leg.screw.stiffness 'relative_std = 0.2'; }
study kr270 0 < /dev/null
{ exact; six_arm; forces; } | study kr270 6
{
    exact
    six_arm
    vary 'arm.fixed_2.translation.*' 'std = 0.1'
    vary 'arm.fixed_3.translation.*' 'std = 0.1'
    printf '[[uncertainty.chain_error]]\nchain = "*"\nbase_translation_mm = { std = 0.1 }\nbase_rotation_deg = { std = 0.01 }\n'
    printf 'end_translation_mm = { std = 0.1 }\nend_rotation_deg = { std = 0.01 }\ndrive_offsets_mm_or_deg = { std = 0.01 }\n'
    forces
} | study kr270 30
study hexapod 0 < /dev/null
{ exact; six_legs; forces; } | study hexapod 6
{
    exact
    six_legs
    printf '[[uncertainty.chain_error]]\nchain = "*"\nbase_translation_mm = { std = 0.05 }\ndrive_offsets_mm_or_deg = { std = 0.02 }\n'
    forces
} | study hexapod 30

TIMEFORMAT='%U %S %R'
# Adds a line of what a map takes with so many points along each axis.
measure() {
    rm -rf "$folder/results"
    if ! { time target/release/kinetostat run "$folder/$1" --grid "$2" --threads 1 --no-figures --out "$folder/results" &> "$folder/said"; } 2> "$folder/time"; then
        cat "$folder/said" >&2
        exit 1
    fi
    echo "$3 $(cat "$folder/time")" >> "$folder/times"
}
for ((run = 0; run < runs; run++)); do
    for machine in kr270 hexapod; do
        measure ${machine}_0 1 ${machine}_start
        for count in 0 6 30; do measure ${machine}_$count "$grid" ${machine}_$count; done
    done
done
awk '
    { processor = $2 + $3; if (!($1 in least) || processor < least[$1]) { least[$1] = processor; clock[$1] = $4 } }
    END {
        machines[1] = "kr270"; machines[2] = "hexapod"; counts[1] = 0; counts[2] = 6; counts[3] = 30
        for (m = 1; m <= 2; m++) for (c = 1; c <= 3; c++) {
            machine = machines[m]; own = machine "_" counts[c]; nominal = machine "_0"; start = machine "_start"
            printf "%s, %d uncertain parameters: processor %.2f s, clock %.2f s; times as long as with exact inputs: %.1f, computation %.1f\n", machine,
                counts[c], least[own], clock[own], least[own] / least[nominal], (least[own] - least[start]) / (least[nominal] - least[start])
        }
    }' "$folder/times"
