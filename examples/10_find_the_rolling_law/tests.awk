# A table of tests (design.csv, or one with the same columns) as files of `grouser soil`: -v test=shear|plate, -v shear_speed=6.6 -v rest=0.1 -v plate_speed=50 (mm/s, s).
# `rolling` of the rate law is A = coefficient x speed^2, with -v raw=1 the coefficient itself.
# Stored tests with the constant law rest for 1 s: it does not creep, and the bed has to take up its load.
# The rate law knows coefficient x speed^2 only where grains move slowly: at ten times the speed, a tenth of the rest and a hundredth of the coefficient it is the same test.
BEGIN { FS = "," }
NR == 1 {
  for (i = 1; i <= NF; ++i) at[$i] = i
  print "soil_test: " (test == "shear" ? "direct shear" : "plate") " of " FILENAME
  print "soil: \n  diameter: [5 mm, 10 mm]\n  density: 3.1 g/cm^3\n  bulk_density: 1.6 g/cm^3\n  young_modulus: 70 MPa\n  poisson_ratio: 0.35\n  friction: 0.86"
  print "  rolling: {law: constant, coefficient: 0.3}\n  restitution: 0.4\n  wall: {friction: 0, restitution: 0.06}"
  print "solver: {time_step: auto}\nseeds: [1]"
  print "packing: {young_modulus: 70 MPa, friction: 0.5, rolling: {law: constant, coefficient: 0.1}, cohesion: 0 J/m^3, wall: {friction: 0, restitution: 0.06}}"
  if (test == "shear")
    printf "direct_shear: {side: 60 mm, height: 60 mm, pressures: [5 kPa], rates: [%s mm/s], displacement: 6 mm, rest: %s s, rest_speed: 0 m/s, samples: 48}\n", shear_speed, rest
  else
    printf "pressure_sinkage: {bin: [150 mm, 100 mm], depth: 80 mm, plate: [60 mm, 40 mm, 10 mm], brick: 50 mm, rates: [%s mm/s], sinkage: 10 mm, samples: 48}\n", plate_speed
  print "variants:"
  next
}
$at["test"] == test {
  speed = (test == "shear" ? shear_speed : plate_speed) / 1000
  law = $at["rolling_law"]
  roll = law == "rate" ? sprintf("%.6g s^2/m^2", raw ? $at["rolling"] : $at["rolling"] / speed ^ 2) : $at["rolling"]
  extra = ""
  if ($at["effect"] == "cohesion") extra = sprintf(", cohesion: %s J/m^3", $at["amount"])
  if ($at["effect"] == "wall_effects") extra = sprintf(", wall: {friction: %s, restitution: 0.06}", $at["amount"])
  if ($at["effect"] == "grain_size") extra = sprintf(", diameter: [%.5g mm, %.5g mm]", 5 * $at["amount"], 10 * $at["amount"])
  printf "  - {name: %s, seeds: [%s], soil: {young_modulus: %s Pa, friction: %s, rolling: {law: %s, coefficient: %s}%s}", $at["run"], $at["seed"], $at["young_modulus_Pa"], $at["friction"], law, roll, extra
  if (test == "shear") printf ", direct_shear: {pressures: [%s Pa]%s}", $at["normal_stress_Pa"], !raw && law == "constant" ? ", rest: 1 s" : ""
  print "}"
}
