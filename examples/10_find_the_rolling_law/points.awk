# One curve of `grouser soil` as rows of a data file, every second sample with the mean of two: -v head="shear,5330,0.66,1,101"
BEGIN { FS = "," }
NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; shear = "displacement_m" in at; next }
{
  d += 1000 * (shear ? $at["displacement_m"] : $at["sinkage_m"]) / 2
  s += (shear ? $at["shear_total_Pa"] : $at["pressure_Pa"]) / 2
  if (NR % 2 == 0) next
  if (d > 0) printf "%s,%.3f,%.4g,%s\n", head, d, s, shear ? sprintf("%.3f", 1000 * $at["rise_m"]) : ""
  d = s = 0
}
