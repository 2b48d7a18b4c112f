#!/usr/bin/env bash
# Writes data/*.csv, the tables that `grouser diagnose` reads, from the measured tables beside examples 03 and 05. Nothing changes but names, units and what is said here.
set -euo pipefail
cd "$(dirname "$0")"
hit=../05_soil_fit/data/hit_ding2011_wheel/wheel_steady.csv
mit=../03_single_wheel_rig/data/mit_mms_wheel/wheel_steady.csv
cmu=../05_soil_fit/data/cmu_single_wheel
mkdir -p data

# HIT: $1 lugs, $2 radius of the slip, $3 noise over the stated one. Torque 0 at slip 0 is a gap in the source: left empty.
# Stated noise: the upper reading errors of the source, 1 N, 0.2 N m, 0.5 mm.
hit() {
  awk -F, -v OFS=, -v lugs="$1" -v radius="$2" -v f="$3" '
    NR == 1 { print "case,slip,slip_definition,slip_radius_m,load_N,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,torque_sd_Nm,sinkage_sd_m" }
    NR > 1 && ($5 > 0) == lugs { print $1, $7, "rim", radius, $6, $8, $7 == 0 ? "" : $10, $9, 1.0 * f, 0.2 * f, 0.0005 * f }' $hit
}
hit 0 0.15735 1 >data/hit_smooth.csv
hit 0 0.15735 0.5 >data/hit_smooth_half_noise.csv
hit 0 0.15735 2 >data/hit_smooth_twice_noise.csv
hit 1 0.15735 1 >data/hit_lugged.csv
hit 1 0.16735 1 >data/hit_lugged_tip_radius.csv

# MIT: $1 definition of slip, $2 load, $3 least slip, $4 = 0 leaves out the torque of braking rows. 17 deg/s.
# Noise: 2 N, 0.2 N m, 1.5 mm, the blind tests' noise for this wheel; the source gives reading errors only.
mit() {
  awk -F, -v OFS=, -v definition="$1" -v load="$2" -v least="$3" -v braking="$4" '
    NR == 1 { print "slip,slip_definition,slip_radius_m,load_N,omega_deg_s,drawbar_N,torque_Nm,sinkage_mm,drawbar_sd_N,torque_sd_Nm,sinkage_sd_mm" }
    NR > 1 && $1 >= least { print $1, definition, 0.13, load, 17, $2, $1 < 0 && !braking ? "" : $6, $4, 2, 0.2, 1.5 }' $mit
}
for load in 115 130; do
  mit rim $load -1 1 >data/mit_rim_$load.csv
  mit larger $load -1 1 >data/mit_larger_$load.csv
  mit rim $load -1 0 >data/mit_no_braking_torque_$load.csv
  mit rim $load 0 1 >data/mit_driving_$load.csv
done

# CMU: slip angle 0, 9 rim speeds x 3 repeats. $2, $3: sd of drawbar and sinkage between repeats. The locked wheel has its travel speed.
cmu() {
  awk -F, -v OFS=, -v drawbar_sd="$2" -v sinkage_sd="$3" '
    NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i
              print "0,test_id,slip,slip_definition,slip_radius_m,load_N,omega_rad_s,travel_speed_mm_s,replicate,drawbar_N,sinkage_mm,drawbar_sd_N,sinkage_sd_mm" }
    NR > 1 && $at["slip_angle_deg"] == 0 {
      v = $at["rim_speed_nominal_mm_s"]
      print v + 1, $at["test_id"], $at["slip"], "larger", 0.058, $at["load_N"], $at["rim_speed_mm_s"] / 58, $at["travel_speed_mm_s"], ++n[v], $at["drawbar_N"], $at["sinkage_mm"], drawbar_sd, sinkage_sd
    }' "$1" | sort -t, -k1,1n -k2,2 | cut -d, -f2-
}
cmu $cmu/wheel_smooth_steady.csv 0.34 0.66 >data/cmu_smooth.csv
cmu $cmu/wheel_grouser_beta0_steady.csv 0.72 0.67 >data/cmu_grouser.csv
awk -F, 'NR == 1 || $2 > -0.01' data/cmu_smooth.csv >data/cmu_smooth_driving.csv
