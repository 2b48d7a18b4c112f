#pragma once
// The smallest rig: one wheel held at a depth, rolled over a registered model until its forces repeat. No files, no
// rigid body.
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/registry.h"

namespace grouser::diagnosis {

struct RigNumerics {
  double step = 5e-4;           ///< [m] of travel
  double average_over = 0.015;  ///< [m] whole number of steps, and of the model's own spacing where it has one
  double settle = 1.2;          ///< [-] contact lengths of travel before the average
  double run_in =
      16;  ///< [-] contact lengths before that, in steps of average_over: what follows slip and travel slowly
};

/// Means over `average_over`.
struct Rolled {
  double drawbar = 0, torque = 0, vertical = 0;  ///< [N], [N m] that the soil asks, [N]
  double rut = 0;                                ///< [m] depth of the surface that the last pass met
};

/// A smooth wheel on flat ground at prescribed depth, slip and spin, by Terrain::step alone.
///
/// Why not the rig of `vehicle`: that one lets a mass settle on the soil over 14 contact lengths in steps of a
/// millisecond and writes files, a second for
/// each case; a diagnosis asks for some ten thousand. At fixed depth a model that forgets what left the contact
/// repeats itself after one contact
/// length, the mean over whole spacings of nodes does not depend on the spacing (measured: ten digits), and load and
/// depth change places in the
/// caller. The steady answer is the same: a wheel free to move up and down stays where the mean force is its load.
class RigDriver {
 public:
  using Amplitude = std::pair<std::string, double>;
  /// options: the model's own, a map or nothing. @throws ConfigError: options that the model refuses, a model that
  /// integrates the wheel itself.
  RigDriver(ModelInfo model, std::string options, std::string name, const RigNumerics& numerics);

  /// depths: lowest point of the wheel below the undisturbed ground [m] in each pass over the same track; the answer
  /// is that of the last.
  /// Nothing where the model refuses the motion, the soil or an amplitude. Cost: about a hundred steps of the model.
  std::optional<Rolled> roll(const Soil& soil, std::span<const Amplitude> effects, double radius, double width,
                             double slip, double omega, std::span<const double> depths) const;

  /// Effects that the model declares.
  std::vector<Effect> effects(const Soil& soil) const;
  bool remembers(const Soil& soil) const;
  const RigNumerics& numerics() const { return numerics_; }

 private:
  std::unique_ptr<Terrain> make(const Soil& soil) const;
  ModelInfo model_;
  ConfigDocument options_;
  RigNumerics numerics_;
  GroundPtr ground_ = flat_ground();
};

}  // namespace grouser::diagnosis
