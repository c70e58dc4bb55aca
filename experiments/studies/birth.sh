#!/usr/bin/env bash
# What the way in which daughters are born does: the small runs of Ciantia et al. (2015) with daughters that overlap as in the paper, that begin without overlap, and
# that overlap but are judged every 50 steps only. The runs behind figures/birth. What is done is not done again.
# From the repository root: experiments/studies/birth.sh [FOLDER [SEEDS]], e.g. experiments/studies/birth.sh runs/birth "1 2 3 4 5"
set -eu
out=${1:-runs/birth}
program=${COMMINUTE:-target/release/comminute}

for seed in ${2:-1 2 3 4 5}; do
    for scene in petroleum_coke/h-c-2 petroleum_coke/l-c-2 petroleum_coke/h-v-2 silica/h-c-2 silica/h-v-2 fontainebleau/h-c-10 \
        fontainebleau/l-c-10 fontainebleau/h-v-10; do
        of=$out/${scene/\//-}
        name=$(sed -n 's/^name = "\(.*\)"/\1/p' "experiments/$scene.toml")
        run() {
            local specimen=()
            [ "$1" = overlapping ] || specimen=(--specimen "$of-overlapping/seed-$seed/specimen.csv")
            "$program" run "experiments/$scene.toml" --continue --threads 1 --quiet --seed "$seed" --out "$of-$1/seed-$seed" "${specimen[@]}" \
                --set "name=\"$name-$1\"" --set records.figures=false --set records.snapshots=false "${@:2}" || echo "$of-$1/seed-$seed failed" >&2
        }
        run overlapping
        run gradual --set crushing.birth=gradual
        run judged-50 --set crushing.interval=50
    done
done
"$program" plot "$out"/petroleum_coke-h-c-2-*/seed-* --quiet --show compression,crush_events,k0 --out figures/birth
