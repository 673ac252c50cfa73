#!/bin/sh
# @title@
#
# Needs mpirun and the engine; no Python. In this folder:
#   sh mpirun.sh                    @ranks@ MPI ranks
#   RANKS=N sh mpirun.sh            N MPI ranks
#   LIGGGHTS_MILL=FILE sh mpirun.sh the engine, if it is not liggghts_mill on the PATH
#   RANKS=N sbatch --nodes=M --ntasks-per-node=1 --cpus-per-task=C mpirun.sh
#                                   a job of Slurm on M nodes with C ranks on each, N = M C
#   sh mpirun.sh OPTION ...         options for mpirun, such as --oversubscribe
# Repeat the command to resume an interrupted run. Its commands:
@lines@
# `millscale status`, `run` and `report` use its results: docs/guide/run-by-hand.md.
set -eu

ranks=${RANKS:-@ranks@}
engine=${LIGGGHTS_MILL:-@engine@}
export OMP_NUM_THREADS=1
if [ "$(id -u)" -eq 0 ]; then
    # Open MPI refuses root without these.
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
nodes=${SLURM_JOB_NUM_NODES:-1} job=${SLURM_JOB_ID:-} names=${SLURM_JOB_NODELIST:-}
slurm_conf=${SLURM_CONF:-}
# mpirun starts all ranks on this node, as in `millscale run`: hide the batch system from it.
for name in $(env | sed -n -e 's/^\(SLURM_[A-Za-z0-9_]*\)=.*/\1/p' \
    -e 's/^\(PBS_[A-Za-z0-9_]*\)=.*/\1/p' -e 's/^\(LSB_[A-Za-z0-9_]*\)=.*/\1/p' \
    -e 's/^\(PE_HOSTFILE\)=.*/\1/p' -e 's/^\(PMIX*_[A-Za-z0-9_]*\)=.*/\1/p'); do
    unset "$name"
done

# In a Slurm job of several nodes, let mpirun spread the ranks over them.
spread() {
    [ "$nodes" -gt 1 ] || return 0
    each=$(((ranks + nodes - 1) / nodes))
    export SLURM_JOB_ID="$job" SLURM_JOBID="$job" SLURM_TASKS_PER_NODE="$each(x$nodes)"
    export SLURM_JOB_NODELIST="$names" SLURM_NODELIST="$names" SRUN_CPUS_PER_TASK="$each"
    export OMPI_MCA_rmaps_base_mapping_policy="ppr:$each:node"
    [ -z "$slurm_conf" ] || export SLURM_CONF="$slurm_conf"
}

stop() {
    echo "mpirun.sh: $*" >&2
    exit 1
}

# Print the value of a variable of parameters.in.
value() {
    awk -v name="$1" '$1 == "variable" && $2 == name { print $4 }' parameters.in
}

# Return whether a log is of a finished run.
finished() {
    [ -e "$1" ] && grep -q '^Loop time of' "$1" &&
        ! grep -q -e '^ERROR' -e 'SIGINT/SIGTERM caught' "$1"
}

# Return whether a log, which echoes parameters.in, is of the present case.json.
of_this_case() {
    [ -e "$1" ] && grep -q "^variable case_digest string $(value case_digest)" "$1"
}

# Print step and name of each restart file that is whole, by the signature at its end.
whole() {
    for file in "$@"; do
        [ -e "$file" ] || continue
        signature=$(tail -n 1 "$file" | LC_ALL=C sed -n '/^millscale restart step [0-9]* bytes /p')
        [ -n "$signature" ] || continue
        bytes=$(echo "$signature" | cut -d ' ' -f 6)
        if [ "$(wc -c <"$file")" -eq $((bytes + ${#signature} + 2)) ]; then
            echo "$(echo "$signature" | cut -d ' ' -f 4) $file"
        fi
    done
}

# Prepare a run with this log: from its first step, or, with resume=1, from the newest restart file
# between two steps of an interrupted start.
begin() {
    log=$1 resume=
    newest=$(whole mill.1.restart mill.2.restart resume.restart |
        awk -v first="$2" -v last="$3" '$1 > first && $1 <= last' | sort -n | tail -n 1)
    # The log of each start is kept, with the signature of the restart file of the next one.
    count=1
    while [ -e "$log.$count" ]; do count=$((count + 1)); done
    if [ -e "$log" ]; then
        latest=$log
    else
        count=$((count - 1))
        latest=$log.$count
    fi
    if [ -z "$newest" ] || [ ! -e "$latest" ] || finished "$latest"; then
        [ ! -e series.csv ] || stop "series.csv is there, and no restart file: move it to begin anew"
        rm -f mill.1.restart mill.2.restart resume.restart "$log".[0-9]*
        return
    fi
    of_this_case "$latest" ||
        stop "$latest is not of this case, so its restart files are not: move all to begin anew"
    ranks=$(sed -n 's/^ *1 by \([0-9]*\) by 1 MPI processor grid.*/\1/p' "$latest" | head -n 1)
    [ "${RANKS:-$ranks}" = "$ranks" ] ||
        stop "begun with RANKS=$ranks; RANKS=$RANKS would change the results"
    if [ "$latest" = "$log" ]; then
        mv "$log" "$log.$count"
        tail -n 1 "${newest#* }" >>"$log.$count"
    fi
    [ "${newest#* }" = resume.restart ] || mv "${newest#* }" resume.restart
    rm -f restart_forced_liggghts_*
    for series in series.csv ledger.csv; do
        [ -e "$series" ] || continue
        # Keep the rows up to that step; the engine appends the next ones.
        awk -F , -v last="${newest% *}" 'NR == 1 { columns = NF; print; next }
            NF == columns && $1 + 0 <= last' "$series" >"$series.part"
        mv "$series.part" "$series"
    done
    resume=1
    echo "mpirun.sh: goes on from step ${newest% *} (${newest#* })"
}

[ -e parameters.in ] || stop "no parameters.in here: change to the case folder first"
for program in mpirun "$engine"; do
    command -v "$program" >/dev/null || stop "no $program on the PATH (LIGGGHTS_MILL names the engine)"
done
for part in settle.part rotate.part; do
    [ ! -e "$part" ] || stop "$part is of millscale run: resume with that, or delete $part"
done
if command -v flock >/dev/null; then
    # The lock of millscale run. The engine inherits it.
    exec 9>>.millscale.lock
    flock -n 9 || stop "another run is in this folder: $(cat .millscale.lock)"
    echo "process $$ on $(uname -n) since $(date '+%Y-%m-%d %H:%M:%S') by mpirun.sh" >.millscale.lock
fi
# Steps of the engine at the begin and the end of the rotation.
first=$(value settle_steps)
last=$((first + $(value rest_steps) + $(value rotation_steps)))

@stages@
