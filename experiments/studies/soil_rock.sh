#!/usr/bin/env bash
# Fan's soil-rock triaxial tests (Li et al. 2023, section 4.3): rocks of 10, 15 and 20 mm at 200, 400 and 800 kPa. `soil_rock.sh` has the paper's contacts of 50 GPa,
# `soil_rock.sh 0.4` others (GPa). What is done is not done again, what was stopped goes on. Runs stay in runs/soil_rock; figures go to figures/mixture.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
bin=${CARGO_TARGET_DIR:-target}/release/comminute
modulus=${1:-50}
for pressure in 200 800 400; do
    tests=()
    for rock in 20 10 15; do
        name=fan_${rock}mm_${pressure}kPa
        out=runs/soil_rock/$modulus/$name
        "$bin" run "experiments/mixture/$name.toml" --out "$out" --continue \
            --set "materials.fines.elastic.E_GPa=$modulus" --set "materials.coarse.elastic.E_GPa=$modulus"
        tests+=("$out")
    done
    "$bin" plot "${tests[@]}" --show stress_ratio,volumetric_strain,stress_bearers --out "figures/mixture/soil_rock_${pressure}kPa_${modulus}GPa"
done
