#!/usr/bin/env bash
# Grains that turn against grains that do not: the runs behind figures/rotation. From the repository root: experiments/studies/rotation.sh [FOLDER]
set -eu
out=${1:-runs/rotation}
program=${COMMINUTE:-target/release/comminute}

for scene in petroleum_coke/h-c-2 petroleum_coke/l-c-2 petroleum_coke/h-v-2 fontainebleau/h-c-10 fontainebleau/h-v-10 fontainebleau/triaxial-h silica/h-c-2 silica/h-v-2; do
    name=${scene/\//-}
    file=experiments/$scene.toml
    label=$(sed -n 's/^name = "\(.*\)"/\1/p' "$file")
    # the sands' preparation of the runs that are shown; their scenes have another one since
    keys=()
    case $scene in
    fontainebleau/triaxial-h) keys=(--set preparation.growth_friction=0.4 --set loading.inertial_number=0.0003) ;;
    fontainebleau/*) keys=(--set preparation.growth_friction=0.1 --set loading.max_lag=0.015) ;;
    silica/*) keys=(--set preparation.growth_friction=0.2 --set loading.max_lag=0.015) ;;
    esac
    "$program" run "$file" --continue --threads 1 --quiet --out "$out/$name" --set contact.rotation=free "${keys[@]}"
    "$program" run "$file" --continue --threads 1 --quiet --out "$out/$name-fixed" --set contact.rotation=fixed "${keys[@]}" \
        --set "name=\"$label-fixed\""
done
draw() { "$program" plot "${@:2}" --quiet --out "figures/rotation/$1"; }
draw triaxial "$out"/fontainebleau-triaxial-h{,-fixed}
draw fontainebleau "$out"/fontainebleau-h-c-10{,-fixed}
draw silica "$out"/silica-h-{c,v}-2{,-fixed}
draw petroleum_coke "$out"/petroleum_coke-h-c-2{,-fixed}
