#!/bin/sh
# A cluster of one node on this machine, and what it must do with a sweep: run it through Snakemake and Slurm, try a failed
# job again, end one at its time limit, take one back into the queue, with the same table as `contact3d-pipe sweep` each time.
#
#   apt-get install slurmctld slurmd slurm-client munge; pip install snakemake snakemake-executor-plugin-slurm
#   PROGRAM=target/release/contact3d-pipe sh pipelines/snakemake/one_node.sh [CASES]
#
# As root, on Debian 12. Daemons, keys and logs are in a folder of their own, and end with the script; on the machine itself
# only /etc/slurm/slurm.conf is made, where Snakemake's jobs look for it, and removed. CASES tiny cases (20 by default) are also timed: by the program, by Snakemake alone, and by Slurm.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cases=${1:-20}
PROGRAM=$(realpath "${PROGRAM:-$(command -v contact3d-pipe)}")
known=/etc/slurm/slurm.conf
[ ! -e $known ] || { echo "error: this machine has a cluster: $known" >&2; exit 2; }
scratch=$(mktemp -d)
daemons=
# Only what this script started is ended.
trap 'for daemon in $daemons; do kill "$daemon" 2>/dev/null || true; done; wait; rm -f $known; [ -n "${KEEP:-}" ] || rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM
cd "$scratch"
chmod 755 .
mkdir state spool munge

# --- the cluster --------------------------------------------------------------------------------------------------
head -c 1024 /dev/urandom > munge/key
chmod 700 munge
chmod 600 munge/key
node=$(hostname -s)
cat > slurm.conf <<END
ClusterName=one_node
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$scratch/munge/socket
CredType=cred/munge
StateSaveLocation=$scratch/state
SlurmdSpoolDir=$scratch/spool
SlurmctldPidFile=$scratch/slurmctld.pid
SlurmdPidFile=$scratch/slurmd.pid
SlurmctldLogFile=$scratch/slurmctld.log
SlurmdLogFile=$scratch/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_interval=5
KillWait=5
ReturnToService=2
JobRequeue=1
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.8) }' /proc/meminfo) State=UNKNOWN
PartitionName=all Nodes=$node Default=YES MaxTime=60 State=UP
END
mkdir -p /etc/slurm
ln -s "$scratch/slurm.conf" $known
munged --foreground --force --key-file=munge/key --socket=munge/socket --pid-file="$scratch/munge/pid" \
    --log-file="$scratch/munge/log" --seed-file="$scratch/munge/seed" > munged.out 2>&1 &
daemons="$daemons $!"
until [ -S munge/socket ]; do sleep 0.2; done
slurmctld -D > slurmctld.out 2>&1 &
daemons="$! $daemons"
slurmd -D -N "$node" > slurmd.out 2>&1 &
daemons="$! $daemons"
tries=0
until sinfo --noheader -o %t 2>/dev/null | grep -qx idle; do
    tries=$((tries + 1))
    [ $tries -lt 60 ] || { echo "error: no idle node" >&2; tail -n 5 slurm*.log >&2; exit 1; }
    sleep 1
done
echo "cluster: $(slurmd -V), $(sinfo --noheader -o '%D node, %c processors, %m MB, %t')"

# --- the sweep ----------------------------------------------------------------------------------------------------
write_sweep() { # FILE CASES
    cat > "$1" <<END
scene = "$here/../newton.toml"
[set]
"body.brick.cells" = [6, 2, 2]
[[axis]]
key = "contact.gap"
range = { from = 0.0, to = 1e-5, count = $2 }
END
}
write_sweep sweep.toml 4
write_sweep many.toml "$cases"
digest() { # FOLDER: what all cases of a table have found
    awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) if ($k == "solve_digest") c = k; next } { print $1, $c }' "$1/summary.csv"
}
same() { # FOLDER WHAT
    [ "$(digest "$1")" = "$(digest whole)" ] || { echo "error: $2: another table than that of sweep" >&2; exit 1; }
    echo "ok: $2"
}
"$PROGRAM" --quiet sweep sweep.toml whole --no-figures --jobs 1

