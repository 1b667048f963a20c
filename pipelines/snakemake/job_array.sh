#!/bin/sh
# A sweep as a plain Slurm job array, without Snakemake:
#
#   n=$(contact3d-pipe sweep plan SWEEP.toml DIR | grep -c '"id"')
#   sbatch --array=0-$((n - 1)) job_array.sh SWEEP.toml DIR
#   contact3d-pipe sweep summary SWEEP.toml DIR      # when all jobs have ended
#
# Not for warm_start: array jobs know no order. PROGRAM names another program than the one on PATH.
#SBATCH --job-name=contact3d-sweep
#SBATCH --cpus-per-task=1
set -eu
sweep=$1
out=$2
program=${PROGRAM:-contact3d-pipe}
case_id=$("$program" sweep plan "$sweep" "$out" \
    | sed -n 's/^ *"id": "\([0-9a-f]*\)",$/\1/p' | sed -n "$((SLURM_ARRAY_TASK_ID + 1))p")
exec "$program" sweep run-case "$sweep" "$out" "$case_id" \
    --threads "${SLURM_CPUS_PER_TASK:-1}" --retry-failed
