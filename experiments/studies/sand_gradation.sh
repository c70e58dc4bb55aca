#!/usr/bin/env bash
# The sands' initial gradations are in no table. Counts, D, H and porosity give one number, the mean of d³; these gradations keep it (and so the porosity)
# and are otherwise as different as the counts allow: mass uniform in size (the materials), in the logarithm of size, and steep with tails.
# The runs behind figures/sand_gradation. From the repository root: experiments/studies/sand_gradation.sh [FOLDER]
set -eu
out=${1:-runs/sand_gradation}
program=${COMMINUTE:-target/release/comminute}

mkdir -p figures/sand_gradation
go() { # scene label gradation
    name=$(basename "$1" .toml)
    "$program" ensemble "$1" --seeds 1 --jobs "${JOBS:-2}" --quiet --out "$out/$(basename "$(dirname "$1")")-$name-$2" \
        --set "name=\"$name-$2\"" ${3:+--set "material.gradation.points=$3"}
}
for area in c v; do
    go experiments/fontainebleau/h-$area-10.toml uniform ""
    go experiments/fontainebleau/h-$area-10.toml log "[[0.1166,0],[0.1351,0.125],[0.1565,0.25],[0.1813,0.375],[0.21,0.5],[0.2433,0.625],[0.2819,0.75],[0.3265,0.875],[0.3783,1]]"
    go experiments/fontainebleau/h-$area-10.toml tails "[[0.0844,0],[0.1785,0.15],[0.2415,0.85],[0.3356,1]]"
    go experiments/silica/h-$area-2.toml uniform ""
    go experiments/silica/h-$area-2.toml log "[[0.7852,0],[0.9231,0.125],[1.085,0.25],[1.276,0.375],[1.5,0.5],[1.763,0.625],[2.073,0.75],[2.437,0.875],[2.866,1]]"
    go experiments/silica/h-$area-2.toml tails "[[0.5446,0],[1.275,0.15],[1.725,0.85],[2.455,1]]"
done
draw() { "$program" plot "${@:2}" --quiet --show crush_events,gradation --out "figures/sand_gradation/$1"; }
for area in c v; do
    draw fontainebleau-h-$area-10 "$out"/fontainebleau-h-$area-10-{uniform,log,tails}/seed-*
    draw silica-h-$area-2 "$out"/silica-h-$area-2-{uniform,log,tails}/seed-*
done
