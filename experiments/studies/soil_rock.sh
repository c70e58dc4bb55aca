#!/usr/bin/env bash
# What the stiffness of contacts does in one of Fan's soil-rock triaxial tests (Li et al. 2023, section 4.3): rocks of 20 mm at 200 kPa with the paper's contacts of 50 GPa and with 0.4 GPa,
# with which `comminute reproduce li2023 --only 'fan*'` makes all nine. Then rocks of 10, 15 and 20 mm at 200 kPa with the paper's points of 2 mm: some two hours each on one core.
# What is done is not done again, what was stopped goes on. Runs stay in runs/soil_rock; figures go to figures/mixture.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
bin=${CARGO_TARGET_DIR:-target}/release/comminute
out() { echo "runs/soil_rock/fan_20mm_200kPa_$1GPa"; }
for modulus in 50 0.4; do
    "$bin" run experiments/mixture/fan_20mm_200kPa.toml --out "$(out $modulus)" --continue \
        --set "materials.fines.elastic.E_GPa=$modulus" --set "materials.coarse.elastic.E_GPa=$modulus"
    "$bin" plot "$(out $modulus)" --show stress_bearers --out "figures/mixture/soil_rock_${modulus}GPa_bearers"
done
"$bin" plot "$(out 50)" "$(out 0.4)" --show stress_ratio,volumetric_strain --out figures/mixture/soil_rock_contacts

fine() { echo "runs/soil_rock/fan_${1}mm_200kPa_2mm_points"; }
for rocks in 10 15 20; do
    "$bin" run "experiments/mixture/fan_${rocks}mm_200kPa.toml" --out "$(fine $rocks)" --continue --threads 1 \
        --set growth.fines_diameter_mm='[1.9,2.1]' --set grid.cell_mm=4 --set test.strain_per_wave=1e-3 \
        --set materials.fines.elastic.E_GPa=0.4 --set materials.coarse.elastic.E_GPa=0.4
done
"$bin" plot "$(fine 10)" "$(fine 15)" "$(fine 20)" --show stress_ratio,volumetric_strain --out figures/mixture/soil_rock_2mm
