#!/bin/bash
# Particle-steps per second of processor time on one bed: grouser, LIGGGHTS and LAMMPS (each where it is installed), turn by turn
# in one run on one core, so that a busy machine slows all of them alike. Prints each turn and the best of each.
#   dem_peers.sh bench_dem_speed BED.csv.gz LX LY [TILES_X TILES_Y] [TURNS] [STEPS]
# Same grains, floor, gravity, materials (Table 4.2, constant rolling coefficient 0.3), dt 2.2e-6 s. LIGGGHTS runs the same law;
# LAMMPS has no rolling model with the same torque: its nearest (sds). Both start from the file's positions at rest.
set -u
bench=$(readlink -f "$1"); bed=$(readlink -f "$2"); lx=$3; ly=$4; tx=${5:-1}; ty=${6:-1}; turns=${7:-3}; steps=${8:-300}
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT; cd "$work" || exit 1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1

# Grains along 10 mm cells, which suits the peers' caches.
gzip -cdf "$bed" | awk -F, -v lx="$lx" -v ly="$ly" -v tx="$tx" -v ty="$ty" '
  $1 ~ /^[0-9]+$/ { n++; x[n] = $2 - lx * int($2 / lx); if (x[n] < 0) x[n] += lx; y[n] = $3 - ly * int($3 / ly); if (y[n] < 0) y[n] += ly; z[n] = $4; d[n] = 2 * $5 }
  END { for (a = 0; a < tx; a++) for (b = 0; b < ty; b++) for (i = 1; i <= n; i++) {
          X = x[i] + a * lx; Y = y[i] + b * ly; printf "%d %.7g 3100 %.8g %.8g %.8g\n", (int(X * 100) * 1000 + int(Y * 100)) * 1000 + int(z[i] * 100), d[i], X, Y, z[i] } }' |
  sort -n -s -k1,1 | awk '{ print NR, 1, $2, $3, $4, $5, $6 }' > atoms
n=$(wc -l < atoms)
{ printf 'bed\n\n%d atoms\n1 atom types\n\n0 %s xlo xhi\n0 %s ylo yhi\n-0.001 0.5 zlo zhi\n\nAtoms\n\n' "$n" \
    "$(awk "BEGIN { print $lx * $tx }")" "$(awk "BEGIN { print $ly * $ty }")"; cat atoms; } > bed.data

common='atom_modify map array
boundary p p f
newton off
units si
read_data bed.data
neighbor 0.0005 bin
fix grav all gravity 9.81 vector 0 0 -1
fix nve all nve/sphere
timestep 2.2e-6
thermo 1000000'
cat > liggghts.in <<END
atom_style granular
communicate single vel yes
${common/fix grav/neigh_modify delay 0
fix m1 all property\/global youngsModulus peratomtype 7e7
fix m2 all property\/global poissonsRatio peratomtype 0.35
fix m3 all property\/global coefficientRestitution peratomtypepair 1 0.4
fix m4 all property\/global coefficientFriction peratomtypepair 1 0.86
fix m5 all property\/global coefficientRollingFriction peratomtypepair 1 0.3
fix m6 all property\/global coefficientRollingViscousDamping peratomtypepair 1 1.0
pair_style gran model hertz tangential history rolling_friction epsd
pair_coeff * *
fix floor all wall\/gran model hertz tangential history rolling_friction epsd primitive type 1 zplane 0.0
fix grav}
run \${n}
END
grain='hertz/material 7e7 0.4 0.35 damping tsuji tangential mindlin NULL 1.0 0.86 rolling sds 1300.0 1.4 0.3'
cat > lammps.in <<END
atom_style sphere
comm_modify mode single vel yes
${common/fix grav/pair_style granular
pair_coeff * * $grain
fix floor all wall\/gran granular $grain zplane 0.0 NULL
neigh_modify delay 0 every 1 check yes
fix grav}
run \${n}
END

seconds() { local TIMEFORMAT=%U; { time "$@" > out 2>&1; } 2>&1; }
rate() { # program input: processor time of `steps` steps, without the start
  local t0 t1
  t0=$(seconds "$1" -in "$2" -var n 0 -log none); t1=$(seconds "$1" -in "$2" -var n "$steps" -log none)
  if ! grep -q "Loop time" out; then echo "failed: $(tail -1 out)" >&2; echo 0; return; fi
  awk "BEGIN { printf \"%.3f\", $n * $steps / ($t1 - $t0) / 1e6 }"
}
declare -A best; for p in grouser liggghts lmp; do best[$p]=0; done
keep() { printf '%s %s M particle-steps/s\n' "$1" "$2"; best[$1]=$(awk "BEGIN { print ($2 > ${best[$1]}) ? $2 : ${best[$1]} }"); }
echo "$n grains, $steps steps, $turns turns"
for ((k = 0; k < turns; k++)); do
  keep grouser "$("$bench" "$bed" "$lx" "$ly" "$tx" "$ty" warm="$steps" steps="$steps" repeat=5 | grep -o '[0-9.]* M part' | cut -d' ' -f1)"
  command -v liggghts > /dev/null && keep liggghts "$(rate liggghts liggghts.in)"
  command -v lmp > /dev/null && keep lmp "$(rate lmp lammps.in)"
done
awk "BEGIN { g = ${best[grouser]}; l = ${best[liggghts]}; m = ${best[lmp]};
  printf \"best: grouser %.1f\", g; if (l > 0) printf \", liggghts %.2f (ratio %.1f)\", l, g / l; if (m > 0) printf \", lammps %.2f (ratio %.1f)\", m, g / m; print \"\" }"
