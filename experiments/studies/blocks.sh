#!/usr/bin/env bash
# The runs and figures of figures/blocks: towers, arches and rocks of rigid bodies, a silo (Jiang et al. 2020), and a box
# that rests on another for 10⁷ steps, rocks that break, and bodies between platens. Forty minutes on two slow cores, half of them for the oedometer. From the repository root: experiments/studies/blocks.sh [FOLDER]
set -eu
out=${1:-runs/blocks}
program=${COMMINUTE:-target/release/comminute}
mkdir -p figures/blocks

for scene in tower arch_stands arch_falls rocks crushed_rocks crushed_tetrapods pieces oedometer biaxial; do
    "$program" run experiments/blocks/$scene.toml --continue --quiet --out "$out/$scene"
done
for scene in tower arch_stands arch_falls; do
    for kind in svg csv; do cp "$out/$scene/figures/bodies.$kind" figures/blocks/$scene.$kind; done
done
for scene in rocks crushed_rocks crushed_tetrapods pieces oedometer biaxial; do cp "$out/$scene/figures/bodies.png" figures/blocks/$scene.png; done
for figure in wall_forces gradation; do
    for kind in svg csv; do cp "$out/crushed_rocks/figures/$figure.$kind" figures/blocks/crushed_rocks_$figure.$kind; done
done
for figure in stress_ratio volumetric_strain; do
    for kind in svg csv; do cp "$out/biaxial/figures/$figure.$kind" figures/blocks/biaxial_$figure.$kind; done
done
for figure in compression gradation; do
    for kind in svg csv; do cp "$out/oedometer/figures/$figure.$kind" figures/blocks/oedometer_$figure.$kind; done
done
"$program" verify --only silo --out "$out/silo" --force
cp "$out"/silo/silo_discharge.{csv,svg} figures/blocks
"$program" run experiments/blocks/rest.toml --continue --quiet --out "$out/rest"
tail -n 2 "$out/rest/blocks.csv"
