#!/usr/bin/env bash
# Porosity with the lost mass restored against stress, silica and Fontainebleau sand to 100 MPa, one seed: the runs behind figures/restored_porosity, some 17 minutes on one core. From
# the repository root: experiments/studies/restored_porosity.sh [FOLDER]
set -eu
out=${1:-runs/restored_porosity}
program=${COMMINUTE:-target/release/comminute}

folders=()
for scene in silica/h-c-2 silica/h-v-2 fontainebleau/l-c-10 fontainebleau/h-c-10 fontainebleau/h-v-10; do
    folders+=("$out/${scene/\//-}")
    "$program" run "experiments/$scene.toml" --continue --threads 1 --quiet --out "${folders[-1]}"
done
"$program" plot "${folders[@]}" --quiet --show compression --out figures/restored_porosity
