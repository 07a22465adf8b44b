#!/bin/bash
# slurm_one_node.sh COMMAND...: runs a command with a Slurm of this machine, of two processors, whose
# daemons end with it. Needs root, but no systemd. Exits with 77 and the reason where it cannot.
set -u
for program in munged slurmctld slurmd sbatch setpriv; do
    command -v "$program" > /dev/null || { echo "$program is missing"; exit 77; }
done
[ "$(id -u)" = 0 ] || { echo "Slurm needs root"; exit 77; }

folder=$(mktemp -d)
chmod 755 "$folder"
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/munge" "$folder/state" "$folder/spool"
head -c 1024 /dev/urandom > "$folder/munge/key"
chown -R munge: "$folder/munge"
chmod 711 "$folder/munge"
chmod 400 "$folder/munge/key"
host=$(hostname -s)
cat > "$folder/slurm.conf" <<CONF
ClusterName=aula
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CryptoType=crypto/munge
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
MaxArraySize=1001
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf

# Waits up to 10 s for a condition.
wait_for() {
    for _ in $(seq 100); do
        if "$@"; then return; fi
        sleep 0.1
    done
}
is_idle() { [ "$(sinfo -h -o %T 2> /dev/null)" = idle ]; }

setpriv --reuid=munge --regid=munge --clear-groups munged -F --key-file="$folder/munge/key" \
    --socket="$folder/munge/socket" --pid-file="$folder/munge/pid" \
    --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" 2> /dev/null &
munged=$!
wait_for test -S "$folder/munge/socket"
slurmctld -D -c > "$folder/slurmctld.out" 2>&1 &
slurmctld=$!
slurmd -D -N "$host" > "$folder/slurmd.out" 2>&1 &
slurmd=$!
wait_for is_idle
if is_idle; then
    "$@"
    status=$?
else
    echo "Slurm does not start: $(tail -n 1 "$folder/slurmctld.out" "$folder/slurmd.out")"
    status=77
fi
kill $slurmd $slurmctld
wait $slurmd $slurmctld
kill $munged
wait $munged
exit $status
