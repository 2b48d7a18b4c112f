#pragma once
// Soil tests on packings of grains (section 4.2.3), in pieces: between two of them a test may be saved and continued
// with the same bits.
#include <memory>
#include <string>
#include <vector>

#include "grouser/dem/packing.h"
#include "grouser/terrain/state.h"

namespace grouser::dem {

/// Named columns in SI units.
struct Table {
  std::vector<std::string> columns;       ///< with the unit behind: "shear_Pa"
  std::vector<std::vector<double>> rows;  ///< as many values as columns
  /// @throws DemError for an unknown name.
  std::vector<double> column(const std::string& name) const;
  void traverse(State& s, const char* name);  ///< the rows
};

class SoilTest {
 public:
  virtual ~SoilTest() = default;
  /// One piece further: 20 ms of coming to rest, or one sample. False when complete. @throws DemError.
  virtual bool advance() = 0;
  virtual double left() const = 0;  ///< simulated time still to go, at most [s]
  double time() const { return solver_->time(); }
  const Table& table() const { return table_; }
  Counters counters() const { return solver_->counters(); }
  /// Single numbers beside the table, with the unit in the name.
  virtual std::vector<std::pair<std::string, double>> notes() const { return {}; }
  /// Save, load. Loading wants a test made from the same inputs that has not been advanced.
  void traverse(State& s);

 protected:
  virtual void own_state(State& s) = 0;
  std::unique_ptr<Solver> solver_;
  Table table_;
};

struct ShearSettings {
  double side = 0.06, height = 0.06;  ///< of the soil [m]
  double pressure = 5330;             ///< [Pa]
  double rate = 6.6e-4;               ///< [m/s]
  double displacement = 6.6e-3;       ///< [m]
  double rest = 1.0;                  ///< [s] under the load before shearing, at most
  double rest_speed = 1e-4;           ///< [m/s] rms at which the rest ends earlier; 0: never
  int samples = 100;
};
PourSettings pour_settings(const ShearSettings& t);
std::string inputs_text(const ShearSettings& t);
/// Split box, loaded by a rough plate (a layer of grains as one body); upper half and plate move at `rate`.
/// Columns: displacement_m, shear_box_Pa (force on the upper box over the area, mean over the sample), shear_total_Pa (with the
/// plate), normal_Pa (from the plate), rise_m (of the plate, dilation positive). Cost: 640 grains, 10 s: 90 s.
/// @throws DemError: settings not positive, packing of another size.
std::unique_ptr<SoilTest> make_direct_shear(const SoilSettings& soil, const Packing& bed, const ShearSettings& test);

struct SinkageSettings {
  double bin_x = 0.4, bin_y = 0.15, depth = 0.16;  ///< periodic bin [m]
  double plate_x = 0.13, plate_y = 0.05, plate_z = 0.01;
  double rate = 0.01, sinkage = 0.02;  ///< [m/s], [m]
  double brick = 0.05;                 ///< side of the poured brick that is tiled [m]
  int samples = 100;
  int threads = 1;
};
PourSettings pour_settings(const SinkageSettings& t);
std::string inputs_text(const SinkageSettings& t);
/// Smooth plate pushed into tiles of a brick. Columns: sinkage_m (below the surface of the packing), pressure_Pa (mean over the
/// sample). Cost: 30,000 grains, 2 s: 5 minutes.
/// @throws DemError: settings not positive, bin no whole number of bricks, packing of another size.
std::unique_ptr<SoilTest> make_pressure_sinkage(const SoilSettings& soil, const Packing& brick,
                                                const SinkageSettings& test);

struct ReposeSettings {
  double base_x = 0.06, base_y = 0.06, height = 0.08;  ///< of the soil in the box [m]
  double lift = 0.1;                                   ///< speed of the wall that lets it out [m/s]
  double duration = 2;                                 ///< [s] from the lift on
  int samples = 50;
};
PourSettings pour_settings(const ReposeSettings& t);
std::string inputs_text(const ReposeSettings& t);
/// One wall of a box is lifted and the soil slides out over a floor as rough as grains, between smooth side walls.
/// Columns: time_s (since the lift began), angle_deg (slope of a straight line through the surface between 20 and 80 % of its height),
/// height_m (of the surface at the back wall), rms_speed_m_s.
/// @throws DemError: settings not positive, packing of another size.
std::unique_ptr<SoilTest> make_angle_of_repose(const SoilSettings& soil, const Packing& bed,
                                               const ReposeSettings& test);

struct OedometerSettings {
  double side = 0.06, height = 0.04;                                 ///< of the soil [m]
  std::vector<double> pressures{5e3, 1e4, 2e4, 4e4, 2e4, 1e4, 5e3};  ///< [Pa], one after the other
  double hold = 0.3;                                                 ///< [s] each, at most; ends at `rest_speed`
  double rest_speed = 1e-4;                                          ///< [m/s] rms
};
PourSettings pour_settings(const OedometerSettings& t);
std::string inputs_text(const OedometerSettings& t);
/// Compression between smooth walls under a smooth lid. Columns: pressure_Pa, strain (of the height under the first
/// pressure, compression positive), void_ratio, rms_speed_m_s, hold_s.
/// @throws DemError: settings not positive, packing of another size.
std::unique_ptr<SoilTest> make_oedometer(const SoilSettings& soil, const Packing& bed, const OedometerSettings& test);

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
/// Pour and test in one call.
ShearCurve direct_shear(const SoilSettings& soil, const ShearSettings& test, const Progress& progress = {});

struct SinkageCurve {
  std::vector<double> sinkage;   ///< below the surface of the packing [m]
  std::vector<double> pressure;  ///< [Pa], mean over the sample
  double bulk_density = 0;
  std::size_t grains = 0;
  Counters counters;
};
SinkageCurve pressure_sinkage(const SoilSettings& soil, const SinkageSettings& test, const Progress& progress = {});

}  // namespace grouser::dem
