#pragma once
// The named effects of effects.h under a wheel of bekker.steady.
#include <cmath>

#include "grouser/bekker/effects.h"
#include "grouser/bekker/wheel_forces.h"
#include "grouser/terrain/terrain.h"

namespace grouser::bekker {

/// Speeds of the rim, of travel and to the side in the patch [m/s].
struct ArcMotion {
  double rolling = 0, forward = 0, side = 0;
};

/// What the effects need to know of a wheel beside the arc itself.
struct ArcPoint {
  double theta_f = 0;
  ShearState e;
  double slip = 0;  ///< of theta_m, signed as the distribution runs
  ArcMotion motion;
  double load = 0;  ///< W [N]
};

class ArcEffects {
 public:
  ArcEffects() = default;
  ArcEffects(const EffectConstants& constants, double radius, double reference_width, int pass, double order);

  /// Amplitude; `off` of the table switches it off.
  void set(Effect e, double amplitude);
  double of(Effect e) const { return value_[static_cast<std::size_t>(e)]; }
  bool on(Effect e) const { return active_ >> static_cast<unsigned>(e) & 1U; }
  bool any() const { return active_ != 0; }
  const EffectConstants& constants() const { return constants_; }
  /// Whether the arc depends on the load that it carries.
  bool by_load() const { return on(Effect::shear_modulus_load) || on(Effect::flexible_wheel); }

  /// The wheel as it stands under load W [N].
  WheelSize size(const WheelSize& nominal, double load) const;
  double shear_radius(const WheelSize& loaded) const;
  /// Parameters that do not change along the arc.
  SoilLaw law(const SoilLaw& nominal, double theta_f, double slip, double load) const;
  /// Depth that the slipping wheel has dug away [m]; slip: driving positive in the direction of travel.
  double dug(double slip) const;
  /// Resistance of soil ahead and at the sides of the wheel [N]; it acts against the travel, at hub height.
  double resistance(const WheelSize& loaded, const SoilLaw& nominal, double theta_f) const;
  /// Growth of ln sigma with depth that comes from a hard pan [1/m].
  double pan_stiffness(double sinkage) const;

  /// Forces of the arc with all effects but digging and resistance. Quadrature with at least 20 points a piece; about 4 us.
  WheelForces force(const WheelSize& loaded, const SoilLaw& nominal, const ArcPoint& at, Quadrature q,
                    double pressure_factor) const;

 private:
  double relative_load(double load) const { return std::max(load / constants_.load, 0.01); }

  EffectConstants constants_;
  EffectValues value_ = no_effects();
  std::uint32_t active_ = 0;
  double radius_ = 0, reference_width_ = 0, order_ = 0;
  int pass_ = 1;
};

/// W = carried(W) [N] by secants, to 1e-12 of it. @throws TerrainError when the wheel finds no load that agrees with its own effects.
template <class F>
double agreed_load(F&& carried, double guess) {
  double x0 = guess, f0 = carried(x0) - x0;
  double x1 = std::max(x0 + f0, 0.0);
  for (int i = 0; i < 60; ++i) {
    if (std::abs(x1 - x0) <= 1e-12 * std::max(std::abs(x1), 1e-3)) return x1;
    const double f1 = carried(x1) - x1, change = f1 - f0;
    double next = change != 0 ? x1 - f1 * (x1 - x0) / change : x1 + f1;
    if (!(next >= 0) || next > 10 * std::max(x1 + f1, 1.0)) next = std::max(x1 + f1, 0.0);
    x0 = x1;
    f0 = f1;
    x1 = next;
  }
  throw TerrainError(
      "bekker.steady: effects shear_modulus_load and flexible_wheel find no load that agrees with the force "
      "they make; lower their amplitudes");
}

}  // namespace grouser::bekker
