#!/usr/bin/env bash
# The figures of figures/platen. From the repository root: experiments/platen/study.sh [FOLDER]
set -eu
out=${1:-runs/platen}
program=${COMMINUTE:-target/release/comminute}
for scene in petroleum_coke petroleum_coke_hertz silica silica_hertz; do
    "$program" run "experiments/platen/$scene.toml" --force --quiet --out "$out/$scene"
    mkdir -p "figures/platen/$scene"
    cp "$out/$scene"/figures/*.{svg,csv} "figures/platen/$scene/"
done
