#!/bin/sh
# What the program says of calls, scenes and data that are wrong, as docs/validation/hard_to_break/bad_inputs.csv, in some seconds. From the repository root, after
# cargo build --release. Every one must be refused with exit code 2 before any work.
set -eu
program=${COMMINUTE:-target/release/comminute}
table=docs/validation/hard_to_break/bad_inputs.csv
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo "input,exit_code,message" > "$table"

# what is wrong, then the call
refused() {
    what=$1
    shift
    code=0
    "$program" "$@" > /dev/null 2> "$work/said" || code=$?
    [ "$code" = 2 ] || { echo "$what: exit code $code: $(cat "$work/said")"; exit 1; }
    message=$(sed -n '/^error: /,$p' "$work/said" | sed 's/^error: //' | head -1 | sed "s#$work#FOLDER#g; s/\"/\"\"/g")
    echo "$what,$code,\"$message\"" >> "$table"
}

coke=experiments/petroleum_coke/h-c-2.toml
refused "a key that does not exist" check $coke --set loading.max_stres_kPa=100
refused "a word for a number" check $coke --set loading.max_stress_kPa=high
refused "a negative stress" check $coke --set loading.max_stress_kPa=-5
refused "not a number" check $coke --set loading.max_stress_kPa=nan
refused "a word that is no choice" check $coke --set contact.law=hertzian
refused "a fraction for a number of grains" check $coke --set specimen.grains=12.5
refused "too many grains for the memory" run $coke --set specimen.grains=90000000 --set specimen.diameter_mm=10000 --quiet --out "$work/many"
refused "a Poisson ratio of 0.6" check $coke --set material.elastic.nu=0.6
refused "a file that is not there" check nowhere.toml
refused "a folder for a scene" check experiments
printf 'kind = "oedometer"\nname = ' > "$work/cut.toml"
refused "a scene that is cut off" check "$work/cut.toml"
printf 'base = "loop.toml"\n' > "$work/loop.toml"
refused "a base that is its own" check "$work/loop.toml"
printf '\377\376' > "$work/binary.toml"
refused "bytes that are no text" check "$work/binary.toml"
refused "a device without an end" check /dev/zero
refused "a specimen without an end" run $coke --set specimen.file=/dev/zero --quiet --out "$work/zero"
refused "no threads" run $coke --threads 0 --out "$work/none"
refused "more threads than any machine has" run $coke --threads 65535 --out "$work/threads"
refused "grains at one place" run experiments/hard/empty_box.toml --quiet --out "$work/same" \
    --set "grain=[{position_m=[0.0,0.0,0.0005],radius_m=0.0005},{position_m=[-0.0,0.0,0.0005],radius_m=0.0005}]"
printf 'diameter_mm,force_N\n1.0,ten\n' > "$work/crushing.csv"
refused "crushing data with a word for a force" calibrate grains "$work/crushing.csv" --out "$work/fit"
refused "a sweep over a key that does not exist" sweep $coke --grid loading.pase=0.1 --out "$work/sweep"
refused "seeds that are none" ensemble $coke --seeds one,two --out "$work/seeds"
refused "a folder that holds no run" resume "$work"
mkdir "$work/strange"
echo mine > "$work/strange/notes.txt"
refused "a folder with files of somebody else" run $coke --force --quiet --out "$work/strange"
[ "$(cat "$work/strange/notes.txt")" = mine ]
