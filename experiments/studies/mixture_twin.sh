#!/usr/bin/env bash
# What the continuum costs in accuracy and saves in time: the small twin with grains and with points for its fines, 0, 20 and 40 % of coarse grains, three seeds each (five with 20 %); the particle
# reduction of triaxial_20_50kPa and triaxial_small; smaller cells; crushable coke in fines. What is done is not done again. Runs stay in runs/twin; tables and figures go to figures/mixture.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
bin=${CARGO_TARGET_DIR:-target}/release/comminute
runs=runs/twin
run() { # NAME SCENE ARGS…
    local name=$1 scene=$2
    shift 2
    if [ -e "$runs/$name/summary.json" ]; then return; fi
    "$bin" run "experiments/mixture/$scene.toml" --out "$runs/$name" --force --set records.snapshots=false "$@"
}

for seed in 1 2 3; do
    # further than the mixtures: between coarse grains fines are sheared more than the specimen
    run "fines_$seed" twin_grains --set coarse.mass_fraction=0 --seed "$seed" --set test.axial_strain=0.25 --set records.rows=500
done
contacts=(--set records.contacts=true --set records.frames=12 --set records.snapshots=true)
for seed in 1 2 3 4 5; do
    run "grains_$seed" twin_grains --seed "$seed" "${contacts[@]}"
done
for seed in 1 2 3; do
    run "grains40_$seed" twin_grains --set coarse.mass_fraction=0.4 --seed "$seed" "${contacts[@]}"
done
# materials/twin_fines.toml is this law
"$bin" calibrate fines "$runs"/fines_{1,2,3} --interface "$runs"/grains_{1,2,3,4,5} "$runs"/grains40_{1,2,3} --dilation mobilised --base li2023_fines.toml --out "$runs/law" --force
for seed in 1 2 3 4 5; do
    run "points_$seed" twin_points --seed "$seed"
done
for seed in 1 2 3; do
    run "points_fines_$seed" twin_points --set coarse.mass_fraction=0 --seed "$seed"
    run "points40_$seed" twin_points --set coarse.mass_fraction=0.4 --seed "$seed"
done
# the same at full size, 75 mm instead of 37.5: an hour or two
run full_grains twin_full_grains
run full_points twin_full_points
for cell in 3.75 2.5 1.875; do
    run "cells_$cell" twin_cells --set grid.cell_mm=$cell
done
for share in 0.5 0.6 0.7 0.8 0.9 1.0; do
    run "coke_${share}_true" coke_in_fines --set coarse.mass_fraction=$share
    run "coke_${share}_false" coke_in_fines --set coarse.mass_fraction=$share --set crushing.enabled=false --set crushing.lost_mass=leave
done
for number in 1 8 64; do
    run "small_reduction_$number" triaxial_small --set grid.grains_per_point=$number --set test.axial_strain=0.06
done
run reduction_64 triaxial_20_50kPa --set grid.grains_per_point=64
run reduction_8 triaxial_20_50kPa
run full_40 triaxial_40_50kPa
run full_40_ratio_2_5 triaxial_40_ratio_2_5
run half_rate triaxial_20_50kPa --set test.strain_per_wave=1.5e-4
# with the usual gain: at the highest rate the platens lag
run third_rate triaxial_20_50kPa --set test.strain_per_wave=1e-4 --set test.servo_gain=0.3
run rate_2e-4 triaxial_20_50kPa --set test.strain_per_wave=2e-4 --set test.servo_gain=0.3
run rate_4e-4 triaxial_20_50kPa --set test.strain_per_wave=4e-4 --set test.servo_gain=0.3

of() { for name in "$@"; do echo "$runs/$name"; done; }
"$bin" plot $(of fines_{1,2,3} points_fines_{1,2,3}) --show stress_ratio,volumetric_strain --out figures/mixture/twin_00
"$bin" plot $(of grains_{1,2,3,4,5} points_{1,2,3,4,5}) --show stress_ratio,volumetric_strain --out figures/mixture/twin_20_seeds
"$bin" plot $(of grains40_{1,2,3} points40_{1,2,3}) --show stress_ratio,volumetric_strain --out figures/mixture/twin_40
"$bin" plot $(of full_{grains,points}) --show stress_ratio,volumetric_strain --out figures/mixture/twin_full
"$bin" plot $(of full_40) --show stress_bearers --out figures/mixture/full_40
"$bin" plot $(of full_40 full_40_ratio_2_5) --show stress_ratio,volumetric_strain --out figures/mixture/full_40
"$bin" plot $(of reduction_8 half_rate third_rate rate_2e-4 rate_4e-4) --show stress_ratio --out figures/mixture/rate
"$bin" plot $(of reduction_8) --show stress_bearers --out figures/mixture/reduction
"$bin" plot $(of reduction_8 reduction_64) --show stress_ratio,volumetric_strain --out figures/mixture/reduction
"$bin" plot $(of cells_3.75 cells_2.5 cells_1.875) --show stress_ratio --out figures/mixture/twin_cells
"$bin" plot $(of small_reduction_1 small_reduction_8 small_reduction_64) --show stress_ratio,volumetric_strain --out figures/mixture/reduction_small
"$bin" plot $(of coke_{0.5,0.6,0.7,0.8,0.9,1.0}_true) --show axial_strain --out figures/mixture/coke_crushing
"$bin" plot $(of coke_{0.5,0.6,0.7,0.8,0.9,1.0}_false) --show axial_strain --out figures/mixture/coke_whole
