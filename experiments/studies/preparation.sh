#!/usr/bin/env bash
# How much of a result is the specimen's preparation: H-C-2 of coke, prepared in three ways to the same porosity, three seeds each. The runs behind
# figures/preparation. From the repository root: experiments/studies/preparation.sh [FOLDER]
set -eu
out=${1:-runs/preparation}
program=${COMMINUTE:-target/release/comminute}
scene=experiments/petroleum_coke/h-c-2.toml

go() { "$program" ensemble "$scene" --seeds 1..3 --jobs "${JOBS:-2}" --quiet --out "$out/$1" --set "name=\"H-C-2-$1\"" "${@:2}"; }
go reference
go friction-0.2 --set preparation.growth_friction=0.2   # friction while radii grow, which has to be taken away afterwards; the scene has none
go fast-growth --set preparation.growth_steps=2000       # radii grow four times as fast
"$program" plot "$out"/{reference,friction-0.2,fast-growth}/seed-* --quiet --show compression,crush_events,k0 --out figures/preparation
