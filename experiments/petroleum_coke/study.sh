#!/usr/bin/env bash
# Runs behind the tables and figures of figures/petroleum_coke: seeds, twins without crushing, half the loading rate, the adaptive programme, wall friction,
# truncation of the strength draw. From the repository root: experiments/petroleum_coke/study.sh PART [FOLDER]
# with PART one of seeds, twins, rate, adaptive, walls, truncation, scale1, all. What is finished is skipped.
set -u
part=${1:?part: seeds, twins, rate, adaptive, walls, truncation, scale1 or all}
out=${2:-runs/study}
program=${COMMINUTE:-target/release/comminute}
scenes=experiments/petroleum_coke

# run FOLDER SCENE OPTION…
run() {
    local folder=$out/$1 scene=$scenes/$2.toml
    shift 2
    if [ -f "$folder/summary.json" ]; then return; fi
    if [ -f "$folder/checkpoint.bin" ]; then "$program" resume --threads 1 --quiet "$folder"; return; fi
    "$program" run "$scene" --threads 1 --quiet --force --out "$folder" "$@"
}

# variant FOLDER SCENE SEED OPTION…: starts from the specimen of the scene's own run with that seed
variant() {
    local folder=$1 scene=$2 seed=$3
    shift 3
    run "$folder" "$scene" --seed "$seed" --specimen "$out/$scene-s$seed/specimen.csv" "$@"
}

seeds() {
    for s in {1..20}; do run "h-c-2-s$s" h-c-2 --seed "$s"; done
    for s in 1 2 3; do run "l-c-2-s$s" l-c-2 --seed "$s"; run "h-v-2-s$s" h-v-2 --seed "$s"; done
}
twins() { for k in l-c-2 h-c-2 h-v-2 l-c-1 h-c-1 h-v-1; do run "$k-nc" "$k-nc"; done; }
rate() {
    for s in {1..20}; do variant "half-rate-s$s" h-c-2 "$s" --set loading.rate=0.005 --set 'name="H-C-2-half-rate"'; done
}
adaptive() {
    for s in {1..20}; do variant "adaptive-s$s" h-c-2 "$s" --set loading.programme=adaptive --set 'name="H-C-2-adaptive"'; done
}
walls() {
    for s in 1 2; do
        for mu in 0.1 0.4228; do
            variant "walls-$mu-s$s" h-c-2 "$s" --set walls.friction.bottom=$mu --set walls.friction.top=$mu \
                --set walls.friction.cylinder=$mu --set "name=\"H-C-2-walls-$mu\""
        done
    done
}
clamp() { variant "$1-clamp-s$2" "$1" "$2" --set material.strength.truncation=clamp --set "name=\"$3-clamp\""; }
truncation() {
    for s in 1 2 3 4 5; do clamp h-c-2 "$s" H-C-2; done
    clamp l-c-2 1 L-C-2
    clamp h-v-2 1 H-V-2
}
scale1() { for k in h-c-1 l-c-1 h-v-1; do run "$k" "$k"; done; }
all() { seeds; twins; rate; adaptive; walls; truncation; scale1; }
"$part"
