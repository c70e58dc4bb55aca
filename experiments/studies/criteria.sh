#!/usr/bin/env bash
# The same specimens with every failure criterion of grains, all calibrated to the same crushing stress of single grains: first single grains between platens, then the oedometer with
# three specimens each. The runs behind figures/criteria. What is done is not done again.
# From the repository root: experiments/studies/criteria.sh [FOLDER [SEEDS]]
set -eu
out=${1:-runs/criteria}
program=${COMMINUTE:-target/release/comminute}
criteria="fixed_angle hertz_area von_mises mohr_coulomb christensen"
runs=()

for seed in ${2:-1 2 3}; do
    specimen=()
    for criterion in $criteria; do
        of=$out/$criterion/seed-$seed
        "$program" run experiments/criteria/oedometer.toml --continue --threads 1 --quiet --seed "$seed" --out "$of" "${specimen[@]}" \
            --set "name=\"$criterion\"" --set crushing.criterion="$criterion" --set records.figures=false --set records.snapshots=false ||
            echo "$of failed" >&2
        # the others begin with the same grains
        [ ! -e "$out/fixed_angle/seed-$seed/specimen.csv" ] || specimen=(--specimen "$out/fixed_angle/seed-$seed/specimen.csv")
        runs+=("$of")
    done
done

# breakages and void ratio at four stresses (empty where the void ratio has fallen below what fines can fill, where a run ends), state at the end
table=figures/criteria/criteria.csv
echo "criterion,seed,breakages_2_MPa,breakages_3_MPa,breakages_5_MPa,breakages_10_MPa,void_ratio_2_MPa,void_ratio_3_MPa,void_ratio_5_MPa,void_ratio_10_MPa,sigma_v_end_MPa,k0_end,d50_mm_end,hardin_br_end,utilisation_median,seconds" > "$table"
for criterion in $criteria; do
    for seed in ${2:-1 2 3}; do
        of=$out/$criterion/seed-$seed
        [ -e "$of/summary.json" ] || continue
        value() { sed -n "s/.*\"$1\": \([0-9.e+-]*\).*/\1/p" "$of/summary.json" | head -1; }
        awk -F, -v criterion="$criterion" -v seed="$seed" -v seconds="$(value loading_seconds)" -v u="$(value utilisation_median)" '
            /^#/ { next }
            !c { for (i = 1; i <= NF; i++) at[$i] = i; c = 1; next }
            { s = $at["sigma_v_kPa"] / 1e3; e = $at["void_ratio"]; k = $at["k0"]; n = $at["crush_events"]; d = $at["d50_mm"]; b = $at["hardin_br"]
              split("2 3 5 10", w, " "); for (j = 1; j <= 4; j++) if (!(j in found) && s >= 0.985 * w[j]) { found[j] = sprintf("%.3f", e); events[j] = n } }
            END { printf "%s,%s,%s,%s,%s,%s,%s,%s,%s,%s,%.2f,%.3f,%.3f,%.3f,%.4f,%.0f\n", criterion, seed, events[1], events[2], events[3], events[4],
              found[1], found[2], found[3], found[4], s, k, d, b, u, seconds }' "$of/history.csv" >> "$table"
    done
done
"$program" plot "${runs[@]}" --show void_ratio,crush_events,k0,gradation --quiet --out figures/criteria
