#!/bin/bash
# Forces on a wheel and kinetic energy of the grains against the step, LIGGGHTS and here, from one packing (Table 4.2).
#   peer_wheel.sh PROGRAM WORK      what is in WORK already is not computed again; OWN, SAME, LIGGGHTS: other steps, in us
# Leaves WORK/wheel_steps.csv: means over the driven part (0.1 s at its end) and processor time per simulated second.
set -eu
program=$(readlink -f "$1"); mkdir -p "$2"; work=$(readlink -f "$2"); cd "$work"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
case_() { # code rolling step_us
  local d=$1_$2_$3
  [ -s "$d/seconds" ] && return
  "$program" "$1" "$2" "$3" beds "$d" > "$d.time" || { echo "$1 mu_r $2 $3 us: stopped"; echo refused > "$d/seconds"; return; }
  if [ "$1" = liggghts ]; then
    ( cd "$d"; TIMEFORMAT=%U; { time liggghts -in in.liggghts -log none > liggghts.out 2>&1 || true; } 2> seconds.new
      paste -d' ' <(grep -v '^#' force.txt) <(grep -v '^#' energy.txt | tail -n +2) |
        awk -v dt="$3e-6" 'BEGIN { print "time_s,drawbar_N,load_N,translation_J,rotation_J" } { print $1 * dt "," $2 "," $3 "," $5 "," $6 }' > series.csv
      mv seconds.new seconds )
  else mv "$d.time" "$d/seconds"; fi
  rm -f "$d.time"
  echo "$1 mu_r $2 $3 us: $(cat "$d/seconds") s"
}
for mu in 0.3 1; do
  for dt in ${OWN:-4 8 12 16 20 24}; do case_ own $mu $dt; done
  for dt in ${SAME:-2.2 4 8 12}; do case_ same_law $mu $dt; done
  for dt in ${LIGGGHTS:-2.2 4 6 8 12 16 20}; do case_ liggghts $mu $dt; done
done
{ echo "code,rolling,step_us,drawbar_N,drawbar_sd_N,load_N,translation_J,rotation_J,largest_rotation_J,processor_s_per_s"
  for d in *_*_*/; do
    d=${d%/}; [ -s "$d/series.csv" ] || continue
    awk -F, -v head="$(echo "$d" | sed 's/same_law/same law/; s/_/,/g')" -v cost="$(tail -1 "$d/seconds")" '
      NR > 1 { end = $1; if ($1 > 0.4) { n++; x += $2; xx += $2 * $2; z += $3; t += $4; r += $5 } if ($5 > most) most = $5 }
      END { if (n) printf "%s,%.3f,%.3f,%.3f,%.3g,%.3g,%.3g,%.2f\n", head, x / n, sqrt(xx / n - (x / n) ^ 2), z / n, t / n, r / n, most, cost / end; else print head ",,,,,,," }' "$d/series.csv"
  done; } > wheel_steps.csv
