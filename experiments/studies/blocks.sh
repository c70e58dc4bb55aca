#!/usr/bin/env bash
# The runs and figures of figures/blocks: towers, arches and rocks of rigid bodies, a silo (Jiang et al. 2020), and a box
# that rests on another for 10⁷ steps. Five minutes on two slow cores. From the repository root: experiments/studies/blocks.sh [FOLDER]
set -eu
out=${1:-runs/blocks}
program=${COMMINUTE:-target/release/comminute}
mkdir -p figures/blocks

for scene in tower arch_stands arch_falls rocks; do
    "$program" run experiments/blocks/$scene.toml --continue --quiet --out "$out/$scene"
done
for scene in tower arch_stands arch_falls; do
    for kind in svg csv; do cp "$out/$scene/figures/bodies.$kind" figures/blocks/$scene.$kind; done
done
cp "$out/rocks/figures/bodies.png" figures/blocks/rocks.png
"$program" verify --only silo --out "$out/silo" --force
cp "$out"/silo/silo_discharge.{csv,svg} figures/blocks
"$program" run experiments/blocks/rest.toml --continue --quiet --out "$out/rest"
tail -n 2 "$out/rest/blocks.csv"
