#!/bin/sh
# Instructions per particle evaluation, counted by valgrind: the same on a busy machine, so that commits can be compared.
#
#   scripts/instructions.sh              both motions, the made dam break of 10 000 particles
#   scripts/instructions.sh 2500         another number of particles
#   scripts/instructions.sh 10000 perf   by the counters of the processor (perf stat), with the loops that this machine takes
#
# Two runs of one bench, of 2 and of 6 steps; their difference leaves out everything but the steps. Prints CSV: motion, particles,
# instructions per evaluation, evaluations, counter. valgrind knows no AVX-512: the loops take their AVX2 copies, as on most machines.
set -eu
cd "$(dirname "$0")/.."
particles=${1:-10000}
counter=${2:-valgrind}
command -v "$counter" >/dev/null || { echo "please install $counter" >&2; exit 1; }
bench=$(cargo bench --locked --bench measure --no-run 2>&1 | sed -n 's/.*Executable.*(\(.*\))/\1/p')
[ -x "$bench" ] || { echo "the bench was not built" >&2; exit 1; }
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT

# Evaluations and instructions of so many steps.
count() {
    if [ "$counter" = perf ]; then
        evaluations=$(perf stat -x, -e instructions:u "$bench" steps "$1" "$particles" "$2" 2>"$counts")
        echo "$evaluations $(sed -n 's/,.*instructions.*//p' "$counts")"
    else
        evaluations=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null "$bench" steps "$1" "$particles" "$2" 2>"$counts")
        echo "$evaluations $(sed -n 's/.*Collected : //p' "$counts")"
    fi
}

echo "motion,particles,instructions_per_evaluation,particle_evaluations,counter"
for motion in eulerian lagrangian; do
    short=$(count "$motion" 2)
    long=$(count "$motion" 6)
    echo "$short $long" | awk -v motion="$motion" -v particles="$particles" -v counter="$counter" \
        '{ printf "%s,%d,%.1f,%d,%s\n", motion, particles, ($4 - $2) / ($3 - $1), $3 - $1, counter }'
done