# A program that does what FAULT says, the first time that the second case runs.
second=$("$PROGRAM" sweep plan sweep.toml whole | sed -n 's/^ *"id": "\([0-9a-f]*\)",$/\1/p' | sed -n 2p)
cat > faulty <<END
#!/bin/sh
case "\$*" in
*run-case*$second*)
    if mkdir "$scratch/\$FAULT.done" 2>/dev/null; then
        case \$FAULT in
        killed) kill -9 \$\$ ;;
        slow) sleep 300 ;;
        waits) sleep 20 ;;
        esac
    fi ;;
esac
exec "$PROGRAM" "\$@"
END
chmod +x faulty
through_slurm() { # PROGRAM SWEEP OUT and more
    program=$1 sweep=$2 out=$3
    shift 3
    snakemake -s "$here/Snakefile" --workflow-profile "$here/profiles/slurm" --quiet rules --latency-wait 5 \
        --slurm-status-command squeue --slurm-no-account --slurm-init-seconds-before-status-checks 1 \
        --max-status-checks-per-second 10 --default-resources runtime=1 \
        --directory "$scratch/$out.work" --config program="$program" sweep="$scratch/$sweep" out="$scratch/$out" mem_mb=100 "$@" > "$out.log" 2>&1
}
seconds() { # a command, in seconds of the clock
    began=$(date +%s.%N)
    "$@"
    date +%s.%N | awk -v began="$began" '{ printf "%.1f", $1 - began }'
}

# --- what must work -----------------------------------------------------------------------------------------------
through_slurm "$PROGRAM" sweep.toml plain
same plain "four cases through Snakemake and Slurm"

export FAULT=killed
through_slurm "$scratch/faulty" sweep.toml killed --retries 1
[ -d killed.done ]
same killed "a job killed by SIGKILL, tried again by Snakemake"

export FAULT=slow
array() { # PROGRAM SWEEP LAST OUT and more: the sweep as a job array; its number
    program=$1 sweep=$2 last=$3 out=$4
    shift 4
    mkdir -p "$out"
    PROGRAM=$program sbatch --parsable --array="0-$last" --mem=100 --output="$out.%a.log" "$@" "$here/job_array.sh" "$sweep" "$out"
}
finish() { # JOB
    while squeue --noheader --job "$1" 2>/dev/null | grep -q .; do sleep 1; done
}
job=$(array "$scratch/faulty" sweep.toml 3 limit --time=0:10)
finish "$job"
scontrol show job "${job}_1" | grep -q JobState=TIMEOUT || { echo "error: no time limit" >&2; scontrol show job "${job}_1" >&2; exit 1; }
finish "$(array "$scratch/faulty" sweep.toml 3 limit --time=1)"
"$PROGRAM" --quiet sweep summary sweep.toml limit
same limit "a job ended at its time limit, submitted again"

export FAULT=waits
job=$(array "$scratch/faulty" sweep.toml 3 requeued --time=5)
until [ -d waits.done ]; do sleep 0.5; done
sleep 1
scontrol requeue "${job}_1"
finish "$job"
scontrol show job "${job}_1" | grep -q Restarts=1 || { echo "error: not requeued" >&2; exit 1; }
"$PROGRAM" --quiet sweep summary sweep.toml requeued
same requeued "a job taken back into the queue while it ran"

# --- what scheduling costs ----------------------------------------------------------------------------------------
local_snakemake() {
    snakemake -s "$here/Snakefile" --cores "$(nproc)" --quiet rules --directory "$scratch/local.work" \
        --config program="$PROGRAM" sweep="$scratch/many.toml" out="$scratch/local" > local.log 2>&1
}
echo "$cases tiny cases, seconds: sweep $(seconds "$PROGRAM" --quiet sweep many.toml many --no-figures)"
echo "$cases tiny cases, seconds: Snakemake on this machine $(seconds local_snakemake)"
whole_array() { finish "$(array "$PROGRAM" many.toml $((cases - 1)) array --time=5)"; }
echo "$cases tiny cases, seconds: a job array of Slurm $(seconds whole_array)"
if [ "$cases" -le 100 ]; then
    echo "$cases tiny cases, seconds: Snakemake through Slurm $(seconds through_slurm "$PROGRAM" many.toml slurm)"
else
    echo "Snakemake through Slurm is left out: every job starts a Snakemake of its own, and $cases take hours"
fi
