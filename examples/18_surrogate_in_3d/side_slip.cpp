// One wheel (one_wheel.h) on any terrain model.
//   surrogate_side_slip MODEL SOIL.yaml OPTIONS WIDTH_m LOAD_N SLIP ANGLE_deg WAY_m      prints one row of CSV
// OPTIONS: those of the model as YAML, '{law: law.h5, rows: 4}'; file names in it from the folder this runs in.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "one_wheel.h"

int main(int argc, char** argv) {
  if (argc != 9) {
    std::fprintf(stderr,
                 "usage: surrogate_side_slip MODEL SOIL.yaml OPTIONS WIDTH_m LOAD_N SLIP ANGLE_deg WAY_m\n"
                 "columns: slip, angle deg, load N, then mean and sd of sinkage mm, drawbar N, side N, torque N m, "
                 "processor seconds per simulated second\n");
    return 2;
  }
  try {
    const double width = std::atof(argv[4]), load = std::atof(argv[5]), slip = std::atof(argv[6]),
                 angle = std::atof(argv[7]), way = std::atof(argv[8]);
    if (!(width > 0 && width < 1) || !(load > 0) || !(slip > -10 && slip < 1) || !(std::abs(angle) < 80) ||
        !(way > 0 && way < 10)) {
      std::fprintf(stderr,
                   "WIDTH_m above 0 and below 1, LOAD_N above 0, SLIP above -10 and below 1, |ANGLE_deg| below 80, "
                   "WAY_m above 0 and below 10\n");
      return 2;
    }
    one_wheel::Wheel w(one_wheel::flat_terrain(argv[1], argv[2], argv[3]), width, load);
    w.run(slip, angle * grouser::pi / 180, way);
    std::printf("%g,%g,%g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.3f\n", slip, angle, load, 1e3 * w.sinkage().mean(),
                1e3 * w.sinkage().sd(), w.drawbar().mean(), w.drawbar().sd(), w.side().mean(), w.side().sd(),
                w.torque().mean(), w.torque().sd(), w.processor());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
