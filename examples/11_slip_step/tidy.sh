#!/usr/bin/env bash
# data/cmu_transients.csv from the measured courses: 21 s to 75 s of each run (the rim speed has stepped at 20 s), one row in eight (2 s).
# Speeds are those that were set: 10 mm/s of travel, and the rim's; the measured ones scatter about them by the encoder's step.   bash tidy.sh FOLDER
# FOLDER: cmu_single_wheel of the measured data, with wheel_smooth_steady.csv (loads) and wheel_smooth_beta0_transient.csv.
set -euo pipefail
cd "$(dirname "$0")"
awk -F, '
  FNR == NR { if (FNR > 1) { load[$1] = $13; rim[$1] = $3 } next }
  FNR == 1 { next }
  $2 >= 21 && $2 <= 75 && (++rows[$1] % 8) == 1 {
    printf "%s,%s,%.6f,0.01,%s,%s,0.66\n", $1, $2, rim[$1] / 58, load[$1], $6 }' "$1/wheel_smooth_steady.csv" "$1/wheel_smooth_beta0_transient.csv" |
  { echo batch,time_s,omega_rad_s,travel_speed_m_s,load_N,sinkage_mm,sinkage_sd_mm; cat; } >data/cmu_transients.csv
wc -l data/cmu_transients.csv
