#!/bin/bash
# Processor time per simulated second of LIGGGHTS and of this program, each at its largest stable step under a wheel (found by
# peer_wheel.sh): a plate pressed in and a wheel pressed in and driven, one code after the other from the same packings.
#   peer_steps.sh PEER_SOIL_TESTS PEER_WHEEL WORK      what is in WORK already is not computed again
# Leaves WORK/step_costs.csv: the forces say whether the results are equal, energies of rotation whether grains jitter.
set -eu
soil=$(readlink -f "$1"); wheel=$(readlink -f "$2"); mkdir -p "$3"; cd "$3"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
timed() { ( cd "$1"; TIMEFORMAT=%U; { time liggghts -in in.liggghts -log none > liggghts.out 2>&1; } 2> seconds.new; mv seconds.new seconds ); }
for case_ in "0.3 15 12" "1 10 4"; do  # 16 us is refused in the plate test of packing 1
  read -r mu own peer <<< "$case_"
  for seed in 1 2; do
    d=plate_${mu}_${own}_${peer}_$seed
    [ -s "$d/seconds" ] || { "$soil" sinkage 0 $seed beds "$d" rolling="$mu" step_us="$own" peer_step_us="$peer"; timed "$d"; }
  done
  d=wheel_${mu}_$own
  [ -s "$d/seconds" ] || { "$wheel" own "$mu" "$own" beds "$d" > "$d.time"; mv "$d.time" "$d/seconds"; }
  d=peer_wheel_${mu}_$peer
  [ -s "$d/seconds" ] || { "$wheel" liggghts "$mu" "$peer" beds "$d"; timed "$d"; }
done
{ echo "test,rolling,code,step_us,packing,processor_s_per_s,mean_force_N,rotation_J"
  for d in plate_*/; do
    d=${d%/}; IFS=_ read -r _ mu own peer seed <<< "$d"
    for c in own same_law; do
      if grep -q '^# stopped' "$d/$c.csv"; then echo "plate,$mu,same law,$peer,$seed,,,"; continue; fi
      awk -F, -v head="plate,$mu,$([ $c = own ] && echo "own,$own" || echo "same law,$peer"),$seed" '
        /^#/ { split($0, a, " "); cost = a[3]; time = $2; sub(/.*simulated_s /, "", time) }
        $1 + 0 == $1 && $1 > 0.005 { n++; p += $2 } END { printf "%s,%.2f,%.3f,\n", head, cost / time, 0.0024 * p / n }' "$d/$c.csv"
    done
    awk -v head="plate,$mu,LIGGGHTS,$peer,$seed" -v cost="$(cat "$d/seconds")" -v z0="$(awk '!/^#/ { print $3; exit }' "$d/series.txt")" '
      !/^#/ { if ($3 > 0.005) { n++; p += $2 } last = $3 } END { printf "%s,%.2f,%.3f,\n", head, cost / (0.1 + (last - z0) / 0.05), p / n }' "$d/series.txt"
  done
  for d in wheel_* peer_wheel_*; do
    mu=${d%_*}; mu=${mu##*_}; code=own
    [ "${d#peer}" = "$d" ] || { code=LIGGGHTS; paste -d' ' <(grep -v '^#' "$d/force.txt") <(grep -v '^#' "$d/energy.txt" | tail -n +2) |
        awk -v dt="${d##*_}e-6" 'BEGIN { print "time_s,drawbar_N,load_N,translation_J,rotation_J" } { print $1 * dt "," $2 "," $3 "," $5 "," $6 }' > "$d/series.csv"; }
    awk -F, -v head="wheel,$mu,$code,${d##*_},1" -v cost="$(tail -1 "$d/seconds" | sed 's/[^0-9.]//g')" '
      NR > 1 { end = $1; n++; z += $3; r += $5 } END { printf "%s,%.2f,%.3f,%.3g\n", head, cost / end, z / n, r / n }' "$d/series.csv"
  done; } > step_costs.csv
