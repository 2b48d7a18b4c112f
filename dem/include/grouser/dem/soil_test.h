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

struct TriaxialSettings {
  double side = 0.06, height = 0.06;  ///< of the soil poured [m]
  double pressure = 2e4;              ///< on the sides [Pa]
  double strain_rate = 0.2;           ///< of the height after pressing [1/s]
  double strain = 0.2;                ///< axial, at the end, in (0, 0.5]
  double wall_speed = 0.05;           ///< of the walls that hold the pressure, at most [m/s]
  double rest = 1.0;                  ///< [s] under the same pressure on all sides, at most
  double rest_speed = 1e-3;           ///< [m/s] rms at which it ends earlier
  int samples = 60;
  bool ledger = false;  ///< energies in notes(): about twice the time
};
PourSettings pour_settings(const TriaxialSettings& t);
std::string inputs_text(const TriaxialSettings& t);
/// Drained triaxial compression between six smooth rigid walls, without gravity: pressed to `pressure` on all sides, then the lid
/// comes down at constant speed while the side walls hold the pressure: outward speed of both walls of a pair
///   v = gain (e + integral of e dt/(2 T)), |v| <= wall_speed,  e = mean pressure of the pair in the last 0.1 ms less the aim,
/// T twice the time of sound through the sample, gain from the stiffness of a packing of spheres (Walton 1987).
/// Columns: axial_strain, volumetric_strain (compression positive, from the end of pressing), deviator_Pa = axial - confining,
/// axial_Pa, confining_Pa (means over the sample), mobilised_friction_deg = asin((axial - confining)/(axial + confining)), void_ratio.
/// notes(): what the walls carried at the end of pressing, and the largest deviation of a side pressure in any sample.
/// Cost: 640 grains, 1 s: 10 s. Limits: the walls stay flat and upright, so no shear band can leave through the sides.
/// @throws DemError: settings out of range, packing of another size; later: the pressure is not held to 1 % after `rest`.
std::unique_ptr<SoilTest> make_triaxial(const SoilSettings& soil, const Packing& bed, const TriaxialSettings& test);

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
