#!/usr/bin/env bash
# Does a calibration give back what a curve was made with? The runs behind figures/calibration/curve: twelve curves of the small coke scene
# with known parameters, each calibrated; then three of them again with k0 and the gradation at the end beside the curve. About half an
# hour on one core; started again, it goes on. From the repository root: experiments/calibration/study.sh [FOLDER]
set -eu
out=${1:-runs/curve-study}
program=${COMMINUTE:-target/release/comminute}
here=experiments/calibration
figures=figures/calibration/curve

study() { "$program" calibrate curve-study --scene $here/coke_small.toml --check 2 --jobs 1 --threads 1 --quiet "$@"; }
study --truths $here/truths.csv --budget 66 --out "$out/curve"
mkdir -p "$out"
grep -v '^[0-9]' $here/truths.csv > "$out/three.csv"
grep '^[0-9]' $here/truths.csv | head -3 >> "$out/three.csv"
study --truths "$out/three.csv" --all-data --budget 56 --out "$out/all_data"

mkdir -p $figures/example $figures/all_data $here/targets
cp "$out"/curve/{recovery,left_out}*.csv "$out"/curve/recovery*.svg $figures
cp "$out"/all_data/recovery.csv $figures/all_data
cp "$out"/curve/targets/target-*.csv $here/targets
for name in curve corner sensitivity convergence; do
    cp "$out"/curve/calibration-05/figures/$name.{svg,csv} $figures/example
done
cp "$out"/curve/calibration-05/{calibration.json,evaluations.csv,report.md} $figures/example
cp "$out"/all_data/calibration-03/figures/{k0,gradation}*.{svg,csv} $figures/all_data
