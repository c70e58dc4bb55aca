#!/usr/bin/env bash
# Fan's soil-rock triaxial tests (Li et al. 2023, section 4.3): rocks of 10, 15 and 20 mm at 200, 400 and 800 kPa. `soil_rock.sh` has the paper's contacts of 50 GPa,
# `soil_rock.sh 0.4` others (GPa). What is done is not done again, what was stopped goes on. Runs stay in runs/soil_rock; figures go to figures/mixture.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
bin=${CARGO_TARGET_DIR:-target}/release/comminute
modulus=${1:-50}
out() { echo "runs/soil_rock/fan_$1mm_$2kPa_${modulus}GPa"; }
for rock in 20 10 15; do
    for pressure in 200 800 400; do
        "$bin" run "experiments/mixture/fan_${rock}mm_${pressure}kPa.toml" --out "$(out $rock $pressure)" --continue \
            --set "materials.fines.elastic.E_GPa=$modulus" --set "materials.coarse.elastic.E_GPa=$modulus"
    done
done
figures=figures/mixture/soil_rock_${modulus}GPa
"$bin" plot "$(out 20 200)" "$(out 10 200)" "$(out 20 800)" "$(out 10 800)" --show stress_ratio,volumetric_strain --out "$figures"
"$bin" plot "$(out 20 200)" --show stress_bearers --out "${figures}_bearers"
# what the stiffness of contacts does, where both have been run
if [ -e runs/soil_rock/fan_20mm_200kPa_50GPa/summary.json ] && [ -e runs/soil_rock/fan_20mm_200kPa_0.4GPa/summary.json ]; then
    "$bin" plot runs/soil_rock/fan_20mm_200kPa_{50,0.4}GPa --show stress_ratio,volumetric_strain --out figures/mixture/soil_rock_contacts
fi
