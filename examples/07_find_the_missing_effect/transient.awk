# Sinkage after the slip step of each run: travel to 63 % and 95 % of its change between 20 s (the step) and 70..75 s (steady).   awk -F, -f transient.awk steady.csv transient.csv
FNR == NR { if (FNR > 1) { rim[$1] = $3; slip[$1] = $8 } next }
FNR == 1 { next }
{ n = ++rows[$1]; t[$1, n] = $2; x[$1, n] = $3; z[$1, n] = $6; if ($2 >= 70 && $2 <= 75) { sum[$1] += $6; ++count[$1] } }
END {
  print "rim_speed_mm_s,test_id,slip,sinkage_at_step_mm,steady_sinkage_mm,travel_to_63_percent_mm,travel_to_95_percent_mm"
  for (id in rows) {
    last = sum[id] / count[id]; a = b = ""; start = 0
    for (i = 1; i <= rows[id]; ++i) {
      if (t[id, i] < 20) continue
      if (!start) { start = i }
      share = (z[id, i] - z[id, start]) / (last - z[id, start])
      if (a == "" && share >= 0.632) a = x[id, i] - x[id, start]
      if (b == "" && share >= 0.95) b = x[id, i] - x[id, start]
    }
    printf "%s,%s,%.2f,%.1f,%.1f,%.0f,%.0f\n", rim[id], id, slip[id], z[id, start], last, a, b
  }
}
