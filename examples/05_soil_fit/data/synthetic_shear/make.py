#!/usr/bin/env python3
"""Direct-shear curves that are not exponential, to show what the method for K does. Writes direct_shear.csv."""
import math
import random

random.seed(1)
c, phi = 139.28, 0.606  # Table 4.1 of the dissertation
with open("direct_shear.csv", "w") as out:
    out.write("# synthetic, not measured: 70 % of the strength with 0.4 mm, 30 % with 4 mm, 1 % noise; see README.md\n")
    out.write("normal_stress_Pa,test,displacement_mm,shear_stress_Pa\n")
    for sigma in (2080, 5330, 17830):
        top = c + sigma * math.tan(phi)
        for test in (1, 2):
            for i in range(1, 66):
                j = 0.1 * i
                tau = top * (1 - 0.7 * math.exp(-j / 0.4) - 0.3 * math.exp(-j / 4)) + random.gauss(0, 0.01 * top)
                out.write(f"{sigma},{test},{j:.1f},{tau:.1f}\n")
