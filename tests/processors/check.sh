#!/usr/bin/env bash
# Runs every kind of study, single points and a program on this processor and on one without FMA and AVX: the bytes are the same.
#   tests/processors/check.sh PROGRAM FOLDER    needs qemu-x86_64; FOLDER, a new one, gets what both have written
set -euo pipefail
program=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
cd "$(dirname "$0")/../.."
kinds=(map path placement superposition validation online redundancy identification measurements)
for kind in "${kinds[@]}"; do
    "$program" new "$kind" "$folder/studies/$kind" > /dev/null
done
# What is computed is emulated: a few points of each will do.
sed -i 's/^grid = .*/grid = [2, 2, 2]/' "$folder"/studies/{map,superposition,redundancy}/study.toml
sed -i 's/^grid = .*/grid = { x = 2, y = 2 }/; s/^starts = .*/starts = 1/; s/^max_iterations = .*/max_iterations = 5/; s/points = 37/points = 9/' \
    "$folder/studies/placement/study.toml"
sed -i 's/^seeds = .*/seeds = 2/; s/points = 121/points = 31/' "$folder/studies/online/study.toml"

# all FOLDER RUNNER...: fills FOLDER with results.
all() {
    local out=$1
    shift
    mkdir -p "$out"
    # A part holds numbers as they are, where tables round them.
    for study in 05_superposition 07_robot_arm 08_three_architectures; do
        "$@" run "studies/$study" --grid 2 --part 1/1 --threads 1 --quiet --out "$out/part_$study"
    done
    "$@" run studies/07_robot_arm_path --points 7 --part 1/1 --threads 1 --quiet --out "$out/part_path"
    for kind in "${kinds[@]}"; do
        "$@" run "$folder/studies/$kind" --quiet --no-figures --threads 1 --out "$out/$kind"
    done
    "$@" run studies/01_workspace_map --grid 2 --quiet --threads 1 --out "$out/figures"
    "$@" point --machine orthoglide --at Q1 --phi 130 --chain-errors 1,-1,1 --json > "$out/orthoglide.json"
    "$@" point --machine kr270 --pose 1600,200,900,0,180,30 --full-pose --json > "$out/kr270.json"
    "$@" check hexapod > "$out/hexapod.txt"
    "$@" compensate studies/02_groove_50mm/groove.nc --machine orthoglide --process studies/02_groove_50mm/process.toml --quiet --out "$out/groove.nc"
}

all "$folder/here" "$program"
all "$folder/without" qemu-x86_64 -cpu Nehalem "$program"
diff -r "$folder/here" "$folder/without"
