#!/usr/bin/env bash
# A sweep by shell loops: the gain of a proportional controller, then the first length scale of SP's drift kernel, in the
# paper's Experiment 1. Every run gets a name of its own, hence a folder; `bayesctrl table` gathers them. (A spec may also
# hold a `sweep`: see `bayesctrl run --help`.)
#   scripts/sweep_example.sh [FOLDER]     FOLDER: where results go, default a new temporary one
#   BAYESCTRL=PROGRAM                     the program, default build/release/bayesctrl of this tree
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

spec=$root/configs/exp1.yaml
bayesctrl=${BAYESCTRL:-$root/build/release/bayesctrl}
if ! command -v "$bayesctrl" >/dev/null; then
  echo "sweep_example: no program '$bayesctrl': run scripts/build, or set BAYESCTRL" >&2
  exit 6
fi
out=${1:-$(mktemp -d -t bayesctrl-sweep-XXXXXX)}

folders=()
for gain in 10 30 100; do
  name=gain-$gain
  "$bayesctrl" run "$spec" --set "name=$name" --set "controllers.P100.gain=$gain" --out "$out" --quiet
  folders+=("$out/$name")
done
for scale in 5 10 20; do
  name=length-scale-$scale
  "$bayesctrl" run "$spec" --set "name=$name" --set "belief.drift.kernel.length_scales.0=$scale" --out "$out" --quiet
  folders+=("$out/$name")
done

"$bayesctrl" table "${folders[@]}"
echo "results in $out" >&2
