#!/usr/bin/env bash
# A map in shards under GNU parallel, on this machine or, with --sshlogin in PARALLEL, on several that share the folder.
#
#   examples/shards/parallel.sh 8 maps --samples 1000000 --mechanisms A,F
#
# works out eight shards of the study, two at a time, and joins them in the folder maps. Run it again after whatever stopped it: shards
# that were done are not worked out again. JOBS sets how many run at a time, STIFFBENCH the program.
set -euo pipefail
if [ $# -lt 2 ]; then
    sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
shards=$1 folder=$2
shift 2
program=${STIFFBENCH:-stiffbench}
mkdir -p "$folder"
export RAYON_NUM_THREADS=${RAYON_NUM_THREADS:-1}
parallel --jobs "${JOBS:-2}" --joblog "$folder/jobs.log" --resume-failed --quote \
    "$program" robot map "$@" --shard "{}/$shards" --out "$folder/shards" --quiet ::: $(seq "$shards")
"$program" robot map merge "$folder"/shards/*.map-shard --out "$folder/map" --quiet > /dev/null
