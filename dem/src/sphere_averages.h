#pragma once
// What a surrogate learns from (section 5.2): states averaged over a short way of the wheel, at regular ways.
//
//   window k: hub's path from k `every` to k `every` + `over`;  mean over samples every kSampled inner steps                (S3)
//
// File (HDF5, of the Recorder's form), one frame per window, time at its end: hub_position, hub_velocity, spin, force and torque of the
// grains on the wheel (impulse over the window), pressure [bins x 3]: normal (positive in compression), along the rim (positive where it
// pushes the wheel on), along the axle, by angle about the axle from the bottom (positive forward), over the outer radius; contacts.
// grains.<k>.position, .velocity, .radius, .number: the grains that were in the solver during the whole window, x about the hub's x.
// Angles of the bins: dataset angle. Inputs and their hash: attributes scenario and inputs_hash.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grouser/dem/solver.h"
#include "grouser/terrain/recorder.h"

namespace grouser::dem {

struct AveragesSettings {
  std::filesystem::path file;             ///< empty: none
  double over = 0.25e-3, every = 2.5e-3;  ///< [m]
};

class Averages {
 public:
  static constexpr long kSampled = 16;  ///< inner steps between samples
  static constexpr int kBins = 180;     ///< round the wheel
  /// @throws ResultsError: the file is there already.
  /// `slab`: width of the slab that the forces in the solver belong to [m]; force and torque become those of `width`; 0: none.
  Averages(const AveragesSettings& s, const std::string& inputs, double radius, double width, double slab = 0);
  ~Averages();

  /// Steps, `way` of the hub each, until the window opens or closes, or to the next sample; never 0, at most `left`.
  long next(double way, long left) const;
  /// After that many steps. now: body 0's pose in the solver, `hub` in the world.
  template <class Parked>
  void after(long steps, double way, const Solver& solver, const Pose& hub_W, double period_x, double period_y,
             double dt, Parked parked) {
    path_ += way * static_cast<double>(steps);
    if (!open_ && path_ >= begin_ - 1e-12) begin(solver);
    if (!open_) return;
    sample(solver, hub_W, period_x, period_y, parked);
    if (path_ >= begin_ + set_.over - 1e-12) end(solver, dt);
  }

 private:
  void begin(const Solver& solver);
  void sample(const Solver& solver, const Pose& hub_W, double lx, double ly,
              const std::function<bool(std::size_t)>& parked);
  void end(const Solver& solver, double dt);

  AveragesSettings set_;
  double radius_, width_, slab_;  ///< width_: that the solver's forces belong to
  double share_;                  ///< of force and torque
  std::optional<Recorder> file_;
  std::vector<int> channels_;
  double path_ = 0, begin_ = 0;
  bool open_ = false;
  int samples_ = 0, windows_ = 0;
  double since_ = 0;
  Vec3 impulse_ = Vec3::Zero(), angular_ = Vec3::Zero(), hub_ = Vec3::Zero(), velocity_ = Vec3::Zero();
  double spin_ = 0, contacts_ = 0;
  std::vector<double> pressure_;
  struct Sum {
    Vec3 x = Vec3::Zero(), v = Vec3::Zero();
    int n = 0;
    double radius = 0;
  };
  std::vector<Sum> grains_;
};

}  // namespace grouser::dem
