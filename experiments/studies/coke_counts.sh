#!/usr/bin/env bash
# What moves the counts of crush events of petroleum coke that differ from Table 4: what is done with negative strengths, the stiffness of linear
# contacts, the strength with the Hertzian area. One seed each. The runs behind figures/coke_counts; runs are taken over from `reproduce ciantia2015`
# where they are the same. From the repository root: experiments/studies/coke_counts.sh [FOLDER]
set -eu
out=${1:-runs/coke_counts}
program=${COMMINUTE:-target/release/comminute}
coke=experiments/petroleum_coke

go() { "$program" run "$coke/$1.toml" --seed 1 --continue --threads 1 --quiet --out "$out/$1$2" "${@:3}"; }
for scene in h-c-2 l-c-2 h-v-2; do
    go $scene ""
    for how in symmetric clamp; do go $scene -$how --set material.strength.truncation=$how; done
done
go l-c-2 -K_eff-66.6 --set material.linear.K_eff_MPa=66.6
# a specimen of its own takes long to settle with stiffer contacts; at 5 kPa the softest are hardly deformed either
for K in 133.2 266.4; do go l-c-2 -K_eff-$K --set material.linear.K_eff_MPa=$K --specimen "$out/l-c-2/specimen.csv"; done
font=experiments/fontainebleau/l-c-10.toml
"$program" run $font --seed 1 --continue --threads 1 --quiet --out "$out/fontainebleau-l-c-10"
for K in 600 1200; do
    "$program" run $font --seed 1 --continue --threads 1 --quiet --out "$out/fontainebleau-l-c-10-K_eff-$K" --set material.linear.K_eff_MPa=$K \
        --specimen "$out/fontainebleau-l-c-10/specimen.csv"
done
for sigma in 150 100; do go h-v-2 -sigma-$sigma --set material.strength.hertz_area.sigma_lim0_MPa=$sigma; done

draw() { "$program" plot "${@:2}" --quiet --show crush_events,compression --out "figures/coke_counts/$1"; }
draw truncation-h-c-2 "$out"/h-c-2{,-symmetric,-clamp}
draw truncation-l-c-2 "$out"/l-c-2{,-symmetric,-clamp}
draw truncation-h-v-2 "$out"/h-v-2{,-symmetric,-clamp}
draw stiffness "$out"/l-c-2{,-K_eff-66.6,-K_eff-133.2,-K_eff-266.4}
draw stiffness-fontainebleau "$out"/fontainebleau-l-c-10{,-K_eff-600,-K_eff-1200}
draw strength "$out"/h-v-2{,-sigma-150,-sigma-100}
