#!/usr/bin/env bash
# What the way in which daughters are born does: the small runs of Ciantia et al. (2015) with daughters that overlap as in the paper, that begin without overlap, and
# that overlap but are judged every 50 steps only. The runs behind figures/birth.
# A run that has its row in figures/birth/birth.csv is not made again, unless another one needs its specimen.
# From the repository root: experiments/studies/birth.sh [FOLDER [SEEDS]], e.g. experiments/studies/birth.sh runs/birth "1 2 3 4 5"
set -eu
out=${1:-runs/birth}
program=${COMMINUTE:-target/release/comminute}
table=figures/birth/birth.csv
columns=run,birth,seed,breakages,young_share,above_1_1_share,above_1_1_without_collision_share,utilisation_median,utilisation_largest
[ -e "$table" ] || echo "$columns,porosity_grains_end,void_ratio_end,sigma_v_end_kPa,k0_end,d50_mm_end,hardin_br_end,seconds" > "$table"

# the row of a finished run: shares and quantiles of its breakages, and the last row of its history
row() {
    local seconds
    seconds=$(sed -n 's/.*"loading_seconds": \([0-9.]*\).*/\1/p' "$4/summary.json" 2>/dev/null || true)
    awk -F, -v run="$1" -v birth="$2" -v seed="$3" -v seconds="$seconds" '
        /^#/ { next }
        FNR == 1 { file++; for (i = 1; i <= NF; i++) column[file, $i] = i; next }
        file == 1 { n++; u[n] = $column[1, "utilisation"] + 0
            if ($column[1, "generation"] > 0 && $column[1, "age_steps"] <= 20) young++
            if (u[n] > 1.1) { above++; if ($column[1, "utilisation_before"] - 1 > 0.05 * (u[n] - 1)) resting++ } }
        file == 2 { e = $column[2, "void_ratio"]; g = $column[2, "porosity_grains"]; s = $column[2, "sigma_v_kPa"]; k = $column[2, "k0"]
            d = $column[2, "d50_mm"]; b = $column[2, "hardin_br"] }
        END { for (i = 2; i <= n; i++) { x = u[i]; for (j = i - 1; j && u[j] > x; j--) u[j + 1] = u[j]; u[j + 1] = x }
            median = n % 2 ? u[(n + 1) / 2] : (u[n / 2] + u[n / 2 + 1]) / 2
            printf "%s,%s,%s,%d,%.4f,%.4f,%.4f,%.4f,%.2f,%s,%s,%s,%s,%s,%s,%s\n", run, birth, seed, n, young / n, above / n, resting / n, median, u[n], g, e, s, k, d, b, seconds == "" ? "" : sprintf("%.0f", seconds) }' \
        "$4/breakage.csv" "$4/history.csv"
}

# one run, its scene and folder in $scene and $of; one that stopped itself (exit code 3) has a row up to there
run() {
    local specimen=()
    ! grep -q "^$name,$1,$seed," "$table" || [ "$1" = overlapping ] || return 0
    [ ! -e "$of-overlapping/seed-$seed/specimen.csv" ] || [ "$1" = overlapping ] || specimen=(--specimen "$of-overlapping/seed-$seed/specimen.csv")
    local code=0
    "$program" run "experiments/$scene.toml" --continue --threads 1 --quiet --seed "$seed" --out "$of-$1/seed-$seed" "${specimen[@]}" \
        --set "name=\"$name-$1\"" --set records.figures=false --set records.snapshots=false "${@:2}" || code=$?
    [ "$code" = 0 ] || [ "$code" = 3 ] || { echo "$of-$1/seed-$seed: exit code $code" >&2; return 0; }
    grep -q "^$name,$1,$seed," "$table" || row "$name" "$1" "$seed" "$of-$1/seed-$seed" >> "$table"
}

name_of() { sed -n 's/^name = "\(.*\)"/\1/p' "experiments/$1.toml"; }

for seed in ${2:-1 2 3 4 5}; do
    for scene in petroleum_coke/h-c-2 petroleum_coke/l-c-2 petroleum_coke/h-v-2 silica/h-c-2 silica/h-v-2 fontainebleau/h-c-10 \
        fontainebleau/l-c-10 fontainebleau/h-v-10; do
        of=$out/${scene/\//-} name=$(name_of "$scene")
        [ "$(grep -c "^$name,[^,]*,$seed," "$table")" -lt 3 ] || continue
        run overlapping
        run gradual --set crushing.birth=gradual
        run judged-50 --set crushing.interval=50
    done
done
# the large runs, which figures/ciantia2015 has with overlapping daughters: one seed, a quarter of an hour each
seed=1
for scene in petroleum_coke/h-c-1 petroleum_coke/l-c-1 petroleum_coke/h-v-1 silica/h-c-1 silica/h-v-1 fontainebleau/h-c-5 fontainebleau/l-c-5 \
    fontainebleau/h-v-5; do
    of=$out/${scene/\//-} name=$(name_of "$scene")
    run gradual --set crushing.birth=gradual
done
# the figure, of the runs that lie here
[ ! -e "$out/petroleum_coke-h-c-2-gradual" ] ||
    "$program" plot "$out"/petroleum_coke-h-c-2-*/seed-* --quiet --show compression,crush_events,k0 --out figures/birth
