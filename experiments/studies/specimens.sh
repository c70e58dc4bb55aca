#!/usr/bin/env bash
# How many specimens can be made: 60 of gradations with Cu 1.1 to 6, of void ratios inside the measured range and of up to 20 000 grains, drawn evenly by three irrational
# steps; the fewest grains are 500, or as many as make the specimen four largest grains wide. The smallest come first; what has its row in the table is not done again (take the row out to try once more). The table behind figures/specimens.
# From the repository root: experiments/studies/specimens.sh [FOLDER [MOST_GRAINS]], e.g. experiments/studies/specimens.sh runs/specimens 3000
set -eu
out=${1:-runs/specimens}
most=${2:-20000}
program=${COMMINUTE:-target/release/comminute}
table=figures/specimens/specimens.csv
export COMMINUTE_CACHE=$out/cache
mkdir -p "$out"
[ -e "$table" ] || echo "number,cu,grains,diameter_mm,void_ratio_densest,void_ratio_loosest,void_ratio_asked,porosity_made,error_percent,seconds,steps,outcome" > "$table"

# number, Cu, grains, diameter in mm, place in the range (0 loosest), gradation: D50 0.5 mm, straight in log d from D10 to D60, short tails; height 0.7 diameters
draws() {
    awk 'function frac(x) { return x - int(x) }
    function d(p) { return 0.5 * cu ^ (((p < 0.1 ? 0.1 : p > 0.6 ? 0.6 : p) - 0.5) / 0.5) * (p < 0.1 ? 0.85 : p > 0.6 ? 1 + 0.4 * (p - 0.6) / 0.4 * (1 - 1 / cu) + 0.05 : 1) }
    BEGIN { for (k = 1; k <= 60; k++) {
        cu = 1.1 + 4.9 * frac(k * 0.6180339887)
        split("0 0.1 0.2 0.3 0.4 0.5 0.6 1", ps, " "); points = ""; inverse = 0; last = 0
        for (i = 1; i <= 8; i++) { p = ps[i]; x = d(p); if (x <= last) x = last * 1.001
            points = points (i > 1 ? ", " : "") sprintf("[%.5f, %s]", x, p)
            # mean of d^-3 by mass, exact where mass is uniform in d
            if (i > 1) inverse += (p - q) * (last ^ -2 - x ^ -2) / (2 * (x - last))
            last = x; q = p }
        solid = 3.14159265 / 6 / inverse
        least = 0.7 * 0.7853982 * (4 * last) ^ 3 * 0.6 / solid; if (least < 500) least = 500
        n = int(least * (20000 / least) ^ frac(k * 0.7548776662))
        diameter = (n * solid / 0.6 / 0.7 / 0.7853982) ^ (1 / 3)
        printf "%d;%.3f;%d;%.4f;%.3f;[%s]\n", k, cu, n, diameter, 0.02 + 0.96 * frac(k * 0.5698402910), points } }' | sort -t';' -k3n
}

of() { sed -n "s/.*\"$1\": \([-0-9.e]*\).*/\1/p" "$2" | head -1; }

draws | while IFS=';' read -r k cu n diameter share points; do
    [ "$n" -le "$most" ] || continue
    folder=$out/$k
    ! grep -q "^$k," "$table" || continue
    mkdir -p "$folder"
    [ -e "$folder/scene/scene.toml" ] || "$program" new oedometer "$folder/scene" --quiet
    sets=(--set "material.gradation.points=$points" --set specimen.grains="$n" --set specimen.diameter_mm="$diameter" --set seed.packing="$k")
    row() { echo "$k,$cu,$n,$diameter,$1" >> "$table"; }
    if ! "$program" check "$folder/scene/scene.toml" "${sets[@]}" --set specimen.relative_density=0.5 --range --json > "$folder/range.json" 2> "$folder/range.log"; then
        row ",,,,,,,no range"
        continue
    fi
    dense=$(printf "%.4f" "$(of void_ratio_densest "$folder/range.json")")
    loose=$(printf "%.4f" "$(of void_ratio_loosest "$folder/range.json")")
    e=$(awk "BEGIN { printf \"%.4f\", $loose - $share * ($loose - $dense) }")
    if "$program" run "$folder/scene/scene.toml" "${sets[@]}" --set specimen.void_ratio="$e" --set crushing.enabled=false --set loading.max_stress_kPa=5.5 \
        --set loading.control=stress --set 'loading.stages_kPa=[]' --set 'records.at_kPa=[]' --set records.figures=false --threads 1 --quiet --force \
        --out "$folder/run" > "$folder/run.log" 2>&1; then
        made=$(awk -F, '/^#/ { next } !c { for (i = 1; i <= NF; i++) if ($i == "porosity") c = i; next } { print $c; exit }' "$folder/run/history.csv")
        error=$(awk "BEGIN { n = $e / (1 + $e); printf \"%.2f\", 100 * ($made / n - 1) }")
        seconds=$(awk "BEGIN { printf \"%.1f\", $(of wall_seconds "$folder/run/summary.json") - $(of loading_seconds "$folder/run/summary.json") }")
        row "$dense,$loose,$e,$made,$error,$seconds,$(of preparation_steps "$folder/run/summary.json"),made"
    else
        row "$dense,$loose,$e,,,,,$(sed -n 's/.*preparation (\([a-z]*\)) \([^;:]*\).*/\2/p' "$folder/run.log" | tr ',' ' ' | head -1)"
    fi
done
