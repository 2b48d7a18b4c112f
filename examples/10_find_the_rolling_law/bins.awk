# One curve of `grouser soil` as the end of a line of stored/runs.csv: rise at 6 mm, then mean stress in steps of 0.5 mm.
BEGIN { FS = "," }
NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; shear = "displacement_m" in at; next }
{
  d = 1000 * (shear ? $at["displacement_m"] : $at["sinkage_m"])
  k = int(d / 0.5)
  if (d < 0 || k > 19) next
  sum[k] += shear ? $at["shear_total_Pa"] : $at["pressure_Pa"]
  ++n[k]
  if (shear) rise = $at["rise_m"] * 1000
}
END {
  printf "%s", shear ? sprintf("%.4g", rise) : ""
  for (k = 0; k < 20; ++k) printf ",%s", n[k] ? sprintf("%.4g", sum[k] / n[k]) : ""
  print ""
}
