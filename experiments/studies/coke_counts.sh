#!/usr/bin/env bash
# What moves the counts of crush events of petroleum coke that differ from Table 4: what is done with negative strengths, the stiffness of linear
# contacts, the strength with the Hertzian area. The runs behind figures/coke_counts. From the repository root: experiments/studies/coke_counts.sh [FOLDER]
set -eu
out=${1:-runs/coke_counts}
program=${COMMINUTE:-target/release/comminute}
coke=experiments/petroleum_coke
sweep() { "$program" sweep "$coke/$1.toml" --jobs "${JOBS:-2}" --quiet --out "$out/$2" "${@:3}"; cp "$out/$2/sweep.csv" "figures/coke_counts/$2.csv"; }

mkdir -p figures/coke_counts
for scene in h-c-2 l-c-2 h-v-2; do
    sweep $scene $scene-truncation --grid material.strength.truncation=redraw,symmetric,clamp --seeds 1,2
done
# an own specimen for each stiffness takes long to settle; without breakage 5 kPa hardly deform any of them
"$program" run $coke/l-c-2.toml --seed 1 --continue --quiet --out "$out/l-c-2-specimen" --set loading.max_stress_kPa=6
sweep l-c-2 l-c-2-stiffness --grid material.linear.K_eff_MPa=33.3,66.6,133.2,266.4 --set "specimen.file=\"$PWD/$out/l-c-2-specimen/specimen.csv\""
sweep h-v-2 h-v-2-strength --grid material.strength.hertz_area.sigma_lim0_MPa=200,150,130
