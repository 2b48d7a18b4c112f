#pragma once
// The channels of run.h5 of a vehicle run.
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/terrain/recorder.h"
#include "grouser/vehicle/scenario.h"
#include "grouser/vehicle/vehicle_world.h"

namespace grouser::vehicle {

/// Quantities that belong to the run rather than to the world; part of the checkpoint.
struct RunTotals {
  std::int64_t step = 0;  ///< since t = 0
  double distance = 0;    ///< [m] travelled by the chassis, horizontal
  double drift = 0;       ///< [m] largest so far
  // At the last frame, for means over the frame:
  double frame_vertical_speed = 0, frame_motor = 0;
  // Terrain's ledger at t = 0.
  EnergyLedger soil_0;
  void traverse(State& s);
};

struct Attitude {
  double roll = 0, pitch = 0, yaw = 0;  ///< [rad] R = Rz(yaw) Ry(pitch) Rx(roll)
};
Attitude attitude(const Quat& q);
VehicleView view_of(const VehicleWorld& w);

/// Balance of the whole: vehicle and terrain ledgers together [J].
double total_residual(const VehicleEnergy& e, const EnergyLedger& soil, const EnergyLedger& soil_0);

class RunRecord {
 public:
  static RunRecord create(const std::filesystem::path& file, const Scenario& s, const std::string& text,
                          const Driver& driver);
  static RunRecord resume(const std::filesystem::path& file, const Scenario& s, std::uint64_t frames);
  /// Append the frame of the world as it is. `t` [s] since the end of settling.
  void frame(double t, double frame_dt, const VehicleWorld& w, const EnergyLedger& soil, RunTotals& totals);
  /// After every fourth frame, of soil that is made of grains: statics points.<frame> and points.<frame>.time, and the squares
  /// of its surface that changed since, surface.<frame> and surface.<frame>.time.
  void points(double t, Terrain& terrain);
  Recorder& recorder() { return recorder_; }

 private:
  explicit RunRecord(Recorder r) : recorder_(std::move(r)) {}
  /// The same for a new file and for one that is continued.
  void add_channels(const VehicleSpec& v);
  Recorder recorder_;
  struct BodyChannels {
    int position, orientation;
  };
  struct WheelChannels {
    int sinkage, slip, slip_angle, normal, drawbar, side, torque, motor_torque, speed, entry, point, force;
  };
  std::vector<BodyChannels> bodies_;
  std::vector<WheelChannels> wheels_;
  std::vector<int> vehicle_, energy_;
  int drift_ = 0;
};

}  // namespace grouser::vehicle
