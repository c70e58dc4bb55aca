#!/bin/sh
# Long forms of the tests that try to break the program, and the tables of docs/validation/hard_to_break.md that they write: hard cases in some ten minutes, damaged
# checkpoints in an hour, kills in half an hour (COMMINUTE_KILLS of them, 1000 if not set), inputs for ten minutes each (COMMINUTE_FUZZ_SECONDS), memory in some minutes. From the
# repository root. Hard cases and kills that their tables hold are not made again: after a change remove hard_cases.csv and kills.csv first.
set -eu
cargo test --release --locked --test hard -- --ignored
COMMINUTE_DAMAGED_TABLE=${COMMINUTE_DAMAGED_TABLE:-docs/validation/hard_to_break/damaged_checkpoints.csv} cargo test --release --locked --test damaged -- --ignored
cargo test --release --locked --test kills -- --ignored
COMMINUTE_FUZZ_SECONDS=${COMMINUTE_FUZZ_SECONDS:-600} cargo test --release --locked --test fuzz -- --ignored
cargo build --release --locked
experiments/studies/memory.sh
experiments/studies/bad_inputs.sh
COMMINUTE_BOOK=write cargo test --release --locked --test book
