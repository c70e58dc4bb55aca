#!/usr/bin/env bash
# What becomes of the mass that daughters do not hold, and what that does to the compression line: the silica sand of Ciantia et al. (2015) to 100 MPa under strain control, with mass that
# leaves the test (the paper), fragments that grow to their mother's mass, and fines as material points; the first two with Weibull moduli of 2 to 10, whose lines have the slopes of
# McDowell & de Bono (2013). The runs behind figures/lost_mass. What is done is not done again.
# From the repository root: experiments/studies/lost_mass.sh [FOLDER]
set -eu
out=${1:-runs/lost_mass}
program=${COMMINUTE:-target/release/comminute}

run() {
    "$program" run experiments/silica/h-c-2.toml --continue --threads 1 --quiet --out "$out/$1" --set "name=\"$1\"" --set loading.control=strain \
        --set loading.inertial_number=0.0003 --set crushing.birth=gradual --set contact.unloading=rescale --set records.figures=false \
        --set records.snapshots=false "${@:2}" || echo "$out/$1 failed" >&2
}

run leave-3
same=(--specimen "$out/leave-3/specimen.csv")
run grow-3 "${same[@]}" --set crushing.lost_mass=grow
run points-3 "${same[@]}" --set crushing.lost_mass=points
for m in 2 5 10; do
    run "leave-$m" "${same[@]}" --set material.strength.fixed_angle.m="$m.0"
    run "grow-$m" "${same[@]}" --set crushing.lost_mass=grow --set material.strength.fixed_angle.m="$m.0"
done

# void ratio at four stresses, slope of log e against log σ_v from 30 to 90 MPa where e stays above 0.15, that of the theory (1/2b, b = 3/m), and what the run took
table=figures/lost_mass/lost_mass.csv
echo "lost_mass,m,void_ratio_10_MPa,void_ratio_30_MPa,void_ratio_50_MPa,void_ratio_90_MPa,slope,slope_theory,k0_end,breakages,steps,seconds" > "$table"
for way in leave grow points; do
    for m in 2 3 5 10; do
        of="$out/$way-$m"
        [ -e "$of/summary.json" ] || continue
        seconds=$(sed -n 's/.*"loading_seconds": \([0-9.]*\).*/\1/p' "$of/summary.json")
        awk -F, -v way="$way" -v m="$m" -v seconds="$seconds" '
            /^#/ { next }
            !c { for (i = 1; i <= NF; i++) at[$i] = i; c = 1; next }
            { s = $at["sigma_v_kPa"] / 1e3; e = $at["void_ratio"] + 0; k = $at["k0"]; events = $at["crush_events"]; steps = $at["step"]
              split("10 30 50 90", w, " "); for (j = 1; j <= 4; j++) if (!(j in found) && s >= w[j]) found[j] = e
              if (s >= 30 && s <= 90) { if (e < 0.15) closed = 1; x = log(s); y = log(e); n++; sx += x; sy += y; xx += x * x; xy += x * y } }
            END { slope = n > 2 && !closed ? sprintf("%.2f", (n * xy - sx * sy) / (n * xx - sx * sx)) : ""
              printf "%s,%s,%.3f,%.3f,%.3f,%.3f,%s,%.2f,%.2f,%d,%d,%.0f\n", way, m, found[1], found[2], found[3], found[4], slope, -m / 6, k, events, steps, seconds }' \
            "$of/history.csv" >> "$table"
    done
done
"$program" plot "$out"/leave-3 "$out"/grow-3 "$out"/points-3 --data figures/lost_mass/ganju.csv --show void_ratio,k0,crush_events --quiet --out figures/lost_mass
"$program" plot "$out"/grow-* --show void_ratio --quiet --out figures/lost_mass/grow
