#!/bin/sh
# Disks and clocks as farms have them: sh tests/shares.sh PROGRAM TOWN
#
# A small town is made by workers that are killed at random moments (KILLS, 20), by two that see one folder by two paths and whose
# clocks are ten minutes apart, on a disk that is full in the middle of the work, and read from one that is read-only; the
# stacks have to be those of one `update`, byte for byte. With Debian's slurm-wlm two nodes of one machine take the jobs that Snakemake
# hands to a Slurm cluster. What cannot be had or is not allowed is left out by name; tests/full.sh runs it after tests/farm.sh, which installs Snakemake. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
. examples/setup.sh
whole() { (cd "$(dirname "$1")" && printf '%s/%s' "$PWD" "$(basename "$1")"); }
[ $# -eq 2 ] || fail "usage: sh tests/shares.sh PROGRAM TOWN"
program=$(whole "$1")
town=$(whole "$2")
tools=$(whole "${CARGO_TARGET_DIR:-target}")/farm-python
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1
began=$(date +%s)
step() { printf '== %4d s  %s\n' $(($(date +%s) - began)) "$*"; }

work=$(mktemp -d)
running=
mounted=
slurm=
conf=
leave() {
    for process in $running $slurm; do kill "$process" 2>/dev/null || true; done
    [ -z "$conf" ] || rm -f "$conf"
    for folder in $mounted; do umount "$folder" 2>/dev/null || true; done
    rm -rf "$work"
}
trap leave EXIT
trap 'exit 130' INT TERM
memory="--memory 512M"
"$town" "$work/town" --photos "${PHOTOS:-8}" --width "${WIDTH:-300}" >/dev/null
project() {
    "$program" --quiet new "$1" --photos "$work/town/photos" --cameras "$work/town/sparse" --model "$work/town/town.obj" >/dev/null
}
bytes() { (cd "$1/stacks" && find . -type f | sort | xargs sha256sum); }
same() {
    bytes "$1" >"$work/bytes"
    diff "$work/alone.bytes" "$work/bytes" >"$work/diff" || { head -n 20 "$work/diff" >&2; fail "$2: other stacks"; }
    step "$2: the same bytes"
}
project "$work/alone"
# shellcheck disable=SC2086 # several words
"$program" --quiet update "$work/alone" $memory >/dev/null
bytes "$work/alone" >"$work/alone.bytes"
step "one machine: $(wc -l <"$work/alone.bytes") files"

project "$work/killed"
killed=0
runs=0
while [ "$killed" -lt "${KILLS:-20}" ]; do
    runs=$((runs + 1))
    [ "$runs" -le $((4 * ${KILLS:-20})) ] || fail "updates end before they are killed: take more photos, or larger ones"
    # shellcheck disable=SC2086
    "$program" --quiet update "$work/killed" $memory >/dev/null 2>&1 &
    running=$!
    sleep "$(awk -v seed="$runs" 'BEGIN { srand(seed); printf "%.2f", 0.1 + 2.4 * rand() }')"
    kill -9 "$running" 2>/dev/null || true
    if wait "$running" 2>/dev/null; then
        # It was done. Derived files may go at any time.
        rm -rf "$work/killed/cache" "$work/killed/stacks/0001.jpg" "$work/killed/stacks/0004.jpg"
    else
        killed=$((killed + 1))
    fi
    running=
done
# shellcheck disable=SC2086
"$program" --quiet update "$work/killed" $memory >/dev/null
same "$work/killed" "killed $killed times at random moments, and run again"

# Two paths of one folder: a bind mount where that is allowed, else a link. And two clocks.
project "$work/shared"
mkdir "$work/other"
if mount --bind "$work/shared" "$work/other" 2>/dev/null; then
    mounted="$work/other"
    paths="by a bind mount"
else
    rmdir "$work/other"
    ln -s "$work/shared" "$work/other"
    paths="by a link"
fi
ahead=
if command -v faketime >/dev/null; then
    ahead="faketime -f +10m"
    clocks="clocks ten minutes apart"
else
    say "shares: clocks apart are left out, because faketime is missing"
    clocks="one clock"
fi
# Workers for stacks first, then for fillings, as jobs of a plan follow each other.
for stage in "build --stacks-only" "fill"; do
    # shellcheck disable=SC2086
    $ahead "$program" --quiet $stage "$work/other" $memory >/dev/null &
    running=$!
    # shellcheck disable=SC2086
    "$program" --quiet $stage "$work/shared" $memory >/dev/null
    wait "$running"
    running=
done
# shellcheck disable=SC2086
"$program" --quiet update "$work/shared" $memory >/dev/null
same "$work/shared" "two workers on one folder, which one of them sees $paths, $clocks"

mkdir "$work/disk"
if mount -t tmpfs -o size=1m shares "$work/disk" 2>/dev/null; then
    mounted="$mounted $work/disk"
    project "$work/disk/site"
    # shellcheck disable=SC2086
    if "$program" --quiet update "$work/disk/site" $memory >/dev/null 2>"$work/log"; then fail "the disk was too large to become full"; fi
    grep -q 'the disk is full' "$work/log" || { cat "$work/log" >&2; fail "nobody says that the disk is full"; }
    mount -o remount,size=100m "$work/disk"
    # shellcheck disable=SC2086
    "$program" --quiet update "$work/disk/site" $memory >/dev/null
    same "$work/disk/site" "a disk that was full in the middle"
    mount -o remount,ro "$work/disk"
    "$program" --quiet info "$work/disk/site" >/dev/null
    "$program" status "$work/disk/site" | grep -q 'everything is done' || fail "status of a read-only disk"
    "$program" --quiet render "$work/disk/site" --cameras photos --size 90x60 --out "$work/views" >/dev/null
    if "$program" --quiet build "$work/disk/site" --force >/dev/null 2>"$work/log"; then fail "written to a read-only disk"; fi
    grep -q 'read-only' "$work/log" || { cat "$work/log" >&2; fail "nobody says that the disk is read-only"; }
    step "a read-only disk: read, and told"
else
    say "shares: a full disk and a read-only one are left out, because nothing can be mounted here"
fi

# A Slurm cluster of one controller and two nodes, all of this machine.
slurm_ready() {
    for tool in slurmctld slurmd sbatch munged; do
        command -v $tool >/dev/null || { say "shares: Slurm is left out, because $tool is missing: apt install slurm-wlm"; return 1; }
    done
    [ "$(id -u)" -eq 0 ] || { say "shares: Slurm is left out, because only root may start its nodes"; return 1; }
    [ ! -e /etc/slurm/slurm.conf ] || { say "shares: Slurm is left out, because this machine has a cluster of its own"; return 1; }
    [ -x "$tools/bin/snakemake" ] || { say "shares: Slurm is left out, because Snakemake is missing"; return 1; }
    "$tools/bin/python" -m pip install --quiet snakemake-executor-plugin-slurm || { say "shares: Slurm is left out: no executor of Snakemake for it"; return 1; }
}
if slurm_ready; then
    mkdir -p "$work/slurm/state" "$work/slurm/n1" "$work/slurm/n2" /run/munge
    chown munge /run/munge
    pgrep -x munged >/dev/null || su -s /bin/sh munge -c munged || fail "munged"
    host=$(hostname -s)
    cat >"$work/slurm/slurm.conf" <<EOF
ClusterName=shares
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
AuthType=auth/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
MinJobAge=600
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/%n
SlurmdPidFile=$work/slurm/%n.pid
SlurmctldPidFile=$work/slurm/control.pid
SlurmctldLogFile=$work/slurm/control.log
SlurmdLogFile=$work/slurm/%n.log
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=16821 CPUs=1 RealMemory=8000 State=UNKNOWN
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=16822 CPUs=1 RealMemory=8000 State=UNKNOWN
PartitionName=nodes Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
EOF
    # Steps of jobs look for it there, whatever their surroundings say.
    ln -s "$work/slurm/slurm.conf" /etc/slurm/slurm.conf
    conf=/etc/slurm/slurm.conf
    slurmctld -D >/dev/null 2>&1 &
    slurm=$!
    for node in n1 n2; do
        slurmd -D -N $node >/dev/null 2>&1 &
        slurm="$slurm $!"
    done
    for _ in $(seq 100); do
        [ "$(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l)" -eq 2 ] && break
        sleep 0.3
    done
    if [ "$(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l)" -ne 2 ]; then
        tail -n 5 "$work"/slurm/*.log >&2
        say "shares: Slurm is left out, because its two nodes do not come up here"
    else
        project "$work/cluster"
        # shellcheck disable=SC2086
        "$program" --quiet plan "$work/cluster" --for snakemake --out "$work/jobs" --cores 1 $memory --photos-per-job 2 >/dev/null
        (cd "$work/jobs" && "$tools/bin/snakemake" --executor slurm --slurm-status-command squeue --jobs 2 --quiet all --latency-wait 20 \
            --default-resources slurm_partition=nodes runtime=30 --config "program=$program") >"$work/log" 2>&1 ||
            { tail -n 40 "$work/log" >&2; fail "Snakemake on Slurm"; }
        same "$work/cluster" "Snakemake's executor for Slurm, two nodes"
    fi
fi
step "shares: passed"
