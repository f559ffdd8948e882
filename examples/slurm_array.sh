#!/usr/bin/env bash
#SBATCH --job-name=kinetostat
#SBATCH --cpus-per-task=8
#SBATCH --time=04:00:00
#SBATCH --requeue
# A study on a cluster with Slurm: each task of a job array computes a part, and a job that waits for all of them merges.
#
#   examples/slurm_array.sh submit STUDY PARTS RESULT [OPTION…]    from a folder that all nodes see; options of sbatch: the lines above
#   sbatch --array=1-PARTS examples/slurm_array.sh part STUDY      the same by hand, first step
#   examples/slurm_array.sh merge STUDY RESULT [OPTION…]           and second step; options are those of kinetostat merge
#
# Variables: KINETOSTAT, the program [kinetostat]; FOLDER, where the parts are left [parts/NAME]; ROUNDS, for placements, how many
# rounds are shared before merging [1]; PARTS, how many parts there are where only some are computed again, as in
# PARTS=10 sbatch --array=3,7 examples/slurm_array.sh part STUDY.
# A task that was stopped, requeued or submitted again goes on where it was; a part that is there already is left alone.
set -euo pipefail
usage() {
    sed -n 's/^# \{0,1\}//p' "$0" | tail -n +2 >&2
    exit 2
}
[ $# -ge 2 ] || usage
verb=$1
study=$2
program=${KINETOSTAT:-kinetostat}
folder=${FOLDER:-parts/$(basename "$study")}
case $verb in
submit)
    [ $# -ge 4 ] || usage
    export PARTS=$3 FOLDER=$folder ROUND
    after=()
    for ROUND in $(seq "${ROUNDS:-1}"); do
        array=$(sbatch --parsable "${after[@]}" --array="1-$PARTS" "$0" part "$study")
        after=(--dependency="afterok:${array%%;*}" --kill-on-invalid-dep=yes)
    done
    merge=$(sbatch --parsable "${after[@]}" "$0" merge "$study" "${@:4}")
    echo "Submitted: parts as job ${array%%;*}, then the merge as job ${merge%%;*}."
    ;;
part)
    parts=${PARTS:-$SLURM_ARRAY_TASK_COUNT}
    # Numbers of an array may begin at 0.
    first=1
    [ -n "${PARTS:-}" ] || first=${SLURM_ARRAY_TASK_MIN:-1}
    exec "$program" run "$study" --part "$((SLURM_ARRAY_TASK_ID - first + 1))/$parts" --round "${ROUND:-1}" --out "$folder" \
        --threads "${SLURM_CPUS_PER_TASK:-1}" --resume --progress none
    ;;
merge)
    [ $# -ge 3 ] || usage
    exec "$program" merge "$folder" --study "$study" --out "$3" --threads "${SLURM_CPUS_PER_TASK:-1}" --resume --progress none "${@:4}"
    ;;
*) usage ;;
esac
