#!/usr/bin/env bash
# The runs behind figures/verification and figures/mpm/triaxial_fine: closed forms of the continuum at several resolutions, collapsing columns, and
# the triaxial tests of Li's fine soil at three cell pressures and with 64 000 points. From the repository root:
# experiments/verification/study.sh [FOLDER]
set -eu
out=${1:-runs/verification}
program=${COMMINUTE:-target/release/comminute}

"$program" verify --out "$out" --force
mkdir -p figures/verification
cp "$out"/verification.{csv,md} "$out"/*_*.{csv,svg} figures/verification

for scene in triaxial_fine_50kPa triaxial_fine_100kPa triaxial_fine_150kPa triaxial_fine_64000; do
    "$program" run experiments/mpm/$scene.toml --continue --quiet --out "$out/$scene"
done
"$program" plot "$out"/triaxial_fine_{50,100,150}kPa --quiet --show stress_ratio,deviatoric_stress,volumetric_strain --out figures/mpm/triaxial_fine
"$program" plot "$out"/triaxial_fine_{50kPa,64000} --quiet --show stress_ratio,volumetric_strain --out figures/mpm/triaxial_fine_64000
