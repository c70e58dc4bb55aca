#!/bin/sh
# Makes one run of this folder, that of runs.sh with the number of the array's element, and writes its exit code into NUMBER.code.
# The first word is the folder. SIGTERM, by which a scheduler takes its node back, goes on to the run, which writes a checkpoint.
# of HyperQueue first, whose workers may be elements of an array of Slurm themselves
number=${HQ_TASK_ID:-$SLURM_ARRAY_TASK_ID}
code="$1/$number.code"
rm -f "$code"
sh "$1/runs.sh" "$number" &
run=$!
trap 'kill -TERM "$run" 2>/dev/null' TERM
wait "$run"
ended=$?
# a signal ends the wait before the run has ended
while kill -0 "$run" 2>/dev/null; do
    wait "$run"
    ended=$?
done
echo "$ended" >"$code"
exit "$ended"
