#!/bin/sh
# Memory that `comminute check` promises and the largest that runs take, as docs/validation/hard_to_break/memory.csv, in some
# minutes. From the repository root, after cargo build --release. Needs GNU time. Long runs are stopped after so many steps, and
# then draw no figures.
set -eu
program=${COMMINUTE:-target/release/comminute}
table=docs/validation/hard_to_break/memory.csv
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$(dirname "$table")"
echo "scene,stopped_after_steps,grains,points,promised_MB,measured_MB,promised_over_measured" > "$table"

# scene, steps or 0 for the whole run, overrides
measure() {
    scene=$1 steps=$2
    shift 2
    stop=
    [ "$steps" = 0 ] || { stop="--stop-after $steps"; set -- "$@" --set records.figures=false; }
    "$program" check "experiments/$scene" "$@" --json > "$work/check.json"
    rm -rf "$work/run"
    # shellcheck disable=SC2086
    /usr/bin/time -o "$work/time" -f %M "$program" run "experiments/$scene" "$@" $stop --threads 2 --quiet --out "$work/run" > /dev/null 2>&1 || true
    tail -1 "$work/time" > "$work/kib"
    python3 - "$work" "$scene" "$steps" >> "$table" <<'PYTHON'
import json, sys
work, scene, steps = sys.argv[1:]
estimate = json.load(open(f"{work}/check.json"))["estimate"]
points = (estimate.get("continuum") or {}).get("points", 0)
measured = 1.024e-3 * float(open(f"{work}/kib").read())
promised = estimate["memory_MB"]
print(f"{scene},{steps},{estimate['grains']},{points},{promised:.1f},{measured:.1f},{promised / measured:.2f}")
PYTHON
}

measure free/box_settling.toml 0
measure platen/petroleum_coke.toml 0
measure petroleum_coke/h-c-2.toml 0 --set loading.max_stress_kPa=1000 --set records.at_kPa=[]
measure isotropic/petroleum_coke.toml 0 --set loading.max_stress_kPa=1000 --set loading.stages_kPa=[] --set records.at_kPa=[]
measure fontainebleau/triaxial-h.toml 60000
measure mpm/oedometer.toml 2000
measure mpm/column_collapse_2d.toml 0
measure mpm/triaxial_fine_64000.toml 300
measure mixture/triaxial_20_50kPa.toml 2000
measure mixture/oedometer_crushing.toml 4000
cat "$table"
