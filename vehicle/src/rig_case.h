#pragma once
// One case of a rig: the motion that is held, what is recorded, the two integrators.
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "grouser/terrain/recorder.h"
#include "grouser/vehicle/rig.h"

namespace grouser::vehicle {

/// Motion that the rig holds, over the time tau since touch-down: nothing for `settle`, then a linear ramp, then constant.
struct HeldMotion {
  double settle, ramp, run;
  double x0, y0;
  double v_x, v_y, w, torque;  ///< after the ramp

  HeldMotion(const RigSpec& s, const RigCase& c)
      : settle(s.settle),
        ramp(s.ramp),
        run(c.run_time),
        x0(s.x),
        y0(s.y),
        v_x(c.travel_speed),
        v_y(c.travel_speed * std::tan(c.slip_angle)),
        w(c.angular_speed),
        torque(c.torque) {}

  double end() const { return settle + ramp + run; }
  double share(double tau) const { return tau <= settle ? 0 : tau >= settle + ramp ? 1 : (tau - settle) / ramp; }
  /// Integral of share [s].
  double travelled(double tau) const {
    if (tau <= settle) return 0;
    if (tau >= settle + ramp) return tau - settle - 0.5 * ramp;
    return 0.5 * (tau - settle) * (tau - settle) / ramp;
  }
};

/// State of the wheel at the end of a step and what the soil did.
struct RigSample {
  double t = 0;    ///< [s] since the start of the case
  double tau = 0;  ///< [s] since touch-down; negative while lowering
  Pose X_WB;
  Twist V_WB;
  ContactReport report;
  double vertical_force = 0;  ///< [N] that reached the wheel
  double motor_torque = 0;    ///< [N m]
};

/// Serialises HDF5, which is not thread-safe, over the cases of a sweep.
using FileLock = std::mutex;

/// Collects the averaging window and writes run.h5.
class RigRecord {
 public:
  RigRecord(const RigSpec& spec, const RigCase& c, const std::filesystem::path& folder, FileLock& lock);
  ~RigRecord();
  /// Every step, in order. @throws RigError when something is not finite or the wheel is lost.
  void add(const RigSample& s, const EnergyLedger& energy);
  /// After the last step. Fills the statistics of the row.
  void finish(RigRow& row, const std::string& hash);
  void warn(const std::string& what);  ///< for the report; empty: nothing
  void fail(const std::string& why);

 private:
  const RigSpec& spec_;
  const RigCase& case_;
  FileLock& lock_;
  std::unique_ptr<Recorder> file_;
  std::vector<int> channels_;
  double window_begin_, frame_interval_, next_frame_ = 0;
  double greatest_before_ramp_ = 0;
  std::vector<double> drawbar_, torque_, side_, normal_, sinkage_, profile_, spin_, speed_;
};

/// Height of the wheel's centre at which it just touches the undisturbed ground: the wheel circle traced over the centre line and
/// both edges.
double touch_height(const Ground& ground, const RunningGear& gear, double x, double y);

struct CaseContext {
  const RigSpec& spec;
  const RigCase& c;
  std::function<std::unique_ptr<Terrain>()> make_terrain;  ///< without bodies
  RigRecord& record;
  std::function<void(double simulated)> progress;  ///< seconds since its last call
};

/// Each runs the whole case, adds every step to the record and fills row's times and hash.
std::string run_fixed(const CaseContext& x, RigRow& row);
std::string run_cvode(const CaseContext& x, RigRow& row);

/// Equilibrium height for the start on a terrain of its own.
double start_height(const CaseContext& x);
std::string case_name(const RigCase& c);

}  // namespace grouser::vehicle
