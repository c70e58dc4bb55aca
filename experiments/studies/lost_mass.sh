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
