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
# between the two: rolling friction, at three densities (porosity, friction while radii grow)
rolling() { # NAME POROSITY GROWTH_FRICTION ROTATION ROLLING_FRICTION
    "$program" run experiments/fontainebleau/triaxial-h.toml --continue --threads 1 --quiet --out "$out/$1" --set records.snapshots=false \
        --set specimen.porosity="$2" --set preparation.growth_friction="$3" --set contact.rotation="$4" --set material.contact.rolling_friction="$5"
}
rolling given-free-0 0.40 0.4 free 0
rolling given-free-0.1 0.40 0.4 free 0.1
rolling given-free-0.3 0.40 0.4 free 0.3
rolling given-fixed-0 0.40 0.4 fixed 0
rolling loose-free-0.1 0.43 1.0 free 0.1
rolling loose-free-0.3 0.43 1.0 free 0.3
rolling dense-free-0.3 0.38 0.1 free 0.3

draw() { "$program" plot "${@:2}" --quiet --out "figures/rotation/$1"; }
draw triaxial "$out"/fontainebleau-triaxial-h{,-fixed}
draw fontainebleau "$out"/fontainebleau-h-c-10{,-fixed}
draw silica "$out"/silica-h-{c,v}-2{,-fixed}
draw petroleum_coke "$out"/petroleum_coke-h-c-2{,-fixed}
draw rolling "$out"/given-{free-0,free-0.1,free-0.3,fixed-0} --show deviatoric_stress,volumetric_strain
draw density "$out"/{loose-free-0.1,given-free-0.1,loose-free-0.3,given-free-0.3,dense-free-0.3} --show deviatoric_stress,volumetric_strain
