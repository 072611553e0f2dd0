#!/usr/bin/env bash
# Runs the recipes of this folder with the real programs: shards under GNU parallel and as a Slurm array (controller and worker on this
# machine), one shard killed half-way and run again; the union must be the bytes of the unsharded run.
#
#   examples/shards/check.sh [STIFFBENCH]
#
# What is not installed is named and skipped, with exit code 77 if anything was; Slurm also needs root, for a cluster of its own.
#   Debian: apt-get install parallel slurm-wlm munge
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
STIFFBENCH=$(realpath "${1:-$(command -v stiffbench)}")
export STIFFBENCH
work=$(mktemp -d)
# Daemons that this script started, by number.
daemons=()
clean() {
    for daemon in "${daemons[@]}"; do kill "$daemon" 2> /dev/null || true; done
    wait
    rm -rf "$work"
}
trap clean EXIT
cd "$work"
skipped=0
skip() {
    echo "SKIPPED: $*" >&2
    skipped=77
}

# A law that is not linear goes pose by pose: slow enough to kill a shard at work, quick enough to wait for.
study=(--mechanisms F --samples 60000 --directions x,y,z --seed 3 --effect 'joint-backlash@A4B:play=0.12mrad,seat_moment=0.05N*m'
    --at-load 50)
"$STIFFBENCH" robot map "${study[@]}" --out whole --quiet > /dev/null

# Waits for a condition, at most so many seconds.
within() {
    local seconds=$1
    shift
    for ((i = 0; i < 10 * seconds; i++)); do
        if "$@"; then return 0; fi
        sleep 0.1
    done
    return 1
}

# The process that works out a shard of a folder, once there is one.
worker() {
    pid=$(pgrep -n -f -- "--shard $1 --out $2" || true)
    [ -n "$pid" ]
}

gnu_parallel() {
    "$here/parallel.sh" 4 "$work/parallel" "${study[@]}" 2> parallel.txt &
    local recipe=$!
    within 30 worker 2/4 "$work/parallel/shards"
    kill -KILL "$pid"
    if wait "$recipe"; then
        echo "a killed shard went unnoticed" >&2
        return 1
    fi
    test ! -e "$work/parallel/shards/2-of-4.map-shard"
    "$here/parallel.sh" 4 "$work/parallel" "${study[@]}"
    diff -r whole "$work/parallel/map"
    echo "GNU parallel: four shards, one killed and run again, joined to the same bytes"
}

# A cluster of one machine: keys, controller and worker of its own.
cluster() {
    mkdir -p slurm/state slurm/spool slurm/munge slurm/socket
    chmod 700 slurm/munge
    chmod 755 "$work"
    dd if=/dev/urandom of=slurm/munge/key bs=32 count=1 2> /dev/null
    chmod 400 slurm/munge/key
    local socket=$work/slurm/socket/munge name cores
    munged --foreground --force --key-file slurm/munge/key --socket "$socket" --pid-file slurm/munge/pid \
        --log-file slurm/munge/log --seed-file slurm/munge/seed 2> slurm/munge.err &
    daemons+=($!)
    name=$(hostname -s)
    cores=$(nproc)
    cat > slurm/slurm.conf <<CONF
ClusterName=shards
SlurmctldHost=$name
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$socket
CryptoType=crypto/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/slurmd.pid
SlurmctldLogFile=$work/slurm/slurmctld.log
SlurmdLogFile=$work/slurm/slurmd.log
MpiDefault=none
SchedulerType=sched/backfill
NodeName=$name CPUs=$cores State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    export SLURM_CONF=$work/slurm/slurm.conf
    within 10 test -S "$socket"
    slurmctld -D -f "$SLURM_CONF" > slurm/ctld.out 2>&1 &
    daemons+=($!)
    slurmd -D -f "$SLURM_CONF" > slurm/d.out 2>&1 &
    daemons+=($!)
    within 30 up
}

up() {
    sinfo -h -o %T 2> /dev/null | grep -q -E '^(idle|mixed|alloc)'
}

ended() {
    [ -z "$(squeue -h -j "$1" 2> /dev/null)" ]
}

slurm() {
    cluster
    export SHARDS=4 FOLDER=$work/slurm-map
    local job again
    job=$(sbatch --parsable --array=1-4 --export=ALL "$here/slurm.sbatch" "${study[@]}")
    within 60 worker 2/4 "$FOLDER/shards"
    kill -KILL "$pid"
    within 120 ended "$job"
    test ! -e "$FOLDER/shards/2-of-4.map-shard"
    again=$(sbatch --parsable --array=2 --export=ALL "$here/slurm.sbatch" "${study[@]}")
    sbatch --parsable --dependency="afterok:$again" --output merge.log \
        --wrap "'$STIFFBENCH' robot map merge '$FOLDER'/shards/*.map-shard --out '$FOLDER/map' --quiet" > merge.job
    within 120 ended "$(cat merge.job)"
    diff -r whole "$FOLDER/map"
    echo "Slurm: an array of four shards, one killed and run again, joined to the same bytes"
}

if command -v parallel > /dev/null && parallel --version 2> /dev/null | grep -q GNU; then
    gnu_parallel
else
    skip "GNU parallel is not installed"
fi
if ! command -v slurmctld > /dev/null || ! command -v slurmd > /dev/null || ! command -v munged > /dev/null; then
    skip "Slurm is not installed"
elif [ "$(id -u)" != 0 ]; then
    skip "Slurm needs root here"
else
    slurm
fi
exit "$skipped"
