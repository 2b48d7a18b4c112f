# The list of tests that stand for measurements (data/?_tests.csv): -v name=a -v law=rate -v Y=5.5e7 -v mu=0.7 -v roll=6.75e8 -v effect= -v amount=0 -v shear="2080 5330 17830" -v plates=1
# -v first=101 -v repeats=4. Seeds from 101 on: packings that the stored runs have not seen.
BEGIN {
  print "run,test,rolling_law,young_modulus_Pa,friction,rolling,normal_stress_Pa,effect,amount,seed"
  n = split(shear, p, " ")
  for (r = 0; r < repeats; ++r) {
    for (k = 1; k <= n; ++k) printf "%s_shear_%d_%d,shear,%s,%s,%s,%s,%s,%s,%s,%d\n", name, p[k], first + r, law, Y, mu, roll, p[k], effect, amount, first + r
    if (plates) printf "%s_plate_%d,plate,%s,%s,%s,%s,0,%s,%s,%d\n", name, first + r, law, Y, mu, roll, effect, amount, first + r
  }
}
