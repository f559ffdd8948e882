#!/usr/bin/env bash
# Runs examples/slurm_array.sh without Slurm: tests/parts/slurm.sh PROGRAM
#
# Arrays are loops that set what Slurm sets. A map and a placement in two rounds, submitted whole; arrays from 0 on; a task that is
# run twice; one that failed and is run again. Results are those of a single run, byte for byte.
set -euo pipefail
program=$(realpath "$1")
script=$(realpath "$(dirname "$0")/../../examples/slurm_array.sh")
studies=$(realpath "$(dirname "$0")/../../studies")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export KINETOSTAT=$program SLURM_CPUS_PER_TASK=2
# sbatch: the tasks of an array one after another, the last one first; a job whose dependency is not known is refused.
mkdir bin jobs
cat > bin/sbatch <<'SBATCH'
#!/usr/bin/env bash
set -euo pipefail
array=
while [[ $1 == --* ]]; do
    case $1 in
    --array=1-*) array=${1#--array=1-} ;;
    --dependency=afterok:*) test -e "jobs/${1#--dependency=afterok:}" ;;
    esac
    shift
done
if [ -n "$array" ]; then
    for task in $(seq "$array" -1 1); do
        SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=$array SLURM_ARRAY_TASK_MIN=1 bash "$@" >> log
    done
else
    bash "$@" >> log
fi
job=$(($(ls jobs | wc -l) + 1))
touch "jobs/$job"
echo "$job;cluster"
SBATCH
chmod +x bin/sbatch
export PATH="$folder/bin:$PATH"

cp -r "$studies/05_superposition" "$studies/03_placement_circle" .
sed -i 's/^grid = .*/grid = [3, 3, 4]/' 05_superposition/study.toml
sed -i 's/^grid = .*/grid = { x = 3, y = 3, z = 1 }/; s/^starts = .*/starts = 1/; s/^max_iterations = .*/max_iterations = 8/' 03_placement_circle/study.toml
"$program" run 05_superposition --out whole --no-figures --progress none > /dev/null
"$program" run 03_placement_circle --out placed --no-figures --progress none > /dev/null

"$script" submit 05_superposition 3 merged --no-figures
diff -r whole merged
ROUNDS=3 "$script" submit 03_placement_circle 2 placed_in_parts --no-figures
diff -r placed placed_in_parts
test "$(ls parts/03_placement_circle | wc -l)" = 6

# From 0 on, and task 1 twice.
for task in 0 1 1; do
    FOLDER=from_0 SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=2 SLURM_ARRAY_TASK_MIN=0 "$script" part 05_superposition > told
done
grep -q "is there already" told
FOLDER=from_0 "$script" merge 05_superposition from_0_merged --no-figures > /dev/null
diff -r whole from_0_merged

# A task that failed, computed again alone.
rm from_0/part_0002_of_0002.kpart
FOLDER=from_0 "$script" merge 05_superposition again --no-figures 2> said && exit 1
grep -q "part 2 of 2: is missing" said
PARTS=2 FOLDER=from_0 SLURM_ARRAY_TASK_ID=2 SLURM_ARRAY_TASK_COUNT=1 SLURM_ARRAY_TASK_MIN=2 "$script" part 05_superposition > /dev/null
FOLDER=from_0 "$script" merge 05_superposition again --no-figures > /dev/null
diff -r whole again
echo "The parts of an array, merged, are a single run."
