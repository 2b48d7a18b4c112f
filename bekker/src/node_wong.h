#pragma once
// Closure `wong`: the stresses of the steady wheel, summed over soil nodes in place of the quadrature, with eq 2.12 for
// earlier passes.
#include "node_footprint.h"
#include "node_wheel.h"
#include "steady_wheel.h"

namespace grouser::bekker::node {

class WongWheel final : public ArcSum {
 public:
  WongWheel(const BodySpec& body, std::vector<WheelSoil> soils, std::vector<SoilLaw> laws, SteadyWheel wheel);

  Footprint& footprint() { return print_; }
  SteadyWheel& steady() { return wheel_; }
  const SteadyWheel& steady() const { return wheel_; }
  /// Answer; the nodes remember the step when `commit` is set. Touches only the nodes of the footprint.
  void advance(const Ground& ground, const SteadyEffects& effects, double dt, bool commit, BodyResult& result);

  void replace(const ContactPatch& patch, ShearState e, double slip, double sign, double pressure_factor,
               WheelForces& f) override;

 private:
  struct Touch {
    double x, y, z;  ///< surface point from the hub, grid axes
    double w, rise;  ///< cover, cosine of the normal's angle to the vertical
    double zu, ku, zs;
    int soil;
  };
  void touch();
  void remember();

  Footprint print_;
  std::vector<WheelSoil> soils_;
  std::vector<SoilLaw> laws_;
  WheelSize size_;
  SteadyWheel wheel_;
  std::vector<Touch> touched_;
  double rut_ = 0;
};

}  // namespace grouser::bekker::node
