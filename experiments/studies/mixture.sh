#!/usr/bin/env bash
# Studies of grains in a continuum: a ball falls into sand (twelve cases against eq. 62 of Zhang et al.), steps of their own for grains and continuum, a ball that hits a ball of
# points. The runs behind figures/mixture; a second call goes on where the first one was stopped. From the repository root: experiments/studies/mixture.sh [FOLDER]
set -eu
out=${1:-runs/mixture}
program=${COMMINUTE:-target/release/comminute}

declare -A figures=(
    [impact_refined]="loss_cells loss_points"
    [crater]="depth ratio"
    [crater_outer]="depth"
    [crater_mohr_coulomb]="depth ratio"
    [crater_cells]="depth"
    [collapse_mohr_coulomb]="run_out"
    [rates]="saving"
)
# up to 1.6 million points: minutes on a graphics device, an hour on the processor
declare -A backends=([crater_cells]=auto)
for case in impact_refined crater crater_outer crater_mohr_coulomb crater_numerics crater_cells collapse_mohr_coulomb rates; do
    "$program" verify --only $case --backend ${backends[$case]:-cpu} --continue --out "$out/$case"
    mkdir -p figures/mixture/$case
    cp "$out/$case"/verification.{csv,md} figures/mixture/$case
    for figure in ${figures[$case]:-}; do
        cp "$out/$case"/${case}_$figure.{csv,svg} figures/mixture/$case
    done
done
"$program" plot "$out"/crater/runs/crater-{7,9,10,12}-3 --quiet --show lowest_grain --out figures/mixture/crater
# stiffer and stiffer rocks: κ by itself, time and energy
"$program" sweep experiments/mixture/stiff_rock.toml --grid materials.rock.elastic.E_GPa=0.05,0.5,5,50 --set records.figures=false --set records.snapshots=false \
    --out "$out/stiff_rock" --jobs 1 --threads 1 --quiet
"$program" plot "$out"/stiff_rock/E_GPa-{0.05,0.5,5,50} --quiet --out figures/mixture/stiff_rock
