#pragma once
// Grains poured into boxes and beds, and the soil tests of section 4.2.3 on them.
#include <functional>
#include <vector>

#include "grouser/dem/solver.h"

namespace grouser::dem {

/// Soil as grains. Defaults: Table 4.2 with the rate-dependent rolling coefficient; walls smooth with e = 0.06.
struct SoilSettings {
  SoilSettings();
  MaterialTable materials;  ///< 0: grains, 1: smooth walls
  LawSettings law;
  double smallest = 0.0025, largest = 0.010;  ///< diameters [m], uniform by number
  double density = 3100;                      ///< of grains while pouring [kg/m3]
  double bulk_density = 1600;                 ///< aimed at by scaling the density of the grains [kg/m3]
  double dt = 8e-6;
  Precision precision = Precision::single;
  unsigned seed = 1;  ///< packing
};

/// Part of the work done, 0 to 1, and the time simulated [s]; long tests call it about a hundred times.
using Progress = std::function<void(double done, double time)>;

struct Packing {
  std::vector<GrainState> grains;
  double height = 0;        ///< of the surface: mean of the highest grain tops over 10 mm squares [m]
  double bulk_density = 0;  ///< mass over base area and height [kg/m3]
  double settle_time = 0;   ///< simulated [s]
};
/// Grains rained into a column lx x ly, periodic in x and y, until they fill `height`, settled under gravity. Seeded.
/// @throws DemError: sizes not positive, base narrower than two large grains.
Packing pour_periodic(const SoilSettings& soil, double lx, double ly, double height, const Progress& progress = {});
/// Copies of a periodic packing side by side.
std::vector<GrainState> tile(const std::vector<GrainState>& grains, double lx, double ly, int nx, int ny);

struct ShearSettings {
  double side = 0.06, height = 0.06;  ///< of the soil [m]
  double pressure = 5330;             ///< [Pa]
  double rate = 6.6e-4;               ///< [m/s]
  double displacement = 6.6e-3;       ///< [m]
  int samples = 100;
};
struct ShearCurve {
  std::vector<double> displacement;  ///< [m]
  std::vector<double> shear;         ///< force on the upper box over the area [Pa], mean over the sample
  std::vector<double> shear_total;   ///< the same with the loading plate, which moves along
  std::vector<double> normal;        ///< pressure that the plate gives [Pa]
  std::vector<double> rise;          ///< of the plate [m], dilation positive
  double bulk_density = 0;
  std::size_t grains = 0;
  Counters counters;
};
/// Direct shear: grains poured into a split box, loaded by a rough plate (a layer of grains as one body), upper
/// half and plate moved at `rate`. Cost: 640 grains, 0.66 mm/s, 6.6 mm: about two minutes.
ShearCurve direct_shear(const SoilSettings& soil, const ShearSettings& test, const Progress& progress = {});

struct SinkageSettings {
  double bin_x = 0.4, bin_y = 0.15, depth = 0.16;  ///< periodic bin [m]
  double plate_x = 0.13, plate_y = 0.05, plate_z = 0.01;
  double rate = 0.01, sinkage = 0.02;  ///< [m/s], [m]
  double brick = 0.05;                 ///< side of the poured brick that is tiled [m]
  int samples = 100;
  int threads = 1;
};
struct SinkageCurve {
  std::vector<double> sinkage;   ///< below the surface of the packing [m]
  std::vector<double> pressure;  ///< [Pa], mean over the sample
  double bulk_density = 0;
  std::size_t grains = 0;
  Counters counters;
};
SinkageCurve pressure_sinkage(const SoilSettings& soil, const SinkageSettings& test, const Progress& progress = {});

}  // namespace grouser::dem
