# ln of the mean stress in the three windows, per pressure: mean and sd over packings of two data files
BEGIN { FS = "," } FNR == 1 { ++file; next } $1 == "shear" { w = $6 < 0.5 ? 0 : $6 < 1.5 ? 1 : $6 < 3 ? 2 : 3; k = file SUBSEP $2 SUBSEP $5 SUBSEP w; s[k] += $7; ++n[k]; p[$2]; r[$2, $5] = $5 }
END { for (q in p) for (w = 1; w <= 3; ++w) { line = q " Pa window " w ":"
  for (f = 1; f <= file; ++f) { m = v = c = 0; for (k in s) { split(k, a, SUBSEP); if (a[1] == f && a[2] == q && a[4] == w) { x = log(s[k] / n[k]); m += x; v += x * x; ++c } }
    m /= c; line = line sprintf("  %.3f +- %.3f", m, sqrt((v - c * m * m) / (c - 1))) } print line } }
