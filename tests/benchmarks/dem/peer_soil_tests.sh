#!/bin/bash
# Soil tests in LIGGGHTS and here from the same packings (Table 4.2, constant rolling coefficient 0.3).
#   peer_soil_tests.sh PROGRAM WORK [SEEDS]      what is in WORK already is not computed again
# Leaves WORK/shear_curves.csv, WORK/sinkage_curves.csv (every curve) and WORK/costs.csv (processor time).
set -eu
program=$(readlink -f "$1"); mkdir -p "$2"; work=$(readlink -f "$2"); seeds=${3:-5}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
case_() { # kind pressure seed
  local d=$work/$1_$2_$3
  [ -s "$d/done" ] && return
  "$program" "$1" "$2" "$3" "$work/beds" "$d"
  ( cd "$d"; TIMEFORMAT=%U; { time liggghts -in in.liggghts -log none > liggghts.out 2>&1; } 2> seconds; mv seconds done )
  echo "$1 $2 Pa packing $3: LIGGGHTS $(cat "$d/done") s"
}
for ((k = 1; k <= seeds; k++)); do
  for p in 5330 2080 17830; do case_ shear $p "$k"; done
  case_ sinkage 0 "$k"
done
{ echo "code,pressure_Pa,packing,displacement_m,shear_Pa,rise_m"
  for d in "$work"/shear_*_*/; do
    d=${d%/}; p=$(basename "$d" | cut -d_ -f2); s=$(basename "$d" | cut -d_ -f3)
    for c in own same_law; do awk -F, -v c=$c -v p="$p" -v s="$s" '!/^#/ && $1 + 0 == $1 { print c "," p "," s "," $1 "," $3 "," $5 }' "$d/$c.csv"; done
    awk -v p="$p" -v s="$s" '!/^#/ { n++; if (n == 1) z = $4; print "LIGGGHTS," p "," s "," (n - 0.5) * 6.6e-5 "," (-($2 + $3) / 0.0036) "," $4 - z }' "$d/series.txt"
  done; } > "$work/shear_curves.csv"
{ echo "code,packing,sinkage_m,pressure_Pa"
  for d in "$work"/sinkage_*_*/; do
    d=${d%/}; s=$(basename "$d" | cut -d_ -f3)
    for c in own same_law; do awk -F, -v c=$c -v s="$s" '!/^#/ && $1 + 0 == $1 { print c "," s "," $1 "," $2 }' "$d/$c.csv"; done
    awk -v s="$s" '!/^#/ { print "LIGGGHTS," s "," (n++ ? ($3 + last) / 2 : $3) "," $2 / 0.0024; last = $3 }' "$d/series.txt"
  done; } > "$work/sinkage_curves.csv"
{ echo "test,pressure_Pa,packing,own_s,same_law_s,liggghts_s"
  for d in "$work"/*_*_*/; do
    d=${d%/}; echo "$(basename "$d" | tr _ ,),$(sed -n 's/.*processor_time_s \([0-9.]*\),.*/\1/p' "$d/own.csv" "$d/same_law.csv" | paste -sd,),$(cat "$d/done")"
  done; } > "$work/costs.csv"
