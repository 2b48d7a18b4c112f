# Table 4.8 (fitted to DEM wheel runs) against Table 4.1 and Table 4.6 with the priors of cases/mit.yaml; with -v cases=1 its wheel at the nine slips for `grouser bekker solve`, k of the wheel's width.
BEGIN {
  if (!cases) {
    print "parameter,table_4_1,table_4_8,prior_sd,z,says"
    judge("ln k [Pa]", log(2.541e5), log(2.305e4), 0.30)
    judge("n", 1.387, 0.418, 0.14)
    judge("c [Pa]", 139.28, 96.24, 415)
    judge("phi [rad]", 0.606, 0.606, 0.0502)
    judge("ln K [m]", log(5.151e-4), log(4.534e-3), 1.0)
    judge("a0", 0.18, 0.09, 0.2)
    judge("a1", 0.32, 0.90, 0.2)
    exit
  }
  print "c_Pa,phi_rad,n,K_m,kc,kphi,radius_m,width_m,load_N,a0,a1,b0,b1,slip,beta_rad"
  split("-0.7 -0.5 -0.3 -0.1 0 0.1 0.3 0.5 0.7", rim, " ")
  for (i = 1; i <= 9; ++i)  # slips of the dissertation are (r w - v)/(r w)
    printf "96.24,0.606,0.418,4.534e-3,0,%.6g,0.13,0.16,115,0.09,0.90,0,0,%.6g,0\n", 2.305e4 / 0.16 ^ 0.418, rim[i] < 0 ? rim[i] / (1 - rim[i]) : rim[i]
}
function judge(name, prior, value, sd) {
  z = (value - prior) / sd
  printf "%s,%.4g,%.4g,%.3g,%.1f,%s\n", name, prior, value, sd, z, (z * z > 9) ? "structural" : ""
}
