# Which tests are computed for the emulator: one line each. Points of a sequence with low discrepancy (Roberts 2018, R_d), logarithms of Y, friction,
# rolling coefficient and pressure evenly over their ranges. Rolling: the constant coefficient, or A = coefficient x speed^2 of the rate law.
function frac(x) { return x - int(x) }
function spread(u, low, high) { return exp(log(low) + u * log(high / low)) }
# `count` tests of one law in one kind of test.
function block(law, effect, kind, count, offset,    k, j, u, phi, Y, mu, roll, p, amount, seed) {
  phi = 2
  for (j = 0; j < 60; ++j) phi = (1 + phi) ^ (1 / 6)
  for (k = 1; k <= count; ++k) {
    for (j = 1; j <= 5; ++j) u[j] = frac(0.5 + (k + offset) * phi ^ -j)
    Y = spread(u[1], 20e6, 120e6)
    mu = spread(u[2], 0.3, 1)
    roll = law == "constant" ? spread(u[3], 0.02, 1) : kind == "shear" ? spread(u[3], 0.1, 3e6) : spread(u[3], 100, 3e6)
    p = kind == "shear" ? spread(u[4], 1500, 25000) : 0
    amount = effect == "" ? 0 : effect == "cohesion" ? 6e5 * u[5] : effect == "wall_effects" ? 0.6 * u[5] : spread(u[5], 0.8, 1.3)
    seed = 1 + int((kind == "shear" ? 12 : 8) * frac(0.5 + k * 0.7548776662))
    printf "%s_%s_%02d,%s,%s,%.5g,%.4g,%.4g,%.5g,%s,%.4g,%d\n", effect == "" ? law : effect, kind, k, kind, law, Y, mu, roll, p, effect, amount, seed
  }
}
BEGIN {
  print "run,test,rolling_law,young_modulus_Pa,friction,rolling,normal_stress_Pa,effect,amount,seed"
  block("constant", "", "shear", 80, 0)
  block("constant", "", "plate", 36, 100)
  block("rate", "", "shear", 80, 200)
  block("rate", "", "plate", 36, 300)
  block("constant", "cohesion", "shear", 32, 400)
  block("constant", "cohesion", "plate", 16, 450)
  block("constant", "wall_effects", "shear", 32, 500)
  block("constant", "wall_effects", "plate", 16, 550)
  block("constant", "grain_size", "shear", 32, 600)
  block("constant", "grain_size", "plate", 16, 650)
}
