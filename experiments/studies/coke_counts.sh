#!/usr/bin/env bash
# What moves the counts of crush events of petroleum coke that differ from Table 4: what is done with negative strengths, the stiffness of linear
# contacts and whose size sets it, the strength with the Hertzian area, damping, and a comminution limit that is not scaled. One seed each, but for
# L-C-2 with inherited stiffness (five). The runs behind figures/coke_counts.
# From the repository root: experiments/studies/coke_counts.sh [FOLDER]
set -eu
out=${1:-runs/coke_counts}
program=${COMMINUTE:-target/release/comminute}
coke=experiments/petroleum_coke

go() { "$program" run "$coke/$1.toml" --seed 1 --continue --threads 1 --quiet --out "$out/$1$2" "${@:3}"; }
for scene in h-c-2 l-c-2 h-v-2; do
    go $scene ""
    for how in symmetric clamp; do go $scene -$how --set material.strength.truncation=$how; done
done
go l-c-2 -inherited --set contact.law=linear_inherited
for seed in 2 3 4 5; do
    "$program" run "$coke/l-c-2.toml" --seed $seed --continue --threads 1 --quiet --out "$out/l-c-2-inherited-seed-$seed" --set contact.law=linear_inherited
done
go l-c-1 -inherited --set contact.law=linear_inherited
for scene in h-c-2 l-c-2 h-v-2; do go $scene -damping-0.7 --set damping.local=0.7; done
# Table 4 prints one d_limit in mm for both scales; L-C-2 loses a fragment through a wall at 4.7 MPa and stops
for scene in h-c-2 l-c-2 h-v-2; do go $scene -unscaled-limit --set crushing.d_limit_over_d50=0.125 || true; done
"$program" run experiments/silica/h-c-2.toml --seed 1 --continue --threads 1 --quiet --out "$out/silica-h-c-2-unscaled-limit" \
    --set crushing.d_limit_over_d50=0.275
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
go h-v-2 -m-5 --set material.strength.hertz_area.m=5
# E instead of E' in eq. (9), which is (E/E')^(-2/3) of the strength
"$program" run experiments/silica/h-v-2.toml --seed 1 --continue --threads 1 --quiet --out "$out/silica-h-v-2-sigma-3355" \
    --set material.strength.hertz_area.sigma_lim0_MPa=3355

draw() { "$program" plot "${@:2}" --quiet --show crush_events,compression --out "figures/coke_counts/$1"; }
draw truncation-h-c-2 "$out"/h-c-2{,-symmetric,-clamp}
draw truncation-l-c-2 "$out"/l-c-2{,-symmetric,-clamp}
draw truncation-h-v-2 "$out"/h-v-2{,-symmetric,-clamp}
draw inherited "$out"/h-c-2 "$out"/l-c-2{,-inherited}
draw damping "$out"/h-c-2{,-damping-0.7} "$out"/l-c-2{,-damping-0.7} "$out"/h-v-2{,-damping-0.7}
draw unscaled-limit "$out"/h-c-2{,-unscaled-limit} "$out"/h-v-2{,-unscaled-limit} runs/ciantia2015/silica-h-c-2/seed-1 "$out"/silica-h-c-2-unscaled-limit
draw stiffness "$out"/l-c-2{,-K_eff-66.6,-K_eff-133.2,-K_eff-266.4}
draw stiffness-fontainebleau "$out"/fontainebleau-l-c-10{,-K_eff-600,-K_eff-1200}
draw strength "$out"/h-v-2{,-sigma-150,-sigma-100}
draw strength-m "$out"/h-v-2{,-m-5}
draw strength-silica runs/ciantia2015/silica-h-v-2/seed-1 "$out"/silica-h-v-2-sigma-3355
