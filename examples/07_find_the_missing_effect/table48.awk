# The wheel of Table 4.8 (fitted to DEM wheel runs) at its nine slips for `grouser bekker solve`, k of the wheel's width.
BEGIN {
  print "c_Pa,phi_rad,n,K_m,kc,kphi,radius_m,width_m,load_N,a0,a1,b0,b1,slip,beta_rad"
  split("-0.7 -0.5 -0.3 -0.1 0 0.1 0.3 0.5 0.7", rim, " ")
  for (i = 1; i <= 9; ++i)  # slips of the dissertation are (r w - v)/(r w)
    printf "96.24,0.606,0.418,4.534e-3,0,%.6g,0.13,0.16,115,0.09,0.90,0,0,%.6g,0\n", 2.305e4 / 0.16 ^ 0.418, rim[i] < 0 ? rim[i] / (1 - rim[i]) : rim[i]
}
