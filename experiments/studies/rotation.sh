#!/usr/bin/env bash
# Grains that turn against grains that do not: the runs behind figures/rotation. From the repository root: experiments/studies/rotation.sh [FOLDER]
set -eu
out=${1:-runs/rotation}
program=${COMMINUTE:-target/release/comminute}

for scene in petroleum_coke/h-c-2 petroleum_coke/l-c-2 petroleum_coke/h-v-2 fontainebleau/h-c-10 fontainebleau/h-v-10 fontainebleau/triaxial-h silica/h-c-2 silica/h-v-2; do
    name=${scene/\//-}
    file=experiments/$scene.toml
    label=$(sed -n 's/^name = "\(.*\)"/\1/p' "$file")
    for rotation in free fixed; do
        "$program" run "$file" --continue --threads 1 --quiet --out "$out/$name-$rotation" --set contact.rotation=$rotation \
            --set "name=\"$label-$rotation\""
    done
done
draw() { "$program" plot "${@:2}" --quiet --show k0,crush_events,deviatoric_stress,volumetric_strain --out "figures/rotation/$1"; }
draw triaxial "$out"/fontainebleau-triaxial-h-{free,fixed}
draw fontainebleau "$out"/fontainebleau-h-c-10-{free,fixed}
draw silica "$out"/silica-h-{c,v}-2-{free,fixed}
draw petroleum_coke "$out"/petroleum_coke-h-c-2-{free,fixed}
